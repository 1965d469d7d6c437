//! Refinement of an effect's parameter between grid values, at fixed noise levels.

use super::model::{SlowSearch, State};
use crate::detect::hypothesis::Hypothesis;
use crate::effects::{Detector, Effect};
use fos_data::recording::RecordingError;
use fos_fit::noise::NoiseLevels;

/// Number of parts of a block at which the time of a step is tried.
const STEP_PARTS: i32 = 5;

/// Number of parabolas through the best three values of a parameter.
const REFINEMENTS: usize = 4;

impl SlowSearch<'_> {
    /// Finds the best value of the parameter on top of `state` between its neighbours on the grid at fixed noise levels,
    /// by parabolas through the best three values.
    pub(super) fn refine(
        &self,
        state: &State,
        levels: NoiseLevels,
        start: Hypothesis,
    ) -> Result<Hypothesis, RecordingError> {
        let Some(value) = start.value else { return Ok(start) };
        if start.effect.search == Detector::Step {
            return self.refine_step(state, levels, start, value);
        }
        let evaluate = |log: f64| -> Result<(f64, f64, Hypothesis), RecordingError> {
            let hypothesis = self.hypotheses.make(&start.effect, Some(log.exp()))?.with_terms_of(&start);
            Ok((log, self.deviance_with(state, &hypothesis, levels), hypothesis))
        };
        let middle = value.ln();
        let width = self.grid_width(&start.effect);
        let limited = |log: f64| match &start.effect.parameter {
            Some(parameter) => log.clamp(parameter.low.ln(), parameter.high.ln()),
            None => log,
        };
        let mut points = vec![evaluate(middle)?];
        for neighbour in [limited(middle - width), limited(middle + width)] {
            if (neighbour - middle).abs() > 1e-3 {
                points.push(evaluate(neighbour)?);
            }
        }
        for _ in 0..REFINEMENTS {
            points.sort_by(|a, b| a.1.total_cmp(&b.1));
            points.truncate(3);
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            if points.len() < 3 {
                // at a limit of the search the third point is half way to the neighbour
                points.push(evaluate(0.5 * (points[0].0 + points[points.len() - 1].0))?);
                continue;
            }
            let next = vertex(&points.iter().map(|p| (p.0, p.1)).collect::<Vec<_>>());
            let (low, high) = match &start.effect.parameter {
                Some(parameter) => (parameter.low.ln(), parameter.high.ln()),
                None => (middle - width, middle + width),
            };
            let Some(next) = next.map(|next| next.clamp(low, high)) else { break };
            if points.iter().any(|point| (point.0 - next).abs() < 1e-3) {
                break;
            }
            points.push(evaluate(next)?);
        }
        points.sort_by(|a, b| a.1.total_cmp(&b.1));
        Ok(points.swap_remove(0).2)
    }

    /// Finds the time of a step inside the blocks on both sides of it.
    fn refine_step(
        &self,
        state: &State,
        levels: NoiseLevels,
        start: Hypothesis,
        time_s: f64,
    ) -> Result<Hypothesis, RecordingError> {
        let width_s = self.blocks.length_s * self.hypotheses.blocks_a_place() as f64;
        let mut best = (f64::INFINITY, start);
        for part in -STEP_PARTS..=STEP_PARTS {
            let at = time_s + f64::from(part) / f64::from(STEP_PARTS) * width_s;
            let hypothesis = self.hypotheses.make(&best.1.effect, Some(at))?;
            let deviance = self.deviance_with(state, &hypothesis, levels);
            if deviance < best.0 {
                best = (deviance, hypothesis);
            }
        }
        Ok(best.1)
    }

    fn grid_width(&self, effect: &Effect) -> f64 {
        let grid = self.hypotheses.grid(effect);
        match grid[..] {
            [Some(first), Some(second), ..] => (second / first).ln(),
            _ => 0.0,
        }
    }
}

/// Returns the minimum of the parabola through three points; a point beyond the better end if the parabola opens
/// downwards.
fn vertex(points: &[(f64, f64)]) -> Option<f64> {
    let [(x0, y0), (x1, y1), (x2, y2)] = *points else { return None };
    let (left, right) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
    let bend = (right - left) / (x2 - x0);
    if bend > 0.0 {
        Some(0.5 * (x0 + x1) - left / (2.0 * bend))
    } else {
        Some(if y0 < y2 { x0 - (x1 - x0) } else { x2 + (x2 - x1) })
    }
}

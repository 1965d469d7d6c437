//! Thermometers with coarse steps, and interpolation of the temperature between two steps.

use super::Recording;
use super::channel::Channel;
use crate::statistics::median_of;
use crate::unit::Unit;

/// Range of steps that count as coarse, K: those of 8 bits to 10 bits over the range. Finer ones drown in noise.
const COARSE_K: std::ops::RangeInclusive<f64> = 0.25..=2.0;

/// Largest distance of a value from a whole number of steps, in steps.
const GRID_TOLERANCE: f64 = 0.02;

/// Consecutive crossings between the same two steps within this share of the usual time between crossings count as one:
/// noise at the edge of a step.
const SAME_CROSSING: f64 = 0.25;

impl Recording {
    /// Step of a thermometer, K, if its values form a staircase.
    pub fn coarse_step(&self, channel: &Channel) -> Option<f64> {
        if channel.unit != Unit::Celsius {
            return None;
        }
        let mut levels: Vec<f64> = channel.values.iter().copied().filter(|value| value.is_finite()).collect();
        levels.dedup();
        levels.sort_unstable_by(f64::total_cmp);
        levels.dedup();
        let gaps = || levels.windows(2).map(|pair| pair[1] - pair[0]);
        let step = gaps().fold(f64::INFINITY, f64::min);
        let on_grid = |gap: f64| (gap / step - (gap / step).round()).abs() < GRID_TOLERANCE;
        (COARSE_K.contains(&step) && gaps().all(on_grid)).then_some(step)
    }

    /// `values` of such a thermometer (one per row, missing only at the begin) with the staircase smoothed: halfway
    /// between two steps at each crossing, on a smooth curve from one crossing to the next, and never further than half
    /// a step from a value.
    pub fn between_steps(&self, values: &[f64], step: f64) -> Vec<f64> {
        let ticks: Vec<f64> = self
            .segments
            .iter()
            .flat_map(|segment| (0..segment.rows.len()).map(|row| (segment.tick + row as u64) as f64))
            .collect();
        let mut smooth = values.to_vec();
        for rows in self.power_ons() {
            let Some(first) = rows.clone().find(|row| !values[*row].is_nan()) else { continue };
            let rows = first..rows.end;
            let knots = crossings(&ticks[rows.clone()], &values[rows.clone()], step);
            let slopes = slopes(&knots);
            let mut at = 0;
            for row in rows {
                while at + 2 < knots.len() && knots[at + 1].0 < ticks[row] {
                    at += 1;
                }
                let ((from, low), (to, high)) = (knots[at], knots[at + 1]);
                let length = to - from;
                let x = if length > 0.0 { ((ticks[row] - from) / length).clamp(0.0, 1.0) } else { 1.0 };
                // cubic Hermite interpolation
                let curve = low
                    + (high - low) * x * x * (3.0 - 2.0 * x)
                    + length * x * (1.0 - x) * (slopes[at] * (1.0 - x) - slopes[at + 1] * x);
                smooth[row] = curve.clamp(values[row] - 0.5 * step, values[row] + 0.5 * step);
            }
        }
        smooth
    }
}

/// Ticks and temperatures of the transitions between steps, and both ends. Values alternating between two steps form one
/// crossing.
fn crossings(ticks: &[f64], values: &[f64], step: f64) -> Vec<(f64, f64)> {
    let mut crossings: Vec<(f64, f64)> = Vec::new();
    for row in 1..values.len() {
        let (before, after) = (values[row - 1], values[row]);
        // a jump by several steps at once is real
        if after != before && (after - before).abs() < 1.5 * step {
            crossings.push((0.5 * (ticks[row - 1] + ticks[row]), 0.5 * (before + after)));
        } else if after != before {
            crossings.extend([(ticks[row - 1], before), (ticks[row], after)]);
        }
    }
    let on = crossings.windows(2).filter(|pair| pair[0].1 != pair[1].1).map(|pair| pair[1].0 - pair[0].0);
    let together = SAME_CROSSING * median_of(on).unwrap_or(0.0);
    let ends = [(ticks[0], values[0]), (ticks[ticks.len() - 1], values[values.len() - 1])];
    let mut knots = vec![ends[0]];
    let same = |a: &(f64, f64), b: &(f64, f64)| a.1 == b.1 && b.0 - a.0 < together;
    for cluster in crossings.chunk_by(same) {
        let (first, last) = (cluster[0], cluster[cluster.len() - 1]);
        knots.push((0.5 * (first.0 + last.0), first.1));
    }
    knots.push(ends[1]);
    knots
}

/// Slope in each knot of the parabola through it and its neighbours (Bessel); 0 at the ends.
fn slopes(knots: &[(f64, f64)]) -> Vec<f64> {
    let slope = |from: (f64, f64), to: (f64, f64)| (to.1 - from.1) / (to.0 - from.0).max(1.0);
    let inner = knots.windows(3).map(|three| {
        let (before, after) = ((three[1].0 - three[0].0).max(1.0), (three[2].0 - three[1].0).max(1.0));
        (after * slope(three[0], three[1]) + before * slope(three[1], three[2])) / (before + after)
    });
    std::iter::once(0.0).chain(inner).chain([0.0]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, LogWarning, Source};
    use super::*;

    fn recording(values: Vec<f64>) -> Recording {
        let columns = vec![("temp_c".to_owned(), values)];
        let options = LoadOptions { rate_hz: Some(10.0), ..LoadOptions::default() };
        Recording::from_columns(Source::made_by("test"), columns, &options).unwrap()
    }

    #[test]
    fn smooths_coarse_steps_to_a_fraction_of_a_step() {
        let true_c: Vec<f64> = (0..9000).map(|row| 25.0 + 6.0 * (0.002 * f64::from(row)).sin()).collect();
        for step in [0.5, 1.0] {
            let log = recording(true_c.iter().map(|t| (t / step).round() * step).collect());
            let channel = log.channel("temp_c").unwrap();
            assert_eq!(log.coarse_step(channel), Some(step));
            let off = |values: &[f64]| {
                let squares = values.iter().zip(&true_c).map(|(v, t)| (v - t).powi(2)).sum::<f64>();
                (squares / 9000.0).sqrt() / step
            };
            let (stairs, smooth) = (off(&channel.values), off(&log.between_steps(&channel.values, step)));
            assert!(stairs > 0.27 && smooth < 0.07, "{stairs} {smooth}");
            let odd = log.warnings(&[true; 9000]);
            assert!(
                matches!(&odd[..], [LogWarning::CoarseSteps { step: found, .. }] if *found == step),
                "{odd:?}"
            );
        }
    }

    #[test]
    fn ignores_fine_steps_jumps_and_other_quantities() {
        let fine = (0..900).map(|row| 25.0 + f64::from(row / 9) / 16.0).collect();
        let off_grid = (0..900).map(|row| 25.0 + 0.31 * f64::from(row / 90).powf(1.5)).collect();
        let jump = (0..900).map(|row| if row < 300 { 20.0 } else { 30.0 }).collect();
        for values in [fine, off_grid, jump, vec![25.0; 900]] {
            let log = recording(values);
            assert_eq!(log.coarse_step(log.channel("temp_c").unwrap()), None);
        }
        let stairs: Vec<f64> = [3.0, 5.0, 6.0, 6.0, 7.0].into();
        assert_eq!(recording(stairs.clone()).between_steps(&stairs, 1.0)[..2], [3.0, 5.0]);
    }
}

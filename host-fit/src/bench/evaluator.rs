//! Cost of a step of the evaluator on the host, against the minimum of necessary operations.

use std::hint::black_box;

use fos_core::{
    Axis, AxisModel, AxisParameters, Coasts, FittedOn, InnovationStatistics, Model, ModelError, Predictor,
    Range, Sample, Term, y,
};
use pulp::{Arch, Simd, WithSimd};
use serde::Serialize;

use crate::timing::least_time;

/// Number of axes, and of terms per axis.
const AXES: usize = 6;
const TERMS: usize = 10;

/// Length of the history, values.
const HISTORY: usize = 128;

/// Number of coasts side by side, as in the evaluation of models by a fit.
const LANES: usize = 8;

const REPEATS: usize = 7;

type Judge = Predictor<f64, AXES, 1, { AXES * TERMS }, HISTORY>;

/// Time of a step of one axis with ten linear terms, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StepTimes {
    /// Tracking, with all checks.
    pub tracked_s: f64,
    /// Coasting, one of eight side by side.
    pub side_by_side_s: f64,
    /// Only the loads of coefficients and values, and the multiplications and additions in their order.
    pub bare_s: f64,
}

/// Times `n_steps` of six axes with ten linear terms each.
pub fn measure(n_steps: usize) -> Result<StepTimes, ModelError> {
    let axes = [Axis::Ax, Axis::Ay, Axis::Az, Axis::Gx, Axis::Gy, Axis::Gz];
    let terms: Vec<Term<f64>> =
        (1..=TERMS as u16).map(|lag| Term::new(0.09 / f64::from(lag), &[y(lag)])).collect();
    let axes = axes.map(|axis| AxisModel { parameters: parameters(axis), physical: &[], stochastic: &terms });
    let model = Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        inputs: &[],
        quantities: &[],
        axes: &axes,
    };
    let mut predictor = Judge::new(&model)?;
    // A fixed pattern of noise, without equal consecutive values.
    let measured: Vec<[f64; AXES]> = (0..256)
        .map(|n| std::array::from_fn(|axis| (f64::from(n * 37 % 101) - 50.0) * 0.01 + axis as f64 * 1e-3))
        .collect();
    let steps = n_steps * AXES;
    let (tracked, _) = least_time(REPEATS, || {
        for measured in measured.iter().cycle().take(n_steps) {
            let _ = black_box(predictor.track(&Sample { measured, quantities: &[] }));
        }
    });
    let side_by_side = Coasts::<f64, LANES, AXES, 1, { AXES * TERMS }, HISTORY>::new(&predictor);
    let side_by_side_s = side_by_side.map_or(f64::NAN, |mut coasts| {
        least_time(REPEATS, || Arch::new().dispatch(SideBySide { coasts: &mut coasts, n_steps })).0
    });
    let mut history = [0.1; 2 * HISTORY];
    let coefficients: [f64; TERMS] = black_box(std::array::from_fn(|lag| 0.09 / (lag + 1) as f64));
    let places: [usize; TERMS] = black_box(std::array::from_fn(|lag| (TERMS - 1 - lag) * AXES));
    let (bare, _) = least_time(REPEATS, || {
        let mut begin = 0;
        for measured in measured.iter().cycle().take(n_steps) {
            for (axis, measured) in measured.iter().enumerate() {
                let window = &history[begin + axis..];
                let mut sum = 0.0;
                for (coefficient, place) in coefficients.iter().zip(&places) {
                    sum += coefficient * window[*place];
                }
                black_box(sum);
                history[(begin + axis + TERMS * AXES) % (2 * HISTORY)] = *measured;
            }
            begin = (begin + AXES) % HISTORY;
        }
    });
    Ok(StepTimes {
        tracked_s: tracked / steps as f64,
        side_by_side_s: side_by_side_s / (steps * LANES) as f64,
        bare_s: bare / steps as f64,
    })
}

struct SideBySide<'a> {
    coasts: &'a mut Coasts<f64, LANES, AXES, 1, { AXES * TERMS }, HISTORY>,
    n_steps: usize,
}

impl WithSimd for SideBySide<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for _ in 0..self.n_steps {
            black_box(self.coasts.step(&[]));
        }
    }
}

fn parameters(axis: Axis) -> AxisParameters<f64> {
    AxisParameters {
        axis,
        reference: 0.0,
        offset: 0.0,
        scale: 1.0,
        constant: 0.0,
        range: Range::new(-10.0, 10.0),
        physical_range: Range::new(0.0, 0.0),
        full_scale: 0.0,
        stuck_after_repeats: 0,
        gap_limit_samples: 1,
        // Never faded: numbers near zero are slow on some processors.
        coast_limit_s: 1e9,
        innovation: InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_takes_time() {
        let StepTimes { tracked_s, side_by_side_s, bare_s } = measure(1000).unwrap();
        assert!(tracked_s > 0.0 && side_by_side_s > 0.0 && bare_s > 0.0);
    }
}

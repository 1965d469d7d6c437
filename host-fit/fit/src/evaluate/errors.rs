//! The errors of one model on one axis, by their definitions (docs/MATHS.md, "Definitions of errors").

use serde::{Deserialize, Deserializer, Serialize};

use super::origins::HORIZONS_S;
use super::trace::{Squares, Trace};
use super::unaided::{Integral, UNAIDED_S, UnaidedError};
use crate::signal;
use crate::signal::allan::allan_deviation;
use crate::signal::blocks::slow_error;
use crate::signal::noise_floor::NoiseFloor;

/// Averaging times of the Allan deviation, s.
const TAUS_S: [f64; 3] = [1.0, 10.0, 100.0];

/// Length of the blocks over whose means the slow error is taken, s.
pub const SLOW_BLOCK_S: f64 = 1.0;

/// Errors of one axis with one model. Squared errors are in the square of the axis' unit. A value is absent where the
/// data are too short for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct ModelErrors {
    /// Name of the model, as in tables.
    pub model: String,
    /// Mean square one-step prediction error: measured − predicted from measured history, on the raw samples.
    #[serde(deserialize_with = "or_nan")]
    pub one_step_mse: f64,
    /// Mean square error of a free run after exactly 1 s, 10 s and 60 s.
    pub coast: Vec<CoastError>,
    /// Mean square error of a free run over all evaluated rows, never restarted.
    #[serde(deserialize_with = "or_nan")]
    pub coast_whole_mse: f64,
    /// Variance of the 1-s block means of the one-step residual, at rest.
    pub slow_error_one_step: Option<f64>,
    /// Variance of the 1-s block means of the residual of free runs of at most 60 s, at rest.
    pub slow_error_coast: Option<f64>,
    /// Variance of the samples of the one-step residual, at rest.
    #[serde(deserialize_with = "or_nan")]
    pub wide_error_one_step: f64,
    /// Variance of the samples of the residual of free runs of at most 60 s, at rest.
    #[serde(deserialize_with = "or_nan")]
    pub wide_error_coast: f64,
    /// Heading or position error after a time without aiding; empty for an axis that is neither gyro nor accelerometer,
    /// and in studies of earlier versions.
    #[serde(default)]
    pub unaided: Vec<UnaidedError>,
    /// Allan deviation of the residual of free runs of at most 60 s.
    pub allan: Vec<AllanValue>,
    /// True if the one-step MSE is below the noise floor; such a result is not to be trusted.
    pub below_noise_floor: bool,
    /// Number of rows whose prediction has a caution (out of range, stuck, saturated, not finite, …).
    pub cautions: usize,
}

/// Reads `null` as NaN, which JSON lacks: the error over no rows, such as that of a model whose history is longer than
/// every rest.
fn or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// Coast error at one horizon.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct CoastError {
    /// Horizon, s.
    pub horizon_s: f64,
    /// Mean square error after exactly that time.
    pub mse: f64,
    /// Standard error of the mean, with the coasts taken as independent of one another.
    pub standard_error: f64,
    /// Number of coasts in the mean.
    pub origins: usize,
}

/// Allan deviation at one averaging time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct AllanValue {
    /// Averaging time, s.
    pub tau_s: f64,
    /// Deviation, in the axis' unit.
    pub deviation: f64,
}

impl ModelErrors {
    /// Computes the errors of axis `axis` in `trace`; `noise_floor` as estimated from the same data.
    pub fn of(
        trace: &Trace,
        axis: usize,
        model: &str,
        column: &str,
        noise_floor: Option<&NoiseFloor>,
    ) -> Self {
        let left = &trace.axes[axis];
        let one_step = trace.stretches_of(&left.one_step);
        let coast = trace.stretches_of(&left.coast);
        let one_step_mse = mean_square(&one_step);
        let horizons = HORIZONS_S.into_iter().zip(&left.horizons).filter(|(_, squares)| !squares.is_empty());
        Self {
            model: model.to_owned(),
            one_step_mse,
            coast: horizons.map(|(horizon_s, squares)| CoastError::of(horizon_s, squares)).collect(),
            coast_whole_mse: left.coast_whole_mse,
            slow_error_one_step: slow_error(&one_step, trace.period_s, SLOW_BLOCK_S),
            slow_error_coast: slow_error(&coast, trace.period_s, SLOW_BLOCK_S),
            wide_error_one_step: signal::variance(&one_step),
            wide_error_coast: signal::variance(&coast),
            unaided: Integral::of(column).map_or_else(Vec::new, |integral| {
                let ends = UNAIDED_S.into_iter().zip(&left.unaided);
                ends.map(|(window_s, ends)| UnaidedError::of(integral.triad(), window_s, ends)).collect()
            }),
            allan: allan_deviation(&coast, trace.period_s, &TAUS_S)
                .into_iter()
                .map(|point| AllanValue { tau_s: point.tau_s, deviation: point.deviation })
                .collect(),
            below_noise_floor: noise_floor.is_some_and(|floor| floor.is_beaten_by(one_step_mse)),
            cautions: left.cautions,
        }
    }
}

impl CoastError {
    fn of(horizon_s: f64, squares: &[f64]) -> Self {
        let standard_error = (signal::variance(&[squares]) / squares.len() as f64).sqrt();
        Self { horizon_s, mse: signal::mean(&[squares]), standard_error, origins: squares.len() }
    }
}

fn mean_square(stretches: &[&[f64]]) -> f64 {
    let mut squares = Squares::default();
    stretches.iter().copied().flatten().for_each(|value| squares.add(*value));
    squares.mean()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regression: a study whose model was evaluated on no row could not be read back.
    #[test]
    fn errors_over_no_rows_are_read_back() {
        let errors = ModelErrors {
            model: "model".to_owned(),
            one_step_mse: f64::NAN,
            coast: Vec::new(),
            coast_whole_mse: f64::NAN,
            slow_error_one_step: None,
            slow_error_coast: None,
            wide_error_one_step: f64::NAN,
            wide_error_coast: 1.5,
            unaided: Vec::new(),
            allan: Vec::new(),
            below_noise_floor: false,
            cautions: 0,
        };
        let read: ModelErrors = serde_json::from_str(&serde_json::to_string(&errors).unwrap()).unwrap();
        assert!(
            read.one_step_mse.is_nan() && read.coast_whole_mse.is_nan() && read.wide_error_one_step.is_nan()
        );
        assert_eq!(read.wide_error_coast, 1.5);
    }
}

//! Fits plain slices: a model, its predictor and a forecast, without files, columns or units.

use fos_core::{ModelError, Sample};
use fos_data::recording::{LoadOptions, Recording, RecordingError, Source};

use crate::fit::{AxisError, AxisFit, AxisReport, FitOptions, fit_axis, rest};
use crate::model::HostPredictor;
use crate::single_axis::SingleAxisModel;

/// Column name of a plain series.
const COLUMN: &str = "series";

/// Model of one series, in the series' unit.
#[derive(Debug, Clone)]
pub struct SeriesFit {
    /// Model with one axis, the column `series`.
    pub model: SingleAxisModel,
    /// Report of the fit: every step of the search, its error, and the reason why it stopped.
    pub report: AxisReport,
    /// Standard deviation of the innovation e(n) on the fitted rows, in the series' unit.
    pub innovation_deviation: f64,
}

/// Forecast of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forecast {
    /// Predicted value, in the series' unit.
    pub value: f64,
    /// Standard error due to future innovations, in the series' unit; the coefficients are taken as exact.
    pub standard_error: f64,
}

/// Reason why a series has no model or forecast.
#[derive(Debug, thiserror::Error)]
pub enum SeriesError {
    /// The series is not a recording: too short, or with a sampling rate of no sensor.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error(transparent)]
    Axis(#[from] AxisError),
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// Fits a series without gaps, sampled at `rate_hz`, on its first half ([`FitOptions::train`]); a value that is not
/// finite counts as missing.
///
/// ```
/// use fos_fit::fit::FitOptions;
/// use fos_fit::series::fit_series;
///
/// // r(n) = 0.9 r(n − 1) + e(n), e uniform with a standard deviation of 1/√12
/// let mut state = 1_u32;
/// let mut noise = || { state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223); f64::from(state >> 8) / 16_777_216.0 - 0.5 };
/// let mut r = vec![0.0; 20_000];
/// for n in 1..r.len() {
///     r[n] = 0.9 * r[n - 1] + noise();
/// }
/// let fit = fit_series(&r, 200.0, &FitOptions { max_lag: 4, ..FitOptions::default() })?;
/// let forecast = fit.forecast(&r, 20)?;
/// assert!((forecast[0].value - 0.9 * r.last().unwrap()).abs() < 0.1);
/// assert!((forecast[0].standard_error - 1.0 / 12_f64.sqrt()).abs() < 0.01);
/// assert!(forecast[19].standard_error > 2.0 * forecast[0].standard_error);
/// # Ok::<(), fos_fit::series::SeriesError>(())
/// ```
pub fn fit_series(values: &[f64], rate_hz: f64, options: &FitOptions) -> Result<SeriesFit, SeriesError> {
    let time = (0..values.len()).map(|n| n as f64 / rate_hz).collect();
    let columns = vec![("t_s".to_owned(), time), (COLUMN.to_owned(), values.to_vec())];
    let read = LoadOptions { rate_hz: Some(rate_hz), ..LoadOptions::default() };
    let recording = Recording::from_columns(Source::made_by("a series"), columns, &read)?;
    let stillness = rest(&recording, options.train);
    let AxisFit { model, report } = fit_axis(&recording, &stillness, COLUMN, options)?;
    let innovation_deviation = report.mse.sqrt() * model.axis().parameters.scale;
    Ok(SeriesFit { model, report, innovation_deviation })
}

impl SeriesFit {
    /// Returns the evaluator of the device, in f64, before its first sample.
    pub fn predictor(&self) -> Result<HostPredictor<f64>, ModelError> {
        self.model.predictor()
    }

    /// Forecasts the `steps` samples that follow `history` with the evaluator itself, with their standard errors.
    ///
    /// With ψ_i the change of the forecast i samples after a unit innovation, the variance of the forecast h samples
    /// ahead is σ²·Σ_{i<h} ψ_i² (Box and Jenkins 1976, section 5.1). The ψ are determined by a second run of the
    /// evaluator with the last value increased by σ: exact for a linear model, the slope at the forecast otherwise.
    pub fn forecast(&self, history: &[f64], steps: usize) -> Result<Vec<Forecast>, ModelError> {
        let mut predictor = self.predictor()?;
        for value in history {
            let _ = predictor.track(&Sample { measured: &[*value], quantities: &[] });
        }
        let values = ahead(predictor.clone(), steps);
        let Some(first) = values.first() else { return Ok(Vec::new()) };
        let sigma = self.innovation_deviation;
        let after = |innovation: f64| {
            let mut predictor = predictor.clone();
            let _ = predictor.track(&Sample { measured: &[first + innovation], quantities: &[] });
            ahead(predictor, steps - 1)
        };
        let (without, with) = (after(0.0), after(sigma));
        // ψ_0 = 1: the innovation itself
        let psi = with.iter().zip(&without).map(|(with, without)| (with - without) / sigma);
        let squares = std::iter::once(1.0).chain(psi).scan(0.0, |sum, psi: f64| {
            *sum += psi * psi;
            Some(*sum)
        });
        let forecast =
            |(value, sum): (&f64, f64)| Forecast { value: *value, standard_error: sigma * sum.sqrt() };
        Ok(values.iter().zip(squares).map(forecast).collect())
    }
}

fn ahead(mut predictor: HostPredictor<f64>, steps: usize) -> Vec<f64> {
    (0..steps).map(|_| predictor.forecast(&[])[0].predicted).collect()
}

#[cfg(test)]
mod tests {
    use fos_testkit::noise::autoregression;

    use super::*;

    #[test]
    fn forecast_matches_the_autoregression() {
        let (ar, variance) = ([1.2, -0.5], 0.04);
        let series = autoregression(3, 40_000, &ar, variance);
        let options = FitOptions { max_lag: 6, degree: 1, memory_s: Vec::new(), ..FitOptions::default() };
        let fit = fit_series(&series, 100.0, &options).unwrap();
        // 20,000 rows: the standard error of σ̂ is 0.5 %
        assert!((fit.innovation_deviation / variance.sqrt() - 1.0).abs() < 0.02);
        let forecast = fit.forecast(&series, 30).unwrap();
        let n = series.len();
        let (mut past, mut psi, mut sum) = ([series[n - 1], series[n - 2]], [1.0, 0.0], 0.0);
        for Forecast { value, standard_error } in forecast {
            let expected = ar[0] * past[0] + ar[1] * past[1];
            sum += psi[0] * psi[0];
            // three standard errors of the coefficients and of their mean
            assert!((value - expected).abs() < 0.03, "{value} for {expected}");
            let expected_error = (variance * sum).sqrt();
            assert!(
                (standard_error / expected_error - 1.0).abs() < 0.04,
                "{standard_error} for {expected_error}"
            );
            (past, psi) = ([expected, past[0]], [ar[0] * psi[0] + ar[1] * psi[1], psi[0]]);
        }
    }

    #[test]
    fn rejects_empty_series_and_forecasts_no_steps() {
        assert!(matches!(fit_series(&[], 200.0, &FitOptions::default()), Err(SeriesError::Recording(_))));
        assert!(matches!(fit_series(&[1.0; 5000], 200.0, &FitOptions::default()), Err(SeriesError::Axis(_))));
        let series = autoregression(1, 5000, &[0.5], 1.0);
        let fit = fit_series(&series, 200.0, &FitOptions::default()).unwrap();
        assert!(fit.forecast(&series, 0).unwrap().is_empty());
    }
}

//! The paper's comparison on any log: Yule-Walker, covariance, modified covariance and Burg, on samples as measured and
//! de-noised, against FOS on samples as measured, at every model order.
//!
//! The rows at rest are split in three, in the order of time: *train* (every model is fitted), *evaluate* (one is chosen) and
//! *predict* (all are judged). Two mean square errors, always both:
//!
//! - *as in the paper*: each method predicts what it was fitted to, de-noised samples from de-noised samples;
//! - *same target*: every method predicts the samples as measured from samples as measured.
//!
//! Only the second compares methods. Residuals are formed sample by sample by the arithmetic of the refit; the tests hold
//! them against fos-core.

mod figures;
mod split;

use fos_data::column::Column;
use std::ops::Range;

use fos_core::y;
use serde::Serialize;

pub use figures::figures;
pub use split::{Split, SplitError};

use crate::bench::median_time;
use fos_data::recording::{ErrorSeries, Recording};
use fos_data::stillness::Stillness;
use fos_fit::candidates::{Candidates, Monomial};
use fos_fit::evaluate::position_error_m;
use fos_fit::fit::autoregression::{self, Method};
use fos_fit::fit::{NoiseRule, Search, StopRule, refit};
use fos_fit::moments::Rows;
use fos_fit::signal;
use fos_fit::signal::noise_floor::{NoiseFloor, noise_floor};
use fos_fit::signal::wavelet::Denoising;

/// How the comparison is made.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Settings {
    /// Length of the training part, s at rest.
    pub train_s: f64,
    /// Length of the evaluation part, s at rest.
    pub evaluate_s: f64,
    /// Model orders 1 … this.
    pub max_order: u16,
    /// Cross-product degrees 1 … this.
    pub max_degree: usize,
    /// What is done to the training data of the methods of the autoregression.
    pub denoising: Denoising,
    /// Fits that each time is the median of.
    pub repeats: usize,
    /// How FOS searches; the paper's is greedy.
    pub search: Search,
}

/// A method, on which samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Entry {
    /// An autoregression of samples as measured.
    Raw(#[serde(serialize_with = "in_words")] Method),
    /// An autoregression of de-noised samples.
    Denoised(#[serde(serialize_with = "in_words")] Method),
    /// FOS of this cross-product degree, on samples as measured.
    Fos(usize),
}

fn in_words<S: serde::Serializer>(method: &Method, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(method)
}

impl std::fmt::Display for Entry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Raw(method) => write!(f, "{method}"),
            Self::Denoised(method) => write!(f, "de-noised, {method}"),
            Self::Fos(degree) => write!(f, "fos, CP {degree}"),
        }
    }
}

/// One method at one order. Errors in the square of the axis' unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// The method.
    pub entry: Entry,
    /// Model order: the largest output lag, L.
    pub order: u16,
    /// The result, or why there is none.
    pub result: Result<Judged, String>,
}

/// What a model does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judged {
    /// Terms, the constant apart.
    pub terms: usize,
    /// MSE on the prediction part, each method on what it was fitted to.
    pub mse_as_fitted: f64,
    /// MSE on the prediction part, samples as measured.
    pub mse_same_target: f64,
    /// MSE on the evaluation part, samples as measured.
    pub mse_evaluation: f64,
    /// `mse_as_fitted` lies below the noise floor of the samples as measured.
    pub as_fitted_below_floor: bool,
    /// `mse_same_target` does.
    pub same_target_below_floor: bool,
    /// The paper's position error from each of the two, m.
    pub position_error_as_fitted_m: Option<f64>,
    /// The same from the second.
    pub position_error_same_target_m: Option<f64>,
    /// Time of a fit, de-noising and search included, s.
    pub time_s: f64,
}

/// The comparison of one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The column.
    pub column: String,
    /// Its unit.
    pub unit: String,
    /// True sample rate, Hz.
    pub rate_hz: f64,
    /// Samples in the three parts.
    pub samples: [usize; 3],
    /// Highest frequency that de-noising keeps whole, Hz.
    pub band_hz: f64,
    /// Variance of the prediction part: the MSE of predicting its mean.
    pub variance: f64,
    /// Least MSE of any linear predictor from the series' own past, on the prediction part, with its 95 % interval.
    pub noise_floor: Option<(f64, (f64, f64))>,
    /// Every method at every order.
    pub cells: Vec<Cell>,
    /// Index of the FOS model chosen: the least MSE on the evaluation part.
    pub chosen: Option<usize>,
}

/// Why there is no comparison.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// The log cannot be split.
    #[error(transparent)]
    Split(#[from] SplitError),
    /// Nothing to predict.
    #[error("{0}: every value in the training part is the same: a stuck or unconnected axis")]
    Constant(String),
}

/// Why a cell is empty, on its way to words.
type CellError = Box<dyn std::error::Error>;

/// A fitted predictor, scaled units.
struct Predictor {
    constant: f64,
    terms: Vec<Monomial>,
    coefficients: Vec<f64>,
}

/// An axis, its samples centred and scaled by the training part.
struct Prepared<'a> {
    column: &'a str,
    samples: Vec<f64>,
    denoised: Vec<f64>,
    /// The axis' unit per scaled unit.
    scale: f64,
    split: Split,
    floor: Option<NoiseFloor>,
}

/// Compares the methods on the errors of one axis of `recording`; with the comparison, the split that it was made on.
///
/// # Errors
/// The log is too short for three parts, or the axis stuck.
pub fn compare(
    recording: &Recording,
    stillness: &Stillness,
    series: &ErrorSeries,
    settings: &Settings,
    mut progress: impl FnMut(&Cell),
) -> Result<(Comparison, Split), PaperError> {
    let rate_hz = recording.rate.true_hz;
    let split = split::split(recording, stillness, &series.values, settings)?;
    let parts = |ranges: &[Range<usize>]| -> Vec<&[f64]> {
        ranges.iter().map(|range| &series.values[range.clone()]).collect()
    };
    let train = parts(&split.train);
    let (mean, scale) = (signal::mean(&train), signal::variance(&train).sqrt());
    if scale == 0.0 {
        return Err(PaperError::Constant(series.channel.clone()));
    }
    let samples: Vec<f64> = series.values.iter().map(|value| (value - mean) / scale).collect();
    // each part on its own: none sees another
    let mut denoised = vec![f64::NAN; samples.len()];
    for range in split.parts().flatten().filter(|range| range.len() >= settings.denoising.shortest()) {
        denoised[range.clone()].copy_from_slice(&settings.denoising.denoise(&samples[range.clone()]));
    }
    let predicted = parts(&split.predict);
    let floor = noise_floor(&predicted);
    let prepared = Prepared { column: &series.channel, samples, denoised, scale, split, floor };

    let entries = Method::ALL
        .map(Entry::Denoised)
        .into_iter()
        .chain(Method::ALL.map(Entry::Raw))
        .chain((1..=settings.max_degree).map(Entry::Fos));
    let mut cells = Vec::new();
    for entry in entries {
        for order in 1..=settings.max_order {
            let judged = judge(&prepared, entry, order, settings);
            let cell = Cell { entry, order, result: judged.map_err(|error| error.to_string()) };
            progress(&cell);
            cells.push(cell);
        }
    }
    let evaluation = |cell: &Cell| match (&cell.entry, &cell.result) {
        (Entry::Fos(_), Ok(judged)) => Some(judged.mse_evaluation),
        _ => None,
    };
    let candidates = cells.iter().enumerate().filter_map(|(i, cell)| Some((i, evaluation(cell)?)));
    let chosen = candidates.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i);
    let comparison = Comparison {
        column: series.channel.clone(),
        unit: Column::named(&series.channel).unit().label().to_owned(),
        rate_hz,
        samples: prepared.split.samples(),
        band_hz: settings.denoising.band_hz(rate_hz),
        variance: signal::variance(&predicted),
        noise_floor: prepared.floor.map(|floor| (floor.variance, floor.interval)),
        cells,
        chosen,
    };
    Ok((comparison, prepared.split))
}

/// Fits and judges one model.
fn judge(
    prepared: &Prepared<'_>,
    entry: Entry,
    order: u16,
    settings: &Settings,
) -> Result<Judged, CellError> {
    let (time_s, fitted) = median_time(settings.repeats, || fit(prepared, entry, order, settings));
    let predictor = fitted?;
    // over the rows that have the largest order of samples before them, the same for all orders; in the axis' unit
    let mse = |samples: &[f64], ranges: &[Range<usize>]| -> Result<f64, CellError> {
        let rows = Rows::usable(&[samples], ranges, &[y(settings.max_order)])?;
        let Predictor { constant, terms, coefficients } = &predictor;
        let mse = refit::mean_square_error(&[samples], &rows, *constant, terms, coefficients)?;
        Ok(mse * prepared.scale * prepared.scale)
    };
    let Split { evaluate, predict, .. } = &prepared.split;
    let mse_same_target = mse(&prepared.samples, predict)?;
    let mse_as_fitted = match entry {
        Entry::Denoised(_) => mse(&prepared.denoised, predict)?,
        Entry::Raw(_) | Entry::Fos(_) => mse_same_target,
    };
    let below_floor = |mse| prepared.floor.as_ref().is_some_and(|floor| floor.is_beaten_by(mse));
    Ok(Judged {
        terms: predictor.terms.len(),
        mse_as_fitted,
        mse_same_target,
        mse_evaluation: mse(&prepared.samples, evaluate)?,
        as_fitted_below_floor: below_floor(mse_as_fitted),
        same_target_below_floor: below_floor(mse_same_target),
        position_error_as_fitted_m: position_error_m(prepared.column, mse_as_fitted),
        position_error_same_target_m: position_error_m(prepared.column, mse_same_target),
        time_s,
    })
}

/// Fits one model to the training part, all that it takes included.
fn fit(
    prepared: &Prepared<'_>,
    entry: Entry,
    order: u16,
    settings: &Settings,
) -> Result<Predictor, CellError> {
    let train = &prepared.split.train;
    let linear = |method, stretches: &[&[f64]]| -> Result<Predictor, CellError> {
        let estimate = autoregression::estimate(method, stretches, usize::from(order))?;
        let terms = (1..=order).map(|lag| vec![y(lag)]).collect();
        Ok(Predictor { constant: 0.0, terms, coefficients: estimate.coefficients })
    };
    let raw = || train.iter().map(|range| &prepared.samples[range.clone()]);
    match entry {
        Entry::Raw(method) => linear(method, &raw().collect::<Vec<_>>()),
        Entry::Denoised(method) => {
            let long = raw().filter(|stretch| stretch.len() >= settings.denoising.shortest());
            let denoised: Vec<Vec<f64>> = long.map(|stretch| settings.denoising.denoise(stretch)).collect();
            linear(method, &denoised.iter().map(Vec::as_slice).collect::<Vec<_>>())
        }
        Entry::Fos(degree) => {
            let pool = Candidates::builder().output(1..=order, degree).build()?;
            let rule = StopRule { noise: NoiseRule::ExtendedBic, ..StopRule::default() };
            let fit = fos_fit::fit::fit(&[&prepared.samples], train, &pool, &rule, settings.search)?;
            Ok(Predictor {
                constant: fit.refit.constant,
                terms: fit.terms,
                coefficients: fit.refit.coefficients,
            })
        }
    }
}

#[cfg(test)]
mod tests;

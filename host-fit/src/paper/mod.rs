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

use std::ops::Range;
use std::time::Instant;

use fos_core::y;
use serde::Serialize;

pub use figures::figures;
pub use split::{Split, SplitError};

use crate::candidates::{Candidates, CandidatesError, Monomial};
use crate::evaluate::position_error_m;
use crate::fit::autoregression::{self, Method};
use crate::fit::{AutoregressionError, FitError, NoiseRule, RefitError, Search, StopRule, refit};
use crate::moments::{Rows, SignalsError};
use crate::recording::{Recording, RecordingError};
use crate::rest::Rest;
use crate::signal;
use crate::signal::noise_floor::noise_floor;
use crate::signal::wavelet::Denoising;

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
    /// A column is not there.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The log cannot be split.
    #[error(transparent)]
    Split(#[from] SplitError),
    /// Nothing to predict.
    #[error("{0}: every value in the training part is the same: a stuck or unconnected axis")]
    Constant(String),
}

/// Why a cell is empty.
#[derive(Debug, thiserror::Error)]
enum CellError {
    #[error(transparent)]
    Autoregression(#[from] AutoregressionError),
    #[error(transparent)]
    Fit(#[from] FitError),
    #[error(transparent)]
    Candidates(#[from] CandidatesError),
    #[error(transparent)]
    Refit(#[from] RefitError),
    #[error(transparent)]
    Signals(#[from] SignalsError),
}

/// A fitted predictor, scaled units.
struct Predictor {
    constant: f64,
    terms: Vec<Monomial>,
    coefficients: Vec<f64>,
}

/// The samples of an axis, centred and scaled by the training part.
struct Scaled {
    samples: Vec<f64>,
    denoised: Vec<f64>,
    split: Split,
}

/// Compares the methods on one axis; with the comparison, the split that it was made on.
///
/// # Errors
/// The column is missing, the log too short for three parts, or the axis stuck.
pub fn compare(
    recording: &Recording,
    rest: &Rest,
    axis: &str,
    settings: &Settings,
    mut progress: impl FnMut(&Cell),
) -> Result<(Comparison, Split), PaperError> {
    let series = recording.error_series(axis)?;
    let rate_hz = recording.rate.true_hz;
    let split = split::split(recording, rest, &series.values, settings)?;
    let parts = |ranges: &[Range<usize>]| -> Vec<&[f64]> {
        ranges.iter().map(|range| &series.values[range.clone()]).collect()
    };
    let train = parts(&split.train);
    let (mean, scale) = (signal::mean(&train), signal::variance(&train).sqrt());
    if scale == 0.0 {
        return Err(PaperError::Constant(series.channel));
    }
    let samples: Vec<f64> = series.values.iter().map(|value| (value - mean) / scale).collect();
    // each part on its own: none sees another
    let mut denoised = vec![f64::NAN; samples.len()];
    for range in split.parts().flatten().filter(|range| range.len() >= settings.denoising.shortest()) {
        denoised[range.clone()].copy_from_slice(&settings.denoising.denoise(&samples[range.clone()]));
    }
    let predicted = parts(&split.predict);
    let floor = noise_floor(&predicted);
    let scaled = Scaled { samples, denoised, split };

    let methods = [Method::YuleWalker, Method::Covariance, Method::ModifiedCovariance, Method::Burg];
    let entries = methods
        .map(Entry::Denoised)
        .into_iter()
        .chain(methods.map(Entry::Raw))
        .chain((1..=settings.max_degree).map(Entry::Fos));
    let mut cells = Vec::new();
    for entry in entries {
        for order in 1..=settings.max_order {
            let judged = judge(&scaled, entry, order, settings).map(|judged| {
                let unscaled = |mse: f64| mse * scale * scale;
                let (as_fitted, same_target) =
                    (unscaled(judged.mse_as_fitted), unscaled(judged.mse_same_target));
                Judged {
                    mse_as_fitted: as_fitted,
                    mse_same_target: same_target,
                    mse_evaluation: unscaled(judged.mse_evaluation),
                    as_fitted_below_floor: floor.as_ref().is_some_and(|floor| floor.is_beaten_by(as_fitted)),
                    same_target_below_floor: floor
                        .as_ref()
                        .is_some_and(|floor| floor.is_beaten_by(same_target)),
                    position_error_as_fitted_m: position_error_m(&series.channel, as_fitted),
                    position_error_same_target_m: position_error_m(&series.channel, same_target),
                    ..judged
                }
            });
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
        unit: crate::model::unit_of(&series.channel).to_owned(),
        rate_hz,
        samples: scaled.split.samples(),
        band_hz: settings.denoising.band_hz(rate_hz),
        variance: signal::variance(&predicted),
        noise_floor: floor.map(|floor| (floor.variance, floor.interval)),
        cells,
        chosen,
    };
    Ok((comparison, scaled.split))
}

/// Fits and judges one model; scaled units, all flags down.
fn judge(scaled: &Scaled, entry: Entry, order: u16, settings: &Settings) -> Result<Judged, CellError> {
    let mut times = Vec::with_capacity(settings.repeats);
    let mut predictor = None;
    for _ in 0..settings.repeats.max(1) {
        let start = Instant::now();
        let fitted = fit(scaled, entry, order, settings)?;
        times.push(start.elapsed().as_secs_f64());
        predictor = Some(fitted);
    }
    times.sort_unstable_by(f64::total_cmp);
    let Some(predictor) = predictor else { unreachable!("fitted at least once") };
    let raw =
        |ranges: &[Range<usize>]| mean_square_error(&scaled.samples, ranges, &predictor, settings.max_order);
    let mse_same_target = raw(&scaled.split.predict)?;
    let mse_as_fitted = match entry {
        Entry::Denoised(_) => {
            mean_square_error(&scaled.denoised, &scaled.split.predict, &predictor, settings.max_order)?
        }
        Entry::Raw(_) | Entry::Fos(_) => mse_same_target,
    };
    Ok(Judged {
        terms: predictor.terms.len(),
        mse_as_fitted,
        mse_same_target,
        mse_evaluation: raw(&scaled.split.evaluate)?,
        as_fitted_below_floor: false,
        same_target_below_floor: false,
        position_error_as_fitted_m: None,
        position_error_same_target_m: None,
        time_s: times[times.len() / 2],
    })
}

/// Fits one model to the training part, all that it takes included.
fn fit(scaled: &Scaled, entry: Entry, order: u16, settings: &Settings) -> Result<Predictor, CellError> {
    let train = &scaled.split.train;
    let linear = |method, stretches: &[&[f64]]| -> Result<Predictor, CellError> {
        let estimate = autoregression::estimate(method, stretches, usize::from(order))?;
        let terms = (1..=order).map(|lag| vec![y(lag)]).collect();
        Ok(Predictor { constant: 0.0, terms, coefficients: estimate.coefficients })
    };
    let raw = || train.iter().map(|range| &scaled.samples[range.clone()]);
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
            let fit = crate::fit::fit(&[&scaled.samples], train, &pool, &rule, settings.search)?;
            Ok(Predictor {
                constant: fit.refit.constant,
                terms: fit.terms,
                coefficients: fit.refit.coefficients,
            })
        }
    }
}

/// One-step mean square error over the rows that have `max_order` samples before them, the same for all orders.
fn mean_square_error(
    samples: &[f64],
    ranges: &[Range<usize>],
    predictor: &Predictor,
    max_order: u16,
) -> Result<f64, CellError> {
    let rows = Rows::usable(&[samples], ranges, &[y(max_order)])?;
    Ok(refit::mean_square_error(
        &[samples],
        &rows,
        predictor.constant,
        &predictor.terms,
        &predictor.coefficients,
    )?)
}

#[cfg(test)]
mod tests;

//! Fits one method at one order to the training part and evaluates it on the others.

use std::ops::Range;

use fos_core::y;

use super::position_error::position_error_m;
use super::result::{Entry, Evaluated};
use super::settings::Settings;
use super::split::Split;
use crate::timing::median_time;
use fos_fit::candidates::{Candidates, Monomial};
use fos_fit::fit::{StopRule, autoregression, refit};
use fos_fit::moments::Rows;
use fos_fit::signal::noise_floor::NoiseFloor;

/// Reason for an empty cell.
pub(super) type CellError = Box<dyn std::error::Error>;

/// A fitted predictor in scaled units.
struct Predictor {
    constant: f64,
    terms: Vec<Monomial>,
    coefficients: Vec<f64>,
}

/// Samples of an axis, centred and scaled by the training part.
pub(super) struct Prepared<'a> {
    pub(super) column: &'a str,
    pub(super) samples: Vec<f64>,
    pub(super) denoised: Vec<f64>,
    /// The axis' unit per scaled unit.
    pub(super) scale: f64,
    pub(super) split: Split,
    pub(super) floor: Option<NoiseFloor>,
}

/// Fits and evaluates one model.
pub(super) fn evaluate(
    prepared: &Prepared<'_>,
    entry: Entry,
    order: u16,
    settings: &Settings,
) -> Result<Evaluated, CellError> {
    let (time_s, fitted) = median_time(settings.repeats, || fit(prepared, entry, order, settings));
    let predictor = fitted?;
    // Mean over the rows preceded by as many samples as the largest order, so the same for all orders; in the axis' unit squared.
    let mse = |samples: &[f64], ranges: &[Range<usize>]| {
        let rows = Rows::usable(&[samples], ranges, &[y(settings.max_order)]);
        let Predictor { constant, terms, coefficients } = &predictor;
        let mse = refit::mean_square_error(&[samples], &rows, *constant, terms, coefficients);
        mse * prepared.scale * prepared.scale
    };
    let Split { evaluate, predict, .. } = &prepared.split;
    let mse_same_target = mse(&prepared.samples, predict);
    let mse_as_fitted = match entry {
        Entry::Denoised(_) => mse(&prepared.denoised, predict),
        Entry::Raw(_) | Entry::Fos(_) => mse_same_target,
    };
    let below_floor = |mse| prepared.floor.as_ref().is_some_and(|floor| floor.is_beaten_by(mse));
    Ok(Evaluated {
        terms: predictor.terms.len(),
        mse_as_fitted,
        mse_same_target,
        mse_evaluation: mse(&prepared.samples, evaluate),
        as_fitted_below_floor: below_floor(mse_as_fitted),
        same_target_below_floor: below_floor(mse_same_target),
        position_error_as_fitted_m: position_error_m(prepared.column, mse_as_fitted),
        position_error_same_target_m: position_error_m(prepared.column, mse_same_target),
        time_s,
    })
}

/// Fits one model to the training part, with all necessary preparation.
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
            let samples = &[&prepared.samples[..]];
            let fit = fos_fit::fit::fit(samples, train, &pool, &StopRule::default(), settings.search)?;
            Ok(Predictor {
                constant: fit.refit.constant,
                terms: fit.terms,
                coefficients: fit.refit.coefficients,
            })
        }
    }
}

//! How far a curve that was fitted may be followed outside what was fitted.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use crate::effects::{Inputs, Regressor};
use fos_data::recording::RecordingError;

/// Steps outwards, as shares of the width of the fitted range, and how many. The first is always granted: the noise and
/// the steps of a thermometer are no extrapolation.
const STEP: f64 = 0.05;
const STEPS: i32 = 5;

/// What a curve adds beyond the edge must be so many standard errors: below, what it holds at the edge is the better
/// guess.
const TRUSTED: f64 = 3.0;

/// The range of each input that a power is taken of, widened as long as what the curve adds to its value at the edge is
/// known: of a cubic nothing is known far outside. `coefficients` and their `covariance` are those of `regressors`.
///
/// # Errors
///
/// A column is missing.
pub(super) fn limits(
    inputs: &Inputs<'_>,
    regressors: &[Regressor],
    coefficients: &DVector<f64>,
    covariance: &DMatrix<f64>,
) -> Result<BTreeMap<String, [f64; 2]>, RecordingError> {
    let mut limits = BTreeMap::new();
    for spec in regressors.iter().flat_map(Regressor::powers) {
        let name = spec.to_string();
        if limits.contains_key(&name) {
            continue;
        }
        let [low, high] = range(&inputs.input(spec)?);
        if low >= high {
            continue;
        }
        let mut means = BTreeMap::new();
        for input in regressors.iter().flat_map(Regressor::inputs) {
            means.insert(input.to_string(), mean(&inputs.input(input)?));
        }
        let at = |x: f64| {
            let value = |input: &str| if input == name { x } else { means[input] };
            DVector::from_iterator(regressors.len(), regressors.iter().map(|regressor| regressor.at(value)))
        };
        let walked = |edge: f64, outwards: f64| {
            let trusted = |step: &i32| {
                let further = at(edge + f64::from(*step) * outwards) - at(edge);
                let variance = (covariance * &further).dot(&further);
                *step == 1 || coefficients.dot(&further).powi(2) > TRUSTED * TRUSTED * variance
            };
            edge + outwards * f64::from((1..=STEPS).take_while(trusted).count() as u32)
        };
        let outwards = STEP * (high - low);
        let widened = [walked(low, -outwards), walked(high, outwards)];
        limits.insert(name, widened);
    }
    Ok(limits)
}

fn finite(values: &[f64]) -> impl Iterator<Item = f64> {
    values.iter().copied().filter(|value| value.is_finite())
}

fn range(values: &[f64]) -> [f64; 2] {
    finite(values)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

fn mean(values: &[f64]) -> f64 {
    finite(values).sum::<f64>() / finite(values).count().max(1) as f64
}

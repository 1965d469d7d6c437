//! Range in which a fitted curve may be extrapolated.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use crate::effects::{Inputs, Regressor};
use fos_data::recording::RecordingError;

/// Width of a step outwards as a share of the fitted range, and the number of steps. The first step is always granted:
/// the noise and the steps of a thermometer are not extrapolation.
const STEP: f64 = 0.05;
const STEPS: i32 = 5;

/// Change of the curve beyond the edge, in standard errors, from which on it is trusted. Below, its value at the edge
/// is the better estimate.
const TRUSTED: f64 = 3.0;

/// Returns the fitted range of each input that occurs as a power, widened as long as the change of the curve from its
/// value at the edge is significant: a cubic is undetermined far outside. `coefficients` and `covariance` are those of
/// `regressors`.
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

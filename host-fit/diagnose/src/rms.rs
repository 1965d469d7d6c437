//! Reductions of an RMS, beside the shares of variance in JSON: `rms_reduction` is 1 − √(1 − share).

use serde::Serialize;

/// The reduction of an RMS that goes with this reduction of its square, a variance.
pub fn rms_reduction(of_variance: f64) -> f64 {
    1.0 - (1.0 - of_variance).max(0.0).sqrt()
}

/// A value with its reductions as RMS.
#[derive(Serialize)]
pub(crate) struct WithRms<'a, T> {
    #[serde(flatten)]
    pub(crate) of: &'a T,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) rms_before: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) rms_after: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) rms_reduction: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) rms_reduction_interval: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) measured_rms_reduction: Option<f64>,
}

impl<'a, T> WithRms<'a, T> {
    pub(crate) fn new(of: &'a T) -> Self {
        Self {
            of,
            rms_before: None,
            rms_after: None,
            rms_reduction: None,
            rms_reduction_interval: None,
            measured_rms_reduction: None,
        }
    }
}

//! RMS reductions, which JSON states beside shares of variance: `rms_reduction` is 1 − √(1 − share).

use serde::Serialize;

/// Converts a reduction of a variance to the reduction of its RMS.
pub fn rms_reduction(of_variance: f64) -> f64 {
    1.0 - (1.0 - of_variance).max(0.0).sqrt()
}

/// RMS values that JSON states beside the variances they are computed from.
#[derive(Default, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS), ts(optional_fields))]
pub(crate) struct RmsTwins {
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

/// A value together with its reductions as RMS.
#[derive(Serialize)]
pub(crate) struct WithRms<'a, T> {
    #[serde(flatten)]
    pub(crate) of: &'a T,
    #[serde(flatten)]
    pub(crate) twins: RmsTwins,
}

/// TypeScript type of a value with its RMS values: ts-rs does not flatten generic fields.
#[cfg(feature = "page-types")]
macro_rules! twinned {
    ($name:ident, $of:ty) => {
        #[derive(ts_rs::TS)]
        #[allow(dead_code, reason = "only its TypeScript type is of use")]
        pub(crate) struct $name {
            #[ts(flatten)]
            of: $of,
            #[ts(flatten)]
            twins: crate::rms::RmsTwins,
        }
    };
}
#[cfg(feature = "page-types")]
pub(crate) use twinned;

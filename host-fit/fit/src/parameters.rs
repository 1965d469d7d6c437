//! Parameters of an axis as stored in a study.

use fos_core::{Axis, AxisParameters, InnovationStatistics, Range};
use serde::{Deserialize, Serialize};

/// Studies of earlier versions have no range of p: it is then unlimited, and not written.
#[derive(Serialize, Deserialize)]
#[serde(remote = "AxisParameters::<f64>")]
pub(crate) struct StoredParameters {
    axis: Axis,
    reference: f64,
    offset: f64,
    scale: f64,
    constant: f64,
    range: Range<f64>,
    #[serde(default = "Range::unlimited", skip_serializing_if = "is_unlimited")]
    physical_range: Range<f64>,
    full_scale: f64,
    #[serde(rename = "stuck_after")]
    stuck_after_repeats: u16,
    #[serde(rename = "gap_limit")]
    gap_limit_samples: u8,
    coast_limit_s: f64,
    innovation: InnovationStatistics<f64>,
}

fn is_unlimited(range: &Range<f64>) -> bool {
    *range == Range::unlimited()
}

//! User's options for reading a log.

use serde::{Deserialize, Serialize};

use super::column_map::ColumnMap;
use super::format::Format;

/// Options for reading a log. The default suits a log with the columns of the log format.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(default)]
pub struct LoadOptions {
    /// Channel and unit of each column.
    #[cfg_attr(feature = "page-types", ts(as = "Vec<String>"))]
    pub columns: ColumnMap,
    /// Sampling rate, Hz; needed if the log has no timestamps, and overrides timestamps that show another rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "page-types", ts(optional))]
    pub rate_hz: Option<f64>,
    /// Format, unless it is to be recognised by content.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "page-types", ts(optional, as = "Option<String>"))]
    pub format: Option<Format>,
    /// Choice among several sensors of a log: number of an instance, or name of a topic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "page-types", ts(optional))]
    pub topic: Option<String>,
    /// Reject the first unusable row instead of skipping up to [`MAX_UNUSABLE`](super::MAX_UNUSABLE) of them. Not
    /// stored in a study: a log that was read once can be read again, however strictly.
    #[serde(skip)]
    pub strict: bool,
    /// Include rows with detected motion although the device should be at rest.
    #[serde(default, skip_serializing_if = "is_false")]
    pub keep_moved: bool,
}

fn is_false(value: &bool) -> bool {
    !value
}

/// States whether axes of a table may have separate rates; after resampling they do not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MayHaveRates {
    Yes,
    No,
}

//! How a log is read, as the user says.

use serde::{Deserialize, Serialize};

use super::column_map::ColumnMap;
use super::format::Format;

/// How a log is read. The default suits a log with the columns of the log format.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(default)]
pub struct LoadOptions {
    /// Which column is which channel, in what unit.
    #[cfg_attr(feature = "page-types", ts(as = "Vec<String>"))]
    pub columns: ColumnMap,
    /// Sample rate, Hz; needed if the log has no time stamps, and replaces stamps that show another rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "page-types", ts(optional))]
    pub rate_hz: Option<f64>,
    /// The format, where it is not to be found by the content.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "page-types", ts(optional, as = "Option<String>"))]
    pub format: Option<Format>,
    /// Which of several sensors, where a log has more than one: the number of an instance, the name of a topic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "page-types", ts(optional))]
    pub topic: Option<String>,
    /// Refuse the first row that cannot be used, instead of skipping up to
    /// [`MAX_UNUSABLE`](super::MAX_UNUSABLE) of them. No study remembers it: a log that was read once is read again,
    /// however strictly.
    #[serde(skip)]
    pub strict: bool,
    /// Count the rows in which the unit was moved as any others, though it was meant to be at rest.
    #[serde(default, skip_serializing_if = "is_false")]
    pub keep_moved: bool,
}

fn is_false(value: &bool) -> bool {
    !value
}

/// Whether axes of a table may have rates of their own: once they are resampled they have not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MayHaveRates {
    Yes,
    No,
}

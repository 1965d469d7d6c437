//! One sensor's samples, with stamps of its own.

/// What one sensor gave, before it is joined with others onto one sample grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream {
    /// As the file names it, as `sensor_gyro 0`.
    pub name: String,
    /// The stamp of every sample, ns since a moment that all streams of a log share.
    pub stamps_ns: Vec<i64>,
    /// Channels named as in the log format and in its units (`gx_rads`, `temp_c`), one value per stamp; NaN: none.
    pub columns: Vec<(String, Vec<f64>)>,
}

/// Stamps in s as ns; none where there is none, or one beyond 292 years.
pub(super) fn stamps(seconds: &[f64]) -> Vec<Option<i64>> {
    let ns = seconds.iter().map(|seconds| (seconds * 1e9).round());
    ns.map(|ns| (ns.abs() < i64::MAX as f64).then_some(ns as i64)).collect()
}

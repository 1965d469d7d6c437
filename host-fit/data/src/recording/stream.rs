//! Samples of one sensor with separate timestamps.

/// Samples of one sensor, before they are resampled to a common time base.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream {
    /// Name in the file, such as `sensor_gyro 0`.
    pub name: String,
    /// Timestamp of every sample, ns since an epoch common to all streams of a log.
    pub stamps_ns: Vec<i64>,
    /// Channels named as in the log format and in its units (`gx_rads`, `temp_c`), one value per timestamp; NaN if
    /// missing.
    pub columns: Vec<(String, Vec<f64>)>,
}

/// Timestamps in s converted to ns; `None` for a missing one, or one beyond 292 years.
pub(super) fn stamps(seconds: &[f64]) -> Vec<Option<i64>> {
    let ns = seconds.iter().map(|seconds| (seconds * 1e9).round());
    ns.map(|ns| (ns.abs() < i64::MAX as f64).then_some(ns as i64)).collect()
}

//! Summary of a log.

use fos_data::column::Column;
use serde::Serialize;

use fos_data::disturbance;
use fos_data::recording::Recording;
use fos_data::stillness::{self, KnownBy};
use fos_diagnose::refine::Logs;

use fos_figures::{Shading, moved};

/// Summary of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct LogSummary {
    /// Path that the log was read from.
    pub path: String,
    /// SHA-256 of the file, hexadecimal; of the first one if there are several.
    pub sha256: String,
    /// Number of samples, of all segments together.
    pub rows: usize,
    /// Time from the first sample to the last, s.
    pub seconds: f64,
    /// First timestamp, s.
    pub from_s: f64,
    /// Last timestamp, s.
    pub to_s: f64,
    /// True sampling rate, Hz.
    pub rate_hz: f64,
    /// Number of gap-free segments.
    pub segments: usize,
    /// Number of samples missing between the segments.
    pub missing: u64,
    /// Share of the rows in which the device is still.
    pub still_share: f64,
    /// Source of `still_share`.
    pub still_known_by: KnownBy,
    /// Channels of the log.
    pub columns: Vec<ColumnSummary>,
    /// Notes on quality, a line each: recognised format, alignment of streams, defects, detected motion, cautions.
    pub quality: Vec<String>,
    /// Detected motion of a device meant to be at rest, shaded wherever the log is drawn over time.
    pub moved: Shading,
}

/// Summaries of the logs of a study.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Summaries {
    /// Log to explain.
    pub log: LogSummary,
    /// Reference log; none if not given.
    pub reference: Option<LogSummary>,
    /// Evaluation log; none if not given.
    pub evaluation: Option<LogSummary>,
}

impl Summaries {
    /// Summarises the logs of a study.
    pub fn of(logs: &Logs) -> Self {
        Self {
            log: LogSummary::of(&logs.log),
            reference: logs.reference.as_ref().map(LogSummary::of),
            evaluation: logs.evaluation.as_ref().map(LogSummary::of),
        }
    }
}

/// A channel of a log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct ColumnSummary {
    /// Name of the column, such as `gx_rads`.
    pub name: String,
    /// Unit of the values, such as `rad/s`.
    pub unit: &'static str,
}

impl LogSummary {
    /// Summarises a recording.
    fn of(log: &Recording) -> Self {
        let stillness = stillness::find(log);
        let still = stillness.still.iter().filter(|still| **still).count();
        let (from_s, to_s) = (log.time_s.first().copied(), log.time_s.last().copied());
        let (from_s, to_s) = (from_s.unwrap_or(0.0), to_s.unwrap_or(0.0));
        let column =
            |name: &String| ColumnSummary { name: name.clone(), unit: Column::named(name).unit().label() };
        let quality = log.quality.to_string();
        let joined = log.alignment.as_ref().map_or_else(String::new, ToString::to_string);
        let read_as =
            log.sources.iter().filter_map(|source| source.read_as.as_ref()).map(ToString::to_string);
        let quality = read_as.chain(joined.lines().chain(quality.lines()).map(str::to_owned));
        let motion = disturbance::describe_disturbances(log, &stillness.disturbances)
            .into_iter()
            .map(|moved| format!("motion: {moved}"));
        let warnings =
            log.warnings(&stillness.still).into_iter().map(|warning| format!("caution: {warning}"));
        Self {
            path: log.paths(),
            sha256: log.sources.first().map_or_else(String::new, |source| source.sha256.clone()),
            rows: log.n_rows(),
            seconds: log.duration_s(),
            from_s,
            to_s,
            rate_hz: log.rate.true_hz,
            segments: log.segments.len(),
            missing: log.samples_missing(),
            still_share: still as f64 / log.n_rows().max(1) as f64,
            still_known_by: stillness.known_by,
            columns: log.channels().iter().map(|channel| column(&channel.name)).collect(),
            quality: quality.chain(motion).chain(warnings).collect(),
            moved: moved(log, &stillness),
        }
    }
}

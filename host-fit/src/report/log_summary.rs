//! A log in a few facts.

use fos_data::column::Column;
use serde::Serialize;

use fos_data::disturbance;
use fos_data::recording::Recording;
use fos_data::stillness::{self, KnownBy};
use fos_diagnose::refine::Logs;

use crate::figures::{Shading, moved};

/// A log in a few facts.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LogSummary {
    /// Where it was read from.
    pub path: String,
    /// Digest of the file.
    pub sha256: String,
    /// Samples that were read, of all segments together.
    pub rows: usize,
    /// From the first sample to the last, s.
    pub seconds: f64,
    /// First stamp, s.
    pub from_s: f64,
    /// Last stamp, s.
    pub to_s: f64,
    /// True sample rate, Hz.
    pub rate_hz: f64,
    /// Stretches without gaps.
    pub segments: usize,
    /// Samples missing between them.
    pub missing: u64,
    /// Share of the rows in which the unit is still.
    pub still_share: f64,
    /// How that is known.
    pub still_known_by: KnownBy,
    /// Its channels.
    pub columns: Vec<ColumnSummary>,
    /// As what it was read, how its streams were joined, and what was wrong with it, a line each.
    pub quality: Vec<String>,
    /// Where the unit was moved though it was meant to be at rest, as it is shaded wherever the log is drawn over time.
    pub moved: Shading,
}

/// The logs of a study in a few facts.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Summaries {
    /// The log where the model fails.
    pub field: LogSummary,
    /// A log in which nothing is missing; absent where none was given.
    pub quiet: Option<LogSummary>,
    /// The log that errors are of.
    pub judged: Option<LogSummary>,
}

impl Summaries {
    /// Of the logs of a study.
    pub fn of(logs: &Logs) -> Self {
        Self {
            field: LogSummary::of(&logs.field),
            quiet: logs.quiet.as_ref().map(LogSummary::of),
            judged: logs.judged.as_ref().map(LogSummary::of),
        }
    }
}

/// A channel of a log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ColumnSummary {
    /// Its column, as `gx_rads`.
    pub name: String,
    /// Unit that its values are in, as `rad/s`.
    pub unit: &'static str,
}

impl LogSummary {
    /// Of a recording.
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
        let told = disturbance::describe_disturbances(log, &stillness.disturbances)
            .into_iter()
            .map(|told| format!("moved: {told}"));
        let oddities = log.oddities(&stillness.still).into_iter().map(|oddity| format!("caution: {oddity}"));
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
            quality: quality.chain(told).chain(oddities).collect(),
            moved: moved(log, &stillness),
        }
    }
}

//! Measured data: channels with units on a regular sample grid, in segments without gaps.
//!
//! [`load`] reads CSV, gzip'd CSV and Parquet with the columns of the log format (`t_s`, `ax_mps2` … `gz_rads`,
//! `temp_c`, …; a [`ColumnMap`] names and converts others) into a [`Recording`]; [`write_columns`] writes.
//! [`Recording::from_streams`] resamples sensors with separate timestamps and rates; `streams/mod.rs` documents the
//! method, and the [`Alignment`] of a log its result. Rules for the defects of real logs:
//!
//! | in the log | treatment |
//! |---|---|
//! | samples missing | the segment ends; [`Segment`] documents the distinction from jitter and bursts |
//! | nothing for ten seconds or more, or pauses of a duty-cycled log (5 s of every 300 s; 3 s of every 6 s at regular intervals) | the segment ends; a pause, in which no sample is missing; the rate is that between pauses |
//! | a stated rate that differs by 7 % from that of the timestamps, or timestamps that cannot be time | the rows count in their order, at the stated rate; both are printed |
//! | a temperature that changes faster than 5 K/s, timestamps rounded by a spreadsheet, a clock that ticks slower than the sensor samples | warning, with the remedy |
//! | a thermometer shows 0, 85, −127 or −273(.15) °C, the values of a failed read, and 5 K from it before and after | NaN there, counted, and reported as a warning |
//! | a thermometer shows one of these values in every row | the column is excluded, with a warning |
//! | time goes back by more than a sample, and stays back | the segment ends; counted |
//! | a row repeats the timestamp and all inertial channels of the previous one | dropped and counted; kept if over 10 % of timestamps repeat (coarse clock) |
//! | a timestamp repeats, the sample differs | kept and counted |
//! | a cell is empty, NaN or infinite | NaN in that channel, counted; the row stays |
//! | a cell is no number, a row is too short or long, a timestamp is missing | row skipped, counted, the first five located; it is a missing sample |
//! | over 5 % of rows are like that, or one in strict mode | rejected |
//! | an axis has a value in every second to twentieth row, or the rows of two sensors alternate | the streams that the table was merged from, resampled to the rows of the fastest |
//! | timestamps and values of every second row differ | rejected: two alternating devices |
//! | no cell of an axis is a number | the axis is excluded and reported |
//! | a column holds text | ignored and listed (`segment`: its labels count) |
//! | the value of `segment` changes | the segment ends |
//! | `still` is above 0.5 | the sensor is known to be still |
//! | timestamps that give fewer than 0.01 or more than 10⁶ samples a second | rejected: in another unit |
//! | no `t_s` | row number over the stated rate, else rejected |

mod cell;
mod channel;
mod clock_check;
mod coarse;
mod column_map;
mod column_words;
mod csv_file;
mod detected;
mod duty_cycle;
mod error;
mod error_series;
mod failed_reads;
mod format;
mod gaps;
mod grid;
mod guess;
#[cfg(feature = "gzip")]
mod gzip;
mod header;
mod held;
mod interleaved;
mod join;
mod load;
mod load_options;
mod other_format;
mod own_rate;
#[cfg(feature = "parquet")]
mod parquet_file;
#[cfg(feature = "parquet")]
mod parquet_input;
#[cfg(feature = "parquet")]
mod parquet_write;
mod preview;
mod provenance;
mod quality;
mod rate;
mod sanity;
mod sensor;
mod source;
mod stream;
mod streams;
mod table;
mod unusable;
mod write;

#[cfg(test)]
mod detected_tests;
#[cfg(test)]
mod gap_tests;
#[cfg(all(test, feature = "gzip", feature = "parquet"))]
mod generated_log_tests;
#[cfg(test)]
mod load_tests;
#[cfg(test)]
mod pause_tests;
#[cfg(test)]
mod real_log_tests;

use std::ops::Range;

use crate::closest::closest;
use crate::column::{AXES, Column};

pub use channel::Channel;
pub use clock_check::ClockProblem;
pub use column_map::{ColumnMap, MapError};
pub(crate) use detected::{Detected, Marks};
pub use detected::{Disturbance, Kind, KnownBy, Stillness};
pub use duty_cycle::DutyCycle;
pub use error::RecordingError;
pub use error_series::{ErrorSeries, Reference};
pub use failed_reads::FailedReads;
pub use format::{Format, FormatKnowledge, KNOWN_FORMATS, LOG_ENDINGS, ReadAs, UnknownFormat, may_be_log};
pub use grid::{Boundary, Segment};
pub use held::back_filled;
pub use load::load;
pub use load_options::LoadOptions;
pub use preview::{ColumnPreview, Preview, preview};
pub use provenance::{Frame, Provenance, SensorProvenance, Values};
pub use quality::{BadRow, MissingCells, Place, Problem, Quality};
pub use rate::{RATES_HZ, Rate, Stamps};
pub use sanity::LogWarning;
pub use source::Source;
pub use stream::Stream;
pub use streams::{Alignment, Apart, Clocks, HowJoined, JoinedStream};
pub use unusable::MAX_UNUSABLE;
pub use write::{check_log_path, write_columns};

/// Measured data of one sensor. All columns have one length, [`Recording::n_rows`].
#[derive(Clone, Debug)]
pub struct Recording {
    /// Source files: one, or several that were joined.
    pub sources: Vec<Source>,
    pub time_s: Vec<f64>,
    channels: Vec<Channel>,
    /// Stretches without gaps, in order, covering all rows. Nothing is fitted or predicted across two.
    pub segments: Vec<Segment>,
    pub rate: Rate,
    /// Rows in which the device is known to be still; `None` if the log does not state it.
    pub still: Option<Vec<bool>>,
    /// Rows from which gravity may have a different direction; not stated by a log.
    pub turns: Vec<usize>,
    /// True if rows with detected motion are used like any others.
    pub keeps_moved: bool,
    pub quality: Quality,
    /// Resampling of its streams, if they had separate timestamps.
    pub alignment: Option<Alignment>,
    pub(crate) detected: Detected,
}

impl Recording {
    /// Number of samples, of all segments together.
    pub fn n_rows(&self) -> usize {
        self.time_s.len()
    }

    /// All channels, in the order of the file.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Channel of this name.
    ///
    /// # Errors
    /// No such channel (the error lists the channels and the most similar name), or an axis without a single number.
    pub fn channel(&self, name: &str) -> Result<&Channel, RecordingError> {
        self.channels.iter().find(|channel| channel.name == name).ok_or_else(|| {
            if self.quality.empty_axes.iter().any(|axis| axis == name) {
                return self.no_values(name);
            }
            // columns that may be axes, but state no unit: the error has the entries of a column map for them
            if AXES.contains(&name)
                && !self.quality.perhaps.is_empty()
                && let Err(no_axes) = self.axes()
            {
                return no_axes;
            }
            let available: Vec<String> = self.channels.iter().map(|channel| channel.name.clone()).collect();
            let closest = closest(name, available.iter().map(String::as_str)).map(str::to_owned);
            RecordingError::NoChannel { name: name.to_owned(), closest, available }
        })
    }

    fn no_values(&self, name: &str) -> RecordingError {
        RecordingError::NoValues { path: self.paths(), name: name.to_owned(), rows: self.n_rows() }
    }

    /// Usable inertial channels: those with a number, and with one in their reference if they have one.
    pub fn axes(&self) -> Result<Vec<String>, RecordingError> {
        let has_values = |channel: &Channel| channel.values.iter().any(|value| value.is_finite());
        let lacks = |axis: &str| -> Option<String> {
            let reference = Column::named(axis).reference();
            let columns = [axis.to_owned(), reference].into_iter();
            let mut channels = columns.filter_map(|name| self.channels.iter().find(|c| c.name == name));
            channels.find(|channel| !has_values(channel)).map(|channel| channel.name.clone())
        };
        let there = AXES.into_iter().filter(|axis| self.channels.iter().any(|c| c.name == *axis));
        let (axes, hollow): (Vec<&str>, Vec<&str>) = there.partition(|axis| lacks(axis).is_none());
        if axes.is_empty() {
            let hollow = hollow.first().and_then(|axis| lacks(axis));
            if let Some(name) = hollow.as_ref().or(self.quality.empty_axes.first()) {
                return Err(self.no_values(name));
            }
            let text_columns = self.quality.text_columns.clone();
            let first = self.quality.first_text.clone().map(Box::new);
            let perhaps = self.quality.perhaps.clone();
            return Err(RecordingError::NoAxes { path: self.paths(), text_columns, first, perhaps });
        }
        Ok(axes.into_iter().map(str::to_owned).collect())
    }

    /// Segments of the first `fraction` of all rows, and segments of the remaining rows: contiguous, never shuffled. A
    /// segment at the cut is split in two. `fraction` is clamped to 0 … 1.
    pub fn split(&self, fraction: f64) -> (Vec<Range<usize>>, Vec<Range<usize>>) {
        let cut = (fraction.clamp(0.0, 1.0) * self.n_rows() as f64).round() as usize;
        let part = |from: usize, to: usize| {
            let rows = self.segments.iter().map(|s| s.rows.start.max(from)..s.rows.end.min(to));
            rows.filter(|rows| !rows.is_empty()).collect()
        };
        (part(0, cut), part(cut, self.n_rows()))
    }

    /// First `rows` rows as a separate recording.
    pub fn first_rows(&self, rows: usize) -> Self {
        let rows = rows.min(self.n_rows());
        let first = |values: &[f64]| values[..rows].to_vec();
        let channels = self.channels.iter();
        let segments = self.segments.iter().filter(|segment| segment.rows.start < rows);
        Self {
            sources: self.sources.clone(),
            time_s: first(&self.time_s),
            channels: channels.map(|c| Channel { values: first(&c.values).into(), ..c.clone() }).collect(),
            segments: segments
                .map(|s| Segment { rows: s.rows.start..s.rows.end.min(rows), ..s.clone() })
                .collect(),
            rate: self.rate.clone(),
            still: self.still.as_ref().map(|still| still[..rows].to_vec()),
            turns: self.turns.iter().copied().filter(|turn| *turn < rows).collect(),
            keeps_moved: self.keeps_moved,
            quality: self.quality.clone(),
            alignment: self.alignment.clone(),
            detected: Detected::default(),
        }
    }

    /// Copy with other values in a channel, one per row; an unchanged copy without such a channel.
    pub fn with_values(&self, name: &str, values: Vec<f64>) -> Self {
        let mut other = Self { detected: Detected::default(), ..self.clone() };
        if let Some(channel) = other.channels.iter_mut().find(|channel| channel.name == name) {
            channel.values = values.into();
        }
        other
    }

    /// Copy with other rows at rest, and other rows from which gravity may have turned.
    pub fn with_rests(&self, still: Vec<bool>, turns: Vec<usize>) -> Self {
        Self { still: Some(still), turns, detected: Detected::default(), ..self.clone() }
    }

    /// Duration by the sample grid, s: timestamps may go back.
    pub fn duration_s(&self) -> f64 {
        let last = self.segments.last().map_or(0, |last| last.tick + last.rows.len() as u64);
        last.saturating_sub(1) as f64 * self.rate.period_s
    }

    /// Number of lost samples, not counting pauses.
    pub fn samples_missing(&self) -> u64 {
        let lossy = self.segments.iter().filter(|segment| segment.boundary != Boundary::Pause);
        lossy.map(|segment| segment.missing_before).sum()
    }

    /// Same recording with monotonic time: a segment stamped as if it began before the end of the previous one is
    /// shifted.
    pub fn with_monotonic_time(mut self) -> Self {
        let period_s = self.rate.period_s;
        let mut shift_s = 0.0;
        let mut ended_s = f64::NEG_INFINITY;
        for segment in &self.segments {
            let times = &mut self.time_s[segment.rows.clone()];
            let begins_s = level(times.iter().copied(), period_s) + shift_s;
            if begins_s < ended_s - 0.5 * period_s {
                shift_s += ended_s + period_s - begins_s;
            }
            times.iter_mut().for_each(|time_s| *time_s += shift_s);
            ended_s = -level(times.iter().rev().map(|time_s| -time_s), period_s);
        }
        self
    }

    /// Stretches of rows at rest, none across two segments; all segments if the log does not state it.
    pub fn still_rows(&self) -> Vec<Range<usize>> {
        self.stretches_where(|row| self.still.as_ref().is_none_or(|still| still[row]))
    }

    /// Stretches of consecutive rows for which `holds` is true, none across two segments.
    pub fn stretches_where(&self, holds: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
        self.segments.iter().flat_map(|segment| runs(segment.rows.clone(), &holds)).collect()
    }

    /// Paths of the sources, separated by commas.
    pub fn paths(&self) -> String {
        self.sources.iter().map(|source| source.path.as_str()).collect::<Vec<_>>().join(", ")
    }
}

/// Time of the first row, as a median over several rows a period apart: a single timestamp may be wrong.
fn level(times: impl Iterator<Item = f64>, period_s: f64) -> f64 {
    let mut levels: Vec<f64> =
        times.take(9).enumerate().map(|(row, time_s)| time_s - row as f64 * period_s).collect();
    crate::statistics::median(&mut levels)
}

/// Splits ranges into pieces of `length`, each from its own begin; the last of each may be shorter.
pub fn pieces(ranges: &[Range<usize>], length: usize) -> Vec<Range<usize>> {
    let of = |range: &Range<usize>| {
        let end = range.end;
        range.clone().step_by(length).map(move |start| start..(start + length).min(end))
    };
    ranges.iter().flat_map(of).collect()
}

/// Longest ranges within `rows` in which `holds` for every row, in order.
pub fn runs(rows: Range<usize>, holds: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for row in rows.filter(|row| holds(*row)) {
        match runs.last_mut() {
            Some(last) if last.end == row => last.end += 1,
            _ => runs.push(row..row + 1),
        }
    }
    runs
}

//! Streams with separate timestamps, resampled to a common time base: a lead whose timestamps are the rows, and the
//! values of the other streams there.
//!
//! | stream | treatment |
//! |---|---|
//! | inertial, of the highest rate | the lead, unchanged: interpolation to a higher rate keeps the density of slow noise; decimation would fold fast noise into it |
//! | with the timestamps of the lead | joined unchanged, to the last bit |
//! | other inertial ones, and their true values | interpolated by [`fos_core::align::Aligner`], missing where a sample is lost |
//! | everything else | held, missing when older than three of its periods |
//! | a single stream | unchanged |
//!
//! The clocks of an accelerometer and a gyro are aligned if the motion of the device determines their offset
//! (`clocks.rs`), and treated as one otherwise.
//!
//! Timestamps out of order are sorted if they are at most a second back; duplicates and samples with an isolated wrong
//! timestamp are excluded; a clock that was set back is rejected.

mod alignment;
mod beside;
mod clocks;
mod follow;
mod hold;
mod lead;
mod order;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::error::RecordingError;
use super::load_options::MayHaveRates;
use super::source::Source;
use super::{LoadOptions, Recording, Stream};
use crate::column::{ACCELEROMETERS, GYROS};
use beside::Beside;
use lead::Group;

pub use alignment::{Alignment, HowJoined, JoinedStream};
pub use clocks::{Apart, Clocks};
pub(super) use follow::is_followed;

/// Columns of equal length; the first is `t_s`.
#[derive(Debug)]
pub(super) struct Joined {
    pub(super) columns: Vec<(String, Vec<f64>)>,
    pub(super) alignment: Alignment,
}

impl Recording {
    /// Builds a recording from streams with separate timestamps, resampled at those of the fastest inertial one.
    ///
    /// # Errors
    /// Columns longer or shorter than their timestamps, timestamps far out of order, and errors of
    /// [`Recording::from_columns`].
    pub fn from_streams(
        source: Source,
        streams: Vec<Stream>,
        options: &LoadOptions,
    ) -> Result<Self, RecordingError> {
        let Joined { columns, alignment } = join(Path::new(&source.path), streams)?;
        let mut recording = Self::of_columns(source, columns, options, MayHaveRates::No)?;
        recording.alignment = (!alignment.others.is_empty()).then_some(alignment);
        Ok(recording)
    }
}

/// Joins streams into the columns of one table. `path` is for errors.
pub(super) fn join(path: &Path, streams: Vec<Stream>) -> Result<Joined, RecordingError> {
    for stream in &streams {
        let expected = stream.stamps_ns.len();
        if let Some((name, values)) = stream.columns.iter().find(|(_, values)| values.len() != expected) {
            return Err(RecordingError::Lengths { name: name.clone(), expected, found: values.len() });
        }
    }
    let mut groups = lead::groups(streams);
    if let Some(empty) =
        groups.iter().position(|group| group.stamps_ns.is_empty()).filter(|_| groups.len() > 1)
    {
        // all empty ones have the same timestamps
        groups.remove(empty);
    }
    let several = groups.len() > 1;
    if several {
        for group in &mut groups {
            order::sort(path, group)?;
        }
    }
    let Some(leads) = lead::choose(&groups) else {
        return Err(RecordingError::TooFewRows { path: path.to_owned(), rows: 0 });
    };
    let lead = groups.remove(leads);
    let mut alignment = Alignment::led_by(&lead);
    let mut columns = Vec::new();
    for mut group in groups {
        crate::interrupt::check();
        let (period_ns, rate_hz) = (group.period_ns(), group.rate_hz());
        let clocks = apart(&group, &lead, period_ns.unwrap_or(0));
        if let Some(Clocks::Apart(apart)) = clocks.filter(|clocks| clocks.is_applied()) {
            apart.add_to(&mut group.stamps_ns);
        }
        let (followed, held): (Vec<_>, Vec<_>) =
            group.columns.into_iter().partition(|(name, _)| is_followed(name));
        let mut note = |how, rows_missing| {
            alignment.others.push(JoinedStream {
                name: group.name.clone(),
                rate_hz,
                how,
                rows_missing,
                samples_sorted: group.sorted,
                samples_dropped: group.dropped,
            });
        };
        let beside = Beside { lead_ns: &lead.stamps_ns, stamps_ns: &group.stamps_ns, period_ns };
        if !followed.is_empty() {
            let done = follow::onto(beside, followed);
            columns.extend(done.columns);
            note(HowJoined::Interpolated { noise_kept: done.noise_kept, clocks }, done.rows_missing);
        }
        if !held.is_empty() {
            let done = hold::onto(beside, held);
            columns.extend(done.columns);
            note(HowJoined::Held { mean_age_s: done.mean_age_s }, done.rows_missing);
        }
    }
    let Group { stamps_ns, columns: of_lead, .. } = lead;
    let time = ("t_s".to_owned(), seconds(&stamps_ns));
    let columns = std::iter::once(time).chain(of_lead).chain(columns).collect();
    Ok(Joined { columns, alignment })
}

/// Clock offset of a stream from the lead, if one has the accelerometers and the other the gyros.
fn apart(group: &Group, lead: &Group, period_ns: i64) -> Option<Clocks> {
    match (group.triad(ACCELEROMETERS), lead.triad(GYROS), group.triad(GYROS), lead.triad(ACCELEROMETERS)) {
        (Some(force), Some(rate), ..) => Some(clocks::of_accelerometer(&force, &rate, period_ns)),
        (_, _, Some(rate), Some(force)) => Some(clocks::of_accelerometer(&force, &rate, period_ns).negated()),
        _ => None,
    }
}

/// Largest number of whole nanoseconds exact in f64, 104 days: smaller timestamps count from power-on, and are kept.
const EXACT_NS: i64 = 1 << 53;

const NS_PER_S: i64 = 1_000_000_000;

/// Timestamps in seconds, each the nearest to its decimal; relative to a whole second if they are too large for that.
fn seconds(stamps_ns: &[i64]) -> Vec<f64> {
    let earliest = stamps_ns.iter().copied().min().unwrap_or(0);
    let is_exact = (-EXACT_NS..=EXACT_NS).contains(&earliest);
    let origin = if is_exact { 0 } else { earliest.saturating_sub(earliest.rem_euclid(NS_PER_S)) };
    stamps_ns.iter().map(|stamp| stamp.saturating_sub(origin) as f64 / NS_PER_S as f64).collect()
}

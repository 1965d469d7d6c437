//! Streams with stamps of their own, joined into one table: a lead whose stamps are the grid, and what the others have
//! there.
//!
//! | stream | is |
//! |---|---|
//! | inertial, of the highest rate | the lead, not touched: interpolated up, slow noise keeps its density; picked down, fast noise would fold into it |
//! | with the stamps of the lead | joined as it is, to the last bit |
//! | other inertial ones, and their true values | interpolated by [`fos_core::align::Aligner`], missing where a sample is lost |
//! | everything else | held, missing when older than three of its periods |
//! | one alone | as it is |
//!
//! The clocks of an accelerometer and a gyro are set to each other where the motion of the unit tells how far they are apart
//! (`clocks.rs`), and taken as one where it does not.
//!
//! Stamps in no order are sorted where they are at most a second back; a sample that is there
//! twice or whose stamp alone is far off is left out; a clock that was set back is refused.

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

/// Columns of one length, the first is `t_s`.
#[derive(Debug)]
pub(super) struct Joined {
    pub(super) columns: Vec<(String, Vec<f64>)>,
    pub(super) alignment: Alignment,
}

impl Recording {
    /// A recording of streams with stamps of their own, joined onto the stamps of the fastest inertial one.
    ///
    /// # Errors
    /// Columns of another length than their stamps, stamps far out of order, and what [`Recording::from_columns`] refuses.
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

/// Streams as the columns of one table. `path` is named in errors.
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
        // all that are empty have the same stamps
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
        if let Some(Clocks::Apart(apart)) = clocks.filter(|clocks| clocks.are_set()) {
            apart.add_to(&mut group.stamps_ns);
        }
        let (followed, held): (Vec<_>, Vec<_>) =
            group.columns.into_iter().partition(|(name, _)| is_followed(name));
        let mut told = |how, rows_missing| {
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
            told(HowJoined::Interpolated { noise_kept: done.noise_kept, clocks }, done.rows_missing);
        }
        if !held.is_empty() {
            let done = hold::onto(beside, held);
            columns.extend(done.columns);
            told(HowJoined::Held { mean_age_s: done.mean_age_s }, done.rows_missing);
        }
    }
    let Group { stamps_ns, columns: of_lead, .. } = lead;
    let time = ("t_s".to_owned(), seconds(&stamps_ns));
    let columns = std::iter::once(time).chain(of_lead).chain(columns).collect();
    Ok(Joined { columns, alignment })
}

/// How far the clock of a stream is from that of the lead, if one has the accelerometers and the other the gyros.
fn apart(group: &Group, lead: &Group, period_ns: i64) -> Option<Clocks> {
    match (group.triad(ACCELEROMETERS), lead.triad(GYROS), group.triad(GYROS), lead.triad(ACCELEROMETERS)) {
        (Some(force), Some(rate), ..) => Some(clocks::of_accelerometer(&force, &rate, period_ns)),
        (_, _, Some(rate), Some(force)) => {
            Some(clocks::of_accelerometer(&force, &rate, period_ns).of_the_other())
        }
        _ => None,
    }
}

/// Whole nanoseconds that an f64 holds, 104 days: stamps within them are since the start of a device, and stay.
const EXACT_NS: i64 = 1 << 53;

const NS_PER_S: i64 = 1_000_000_000;

/// Stamps as seconds, each the nearest to its decimal; since a whole second if they are too large for that.
fn seconds(stamps_ns: &[i64]) -> Vec<f64> {
    let earliest = stamps_ns.iter().copied().min().unwrap_or(0);
    let is_exact = (-EXACT_NS..=EXACT_NS).contains(&earliest);
    let origin = if is_exact { 0 } else { earliest.saturating_sub(earliest.rem_euclid(NS_PER_S)) };
    stamps_ns.iter().map(|stamp| stamp.saturating_sub(origin) as f64 / NS_PER_S as f64).collect()
}

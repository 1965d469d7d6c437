//! True motion in a log that should be at rest: knocks, steps, motors, hands, a building that sways.
//!
//! The noise of the axes is independent; a motion of the device shows on several of them at the same time. So the energy
//! of each axis is compared with its own usual energy, window by window and on time scales from a sample to seconds;
//! excess energy on several axes at once is motion. The threshold comes from each log itself, so that unusual noise is
//! not taken for motion.
//!
//! | file | subject |
//! |---|---|
//! | `scale` | energy of one axis on one time scale, and its excess |
//! | `shared` | excess on several axes at once |
//! | `explained` | shared steps that a logged channel explains, which are no motion |
//! | `absolute` | scatter beyond that of any sensor at rest: a vehicle that drives all along |
//! | `kind` | classification of a motion |

mod absolute;
mod explained;
mod kind;
mod scale;
mod shared;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod verdict_tests;

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use crate::column::AXES;
use crate::pose;
use crate::recording::{Marks, Recording, RecordingError, Reference};
use crate::unit::Unit;

pub use crate::recording::{Disturbance, Kind};

/// Maximum number of disturbances listed individually, the longest first.
const MAX_LISTED: usize = 12;

/// Describes detected motion by time, duration and kind, one line each; of more than 12 the longest, in order of time.
/// Then the number of stretches that a logged channel explains, one line for each channel.
pub fn describe_disturbances(recording: &Recording, disturbances: &[Disturbance]) -> Vec<String> {
    let seconds = |one: &Disturbance| one.rows.len() as f64 * recording.rate.period_s;
    let (explained, moved): (Vec<&Disturbance>, Vec<&Disturbance>) =
        disturbances.iter().partition(|one| one.channel.is_some());
    let mut longest = moved.clone();
    longest.sort_by_key(|one| std::cmp::Reverse(one.rows.len()));
    longest.truncate(MAX_LISTED);
    longest.sort_by_key(|one| one.rows.start);
    let mut lines: Vec<String> = longest
        .into_iter()
        .map(|one| {
            let turned = one.turned_rad.filter(|_| one.kind == Kind::Handling);
            let turned =
                turned.map_or_else(String::new, |angle| format!(", turned by {:.0}°", angle.to_degrees()));
            format!(
                "{} at {:.1} s for {:.1} s{turned}{}{}",
                one.kind.name(),
                recording.time_s[one.rows.start],
                seconds(one),
                if one.is_tilted { ", perhaps in another orientation afterwards" } else { "" },
                if one.is_excluded() { "; excluded" } else { "" },
            )
        })
        .collect();
    if moved.len() > MAX_LISTED {
        let excluded = moved.iter().filter(|one| one.is_excluded());
        let all = excluded.fold(0.0, |sum, one| sum + seconds(one));
        lines.push(format!("and {} shorter ones; {all:.1} s excluded in total", moved.len() - MAX_LISTED));
    }
    let mut channels: Vec<&str> = explained.iter().filter_map(|one| one.channel.as_deref()).collect();
    channels.sort_unstable();
    for of_one in channels.chunk_by(|one, other| one == other) {
        let [stretches, follow, were] = match of_one.len() {
            1 => ["stretch", "follows", "was"],
            _ => ["stretches", "follow", "were"],
        };
        lines.push(format!("{} {stretches} {follow} {} and {were} kept", of_one.len(), of_one[0]));
    }
    lines
}

/// Rejects a log in nearly continuous motion: less than half a minute of `rows` is at rest (`rest`, with the rows of
/// `found` already excluded).
pub fn check_rest(
    recording: &Recording,
    found: &[Disturbance],
    rest: &[bool],
    rows: &Range<usize>,
) -> Result<(), RecordingError> {
    let within = |one: &Disturbance| one.rows.start.max(rows.start)..one.rows.end.min(rows.end);
    let motions = found.iter().filter(|one| one.kind == Kind::Motion).map(within);
    let Some(longest) = motions.max_by_key(Range::len).filter(|motion| !motion.is_empty()) else {
        return Ok(());
    };
    let rest_s = rest[rows.clone()].iter().filter(|rest| **rest).count() as f64 * recording.rate.period_s;
    if rest_s >= absolute::SHORTEST_REST_S {
        return Ok(());
    }
    let (column, scatter, limit) = AXES
        .into_iter()
        .filter_map(|name| {
            let scatter = absolute::scatter(recording, &recording.channel(name).ok()?.values, &longest);
            Some((name, scatter, absolute::limit(name)?))
        })
        .max_by(|one, other| (one.1 / one.2).total_cmp(&(other.1 / other.2)))
        .unwrap_or_default();
    let (per_si, unit) = match recording.channel(column).map(|channel| channel.unit) {
        Ok(Unit::RadianPerSecond) => (1_f64.to_degrees(), "°/s"),
        _ => (1.0, "m/s²"),
    };
    Err(RecordingError::Moves {
        path: recording.paths(),
        from_s: recording.time_s[longest.start],
        to_s: recording.time_s[longest.end - 1],
        column: column.into(),
        scatter: per_si * scatter,
        limit: per_si * limit,
        unit,
        rest_s,
    })
}

/// Rejects a log with less than half a minute at rest because the device moves; accepts any log whose motion is kept.
pub fn check(recording: &Recording) -> Result<(), RecordingError> {
    let marks = marks(recording);
    check_rest(recording, &marks.found, &marks.rest, &(0..recording.n_rows()))
}

/// The same log with the rows of detected motion marked as not at rest, and the detected motion. Without a column
/// `still` all other rows count as at rest.
pub fn marked(recording: &Recording) -> (Cow<'_, Recording>, Vec<Disturbance>) {
    let marks = marks(recording);
    let found = marks.found.clone();
    if marks.turns.is_empty() && !found.iter().any(Disturbance::is_excluded) {
        return (Cow::Borrowed(recording), found);
    }
    (Cow::Owned(recording.with_rests(marks.rest.clone(), marks.turns.clone())), found)
}

/// Detected motion of a recording, computed once.
fn marks(recording: &Recording) -> Arc<Marks> {
    recording.detected.marks.get_or_find((), || {
        let mut rest = recording.still.clone().unwrap_or_else(|| vec![true; recording.n_rows()]);
        let found = find(recording, &rest);
        exclude(&mut rest, &found);
        let turns = pose::turns(recording, &rest, &tilted(&found));
        Marks { found, rest, turns }
    })
}

/// Result of [`find`] within the rows that the recording states are at rest, or within all rows.
pub(crate) fn find_at_rest(recording: &Recording) -> Vec<Disturbance> {
    marks(recording).found.clone()
}

/// Rows of the motions that tilted the device.
pub(crate) fn tilted(disturbances: &[Disturbance]) -> Vec<Range<usize>> {
    let tilts = disturbances.iter().filter(|disturbance| disturbance.is_tilted);
    tilts.map(|disturbance| disturbance.rows.clone()).collect()
}

/// Marks the rows of excluded disturbances as not at rest.
pub fn exclude(rest: &mut [bool], disturbances: &[Disturbance]) {
    let left_out = disturbances.iter().filter(|disturbance| disturbance.is_excluded());
    left_out.for_each(|disturbance| rest[disturbance.rows.clone()].fill(false));
}

/// Motion in more than this share of a log is its usual state and no disturbance, unless no sensor at rest can show it.
const MAX_SHARE: f64 = 0.5;

/// Returns true if motion is searched for: the log is fast enough, and its motion is not kept.
pub(crate) fn is_detectable(recording: &Recording) -> bool {
    !recording.keeps_moved && recording.rate.period_s <= shared::LONGEST_PERIOD_S
}

/// Detected motion, in order, among the rows marked by `rest`. Empty for a log with fewer than two inertial columns, and
/// for one whose motion is kept. Of an axis with a reference the error is examined: known motion is no disturbance.
pub fn find(recording: &Recording, rest: &[bool]) -> Vec<Disturbance> {
    if !is_detectable(recording) {
        return Vec::new();
    }
    let mut axes = Vec::new();
    let mut has_reference = false;
    for name in AXES {
        let Ok(series) = recording.error_series(name) else { continue };
        has_reference |= matches!(series.reference, Reference::Channel(_));
        let mut values = series.values.into_owned();
        values.iter_mut().zip(rest).filter(|(_, rest)| !**rest).for_each(|(value, _)| *value = f64::NAN);
        axes.push((name, values));
    }
    if axes.len() < 2 {
        return Vec::new();
    }
    let rows_at_rest = rest.iter().filter(|rest| **rest).count() as f64;
    // at rest the reference is the orientation, and does not include motion
    let has_reference =
        has_reference && (recording.still.is_none() || rows_at_rest < MAX_SHARE * rest.len() as f64);
    let lasting = if has_reference { Vec::new() } else { absolute::find(recording, &axes) };
    let lasts =
        |rows: &&Range<usize>| rows.len() as f64 * recording.rate.period_s >= absolute::SHORTEST_REST_S;
    // the usual scatter is that of the remaining log, however short it is compared with the motion
    let mut values: Vec<Vec<f64>> = axes.into_iter().map(|(_, values)| values).collect();
    for rows in lasting.iter().filter(lasts) {
        values.iter_mut().for_each(|values| values[rows.clone()].fill(f64::NAN));
    }
    let found = shared::find(recording, values, has_reference);
    let share = |stretches: &[Range<usize>]| {
        let at_rest = |rows: &Range<usize>| rest[rows.clone()].iter().filter(|rest| **rest).count();
        stretches.iter().map(at_rest).sum::<usize>() as f64 / rows_at_rest.max(1.0)
    };
    let is_usual = share(&found.moved) > MAX_SHARE;
    // an event is detected more precisely against the usual energy; a stretch as long as a rest is motion in any case
    let lasting: Vec<Range<usize>> = lasting.iter().filter(|rows| is_usual || lasts(rows)).cloned().collect();
    let is_inside = |rows: &Range<usize>, all: &[Range<usize>]| {
        all.iter().any(|outer| outer.start <= rows.start && rows.end <= outer.end)
    };
    let events = found.moved.iter().filter(|rows| !is_usual && !is_inside(rows, &lasting));
    // rows that were not examined get no verdict
    let first = rest.iter().position(|rest| *rest).unwrap_or(0);
    let end = rest.iter().rposition(|rest| *rest).map_or(0, |last| last + 1);
    let within = |one: Disturbance| Disturbance {
        rows: one.rows.start.clamp(first, end)..one.rows.end.clamp(first, end),
        ..one
    };
    let moved = events.map(|rows| kind::classify(recording, rows.clone(), rest));
    let lasting = lasting
        .iter()
        .map(|rows| Disturbance { is_tilted: true, ..Disturbance::level(rows.clone(), Kind::Motion) });
    let moved: Vec<Disturbance> = moved.chain(lasting).map(within).collect();
    let vibration = found.shaken.iter().map(|rows| Disturbance::level(rows.clone(), Kind::Vibration));
    // rows excluded for another reason stay excluded
    let is_kept =
        |rows: &Range<usize>| !moved.iter().any(|one| is_inside(rows, std::slice::from_ref(&one.rows)));
    let explained = found.explained.iter().filter(|one| is_kept(&one.rows)).map(|one| Disturbance {
        channel: Some(one.channel.clone()),
        ..Disturbance::level(one.rows.clone(), Kind::Explained)
    });
    let explained: Vec<Disturbance> = explained.collect();
    let mut all: Vec<Disturbance> = moved.into_iter().chain(vibration).chain(explained).collect();
    all.sort_by_key(|disturbance| disturbance.rows.start);
    all
}

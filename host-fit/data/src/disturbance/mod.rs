//! True motion in a log that is meant to be at rest: knocks, steps, motors, hands, a building that sways.
//!
//! The noise of the axes is independent; what moves the unit shows on several of them at the same time. So the energy
//! of each axis is held against its own usual energy, window by window and on time scales from a sample to seconds, and
//! where several axes have too much of it at once the unit was moved. What is too much is told from each log itself, so
//! that strange noise is no motion.
//!
//! | file | subject |
//! |---|---|
//! | `scale` | energy of one axis on one time scale, and by how much it is more than usual |
//! | `shared` | where several axes have too much at once |
//! | `explained` | shared steps that a logged channel explains, which are no motion |
//! | `absolute` | scatter that no sensor at rest has: a vehicle that drives all along |
//! | `kind` | what it looks like |

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

use crate::column::AXES;
use crate::pose;
use crate::recording::{Recording, RecordingError, Reference};
use crate::unit::Unit;

pub use kind::{Disturbance, Kind};

/// Disturbances that are told one by one; of more, the longest.
const MOST_TOLD: usize = 12;

/// Detected motion: when, how long, and what it looks like, one line each; of many the longest, in order. Then the number
/// of stretches that a logged channel explains, one line for each channel.
pub fn told(recording: &Recording, disturbances: &[Disturbance]) -> Vec<String> {
    let seconds = |one: &Disturbance| one.rows.len() as f64 * recording.rate.period_s;
    let (explained, moved): (Vec<&Disturbance>, Vec<&Disturbance>) =
        disturbances.iter().partition(|one| one.channel.is_some());
    let mut longest = moved.clone();
    longest.sort_by_key(|one| std::cmp::Reverse(one.rows.len()));
    longest.truncate(MOST_TOLD);
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
                if one.is_left_out() { "; excluded" } else { "" },
            )
        })
        .collect();
    if moved.len() > MOST_TOLD {
        let excluded = moved.iter().filter(|one| one.is_left_out());
        let all = excluded.fold(0.0, |sum, one| sum + seconds(one));
        lines.push(format!("and {} shorter ones; {all:.1} s excluded in total", moved.len() - MOST_TOLD));
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

/// Refuses a log that moves all along: less than half a minute of `rows` is left at rest (`rest`, without what was
/// `found`).
///
/// # Errors
///
/// [`RecordingError::Moves`].
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

/// Refuses a log of which less than half a minute is at rest because the device moves; none where motion is kept.
///
/// # Errors
///
/// [`RecordingError::Moves`].
pub fn check(recording: &Recording) -> Result<(), RecordingError> {
    let marks = recording.once(Marks::of);
    check_rest(recording, &marks.found, &marks.rest, &(0..recording.n_rows()))
}

/// The same log with the rows in which the unit was moved marked as not at rest, and when it was: where there is no
/// column `still`, all others are.
pub fn marked(recording: &Recording) -> (Cow<'_, Recording>, Vec<Disturbance>) {
    let marks = recording.once(Marks::of);
    let found = marks.found.clone();
    if marks.turns.is_empty() && !found.iter().any(Disturbance::is_left_out) {
        return (Cow::Borrowed(recording), found);
    }
    (Cow::Owned(recording.with_rests(marks.rest.clone(), marks.turns.clone())), found)
}

/// When a recording was moved where it should be at rest, by its own word: all of it if it does not say.
struct Marks {
    found: Vec<Disturbance>,
    /// The rows that are left.
    rest: Vec<bool>,
    turns: Vec<usize>,
}

impl Marks {
    fn of(recording: &Recording) -> Self {
        let mut rest = recording.still.clone().unwrap_or_else(|| vec![true; recording.n_rows()]);
        let found = find(recording, &rest);
        leave_out(&mut rest, &found);
        let turns = pose::turns(recording, &rest, &tilted(&found));
        Self { found, rest, turns }
    }
}

/// As [`find`] of the rows that the recording itself says are at rest, and all if it does not say.
pub(crate) fn find_at_rest(recording: &Recording) -> Vec<Disturbance> {
    recording.once(Marks::of).found.clone()
}

/// Rows of the motions that tilted the unit.
pub(crate) fn tilted(disturbances: &[Disturbance]) -> Vec<Range<usize>> {
    let tilts = disturbances.iter().filter(|disturbance| disturbance.is_tilted);
    tilts.map(|disturbance| disturbance.rows.clone()).collect()
}

/// Takes the rows in which the unit was moved off those at rest.
pub fn leave_out(rest: &mut [bool], disturbances: &[Disturbance]) {
    let left_out = disturbances.iter().filter(|disturbance| disturbance.is_left_out());
    left_out.for_each(|disturbance| rest[disturbance.rows.clone()].fill(false));
}

/// More than this share of a log is its usual state and no disturbance, unless no sensor at rest can show it.
const MOST: f64 = 0.5;

/// Where the unit was moved, in order, among the rows that `rest` marks; none in a log with fewer than two inertial
/// columns, or that is to be taken as it is. An axis with a reference is judged by its error: known motion is no
/// disturbance.
pub fn find(recording: &Recording, rest: &[bool]) -> Vec<Disturbance> {
    if recording.keeps_moved || recording.rate.period_s > shared::LONGEST_PERIOD_S {
        return Vec::new();
    }
    let mut axes = Vec::new();
    let mut is_vouched = false;
    for name in AXES {
        let Ok(series) = recording.error_series(name) else { continue };
        is_vouched |= matches!(series.reference, Reference::Channel(_));
        let mut values = series.values.into_owned();
        values.iter_mut().zip(rest).filter(|(_, rest)| !**rest).for_each(|(value, _)| *value = f64::NAN);
        axes.push((name, values));
    }
    if axes.len() < 2 {
        return Vec::new();
    }
    let rows_at_rest = rest.iter().filter(|rest| **rest).count() as f64;
    // at rest a reference is the pose, and what moves there it does not know
    let is_vouched = is_vouched && (recording.still.is_none() || rows_at_rest < MOST * rest.len() as f64);
    let lasting = if is_vouched { Vec::new() } else { absolute::find(recording, &axes) };
    let lasts =
        |rows: &&Range<usize>| rows.len() as f64 * recording.rate.period_s >= absolute::SHORTEST_REST_S;
    // the usual scatter is that of the rest of the log, however short it is beside the motion
    let mut values: Vec<Vec<f64>> = axes.into_iter().map(|(_, values)| values).collect();
    for rows in lasting.iter().filter(lasts) {
        values.iter_mut().for_each(|values| values[rows.clone()].fill(f64::NAN));
    }
    let found = shared::find(recording, values, is_vouched);
    let share = |stretches: &[Range<usize>]| {
        let at_rest = |rows: &Range<usize>| rest[rows.clone()].iter().filter(|rest| **rest).count();
        stretches.iter().map(at_rest).sum::<usize>() as f64 / rows_at_rest.max(1.0)
    };
    let is_usual = share(&found.moved) > MOST;
    // an event is detected by what is usual, and more precisely; what lasts as long as a rest has to is motion whatever is
    let lasting: Vec<Range<usize>> = lasting.iter().filter(|rows| is_usual || lasts(rows)).cloned().collect();
    let is_inside = |rows: &Range<usize>, all: &[Range<usize>]| {
        all.iter().any(|outer| outer.start <= rows.start && rows.end <= outer.end)
    };
    let events = found.moved.iter().filter(|rows| !is_usual && !is_inside(rows, &lasting));
    // what was not looked at is not judged
    let first = rest.iter().position(|rest| *rest).unwrap_or(0);
    let end = rest.iter().rposition(|rest| *rest).map_or(0, |last| last + 1);
    let within = |one: Disturbance| Disturbance {
        rows: one.rows.start.clamp(first, end)..one.rows.end.clamp(first, end),
        ..one
    };
    let moved = events.map(|rows| kind::described(recording, rows.clone(), rest));
    let lasting = lasting
        .iter()
        .map(|rows| Disturbance { is_tilted: true, ..Disturbance::level(rows.clone(), Kind::Motion) });
    let moved: Vec<Disturbance> = moved.chain(lasting).map(within).collect();
    let vibration = found.shaken.iter().map(|rows| Disturbance::level(rows.clone(), Kind::Vibration));
    // what is excluded for another reason is not kept
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

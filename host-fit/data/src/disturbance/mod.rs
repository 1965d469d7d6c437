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
//! | `kind` | what it looks like |

mod kind;
mod scale;
mod shared;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::ops::Range;

use crate::column::AXES;
use crate::pose;
use crate::recording::{Recording, Reference};

pub use kind::{Disturbance, Kind};

/// Disturbances that are told one by one; of more, the longest.
const MOST_TOLD: usize = 12;

/// When the unit was moved, how long, what it looks like, a line each; the longest, in order, where there are many.
pub fn told(recording: &Recording, disturbances: &[Disturbance]) -> Vec<String> {
    let seconds = |one: &Disturbance| one.rows.len() as f64 * recording.rate.period_s;
    let mut longest: Vec<&Disturbance> = disturbances.iter().collect();
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
                if one.is_tilted { ", perhaps in another pose afterwards" } else { "" },
                if one.is_left_out() { "; left out" } else { "" },
            )
        })
        .collect();
    if disturbances.len() > MOST_TOLD {
        let left_out = disturbances.iter().filter(|one| one.is_left_out());
        let all: f64 = left_out.map(&seconds).sum();
        lines
            .push(format!("and {} shorter ones; {all:.1} s left out in all", disturbances.len() - MOST_TOLD));
    }
    lines
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

/// More than this share of a log is its usual state and no disturbance.
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
        axes.push(values);
    }
    if axes.len() < 2 {
        return Vec::new();
    }
    let rows_at_rest = rest.iter().filter(|rest| **rest).count() as f64;
    // at rest a reference is the pose, and what moves there it does not know
    let is_vouched = is_vouched && (recording.still.is_none() || rows_at_rest < MOST * rest.len() as f64);
    let found = shared::find(recording, axes, is_vouched);
    let share = |stretches: &[Range<usize>]| {
        stretches.iter().map(|rows| rows.len()).sum::<usize>() as f64 / rows_at_rest.max(1.0)
    };
    let left_out = if share(&found.moved) > MOST { &[][..] } else { &found.moved[..] };
    // what was not looked at is not judged
    let first = rest.iter().position(|rest| *rest).unwrap_or(0);
    let end = rest.iter().rposition(|rest| *rest).map_or(0, |last| last + 1);
    let within = |one: Disturbance| Disturbance {
        rows: one.rows.start.clamp(first, end)..one.rows.end.clamp(first, end),
        ..one
    };
    let moved = left_out.iter().map(|rows| within(kind::described(recording, rows.clone(), rest)));
    let vibration = found.shaken.iter().map(|rows| Disturbance {
        rows: rows.clone(),
        kind: Kind::Vibration,
        turned_rad: None,
        is_tilted: false,
    });
    let mut all: Vec<Disturbance> = moved.chain(vibration).collect();
    all.sort_by_key(|disturbance| disturbance.rows.start);
    all
}

//! In which poses a unit lies still, told by gravity.
//!
//! Without a reference an accelerometer at rest is held against a constant: gravity in one pose. In two, the mean of
//! both is the true value of neither, and what a model would call the error is the difference.

use crate::column::{ACCELEROMETERS, Column};
use std::ops::Range;

use fos_core::GRAVITY_MPS2;

use crate::recording::{Recording, Reference};
use crate::statistics::{MAD_TO_SD, finite_median, mean, median};

/// Levels of specific force further apart than this are of two poses, m/s²: a tenth of gravity, a tilt of 6°. No bias
/// moves so far: 100 K at 1 mg/K, the worst coefficient of a data sheet, are as much. A smaller tilt cannot be told
/// from a bias.
const OTHER_POSE_MPS2: f64 = 0.1 * GRAVITY_MPS2 as f64;

/// Length of the windows whose levels are compared, s, and the fewest rows of one.
const WINDOW_S: f64 = 1.0;
const FEWEST_ROWS: usize = 5;

/// A pose is held for so many windows in a row: a knock or a hand is none.
const HELD_WINDOWS: usize = 3;

/// A pose that is held.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// From the first row in which it is held to the last, before another is.
    pub rows: Range<usize>,
    /// Specific force, m/s², of the columns that were asked for.
    pub force: Vec<f64>,
}

/// The columns that tell the pose of an accelerometer: all three, or where the log does not have them the axis alone.
/// None for a gyro.
pub fn columns_of(recording: &Recording, column: &str) -> Vec<&'static str> {
    let own = ACCELEROMETERS.into_iter().filter(|name| *name == column);
    let has_all = ACCELEROMETERS.iter().all(|name| recording.channel(name).is_ok());
    if has_all && ACCELEROMETERS.contains(&column) { ACCELEROMETERS.to_vec() } else { own.collect() }
}

/// The first pose that is held in the rows that `used` marks, and the first that is another; by levels of `columns`.
pub fn first_two(recording: &Recording, columns: &[&str], used: &[bool]) -> Vec<Pose> {
    let values: Vec<&[f64]> =
        columns.iter().filter_map(|name| recording.channel(name).ok()).map(|c| &c.values[..]).collect();
    if values.is_empty() {
        return Vec::new();
    }
    let rows = ((WINDOW_S / recording.rate.period_s).round() as usize).max(FEWEST_ROWS);
    let mut poses: Vec<Pose> = Vec::new();
    for stretch in recording.stretches_where(|row| used[row]) {
        // where the level has been held since it last moved, and for how many windows
        let mut held: Option<(Pose, usize)> = None;
        for window in stretch.clone().step_by(rows).map(|start| start..start + rows) {
            if window.end > stretch.end {
                break;
            }
            let level: Option<Vec<f64>> =
                values.iter().map(|axis| finite_median(&axis[window.clone()])).collect();
            let Some(force) = level else { continue };
            if let Some(first) = poses.first_mut().filter(|first| !is_other(&first.force, &force)) {
                first.rows.end = window.end;
            }
            held = match held {
                Some((pose, windows)) if !is_other(&pose.force, &force) => {
                    Some((Pose { rows: pose.rows.start..window.end, ..pose }, windows + 1))
                }
                _ => Some((Pose { rows: window, force }, 1)),
            };
            let Some((pose, HELD_WINDOWS)) = &held else { continue };
            if poses.first().is_none_or(|first| is_other(&first.force, &pose.force)) {
                poses.push(pose.clone());
            }
            if poses.len() == 2 {
                return poses;
            }
        }
    }
    poses
}

/// Levels on either side of a motion are taken over so long, s.
pub(crate) const LEVEL_S: f64 = 5.0;

/// Who moves a unit does not put it down exactly as it lay: a level has moved if by so many standard errors, and by more
/// than this, m/s²: 1 mg. One accelerometer alone may be a step of its bias.
const MOVED: f64 = 8.0;
const LEAST_TILT_MPS2: f64 = 0.01;

/// The rows at rest from which on gravity may have another direction than before: after a motion that tilted the unit,
/// or where a new log begins in another pose. `tilted` are rows of motions that are known to have tilted it.
pub fn turns(recording: &Recording, still: &[bool], tilted: &[Range<usize>]) -> Vec<usize> {
    let length = ((LEVEL_S / recording.rate.period_s) as usize).max(FEWEST_ROWS);
    let mut turns = Vec::new();
    let mut before: Option<Range<usize>> = None;
    for rest in recording.stretches_where(|row| still[row]) {
        if rest.len() < FEWEST_ROWS {
            continue;
        }
        let head = rest.start..rest.end.min(rest.start + length);
        if let Some(tail) = before.replace(rest.start.max(rest.end.saturating_sub(length))..rest.end) {
            let gap = tail.end..head.start;
            let is_told = || tilted.iter().any(|rows| rows.start < gap.end && gap.start < rows.end);
            let has_turned = match gap.is_empty() {
                // nobody moved it: a bias may have drifted
                true => is_far(recording, &tail, &head),
                false => is_told() || is_tilted(recording, &tail, &head),
            };
            if has_turned {
                turns.push(head.start);
            }
        }
    }
    turns
}

/// Whether a column shows a level that is nobody's to say: that of an accelerometer without a reference holds gravity, in
/// each pose another part of it.
pub fn has_unknown_level(column: &str, reference: &Reference) -> bool {
    *reference == Reference::Constant && Column::named(column).is_specific_force()
}

/// The places `within` a range of each level: from the begin to the first turn, from that to the next, ….
pub fn levels_between(turns: &[usize], within: Range<usize>) -> Vec<Range<usize>> {
    let turns = || turns.iter().copied().filter(|turn| *turn > within.start && *turn < within.end);
    let starts = std::iter::once(within.start).chain(turns());
    starts.zip(turns().chain([within.end])).map(|(start, end)| start..end).collect()
}

/// `values` of an accelerometer with the level of each pose moved: the mean of what is left of it at rest without
/// `explained` becomes what `wanted` makes of it. What is constant in a pose is not known to be an error.
pub fn with_levels(
    values: &[f64],
    explained: &[f64],
    still: &[bool],
    turns: &[usize],
    mut wanted: impl FnMut(f64) -> f64,
) -> Vec<f64> {
    let mut moved = values.to_vec();
    for rows in levels_between(turns, 0..values.len()) {
        let left = rows.clone().filter(|row| still[*row]).map(|row| values[row] - explained[row]);
        let left: Vec<f64> = left.filter(|value| value.is_finite()).collect();
        if left.is_empty() {
            continue;
        }
        let level = mean(&[&left]);
        let shift = level - wanted(level);
        moved[rows].iter_mut().for_each(|value| *value -= shift);
    }
    moved
}

/// What the accelerometers show in the two ranges of rows; `None` where one shows nothing.
fn levels(
    recording: &Recording,
    before: &Range<usize>,
    after: &Range<usize>,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let axes = ACCELEROMETERS.into_iter().filter_map(|name| recording.channel(name).ok());
    let both = axes.map(|axis| {
        Some((finite_median(&axis.values[before.clone()])?, finite_median(&axis.values[after.clone()])?))
    });
    both.collect::<Option<Vec<_>>>().map(|both| both.into_iter().unzip())
}

/// Whether two accelerometers show another level after a motion than before, or one by far.
pub(crate) fn is_tilted(recording: &Recording, before: &Range<usize>, after: &Range<usize>) -> bool {
    let has_moved = |name: &&str| {
        let Ok(series) = recording.error_series(name) else { return false };
        let part = |rows: &Range<usize>| -> Vec<f64> {
            series.values[rows.clone()].iter().copied().filter(|value| value.is_finite()).collect()
        };
        let (mut before, mut after) = (part(before), part(after));
        if before.len() < FEWEST_ROWS || after.len() < FEWEST_ROWS {
            return false;
        }
        // of a median of normal noise
        let error = 1.25 * (noise(&before) / before.len() as f64 + noise(&after) / after.len() as f64).sqrt();
        let moved = (median(&mut after) - median(&mut before)).abs();
        moved > MOVED * error && moved > LEAST_TILT_MPS2
    };
    ACCELEROMETERS.iter().filter(|name| has_moved(name)).count() >= 2 || is_far(recording, before, after)
}

fn is_far(recording: &Recording, before: &Range<usize>, after: &Range<usize>) -> bool {
    levels(recording, before, after).is_some_and(|(before, after)| is_other(&before, &after))
}

/// Variance of noise by the changes from one value to the next.
fn noise(values: &[f64]) -> f64 {
    let mut steps: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    (MAD_TO_SD * median(&mut steps)).powi(2) / 2.0
}

fn is_other(one: &[f64], other: &[f64]) -> bool {
    let squares = one.iter().zip(other).map(|(a, b)| (a - b).powi(2));
    squares.sum::<f64>().sqrt() > OTHER_POSE_MPS2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{LoadOptions, Source};

    const G: f64 = GRAVITY_MPS2 as f64;

    /// 60 s at 50 Hz, lying as `force` says at a time.
    fn log(force: impl Fn(f64) -> [f64; 3]) -> Recording {
        let time_s: Vec<f64> = (0..3000).map(|k| f64::from(k) * 0.02).collect();
        let axis = |i: usize| time_s.iter().map(|t| force(*t)[i] + 0.05 * (311.0 * t).sin()).collect();
        let axes = ACCELEROMETERS.into_iter().enumerate().map(|(i, name)| (name.to_owned(), axis(i)));
        let columns = std::iter::once(("t_s".to_owned(), time_s.clone())).chain(axes).collect();
        Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap()
    }

    fn found(force: impl Fn(f64) -> [f64; 3], columns: &[&str]) -> Vec<Pose> {
        first_two(&log(force), columns, &[true; 3000])
    }

    #[test]
    fn what_a_bias_does_is_no_pose_and_neither_is_a_knock() {
        let warms_up = |t: f64| [0.4 * (1.0 - (-t / 10.0).exp()), 0.1, G];
        let steps = |t: f64| [if t > 20.0 { 0.5 } else { -0.3 }, 0.0, G];
        let knocked = |t: f64| if (30.0..31.5).contains(&t) { [6.0, 0.0, 3.0] } else { [0.0, 0.0, G] };
        let wild = |t: f64| if (10.0..10.3).contains(&t) { [1e9, f64::NAN, G] } else { [0.0, 0.0, G] };
        // what is logged without gravity has no pose
        let free = |_: f64| [0.0; 3];
        let all: [&dyn Fn(f64) -> [f64; 3]; 5] = [&warms_up, &steps, &knocked, &wild, &free];
        for (i, force) in all.into_iter().enumerate() {
            assert_eq!(found(force, &ACCELEROMETERS).len(), 1, "{i}");
        }
    }

    #[test]
    fn two_poses_are_told_by_all_axes_and_by_one_that_changes() {
        let turned = |t: f64| if t < 25.0 { [0.0, 0.0, G] } else { [G * 0.5, 0.0, G * 0.75_f64.sqrt()] };
        let poses = found(turned, &ACCELEROMETERS);
        assert_eq!((poses[0].rows.clone(), poses[1].rows.start), (0..1250, 1250));
        assert_eq!(found(turned, &ACCELEROMETERS[..1]).len(), 2);
        assert_eq!(found(turned, &ACCELEROMETERS[1..2]).len(), 1, "it shows nothing along y");
        // what is not at rest is not looked at
        let mut used = [true; 3000];
        used[1250..].fill(false);
        assert_eq!(first_two(&log(turned), &ACCELEROMETERS, &used).len(), 1);
        assert_eq!(columns_of(&log(turned), "ay_mps2"), ACCELEROMETERS);
        assert!(columns_of(&log(turned), "gx_rads").is_empty());
    }
}

//! In which poses a unit lies still, told by gravity.
//!
//! Without a reference an accelerometer at rest is held against a constant: gravity in one pose. In two, the mean of
//! both is the true value of neither, and what a model would call the error is the difference.

use crate::column::ACCELEROMETERS;
use std::ops::Range;

use fos_core::GRAVITY_MPS2;

use crate::recording::Recording;
use crate::statistics::median_of;

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

fn is_other(one: &[f64], other: &[f64]) -> bool {
    let squares = one.iter().zip(other).map(|(a, b)| (a - b).powi(2));
    squares.sum::<f64>().sqrt() > OTHER_POSE_MPS2
}

/// The median of what is finite, which a few wild values do not move.
fn finite_median(values: &[f64]) -> Option<f64> {
    median_of(values.iter().copied().filter(|value| value.is_finite()))
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

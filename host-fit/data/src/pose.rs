//! Orientations in which a device lies still, from the direction of gravity.
//!
//! Without a reference the error of an accelerometer at rest is measured against a constant: gravity in one orientation.
//! In two orientations the mean of both is the true value of neither, and the difference would be modelled as an error.

use crate::column::ACCELEROMETERS;
use std::ops::Range;

use fos_core::GRAVITY_MPS2;

use crate::recording::{Boundary, Recording};
use crate::statistics::{MAD_TO_SD, finite_median, mean, median};

/// Smallest difference of specific force between two orientations, m/s²: a tenth of gravity, a tilt of 6°. No bias moves
/// so far: 100 K at 1 mg/K, the worst coefficient of a data sheet, are as much. A smaller tilt is indistinguishable from
/// a change of the bias.
const MIN_CHANGE_MPS2: f64 = 0.1 * GRAVITY_MPS2 as f64;

/// Length of the windows whose levels are compared, s, and minimum number of rows of one.
const WINDOW_S: f64 = 1.0;
const MIN_ROWS: usize = 5;

/// Minimum number of consecutive windows of one orientation, so that a knock or a hand is not taken for one.
const HELD_WINDOWS: usize = 3;

#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// First to last row of the orientation, before the next one begins.
    pub rows: Range<usize>,
    /// Specific force, m/s², of the requested columns.
    pub force: Vec<f64>,
}

/// Columns that determine the orientation for an accelerometer: all three, or the axis alone if the log lacks one.
/// Empty for a gyro.
pub fn columns_of(recording: &Recording, column: &str) -> Vec<&'static str> {
    let own = ACCELEROMETERS.into_iter().filter(|name| *name == column);
    let has_all = ACCELEROMETERS.iter().all(|name| recording.channel(name).is_ok());
    if has_all && ACCELEROMETERS.contains(&column) { ACCELEROMETERS.to_vec() } else { own.collect() }
}

/// First orientation held in the rows marked by `used`, and the first one that differs from it, by levels of `columns`.
pub fn first_two(recording: &Recording, columns: &[&str], used: &[bool]) -> Vec<Pose> {
    let values: Vec<&[f64]> =
        columns.iter().filter_map(|name| recording.channel(name).ok()).map(|c| &c.values[..]).collect();
    if values.is_empty() {
        return Vec::new();
    }
    let rows = ((WINDOW_S / recording.rate.period_s).round() as usize).max(MIN_ROWS);
    let mut poses: Vec<Pose> = Vec::new();
    for stretch in recording.stretches_where(|row| used[row]) {
        // rows with an unchanged level so far, and their number of windows
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

/// Time over which the level on either side of a motion is computed, s.
pub(crate) const LEVEL_S: f64 = 5.0;

/// A device is never put down exactly as it lay: a level has changed if the change exceeds this many standard errors
/// and the minimum below, m/s² (1 mg).
const MIN_SIGMAS: f64 = 8.0;
const MIN_TILT_MPS2: f64 = 0.01;

/// Minimum number of accelerometers that a tilt changes: a change of one alone may be a step of its bias.
const MIN_TILTED: usize = 2;

/// Gap in the samples during which the device may have been picked up and put down, s.
const PAUSE_S: f64 = 1.0;

/// Upper bound of the temperature coefficient of a bias, m/s²/K: 1 mg/K, the worst of a data sheet.
const BIAS_PER_K: f64 = 0.01;

/// Share of a level change that may appear as a change of |a| in a pure rotation: biases of 0.05 g and scale errors turn
/// with the device.
const MAX_MAGNITUDE_SHARE: f64 = 0.1;

/// Rows at rest from which gravity may have a different direction: after a motion that tilted the device, after a pause
/// in which it may have been turned, or where a new log begins in another orientation. `tilted` are rows of motions
/// known to have tilted it.
pub fn turns(recording: &Recording, still: &[bool], tilted: &[Range<usize>]) -> Vec<usize> {
    let mut turns = Vec::new();
    for (tail, head) in neighbouring_rests(recording, still) {
        let gap = tail.end..head.start;
        let has_turned = match gap.is_empty() {
            // no motion was recorded in between
            true => is_far(recording, &tail, &head) || after_pause(recording, &tail, &head).is_some(),
            false => {
                let is_told = tilted.iter().any(|rows| rows.start < gap.end && gap.start < rows.end);
                // a device may be put down differently after handling: a step of the bias in between is not identifiable
                let is_stated = recording.still.is_some() && has_paused(recording, &gap);
                let fewest = if is_stated { 1 } else { MIN_TILTED };
                is_told || is_tilted_by(recording, &tail, &head, fewest)
            }
        };
        if has_turned {
            turns.push(head.start);
        }
    }
    turns
}

/// Returns true for rows that last as long as a pause in which the device may have been moved.
fn has_paused(recording: &Recording, rows: &Range<usize>) -> bool {
    rows.len() as f64 * recording.rate.period_s > PAUSE_S
}

/// Last rows of each rest with the first rows of the next.
fn neighbouring_rests(recording: &Recording, still: &[bool]) -> Vec<(Range<usize>, Range<usize>)> {
    let length = ((LEVEL_S / recording.rate.period_s) as usize).max(MIN_ROWS);
    let rests = recording.stretches_where(|row| still[row]).into_iter().filter(|rest| rest.len() >= MIN_ROWS);
    let rests: Vec<Range<usize>> = rests.collect();
    let tail = |rest: &Range<usize>| rest.start.max(rest.end.saturating_sub(length))..rest.end;
    let head = |rest: &Range<usize>| rest.start..rest.end.min(rest.start + length);
    rests.windows(2).map(|pair| (tail(&pair[0]), head(&pair[1]))).collect()
}

/// Describes accelerometer levels that differ across pauses, by less than certainly makes another orientation.
pub(crate) fn after_pauses(recording: &Recording, still: &[bool]) -> Option<String> {
    let changes: Vec<(f64, usize)> = neighbouring_rests(recording, still)
        .into_iter()
        .filter(|(tail, head)| tail.end == head.start && !is_far(recording, tail, head))
        .filter_map(|(tail, head)| Some((after_pause(recording, &tail, &head)?, head.start)))
        .collect();
    let (change, row) = *changes.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let time_s = recording.time_s[row];
    let pause_s = time_s - recording.time_s[row - 1];
    let after = match changes.len() {
        1 => format!("after a pause of {pause_s:.1} s, at {time_s:.1} s,"),
        count => format!("after {count} pauses, most at {time_s:.1} s,"),
    };
    let tilt = (change / f64::from(GRAVITY_MPS2)).to_degrees();
    Some(format!(
        "{after} the accelerometers show another level, by {change:.3} m/s², as a tilt of {tilt:.1}° would: orientation changed or bias step, indistinguishable across a pause; each side has a separate level"
    ))
}

/// Change of the accelerometer levels across a pause, m/s², if a different direction of gravity explains it: beyond the
/// noise and the temperature dependence of a bias, and without a change of |a|. One or two axes do not determine |a|.
/// `None` for a gap shorter than a second, or without such a change.
fn after_pause(recording: &Recording, before: &Range<usize>, after: &Range<usize>) -> Option<f64> {
    let at = recording.segments.binary_search_by_key(&after.start, |segment| segment.rows.start).ok()?;
    let segment = &recording.segments[at];
    let pause_s = segment.missing_before as f64 * recording.rate.period_s;
    if pause_s < PAUSE_S && segment.boundary != Boundary::Recording {
        return None;
    }
    let axes: Vec<&[f64]> = ACCELEROMETERS
        .iter()
        .filter_map(|name| recording.channel(name).ok())
        .map(|c| &c.values[..])
        .collect();
    let level = |axis: &[f64], rows: &Range<usize>| {
        let values: Vec<f64> = axis[rows.clone()].iter().copied().filter(|value| value.is_finite()).collect();
        let squares: f64 = values.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
        let pairs = values.len().checked_sub(1).filter(|pairs| *pairs + 1 >= MIN_ROWS)? as f64;
        Some((mean(&[&values]), squares / (2.0 * pairs) / values.len() as f64))
    };
    let (mut change, mut variance, mut squares) = (0.0, 0.0, [0.0; 2]);
    for axis in &axes {
        let ((was, error), (is, other)) = (level(axis, before)?, level(axis, after)?);
        change += (is - was).powi(2);
        variance += error + other;
        squares[0] += was * was;
        squares[1] += is * is;
    }
    let (change, error) = (change.sqrt(), f64::sqrt(variance));
    let temperature =
        |rows: &Range<usize>| finite_median(&recording.channel("temp_c").ok()?.values[rows.clone()]);
    let warmer =
        temperature(before).zip(temperature(after)).map_or(0.0, |(before, after)| (after - before).abs());
    let has_moved = change > MIN_SIGMAS * error && change > MIN_TILT_MPS2 + BIAS_PER_K * warmer;
    let of_magnitude = (squares[1].sqrt() - squares[0].sqrt()).abs();
    let is_conserved = axes.len() < 3 || of_magnitude < MAX_MAGNITUDE_SHARE * change + MIN_SIGMAS * error;
    (has_moved && is_conserved).then_some(change)
}

/// Ranges of one level each within `within`: from its begin to the first turn, from there to the next, and so on.
pub fn levels_between(turns: &[usize], within: Range<usize>) -> Vec<Range<usize>> {
    let turns = || turns.iter().copied().filter(|turn| *turn > within.start && *turn < within.end);
    let starts = std::iter::once(within.start).chain(turns());
    starts.zip(turns().chain([within.end])).map(|(start, end)| start..end).collect()
}

/// Accelerometer levels in the two ranges of rows; `None` if one has no value.
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

/// Returns true if two accelerometers changed their level across a motion, or one by a large amount.
pub(crate) fn is_tilted(recording: &Recording, before: &Range<usize>, after: &Range<usize>) -> bool {
    is_tilted_by(recording, before, after, MIN_TILTED)
}

/// Returns true if at least `fewest` accelerometers changed their level, or one by a large amount.
fn is_tilted_by(recording: &Recording, before: &Range<usize>, after: &Range<usize>, fewest: usize) -> bool {
    let has_moved = |name: &&str| {
        let Ok(series) = recording.error_series(name) else { return false };
        let part = |rows: &Range<usize>| -> Vec<f64> {
            series.values[rows.clone()].iter().copied().filter(|value| value.is_finite()).collect()
        };
        let (mut before, mut after) = (part(before), part(after));
        if before.len() < MIN_ROWS || after.len() < MIN_ROWS {
            return false;
        }
        // standard error of a median of normal noise
        let error = 1.25 * (noise(&before) / before.len() as f64 + noise(&after) / after.len() as f64).sqrt();
        let moved = (median(&mut after) - median(&mut before)).abs();
        moved > MIN_SIGMAS * error && moved > MIN_TILT_MPS2
    };
    ACCELEROMETERS.iter().filter(|name| has_moved(name)).count() >= fewest || is_far(recording, before, after)
}

fn is_far(recording: &Recording, before: &Range<usize>, after: &Range<usize>) -> bool {
    levels(recording, before, after).is_some_and(|(before, after)| is_other(&before, &after))
}

/// Variance of the noise, from the differences of consecutive values.
fn noise(values: &[f64]) -> f64 {
    let mut steps: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    (MAD_TO_SD * median(&mut steps)).powi(2) / 2.0
}

fn is_other(one: &[f64], other: &[f64]) -> bool {
    let squares = one.iter().zip(other).map(|(a, b)| (a - b).powi(2));
    squares.sum::<f64>().sqrt() > MIN_CHANGE_MPS2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{LoadOptions, Source};
    use fos_testkit::noise::white_noise;

    const G: f64 = GRAVITY_MPS2 as f64;

    /// 60 s at 50 Hz with the specific force `force` of time.
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
    fn bias_drift_and_knocks_are_no_orientation() {
        let warms_up = |t: f64| [0.4 * (1.0 - (-t / 10.0).exp()), 0.1, G];
        let steps = |t: f64| [if t > 20.0 { 0.5 } else { -0.3 }, 0.0, G];
        let knocked = |t: f64| if (30.0..31.5).contains(&t) { [6.0, 0.0, 3.0] } else { [0.0, 0.0, G] };
        let wild = |t: f64| if (10.0..10.3).contains(&t) { [1e9, f64::NAN, G] } else { [0.0, 0.0, G] };
        // a channel logged without gravity has no orientation
        let free = |_: f64| [0.0; 3];
        let all: [&dyn Fn(f64) -> [f64; 3]; 5] = [&warms_up, &steps, &knocked, &wild, &free];
        for (i, force) in all.into_iter().enumerate() {
            assert_eq!(found(force, &ACCELEROMETERS).len(), 1, "{i}");
        }
    }

    #[test]
    fn level_change_across_stated_motion_is_another_orientation() {
        let time_s: Vec<f64> = (0..3000).map(|k| f64::from(k) * 0.02).collect();
        let axis = |(i, name): (usize, &str)| {
            let noise = white_noise(i as u64, 3000);
            let level = |row: usize| if i == 1 && row >= 1500 { 0.1 } else { 0.0 };
            (name.to_owned(), (0..3000).map(|row| level(row) + 0.01 * noise[row]).collect())
        };
        let axes = ACCELEROMETERS.into_iter().enumerate().map(axis);
        let columns = std::iter::once(("t_s".to_owned(), time_s)).chain(axes).collect();
        let unstated =
            Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap();
        let still: Vec<bool> = (0..3000).map(|row| !(1000..2000).contains(&row)).collect();
        assert!(turns(&unstated, &still, &[]).is_empty(), "one accelerometer may have a step of its bias");
        let stated = unstated.with_rests(still.clone(), Vec::new());
        assert_eq!(turns(&stated, &still, &[]), [2000]);
    }

    #[test]
    fn finds_two_orientations_by_all_axes_or_one() {
        let turned = |t: f64| if t < 25.0 { [0.0, 0.0, G] } else { [G * 0.5, 0.0, G * 0.75_f64.sqrt()] };
        let poses = found(turned, &ACCELEROMETERS);
        assert_eq!((poses[0].rows.clone(), poses[1].rows.start), (0..1250, 1250));
        assert_eq!(found(turned, &ACCELEROMETERS[..1]).len(), 2);
        assert_eq!(found(turned, &ACCELEROMETERS[1..2]).len(), 1, "it shows nothing along y");
        // rows that are not at rest are ignored
        let mut used = [true; 3000];
        used[1250..].fill(false);
        assert_eq!(first_two(&log(turned), &ACCELEROMETERS, &used).len(), 1);
        assert_eq!(columns_of(&log(turned), "ay_mps2"), ACCELEROMETERS);
        assert!(columns_of(&log(turned), "gx_rads").is_empty());
    }

    /// Two minutes at 50 Hz with a pause in the middle: noise of 0.012 m/s², specific force and temperature (°C) of
    /// each half.
    fn with_pause(pause_s: f64, force: [[f64; 3]; 2], celsius: [f64; 2]) -> Recording {
        let half = |row: usize| usize::from(row >= 3000);
        let time_s: Vec<f64> = (0..6000).map(|k| k as f64 * 0.02 + pause_s * half(k) as f64).collect();
        let noise: Vec<Vec<f64>> = (1..4).map(|seed| white_noise(seed, 6000)).collect();
        let axis = |i: usize| (0..6000).map(|k| force[half(k)][i] + 0.012 * noise[i][k]).collect();
        let axes = ACCELEROMETERS.into_iter().enumerate().map(|(i, name)| (name.to_owned(), axis(i)));
        let temperature = ("temp_c".to_owned(), (0..6000).map(|k| celsius[half(k)]).collect());
        let columns = std::iter::once(("t_s".to_owned(), time_s)).chain(axes).chain([temperature]).collect();
        Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap()
    }

    /// Pauses (s) and tilts (°) after which a rule for level changes finds none.
    fn overlooked(rule: impl Fn(&Recording) -> Vec<usize>) -> Vec<(f64, f64)> {
        let lying = [0.1, 0.2, 9.79];
        let tilted = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            [lying[0] * cos + lying[2] * sin, lying[1], lying[2] * cos - lying[0] * sin]
        };
        let cases = [1.5, 5.0, 60.0]
            .into_iter()
            .flat_map(|pause_s| [0.5, 1.0, 3.0, 5.0, 8.0, 15.0].map(|degrees| (pause_s, degrees)));
        let turns = |(pause_s, degrees): &(f64, f64)| {
            rule(&with_pause(*pause_s, [lying, tilted(*degrees)], [25.0; 2]))
        };
        cases.filter(|case| turns(case) != [3000]).collect()
    }

    #[test]
    fn tilt_across_a_pause_starts_a_new_level() {
        let at_rest = |log: &Recording| turns(log, &[true; 6000], &[]);
        assert_eq!(overlooked(at_rest), []);
        // negative control: another orientation only if the levels are 6° apart
        let far = |log: &Recording| {
            let rests = neighbouring_rests(log, &[true; 6000]);
            let far = rests.into_iter().filter(|(before, after)| is_far(log, before, after));
            far.map(|(_, after)| after.start).collect()
        };
        assert_eq!(overlooked(far).len(), 12);
    }

    #[test]
    fn level_change_without_a_possible_tilt_is_ignored() {
        let lying = [0.1, 0.2, 9.79];
        let found = |pause_s: f64, after: [f64; 3], celsius: [f64; 2]| {
            turns(&with_pause(pause_s, [lying, after], celsius), &[true; 6000], &[]).len()
        };
        let tilted = [0.27, 0.2, 9.79];
        assert_eq!(found(60.0, tilted, [25.0; 2]), 1);
        assert_eq!(found(0.0, tilted, [25.0; 2]), 0, "recorded without a pause");
        assert_eq!(found(60.0, [0.1, 0.2, 9.9], [25.0; 2]), 0, "|a| changed");
        assert_eq!(found(60.0, lying, [25.0; 2]), 0);
        assert_eq!(found(60.0, [0.2, 0.2, 9.79], [25.0, 37.0]), 0, "a bias may follow 12 K so far");
    }

    #[test]
    fn warns_that_tilt_and_step_are_indistinguishable_across_a_pause() {
        let log = with_pause(60.0, [[0.1, 0.2, 9.79], [0.27, 0.2, 9.79]], [25.0; 2]);
        let message = after_pauses(&log, &[true; 6000]).expect("a change");
        assert!(message.contains("after a pause of 60.0 s") && message.contains("tilt of 1.0°"), "{message}");
        assert!(message.contains("orientation changed or bias step, indistinguishable"), "{message}");
    }
}

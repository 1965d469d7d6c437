//! Classification of a motion by its length, the rotation of the device, and the levels before and after it.

use std::ops::Range;

use crate::column::GYROS;
use crate::pose;
use crate::recording::{Disturbance, Kind, Recording};
use crate::statistics::median;

/// Longest ringing of a blow, s.
const KNOCK_S: f64 = 2.0;

/// Longest shaking by steps or a motor, s.
const SHAKING_S: f64 = 25.0;

/// Minimum rotation by a hand that picks up a device, rad: 10°. A blow that a gyro cannot follow seems to turn the
/// device by some degrees.
const TURNED_RAD: f64 = 0.17;

/// Minimum rotation if the orientation differs afterwards, rad: 2°.
const TILTED_RAD: f64 = 0.035;

/// Classifies the motion in these rows.
pub(super) fn classify(recording: &Recording, rows: Range<usize>, rest: &[bool]) -> Disturbance {
    let period_s = recording.rate.period_s;
    let seconds = rows.len() as f64 * period_s;
    let beside = beside(recording, &rows, rest);
    let turned_rad = beside.as_ref().and_then(|[before, _]| turned(recording, &rows, before));
    let is_tilted = beside.is_some_and(|[before, after]| pose::is_tilted(recording, &before, &after));
    let by_more = |limit: f64| turned_rad.is_some_and(|angle| angle > limit);
    let kind = if by_more(TURNED_RAD) || is_tilted && (seconds > KNOCK_S || by_more(TILTED_RAD)) {
        Kind::Handling
    } else if seconds <= KNOCK_S {
        Kind::Knock
    } else if seconds <= SHAKING_S {
        Kind::Shaking
    } else {
        Kind::Sway
    };
    let rows = if kind == Kind::Handling { with_margin(recording, rows) } else { rows };
    // a device held in the hand is not put down exactly as it lay
    Disturbance { rows, kind, turned_rad, is_tilted: is_tilted || kind == Kind::Handling, channel: None }
}

/// Margin before and after handling, s: a hand starts and stops smoothly.
const HAND_MARGIN_S: f64 = 1.0;

fn with_margin(recording: &Recording, rows: Range<usize>) -> Range<usize> {
    let margin = (HAND_MARGIN_S / recording.rate.period_s) as usize;
    rows.start.saturating_sub(margin)..(rows.end + margin).min(recording.n_rows())
}

/// Rows at rest before and after, of [`pose::LEVEL_S`] each, within the segment.
fn beside(recording: &Recording, rows: &Range<usize>, rest: &[bool]) -> Option<[Range<usize>; 2]> {
    let length = (pose::LEVEL_S / recording.rate.period_s) as usize;
    let segment = recording.segments.iter().find(|segment| segment.rows.contains(&rows.start))?;
    let before = rows.start.saturating_sub(length).max(segment.rows.start)..rows.start;
    let after = rows.end..(rows.end + length).min(segment.rows.end);
    let is_known = |part: &Range<usize>| part.len() >= 10 && part.clone().all(|row| rest[row]);
    (is_known(&before) && is_known(&after)).then_some([before, after])
}

/// Largest angle from the initial orientation, rad, from the gyros minus their level before.
fn turned(recording: &Recording, rows: &Range<usize>, before: &Range<usize>) -> Option<f64> {
    let mut angle = vec![[0.0_f64; 3]; rows.len()];
    for (axis, name) in GYROS.into_iter().enumerate() {
        let values = &recording.channel(name).ok()?.values;
        let bias = median(&mut values[before.clone()].to_vec());
        let mut sum = 0.0;
        for (angle, row) in angle.iter_mut().zip(rows.clone()) {
            let rate = values[row] - bias;
            sum += if rate.is_finite() { rate * recording.rate.period_s } else { 0.0 };
            angle[axis] = sum;
        }
    }
    let size = |angle: &[f64; 3]| angle.iter().map(|part| part * part).sum::<f64>().sqrt();
    Some(angle.iter().map(size).fold(0.0, f64::max))
}

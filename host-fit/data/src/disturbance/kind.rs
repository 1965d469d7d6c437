//! What a motion looks like, from its length, how far the unit turned, and the levels before and after it.

use std::ops::Range;

use crate::column::GYROS;
use crate::pose;
use crate::recording::Recording;
use crate::statistics::median;

/// A stretch of a log in which the unit was moved.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Disturbance {
    /// Its rows, the margins of the sensor's ring-down included.
    pub rows: Range<usize>,
    pub kind: Kind,
    /// Turned by so much, rad, by its gyros; `None` without all three.
    pub turned_rad: Option<f64>,
    /// Gravity may have another direction after it than before: each rest has a level of its own.
    pub is_tilted: bool,
    /// The logged channel that explains it: [`Kind::Explained`] alone has one.
    pub channel: Option<String>,
}

impl Disturbance {
    /// Neither turned nor tilted.
    pub(super) fn level(rows: Range<usize>, kind: Kind) -> Self {
        Self { rows, kind, turned_rad: None, is_tilted: false, channel: None }
    }

    /// Returns true if its rows are excluded: not those of lasting vibration, which is a state of the device's surroundings and
    /// may cause an effect, nor those that a logged channel explains.
    pub fn is_left_out(&self) -> bool {
        !matches!(self.kind, Kind::Vibration | Kind::Explained)
    }
}

/// What a motion looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Short: a blow.
    Knock,
    /// Seconds of shaking: steps, a motor.
    Shaking,
    /// Taken into the hand, or turned.
    Handling,
    /// Slow, of small size, for long: a building that sways.
    Sway,
    /// Lasting vibration: a machine that runs.
    Vibration,
    /// The device moves all along: a vehicle, a body.
    Motion,
    /// No motion: a shared step of the axes that a logged channel explains.
    Explained,
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Self::Knock => "knock",
            Self::Shaking => "shaking",
            Self::Handling => "handling",
            Self::Sway => "sway",
            Self::Vibration => "vibration",
            Self::Motion => "motion",
            Self::Explained => "effect of a logged channel",
        }
    }
}

/// Blows ring no longer, s.
const KNOCK_S: f64 = 2.0;

/// Shaking by steps or a motor lasts no longer, s.
const SHAKING_S: f64 = 25.0;

/// Whoever takes a unit into the hand turns it by more than this, rad: 10°. Blows that a gyro cannot follow seem to turn
/// it by some degrees.
const TURNED_RAD: f64 = 0.17;

/// If it lies in another pose afterwards it was turned by more than this: 2°.
const TILTED_RAD: f64 = 0.035;

/// What the motion in these rows looks like.
pub(super) fn described(recording: &Recording, rows: Range<usize>, rest: &[bool]) -> Disturbance {
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
    // who had it in the hand does not put it down exactly as it lay
    Disturbance { rows, kind, turned_rad, is_tilted: is_tilted || kind == Kind::Handling, channel: None }
}

/// A hand comes and goes without a jerk: so much before and after, s.
const HAND_MARGIN_S: f64 = 1.0;

fn with_margin(recording: &Recording, rows: Range<usize>) -> Range<usize> {
    let margin = (HAND_MARGIN_S / recording.rate.period_s) as usize;
    rows.start.saturating_sub(margin)..(rows.end + margin).min(recording.n_rows())
}

/// The rows at rest before and after, of [`pose::LEVEL_S`] each, within the segment.
fn beside(recording: &Recording, rows: &Range<usize>, rest: &[bool]) -> Option<[Range<usize>; 2]> {
    let length = (pose::LEVEL_S / recording.rate.period_s) as usize;
    let segment = recording.segments.iter().find(|segment| segment.rows.contains(&rows.start))?;
    let before = rows.start.saturating_sub(length).max(segment.rows.start)..rows.start;
    let after = rows.end..(rows.end + length).min(segment.rows.end);
    let is_known = |part: &Range<usize>| part.len() >= 10 && part.clone().all(|row| rest[row]);
    (is_known(&before) && is_known(&after)).then_some([before, after])
}

/// The largest angle away from the begin, by the gyros without their level before; rad.
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

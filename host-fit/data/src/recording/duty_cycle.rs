//! Duty-cycled logs: pauses at regular intervals are the plan of the recorder and no loss.

use std::fmt;

use super::{Boundary, Recording, Segment};
use crate::statistics::median;

/// A shorter wait is no pause of a recorder, s: a buffer that was not read in time or a bus that was busy.
const SHORTEST_PAUSE_S: f64 = 1.0;

/// Fewer pauses show no rule. Losses at random moments have exponential intervals, of which 28 % lie within [`SIMILAR`] of
/// their median: that nearly all of eight do is once in ten thousand logs.
const FEWEST_PAUSES: usize = 8;

/// Lengths that differ from their median by less than this factor are similar.
const SIMILAR: f64 = 1.5;

/// Share of the pauses that must be similar, and lie at similar intervals.
const REGULAR_SHARE: f64 = 0.9;

/// A log that is recorded in bursts at regular intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DutyCycle {
    /// How many bursts.
    pub bursts: usize,
    /// Length of a usual burst, s.
    pub burst_s: f64,
    /// From the start of a usual burst to the start of the next, s.
    pub every_s: f64,
}

impl fmt::Display for DutyCycle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { bursts, burst_s, every_s } = self;
        write!(f, "recorded in {bursts} bursts of {burst_s:.1} s every {every_s:.1} s")
    }
}

impl Recording {
    /// The duty cycle of the log, if it has one.
    pub fn duty_cycle(&self) -> Option<DutyCycle> {
        let (pauses, cycle) = regular(&self.segments, self.rate.period_s)?;
        pauses.iter().all(|pause| self.segments[*pause].boundary == Boundary::Pause).then_some(cycle)
    }
}

/// The segments that begin after a pause at a regular interval, and the duty cycle; `None` if the waits are irregular.
pub(super) fn regular(segments: &[Segment], period_s: f64) -> Option<(Vec<usize>, DutyCycle)> {
    let is_wait = |segment: &Segment| {
        matches!(segment.boundary, Boundary::Gap | Boundary::Pause)
            && segment.missing_before as f64 * period_s >= SHORTEST_PAUSE_S
    };
    let waits: Vec<usize> = (1..segments.len()).filter(|place| is_wait(&segments[*place])).collect();
    if waits.len() < FEWEST_PAUSES {
        return None;
    }
    let length = |wait: usize| segments[wait].missing_before as f64;
    let lengths: Vec<f64> = waits.iter().map(|wait| length(*wait)).collect();
    // from the end of a wait to the start of the next, losses within the burst included
    let bursts = waits.windows(2).map(|pair| (segments[pair[1]].tick - segments[pair[0]].tick) as f64);
    let bursts: Vec<f64> = bursts.zip(&lengths[1..]).map(|(every, wait)| every - wait).collect();
    let (usual_wait, usual_burst) = (median(&mut lengths.clone()), median(&mut bursts.clone()));
    let is_similar = |value: f64, usual: f64| value < SIMILAR * usual && usual < SIMILAR * value;
    let share = |values: &[f64], usual: f64| {
        values.iter().filter(|value| is_similar(**value, usual)).count() as f64 / values.len() as f64
    };
    let is_regular = share(&lengths, usual_wait).min(share(&bursts, usual_burst)) >= REGULAR_SHARE;
    let pauses: Vec<usize> = waits.into_iter().filter(|wait| is_similar(length(*wait), usual_wait)).collect();
    let cycle = DutyCycle {
        bursts: pauses.len() + 1,
        burst_s: usual_burst * period_s,
        every_s: (usual_burst + usual_wait) * period_s,
    };
    is_regular.then_some((pauses, cycle))
}

//! Duty-cycled logs: pauses at regular intervals are planned by the recorder and no loss.

use std::fmt;

use super::grid::regular_pauses;
use super::{Boundary, Recording};

/// Duty cycle of a log recorded in bursts at regular intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DutyCycle {
    pub bursts: usize,
    /// Length of a typical burst, s.
    pub burst_s: f64,
    /// Time from the start of a typical burst to the start of the next, s.
    pub every_s: f64,
}

impl fmt::Display for DutyCycle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { bursts, burst_s, every_s } = self;
        write!(f, "recorded in {bursts} bursts of {burst_s:.1} s every {every_s:.1} s")
    }
}

impl Recording {
    /// Duty cycle of the log, if it has one.
    pub fn duty_cycle(&self) -> Option<DutyCycle> {
        let period_s = self.rate.period_s;
        let (pauses, [burst, wait]) = regular_pauses(&self.segments, period_s)?;
        let are_pauses = pauses.iter().all(|pause| self.segments[*pause].boundary == Boundary::Pause);
        let (burst_s, every_s) = (burst * period_s, (burst + wait) * period_s);
        are_pauses.then_some(DutyCycle { bursts: pauses.len() + 1, burst_s, every_s })
    }
}

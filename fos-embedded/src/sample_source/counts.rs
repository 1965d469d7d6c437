//! Counts of faults.

use super::SourceError;
use crate::raw::Faults;

/// Counts of samples and faults since the source was created. Each count saturates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Counts {
    /// Complete samples returned.
    pub samples: u32,
    /// Transfers that failed, repetitions included ([`Faults::BUS`]).
    pub bus: u32,
    /// Frames discarded because they were incomplete or out of order ([`Faults::BUS`]).
    pub damaged: u32,
    /// Polls that found a FIFO overrun ([`Faults::OVERRUN`]).
    pub overruns: u32,
    /// Gaps of any length ([`Faults::GAP`]).
    pub gaps: u32,
    /// Ticks in these gaps.
    pub skipped: u32,
    /// Repeated set-ups of the part ([`Faults::RESET`]).
    pub resets: u32,
    /// Set-ups that found another part ([`Faults::WRONG_PART`]).
    pub wrong_part: u32,
    /// Set-ups that failed because a register did not hold its value, or the part reported a fatal error.
    pub verify_failed: u32,
    /// Samples from a stuck sensor, which repeats the same codes ([`Faults::STUCK`]).
    pub stuck: u32,
    /// Samples without a temperature ([`Faults::TEMPERATURE`]).
    pub temperature: u32,
}

impl Counts {
    pub(super) const ZERO: Self = Self {
        samples: 0,
        bus: 0,
        damaged: 0,
        overruns: 0,
        gaps: 0,
        skipped: 0,
        resets: 0,
        wrong_part: 0,
        verify_failed: 0,
        stuck: 0,
        temperature: 0,
    };

    /// Counts an error and adds its fault to `faults`, for the next sample.
    pub(super) fn note<E>(&mut self, error: &SourceError<E>, faults: &mut Faults) {
        let (fault, count) = match error {
            SourceError::Bus(_) => (Faults::BUS, &mut self.bus),
            SourceError::WrongPart(_) => (Faults::WRONG_PART, &mut self.wrong_part),
            SourceError::VerifyFailed { .. } | SourceError::Fatal => (Faults::RESET, &mut self.verify_failed),
            SourceError::Resting(_) => return,
        };
        *faults |= fault;
        *count = count.saturating_add(1);
    }
}

//! What went wrong, and how often.

use super::SourceError;
use crate::raw::Faults;

/// What went wrong since a source was made, and how often. Each count stays at its highest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Counts {
    /// Samples given, whole ones alone.
    pub samples: u32,
    /// Transfers that failed, repetitions included ([`Faults::BUS`]).
    pub bus: u32,
    /// Frames that were incomplete or out of order, and could not be used ([`Faults::BUS`]).
    pub torn: u32,
    /// Polls that found the FIFO run over ([`Faults::OVERRUN`]).
    pub overruns: u32,
    /// Gaps ([`Faults::GAP`]), however long each.
    pub gaps: u32,
    /// Ticks in these gaps.
    pub skipped: u32,
    /// Times that the part was set up anew ([`Faults::RESET`]).
    pub resets: u32,
    /// Set-ups that found another part ([`Faults::WRONG_PART`]).
    pub wrong_part: u32,
    /// Set-ups that the part did not take.
    pub not_kept: u32,
    /// Samples that repeat the same codes for too long ([`Faults::STUCK`]).
    pub stuck: u32,
    /// Samples without a temperature ([`Faults::TEMPERATURE`]).
    pub temperature: u32,
}

impl Counts {
    pub(super) const ZERO: Self = Self {
        samples: 0,
        bus: 0,
        torn: 0,
        overruns: 0,
        gaps: 0,
        skipped: 0,
        resets: 0,
        wrong_part: 0,
        not_kept: 0,
        stuck: 0,
        temperature: 0,
    };

    /// Counts an error; the next sample will say what it was.
    pub(super) fn note<E>(&mut self, error: &SourceError<E>, faults: &mut Faults) {
        let (fault, count) = match error {
            SourceError::Bus(_) => (Faults::BUS, &mut self.bus),
            SourceError::WrongPart(_) => (Faults::WRONG_PART, &mut self.wrong_part),
            SourceError::NotKept { .. } | SourceError::Fatal => (Faults::RESET, &mut self.not_kept),
            SourceError::Resting(_) => return,
        };
        *faults |= fault;
        *count = count.saturating_add(1);
    }
}

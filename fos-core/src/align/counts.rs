//! Counts of the samples that did not enter a row unchanged, and the reasons.

/// Reason why a sample was rejected, or entered a row as missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refused {
    /// The stream does not exist.
    NoSuchStream,
    /// The timestamp is not above the newest of its stream.
    NotIncreasing,
    /// A value is NaN or infinite: the sample counts as missing.
    NotFinite,
}

impl core::fmt::Display for Refused {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NoSuchStream => "no such stream",
            Self::NotIncreasing => "the stamp is not above the one before",
            Self::NotFinite => "a value is not finite",
        })
    }
}

impl core::error::Error for Refused {}

/// Counts of one stream; each saturates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counts {
    /// Samples whose timestamp did not increase.
    pub refused: u32,
    /// Samples with a value that is not finite.
    pub not_finite: u32,
    /// Samples dropped because the queue was full or the clock was set back.
    pub dropped: u32,
    /// Number of times the clock was set back.
    pub set_back: u32,
    /// Rows without a value of the stream. 0 for the lead, whose missing rows are in `not_finite`.
    pub missing: u32,
}

impl Counts {
    pub(super) const NONE: Self = Self { refused: 0, not_finite: 0, dropped: 0, set_back: 0, missing: 0 };

    pub(super) fn refuse(&mut self) -> Result<(), Refused> {
        self.refused = self.refused.saturating_add(1);
        Err(Refused::NotIncreasing)
    }

    pub(super) fn miss(&mut self) -> Result<(), Refused> {
        self.not_finite = self.not_finite.saturating_add(1);
        Err(Refused::NotFinite)
    }

    pub(super) fn set_back(&mut self) {
        self.set_back = self.set_back.saturating_add(1);
    }

    pub(super) fn drop_samples(&mut self, samples: usize) {
        let samples = u32::try_from(samples).unwrap_or(u32::MAX);
        self.dropped = self.dropped.saturating_add(samples);
    }

    pub(super) fn missing_in_row(&mut self) {
        self.missing = self.missing.saturating_add(1);
    }
}

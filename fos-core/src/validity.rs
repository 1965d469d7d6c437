//! Whether a corrected value can be trusted, and why not.

use core::fmt;
use core::ops::{BitOr, BitOrAssign};

use serde::Serialize;

/// Everything that speaks against trusting a [`Correction`](crate::Correction); empty when nothing does.
///
/// It is computed for every axis and every sample and travels with the numbers it concerns.
#[must_use = "a correction must not be used without asking whether it is valid"]
#[derive(Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(transparent)]
pub struct Validity(u16);

/// Every reason, with its name, in the order of the bits.
const REASONS: [(Validity, &str); 12] = [
    (Validity::WARMING_UP, "warming up"),
    (Validity::OWN_HISTORY, "own history"),
    (Validity::COASTING_TOO_LONG, "coasting too long"),
    (Validity::OUTPUT_OUT_OF_RANGE, "output out of range"),
    (Validity::INPUT_OUT_OF_RANGE, "input out of range"),
    (Validity::NOT_FINITE, "not finite"),
    (Validity::INPUT_NOT_FINITE, "input not finite"),
    (Validity::SATURATED, "saturated"),
    (Validity::STUCK, "stuck"),
    (Validity::MISSING, "missing"),
    (Validity::NOT_MODELLED, "not modelled"),
    (Validity::AWAY_FROM_GRAVITY, "away from gravity"),
];

impl Validity {
    /// Nothing speaks against it.
    pub const VALID: Validity = Validity(0);
    /// The history is not full yet: only the physical part is subtracted.
    pub const WARMING_UP: Validity = Validity(1);
    /// Some of the history is the model's own prediction, not measurement: normal while coasting and for a few
    /// samples after it. The innovation of such a sample is not one-step.
    pub const OWN_HISTORY: Validity = Validity(1 << 1);
    /// Coasting for longer than the model was validated for: the stochastic part fades out.
    pub const COASTING_TOO_LONG: Validity = Validity(1 << 2);
    /// The remainder is far outside what was seen while fitting; it was limited before it entered the history.
    pub const OUTPUT_OUT_OF_RANGE: Validity = Validity(1 << 3);
    /// An input is outside what was seen while fitting; the model was evaluated at the edge of the range.
    pub const INPUT_OUT_OF_RANGE: Validity = Validity(1 << 4);
    /// The measured value is NaN or infinite; the last corrected value is repeated.
    pub const NOT_FINITE: Validity = Validity(1 << 5);
    /// A logged quantity is NaN, infinite or absent; its last finite value was used.
    pub const INPUT_NOT_FINITE: Validity = Validity(1 << 6);
    /// The measured value is at or beyond full scale; it did not enter the history.
    pub const SATURATED: Validity = Validity(1 << 7);
    /// The measured value has repeated for longer than noise allows; it did not enter the history.
    pub const STUCK: Validity = Validity(1 << 8);
    /// There was no sample.
    pub const MISSING: Validity = Validity(1 << 9);
    /// The model does not have this axis: nothing was taken out.
    pub const NOT_MODELLED: Validity = Validity(1 << 10);
    /// At rest the three accelerometers together, corrected, were further from gravity than as measured: the model was fitted to
    /// something else. A predictor does not look at axes together; a hub does.
    pub const AWAY_FROM_GRAVITY: Validity = Validity(1 << 11);
    /// Everything that can be.
    pub const ALL: Validity = Validity((1 << 12) - 1);

    /// Nothing speaks against it. [`OWN_HISTORY`](Self::OWN_HISTORY) counts: a coasted value is an extrapolation.
    pub const fn is_valid(self) -> bool {
        self.0 == 0
    }

    /// All of `reasons` apply.
    pub const fn contains(self, reasons: Validity) -> bool {
        self.0 & reasons.0 == reasons.0
    }

    /// At least one of `reasons` applies.
    pub const fn intersects(self, reasons: Validity) -> bool {
        self.0 & reasons.0 != 0
    }

    /// The reasons as bits, for storage and telemetry.
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// `reason` if `applies`, else nothing.
    #[inline]
    pub(crate) const fn when(applies: bool, reason: Validity) -> Validity {
        if applies { reason } else { Validity::VALID }
    }

    /// The reasons that apply, one by one.
    pub fn reasons(self) -> impl Iterator<Item = Validity> {
        self.named().map(|(reason, _)| reason)
    }

    /// The reasons that apply, by name.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        self.named().map(|(_, name)| name)
    }

    fn named(self) -> impl Iterator<Item = (Validity, &'static str)> {
        REASONS.into_iter().filter(move |(reason, _)| self.contains(*reason))
    }
}

impl BitOr for Validity {
    type Output = Validity;
    #[inline]
    fn bitor(self, other: Validity) -> Validity {
        Validity(self.0 | other.0)
    }
}

impl BitOrAssign for Validity {
    #[inline]
    fn bitor_assign(&mut self, other: Validity) {
        self.0 |= other.0;
    }
}

impl fmt::Debug for Validity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_valid() {
            return f.write_str("valid");
        }
        let mut separator = "";
        for name in self.names() {
            write!(f, "{separator}{name}")?;
            separator = ", ";
        }
        Ok(())
    }
}

/// As [`Debug`](fmt::Debug) has it.
#[cfg(feature = "defmt")]
impl defmt::Format for Validity {
    fn format(&self, f: defmt::Formatter<'_>) {
        if self.is_valid() {
            return defmt::write!(f, "valid");
        }
        let mut separator = "";
        for name in self.names() {
            // as text: derived formats around this one ask for quotes
            defmt::write!(f, "{=str:a}{=str:a}", separator, name);
            separator = ", ";
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_has_a_reason_and_a_name() {
        let every = Validity::ALL.reasons().fold(Validity::VALID, |every, reason| {
            assert_eq!(reason.bits().count_ones(), 1);
            assert!(!every.intersects(reason), "twice: {reason:?}");
            every | reason
        });
        assert_eq!(every, Validity::ALL);
        assert_eq!(Validity::ALL.names().count(), Validity::ALL.reasons().count());
    }
}

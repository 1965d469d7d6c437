//! Whether a corrected value can be trusted, and why not.

use core::fmt;

use bitflags::{Flags, bitflags};
use serde::{Serialize, Serializer};

bitflags! {
    /// Everything that speaks against trusting a [`Correction`](crate::Correction); empty when nothing does.
    ///
    /// It is computed for every axis and every sample and travels with the numbers it concerns. Storage and telemetry
    /// have its bits.
    #[must_use = "a correction must not be used without asking whether it is valid"]
    #[derive(Clone, Copy, PartialEq, Eq, Default)]
    pub struct Validity: u16 {
        /// The history is not full yet: only the physical part is subtracted.
        const WARMING_UP = 1;
        /// Some of the history is the model's own prediction, not measurement: normal while coasting and for a few
        /// samples after it. The innovation of such a sample is not one-step.
        const OWN_HISTORY = 1 << 1;
        /// Coasting for longer than the model was validated for: the stochastic part fades out.
        const COASTING_TOO_LONG = 1 << 2;
        /// The remainder is far outside what was seen while fitting; it was limited before it entered the history.
        const OUTPUT_OUT_OF_RANGE = 1 << 3;
        /// An input, or the inputs together, are outside what was seen while fitting; the model was evaluated at the edge
        /// of the range.
        const INPUT_OUT_OF_RANGE = 1 << 4;
        /// The measured value is NaN or infinite; the last corrected value is repeated.
        const NOT_FINITE = 1 << 5;
        /// A logged quantity is NaN, infinite or absent; its last finite value was used.
        const INPUT_NOT_FINITE = 1 << 6;
        /// The measured value is at or beyond full scale; it did not enter the history.
        const SATURATED = 1 << 7;
        /// The measured value has repeated for longer than noise allows; it did not enter the history.
        const STUCK = 1 << 8;
        /// There was no sample.
        const MISSING = 1 << 9;
        /// The model does not have this axis: nothing was taken out.
        const NOT_MODELLED = 1 << 10;
        /// At rest the three accelerometers together, corrected, were further from gravity than as measured: the model
        /// was fitted to something else. A predictor does not look at axes together; a hub does.
        const AWAY_FROM_GRAVITY = 1 << 11;
    }
}

/// How people are told the reasons, in the order of the bits.
const NAMES: [&str; Validity::FLAGS.len()] = [
    "warming up",
    "own history",
    "coasting too long",
    "output out of range",
    "input out of range",
    "not finite",
    "input not finite",
    "saturated",
    "stuck",
    "missing",
    "not modelled",
    "away from gravity",
];

impl Validity {
    /// Nothing speaks against it.
    pub const VALID: Validity = Validity::empty();

    /// Nothing speaks against it. A coasted value is an extrapolation and not valid: [`OWN_HISTORY`](Self::OWN_HISTORY)
    /// speaks against it.
    #[inline]
    pub const fn is_valid(self) -> bool {
        self.is_empty()
    }

    /// `reason` if `applies`, else nothing.
    #[inline]
    pub(crate) const fn when(applies: bool, reason: Validity) -> Validity {
        if applies { reason } else { Validity::VALID }
    }

    /// The reasons that apply, as people are told them: "warming up".
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Self::FLAGS
            .iter()
            .zip(NAMES)
            .filter(move |(flag, _)| self.contains(*flag.value()))
            .map(|(_, name)| name)
    }
}

/// As its bits.
impl Serialize for Validity {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.bits().serialize(serializer)
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
    fn people_are_told_the_name_of_every_bit() {
        assert_eq!(Validity::all().bits(), (1 << NAMES.len()) - 1, "no bit between two reasons");
        for (bit, (name, reason)) in Validity::all().iter_names().enumerate() {
            assert_eq!(reason.bits(), 1 << bit);
            assert!(reason.names().eq([name.to_lowercase().replace('_', " ")]), "{name}: {reason:?}");
        }
        assert!(Validity::all().names().eq(NAMES));
    }
}

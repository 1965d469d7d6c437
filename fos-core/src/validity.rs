//! Validity of a corrected value: the reasons not to trust it.

use core::fmt;

use bitflags::{Flags, bitflags};
use serde::{Serialize, Serializer};

bitflags! {
    /// Reasons not to trust a [`Correction`](crate::Correction); empty if it is valid.
    ///
    /// Computed for every axis and sample and returned with the values. Storage and telemetry hold its bits.
    #[must_use = "a correction must not be used without asking whether it is valid"]
    #[derive(Clone, Copy, PartialEq, Eq, Default)]
    pub struct Validity: u16 {
        /// The history is not full yet: only the physical part is subtracted.
        const WARMING_UP = 1;
        /// Part of the history is the model's own prediction, not measurement. Normal while coasting and until the
        /// history is measured again. The innovation of such a sample is not a one-step
        /// prediction error.
        const OWN_HISTORY = 1 << 1;
        /// Coasting has lasted longer than the model was validated for: the stochastic part fades out.
        const COASTING_TOO_LONG = 1 << 2;
        /// The remainder is far outside its fitted range; it was limited before it entered the history.
        const OUTPUT_OUT_OF_RANGE = 1 << 3;
        /// An input, or the physical part as a whole, is outside its fitted range; the model was evaluated at the edge of
        /// the range.
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
        /// The model does not have this axis: nothing was subtracted.
        const NOT_MODELLED = 1 << 10;
        /// At rest, the corrected vector of the three accelerometers was further from gravity than the measured one: the
        /// model was fitted to other data. Set by a hub; a predictor does not combine axes.
        const AWAY_FROM_GRAVITY = 1 << 11;
    }
}

/// Readable names of the reasons, in the order of the bits.
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
    /// No reason against the value.
    pub const VALID: Validity = Validity::empty();

    /// True if there is no reason against the value. A coasted value is an extrapolation and not valid: it has
    /// [`OWN_HISTORY`](Self::OWN_HISTORY).
    #[inline]
    pub const fn is_valid(self) -> bool {
        self.is_empty()
    }

    /// `reason` if `applies`, else nothing.
    #[inline]
    pub(crate) const fn when(applies: bool, reason: Validity) -> Validity {
        if applies { reason } else { Validity::VALID }
    }

    /// Readable names of the reasons that apply, for example "warming up".
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Self::FLAGS
            .iter()
            .zip(NAMES)
            .filter(move |(flag, _)| self.contains(*flag.value()))
            .map(|(_, name)| name)
    }
}

/// Serialised as its bits.
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

/// Same text as [`Debug`](fmt::Debug).
#[cfg(feature = "defmt")]
impl defmt::Format for Validity {
    fn format(&self, f: defmt::Formatter<'_>) {
        if self.is_valid() {
            return defmt::write!(f, "valid");
        }
        let mut separator = "";
        for name in self.names() {
            // as text: derived formats around this one would add quotes
            defmt::write!(f, "{=str:a}{=str:a}", separator, name);
            separator = ", ";
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_has_a_readable_name() {
        assert_eq!(Validity::all().bits(), (1 << NAMES.len()) - 1, "no bit between two reasons");
        for (bit, (name, reason)) in Validity::all().iter_names().enumerate() {
            assert_eq!(reason.bits(), 1 << bit);
            assert!(reason.names().eq([name.to_lowercase().replace('_', " ")]), "{name}: {reason:?}");
        }
        assert!(Validity::all().names().eq(NAMES));
    }
}

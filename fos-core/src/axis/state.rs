//! State of an axis: changes with every sample.

use super::constants::AxisConstants;
use crate::{Scalar, Validity};

/// Gain below which the fading stochastic part is set to 0, so that the gain never becomes subnormal.
const FADED: f64 = 1e-6;

/// Value of the parts of an axis at this tick, its last samples, and the counters of faults and coasting.
#[derive(Debug, Clone)]
pub(crate) struct AxisState<R> {
    /// p at this tick.
    pub(crate) p: R,
    /// r̂ at this tick, before it is limited.
    pub(crate) predicted_remainder: R,
    /// p went beyond its limits at this tick.
    pub(super) limited: bool,
    /// r(n − 1), limited; 0 while it is not known.
    pub(crate) remainder: R,
    /// A remainder is available since the start or restart.
    pub(super) known: bool,
    /// The history holds only measurements, and no counter below needs a reset: the usual state at rest.
    pub(super) steady: bool,
    pub(super) last_measured: R,
    pub(super) repeats: u16,
    /// Consecutive measured samples up to now.
    pub(super) measured_run: u16,
    pub(super) ready: bool,
    pub(super) missing: u8,
    pub(super) coasted: u32,
    pub(super) gain: R,
    pub(super) corrected: R,
}

impl<R: Scalar> AxisState<R> {
    /// State before the first sample.
    pub(super) fn new(constants: &AxisConstants<R>) -> Self {
        Self {
            p: R::ZERO,
            predicted_remainder: R::ZERO,
            limited: false,
            remainder: R::ZERO,
            known: false,
            steady: false,
            // equals nothing, so that the first sample is no repetition
            last_measured: R::NAN,
            repeats: 0,
            measured_run: 0,
            ready: constants.depth == 0,
            missing: 0,
            coasted: 0,
            gain: R::ONE,
            corrected: constants.reference,
        }
    }

    /// Returns the reason not to trust p and clears it.
    pub(crate) fn take_limited(&mut self) -> Validity {
        Validity::when(core::mem::take(&mut self.limited), Validity::INPUT_OUT_OF_RANGE)
    }

    /// r(n − 1), limited. `None` before the first sample, in a gap beyond the limit, and after it until the history is
    /// full again.
    pub(crate) fn remainder(&self) -> Option<R> {
        self.known.then_some(self.remainder)
    }

    /// True if the history holds only measurements, so that a coast can begin.
    #[cfg(feature = "coasts")]
    pub(crate) fn is_steady(&self) -> bool {
        self.steady
    }

    /// Counts a coasted sample; beyond the limit it fades the stochastic part and returns true.
    #[inline(always)]
    pub(super) fn coasts_too_long(&mut self, constants: &AxisConstants<R>) -> bool {
        self.coasted = self.coasted.saturating_add(1);
        let is_too_long = self.coasted > constants.coast_limit;
        if is_too_long {
            self.fade(constants.fade);
        }
        is_too_long
    }

    /// Reduces the gain of the stochastic part by one step.
    fn fade(&mut self, step: R::Gain) {
        self.gain = self.gain.times(step);
        if self.gain < R::from_f64(FADED) {
            self.gain = R::ZERO;
        }
    }
}

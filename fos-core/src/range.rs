//! Ranges of the data of a fit: a polynomial is evaluated only within the range that it was fitted on.

use serde::{Deserialize, Serialize};

use crate::{Real, Scalar};

/// Smallest and largest value of a quantity in the data that a model was fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Range<R> {
    /// Smallest value in the data of the fit.
    pub low: R,
    /// Largest value in the data of the fit.
    pub high: R,
}

impl<R: Scalar> Range<R> {
    /// The range `low ..= high`.
    pub const fn new(low: R, high: R) -> Self {
        Self { low, high }
    }

    /// −10³⁰ … 10³⁰, which disables a limit: no intermediate sum of an accepted model reaches it.
    pub fn unlimited() -> Self {
        Self { low: R::from_f64(-1e30), high: R::from_f64(1e30) }
    }

    /// Largest magnitude in the range.
    pub(crate) fn magnitude(&self) -> R {
        let (low, high) = (self.low.abs(), self.high.abs());
        if low > high { low } else { high }
    }

    /// True if `value` lies in the range; false for NaN.
    #[inline(always)]
    pub(crate) fn contains(&self, value: R) -> bool {
        value >= self.low && value <= self.high
    }

    /// `value` limited to the range; the low end for NaN.
    #[inline]
    pub(crate) fn limit(&self, value: R) -> R {
        value.limit(self.low, self.high)
    }
}

impl<R: Real> Range<R> {
    /// The range widened on either side by `share` of its width.
    #[inline(never)]
    pub(crate) fn widened(&self, share: R) -> Self {
        let margin = share * (self.high - self.low);
        Self { low: self.low - margin, high: self.high + margin }
    }
}

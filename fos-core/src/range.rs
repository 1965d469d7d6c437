//! Was this value seen while fitting? A polynomial is trusted, and evaluated, only where it was fitted.

use serde::{Deserialize, Deserializer, Serialize};

use crate::{Real, Scalar};

/// The smallest and the largest value of a quantity in the data that a model was fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Range<R> {
    /// Smallest value seen while fitting.
    pub low: R,
    /// Largest value seen while fitting.
    pub high: R,
}

impl<R: Scalar> Range<R> {
    /// From `low` to `high`.
    pub const fn new(low: R, high: R) -> Self {
        Self { low, high }
    }

    /// −10³⁰ … 10³⁰: for what is not to be limited. No sum of a model that is run gets there.
    pub fn unlimited() -> Self {
        Self { low: R::from_f64(-1e30), high: R::from_f64(1e30) }
    }

    /// Finite, and the right way round.
    #[inline(never)]
    pub fn is_valid(&self) -> bool {
        self.low.is_finite() && self.high.is_finite() && self.low <= self.high
    }

    /// The largest magnitude in the range.
    pub(crate) fn magnitude(&self) -> R {
        let (low, high) = (self.low.abs(), self.high.abs());
        if low > high { low } else { high }
    }

    /// Whether `value` lies in the range; NaN does not.
    #[inline(always)]
    pub(crate) fn contains(&self, value: R) -> bool {
        value >= self.low && value <= self.high
    }

    /// `value` limited to the range; NaN gives its low end.
    #[inline]
    pub(crate) fn limit(&self, value: R) -> R {
        value.limit(self.low, self.high)
    }
}

impl<R: Real> Range<R> {
    /// Widened on both sides by `share` of its width.
    #[inline(never)]
    pub(crate) fn widened(&self, share: f64) -> Self {
        let margin = R::from_f64(share) * (self.high - self.low);
        Self { low: self.low - margin, high: self.high + margin }
    }
}

/// One copy for all records that have ranges: inlined into each it would be twice the flash.
impl<'de, R: Deserialize<'de>> Deserialize<'de> for Range<R> {
    #[inline(never)]
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(rename = "Range")]
        struct Ends<R> {
            low: R,
            high: R,
        }
        let Ends { low, high } = Ends::deserialize(deserializer)?;
        Ok(Self { low, high })
    }
}

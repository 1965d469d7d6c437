//! A follower: three values with separate timestamps, interpolated.

use super::counts::{Counts, Refused};
use super::order::distance;
use super::queue::{Queue, Stamped};
use crate::Real;

/// Bits of a weight, the number that f32 holds exactly.
const WEIGHT_BITS: u32 = 24;

/// 2⁻²⁴.
const WEIGHT_UNIT: f64 = 1.0 / (1_u32 << WEIGHT_BITS) as f64;

/// Longest distance that is divided exactly, bits: shifted left by the bits of the weight, plus half the divisor, it stays
/// below 2⁶⁴. In nanoseconds that is nine minutes; longer distances lose their lowest bits.
const DISTANCE_BITS: u32 = 63 - WEIGHT_BITS;

/// Values of a follower at a timestamp of the lead.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Interpolated<R> {
    /// Interpolated values; all NaN if missing.
    pub values: [R; 3],
    /// Weight w of the later neighbour in units of 2⁻²⁴: 0 exactly at a sample; `None` if missing.
    pub weight: Option<u32>,
}

#[derive(Debug, Clone)]
pub(super) struct Follower<R, const DEPTH: usize> {
    samples: Queue<[R; 3], DEPTH>,
    /// Maximum distance of neighbours, ticks.
    bridged: u64,
}

impl<R: Real, const DEPTH: usize> Follower<R, DEPTH> {
    pub(super) const NEW: Self = Self { samples: Queue::NEW, bridged: 0 };

    pub(super) fn set_period(&mut self, period: i64) {
        let period = period.max(0).cast_unsigned();
        self.bridged = period.saturating_add(period / 2);
    }

    pub(super) fn counts(&self) -> Counts {
        self.samples.counts
    }

    pub(super) fn push(&mut self, stamp: i64, values: [R; 3]) -> Result<(), Refused> {
        let finite = values.iter().all(|value| value.is_finite());
        self.samples.push(stamp, finite.then_some(values))
    }

    /// True if no later sample can change the values at `stamp`.
    pub(super) fn is_certain_at(&mut self, stamp: i64) -> bool {
        let Some(newest) = self.samples.newest().filter(|newest| *newest >= stamp) else { return false };
        // a sample that is not finite still has a timestamp: any later sample may be too far away to be a neighbour
        match self.samples.around(stamp) {
            (Some(before), None) if before.stamp < stamp => distance(before.stamp, newest) > self.bridged,
            _ => true,
        }
    }

    /// Returns the values at `stamp`, which does not decrease from call to call unless the clock of the lead was set back.
    pub(super) fn at(&mut self, stamp: i64) -> Interpolated<R> {
        let bridged = self.bridged;
        let found = match self.samples.around(stamp) {
            (Some(on), _) if on.stamp == stamp => Some((on.value, 0)),
            (Some(before), Some(after)) if before.stamp < stamp => between(before, after, stamp, bridged),
            _ => None,
        };
        let Some((values, weight)) = found else {
            self.samples.counts.missing_in_row();
            return Interpolated { values: [R::from_f64(f64::NAN); 3], weight: None };
        };
        Interpolated { values, weight: Some(weight) }
    }
}

/// Interpolates between two neighbours; `None` if they are more than `bridged` ticks apart, or so large that their
/// difference is not finite.
fn between<R: Real>(
    before: &Stamped<[R; 3]>,
    after: &Stamped<[R; 3]>,
    stamp: i64,
    bridged: u64,
) -> Option<([R; 3], u32)> {
    let apart = distance(before.stamp, after.stamp);
    if apart > bridged {
        return None;
    }
    let weight = weight(distance(before.stamp, stamp), apart);
    let part = R::from_u32(weight) * R::from_f64(WEIGHT_UNIT);
    let [[ax, ay, az], [bx, by, bz]] = [before.value, after.value];
    let values = [ax + part * (bx - ax), ay + part * (by - ay), az + part * (bz - az)];
    values.iter().all(|value| value.is_finite()).then_some((values, weight))
}

/// part/whole in units of 2⁻²⁴, to the nearest; `part` ≤ `whole`.
fn weight(part: u64, whole: u64) -> u32 {
    let shift = (u64::BITS - whole.leading_zeros()).saturating_sub(DISTANCE_BITS);
    let (part, whole) = (part >> shift, whole >> shift);
    let weight = ((part << WEIGHT_BITS) + whole / 2).checked_div(whole).unwrap_or(0);
    u32::try_from(weight).unwrap_or(1 << WEIGHT_BITS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weight_is_rounded_to_nearest() {
        assert_eq!(weight(0, 7), 0);
        assert_eq!(weight(7, 7), 1 << 24);
        assert_eq!(weight(1, 3), 5_592_405); // 5592405.33
        assert_eq!(weight(2, 3), 11_184_811); // 11184810.67
        for bits in 1..64 {
            let whole = u64::MAX >> (64 - bits);
            for part in [0, 1, whole / 3, whole / 2, whole - 1, whole] {
                let exact = (u128::from(part) << 24) as f64 / whole as f64;
                assert!((f64::from(weight(part, whole)) - exact).abs() <= 0.5 + 1e-3, "{part} of {whole}");
            }
        }
        assert_eq!(weight(0, 0), 0);
        assert_eq!(weight(u64::MAX, u64::MAX), 1 << 24);
    }
}

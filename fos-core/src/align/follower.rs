//! A follower: three values with stamps of their own, interpolated.

use super::counts::{Counts, Refused};
use super::order::distance;
use super::queue::{Queue, Stamped};
use crate::Real;

/// Bits of a weight: as many as f32 holds exactly.
const WEIGHT_BITS: u32 = 24;

/// 2⁻²⁴.
const WEIGHT_UNIT: f64 = 1.0 / (1_u32 << WEIGHT_BITS) as f64;

/// Longest distance that is divided as it is, bits: shifted by those of the weight, and with half of the divisor added,
/// it stays below 2⁶⁴. Nanoseconds go on for nine minutes; of more the last bits are left out.
const DISTANCE_BITS: u32 = 63 - WEIGHT_BITS;

/// What a follower has at a stamp of the lead.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Interpolated<R> {
    /// Between its neighbours; all NaN where it is missing.
    pub values: [R; 3],
    /// w, the weight of the later neighbour in units of 2⁻²⁴: 0 on a sample; `None` where it is missing.
    pub weight: Option<u32>,
}

#[derive(Debug, Clone)]
pub(super) struct Follower<R, const DEPTH: usize> {
    samples: Queue<[R; 3], DEPTH>,
    /// Furthest that neighbours may be apart, ticks.
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

    /// Whether nothing that may still come changes what it has at `stamp`.
    pub(super) fn is_certain_at(&mut self, stamp: i64) -> bool {
        let Some(newest) = self.samples.newest().filter(|newest| *newest >= stamp) else { return false };
        // samples that are missing come with a stamp too: what comes after them may be too far to be a neighbour
        match self.samples.around(stamp) {
            (Some(before), None) if before.stamp < stamp => distance(before.stamp, newest) > self.bridged,
            _ => true,
        }
    }

    /// What it has at `stamp`, which is not before that of the last call unless the lead was set back.
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

/// Between two neighbours; none if they are more than `bridged` apart, or so large that their difference is not finite.
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
    fn a_weight_is_the_nearest_of_its_unit() {
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

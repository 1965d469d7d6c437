//! An effect that a part's models may have.

use serde::Serialize;

use super::coefficient::NINETY;
use fos_fleet::EffectShare;

/// An effect on an axis of a part.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct EffectReport {
    /// As in the library.
    pub effect: String,
    /// Units that have it, and units that were asked.
    pub units: [usize; 2],
    /// The 90 % interval of the share of all units of the part that have it.
    pub share_interval: [f64; 2],
    /// By how much the error should fall if every unit's model had it, in the mean over all units.
    pub mean_reduction: f64,
    /// What it costs on the device.
    pub device: String,
}

impl EffectReport {
    pub(super) fn of(share: &EffectShare) -> Self {
        Self {
            effect: share.effect.clone(),
            units: share.units,
            share_interval: interval_of(share.units),
            mean_reduction: share.mean_reduction,
            device: share.device.clone(),
        }
    }
}

/// Of a share (Wilson 1927).
fn interval_of([with, asked]: [usize; 2]) -> [f64; 2] {
    if asked == 0 {
        return [0.0, 1.0];
    }
    let (n, share, z2) = (asked as f64, with as f64 / asked as f64, NINETY * NINETY);
    let middle = (share + 0.5 * z2 / n) / (1.0 + z2 / n);
    let half = NINETY / (1.0 + z2 / n) * (share * (1.0 - share) / n + 0.25 * z2 / (n * n)).sqrt();
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}

#[cfg(test)]
mod tests {
    use super::interval_of;

    /// Brown, Cai and DasGupta 2001: of 10 none; the end is z²/(n + z²).
    #[test]
    fn of_ten_units_without_it_the_share_may_still_be_a_fifth() {
        let [low, high] = interval_of([0, 10]);
        assert!(low == 0.0 && (high - 2.706 / 12.706).abs() < 1e-4, "{low} {high}");
        let [low, high] = interval_of([50, 100]);
        assert!((low + high - 1.0).abs() < 1e-12 && high < 0.59);
    }
}

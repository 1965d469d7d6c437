//! Effect that the models of a part may include.

use serde::Serialize;

use super::coefficient::NINETY;
use fos_fleet::EffectShare;

/// Effect on an axis of a part.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct EffectReport {
    /// Identifier in the library, such as `thermal_lag`.
    pub effect: String,
    /// Number of units with the effect, and number of diagnosed units.
    pub units: [usize; 2],
    /// 90 % interval of the share of all units of the part that have the effect.
    pub share_interval: [f64; 2],
    /// Predicted reduction if every unit's model had the effect: the mean over all diagnosed units.
    pub mean_reduction: f64,
    /// Cost of the effect on the device, in words.
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

/// 90 % interval of a share (Wilson 1927).
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

    /// Brown, Cai and DasGupta 2001: for 0 of 10 units, the upper bound is z²/(n + z²).
    #[test]
    fn of_ten_units_without_it_the_share_may_still_be_a_fifth() {
        let [low, high] = interval_of([0, 10]);
        assert!(low == 0.0 && (high - 2.706 / 12.706).abs() < 1e-4, "{low} {high}");
        let [low, high] = interval_of([50, 100]);
        assert!((low + high - 1.0).abs() < 1e-12 && high < 0.59);
    }
}

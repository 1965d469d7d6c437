//! Random walks of quantities through the ranges that a model was fitted on, with reproducible random numbers.

use super::schedule::Kind;
use fos_core::Source;
use fos_fit::model::UnitModel;

/// A logged quantity that moves through its fitted range, in steps from 0.03 % to 30 % of its width: slow enough for a filtered rate to
/// stay within its own range, and far enough to cross a backlash.
#[derive(Debug, Clone)]
pub(super) struct Wander {
    pub(super) low: f64,
    pub(super) high: f64,
    now: f64,
}

impl Wander {
    /// Quantity `index` of the model, from the middle of its range.
    pub(super) fn of(model: &UnitModel, index: usize) -> Self {
        let (low, high) = quantity_range(model, index);
        Self { low, high, now: 0.5 * (low + high) }
    }

    pub(super) fn width(&self) -> f64 {
        self.high - self.low
    }

    /// Value in the next sample.
    pub(super) fn next(&mut self, kind: Kind, random: &mut Random) -> f64 {
        let size = [0.3, 0.03, 0.003, 0.0003][(4.0 * random.share()) as usize];
        let step = size * self.width() * if random.share() < 0.5 { -1.0 } else { 1.0 };
        let stays = (self.low..=self.high).contains(&(self.now + step));
        self.now += if stays { step } else { -step };
        match kind {
            Kind::Below => self.low - 0.3 * self.width(),
            Kind::Above => self.high + 0.3 * self.width(),
            _ => self.now,
        }
    }
}

/// Fitted range of a quantity, in its unit: that of the first input computed from it.
fn quantity_range(model: &UnitModel, index: usize) -> (f64, f64) {
    let mut inputs = model.inputs.iter().map(|named| &named.input);
    let Some(input) = inputs.find(|input| input.source == Source::Quantity(index as u8)) else {
        return (0.0, 1.0);
    };
    let at = |x: f64| input.centre + input.scale * x;
    let (low, high) = (at(input.source_range.low), at(input.source_range.high));
    // A quantity that was constant during the fit varies here too.
    if low < high { (low, high) } else { (low, low + input.scale) }
}

/// x ← 1664525·x + 1013904223 modulo 2³² (Press et al., Numerical Recipes, `ranqd1`): sufficient here, and easy to reproduce.
#[derive(Debug, Clone)]
pub(super) struct Random(u32);

impl Random {
    /// Starts at x = 1.
    pub(super) fn new() -> Self {
        Self(1)
    }

    /// Uniform in [0, 1), 24 bits.
    pub(super) fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1 << 24)
    }
}

//! Samples of a test vector: random raw codes within the ranges that a model was fitted on, and beyond them.

use fos_core::Quantity;
use fos_embedded::hub::{AXES, HubError, Motion, is_given};
use fos_embedded::raw::Scales;
use fos_embedded::test_vector::TestSample;

use super::host_hub::{HostHub, loaded};
use super::scales::{LARGEST_CODE, channel, scales};
use super::schedule::{Kind, schedule};
use super::wander::{Random, Wander};
use fos_fit::model::UnitModel;

/// Code of a saturated sample.
const SATURATED: i16 = i16::MAX;

/// Description of the samples, for the comment in the source.
pub(super) const HOW: &str = "\
From power-on, at rest: until the history is full and 30 samples more; then one with everything below its fitted range and one
with everything above; each quantity absent once; all codes saturated once; each axis at its full scale once, where codes reach it;
8 samples in motion; 3 missing; then more missing than any axis coasts over, and the history refilled.
The remainder of an axis is drawn evenly from its fitted range, a quantity wanders through its own in steps of 0.03 % to 30 %.
Random numbers: x = 1664525 x + 1013904223 modulo 2^32 from x = 1, the upper 24 bits.
Not shown: detection of stillness, stuck axes, coasting beyond its limit, the watch over the innovations.";

/// Generates samples in sequence.
#[derive(Debug)]
pub(super) struct Generator<'a> {
    model: &'a UnitModel,
    scales: Scales,
    random: Random,
    /// All quantities of the model.
    quantities: Vec<Wander>,
    /// Physical part only, around which remainders are generated.
    physical: Box<HostHub>,
}

impl<'a> Generator<'a> {
    pub(super) fn new(model: &'a UnitModel) -> Result<Self, HubError> {
        let mut physical = model.clone();
        physical.calibration = None;
        for axis in &mut physical.axes {
            axis.stochastic.clear();
            axis.parameters.constant = 0.0;
        }
        let quantities: Vec<Wander> =
            (0..model.quantities.len()).map(|index| Wander::of(model, index)).collect();
        let scales = scales(model, &quantities);
        let mut physical = Box::new(loaded(&physical, scales)?);
        physical.set_motion(Some(Motion::Moving));
        Ok(Self { model, scales, random: Random::new(), quantities, physical })
    }

    pub(super) fn scales(&self) -> Scales {
        self.scales
    }

    /// Index of every axis of the model among the hub's six.
    pub(super) fn channels(&self) -> Vec<u8> {
        self.model.axes.iter().filter_map(|axis| channel(axis.parameters.axis)).map(|c| c as u8).collect()
    }

    /// Quantities measured neither by the temperature sensor nor by the axes.
    pub(super) fn given(&self) -> Vec<u8> {
        (0..self.model.quantities.len())
            .filter(|index| self.is_given(*index))
            .map(|index| index as u8)
            .collect()
    }

    fn is_given(&self, index: usize) -> bool {
        is_given(self.model.quantities[index].quantity)
    }

    /// Kinds of the samples, in their order.
    pub(super) fn schedule(&self) -> Vec<Kind> {
        schedule(self.model)
    }

    /// Generates a sample, and the quantities that the application supplies before it.
    pub(super) fn sample(&mut self, kind: Kind) -> (TestSample, Vec<f32>) {
        let quantities: Vec<f64> =
            self.quantities.iter_mut().map(|quantity| quantity.next(kind, &mut self.random)).collect();
        let is_absent = |index: usize| kind == Kind::Absent(index);
        let mut sample = TestSample {
            motion: if kind == Kind::Moving { Motion::Moving } else { Motion::Still },
            skipped: if let Kind::After(missing) = kind { missing } else { 0 },
            codes: [0; AXES],
            temperature: Some(0),
        };
        let mut given = Vec::new();
        for (index, logged) in self.model.quantities.iter().enumerate() {
            let value = quantities[index];
            match logged.quantity {
                Quantity::Temperature => {
                    let code = (value - f64::from(self.scales.temperature_zero_c))
                        / f64::from(self.scales.temperature_k);
                    sample.temperature = (!is_absent(index)).then_some(rounded(code));
                }
                Quantity::Measured(axis) => {
                    if let Some(channel) = channel(axis) {
                        sample.codes[channel] = rounded(value / self.code(channel));
                    }
                }
                _ => given.push(if is_absent(index) { f32::NAN } else { value as f32 }),
            }
        }
        self.place_axes(kind, &mut sample, &given);
        (sample, given)
    }

    /// Sets the codes of the axes: reference, current physical part, and a remainder.
    fn place_axes(&mut self, kind: Kind, sample: &mut TestSample, given: &[f32]) {
        for (nth, value) in given.iter().enumerate() {
            self.physical.give_application(nth, *value);
        }
        let predicted = {
            let output = self.physical.update(&sample.raw());
            let difference = |channel: usize| output.measured[channel] - output.corrected()[channel];
            std::array::from_fn::<f32, AXES, _>(difference)
        };
        for axis in &self.model.axes {
            let Some(channel) = channel(axis.parameters.axis) else { continue };
            let parameters = &axis.parameters;
            let (low, width) = (parameters.range.low, parameters.range.high - parameters.range.low);
            let share = match kind {
                // Beyond the limits of the remainder by half a width.
                Kind::Below => -1.0 - self.random.share(),
                Kind::Above => 2.0 + self.random.share(),
                _ => self.random.share(),
            };
            let remainder = parameters.scale * (low + share * width);
            let value = parameters.reference + f64::from(predicted[channel]) + remainder;
            let moved = if kind == Kind::Moving { 8000.0 * (self.random.share() - 0.5) } else { 0.0 };
            let code = self.code(channel);
            sample.codes[channel] = match kind {
                Kind::FullScale if parameters.full_scale > 0.0 => {
                    // At the limit, or one code beyond it.
                    rounded((parameters.full_scale / code).ceil())
                }
                _ => rounded(value / code + moved),
            };
        }
        if kind == Kind::Saturated {
            sample.codes = [SATURATED; AXES];
        }
    }

    /// Value of a code of a channel, in its unit.
    fn code(&self, channel: usize) -> f64 {
        f64::from(if channel < 3 { self.scales.accel_mps2 } else { self.scales.gyro_rads })
    }
}

fn rounded(code: f64) -> i16 {
    code.round().clamp(-LARGEST_CODE - 700.0, LARGEST_CODE + 700.0) as i16
}

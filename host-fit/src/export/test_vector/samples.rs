//! The samples of a test vector: raw codes drawn from the ranges that a model was fitted on, and from beyond them.

use fos_core::{Axis, Quantity, Source};
use fos_embedded::hub::{AXES, HubError, Motion, SIX, is_given};
use fos_embedded::raw::Scales;
use fos_embedded::test_vector::TestSample;

use super::{HostHub, loaded};
use fos_fit::model::{FittedAxis, UnitModel};

/// Codes that the narrowest fitted range of three axes spans, unless their size does not allow it.
const CODES_OF_AN_AXIS: f64 = 300.0;

/// Codes that the fitted range of temperature spans; it moves in finer steps.
const CODES_OF_TEMPERATURE: f64 = 3000.0;

/// The largest code of a sample that is not saturated.
const LARGEST_CODE: f64 = 32_000.0;

/// A code at full scale.
const SATURATED: i16 = i16::MAX;

/// How the samples are made, for the comment beside them.
pub(super) const HOW: &str = "\
From power-on, at rest: until the history is full and 30 samples more; then one with everything below its fitted range and one
with everything above; each quantity absent once; all codes saturated once; each axis at its full scale once, where codes reach it;
8 samples in motion; 3 missing; then more missing than any axis coasts over, and the history filled anew.
The remainder of an axis is drawn evenly from its fitted range, a quantity wanders through its own in steps of 0.03 % to 30 %.
Random numbers: x = 1664525 x + 1013904223 modulo 2^32 from x = 1, the upper 24 bits.
Not shown: detection of stillness, stuck axes, coasting beyond its limit, the watch over the innovations.";

/// What a sample is to show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// At rest, everything within its fitted range.
    Still,
    /// At rest, everything beyond its fitted range: below it, above it.
    Below,
    Above,
    /// At rest, this quantity of the model absent.
    Absent(usize),
    /// At rest, all codes at full scale.
    Saturated,
    /// At rest, each axis at the magnitude that the model has as full scale, where codes reach it.
    FullScale,
    /// In motion.
    Moving,
    /// At rest, after so many missing samples.
    After(u32),
}

/// Makes samples, one after the other.
#[derive(Debug)]
pub(super) struct Generator<'a> {
    model: &'a UnitModel,
    scales: Scales,
    random: Random,
    /// Every quantity of the model.
    quantities: Vec<Wander>,
    /// The physical part alone, to draw remainders around it.
    physical: Box<HostHub>,
}

impl<'a> Generator<'a> {
    pub(super) fn new(model: &'a UnitModel) -> Result<Self, HubError> {
        let mut physical = model.clone();
        for axis in &mut physical.axes {
            axis.stochastic.clear();
            axis.parameters.constant = 0.0;
        }
        let quantities: Vec<Wander> =
            (0..model.quantities.len()).map(|index| Wander::new(quantity_range(model, index))).collect();
        let scales = scales(model, &quantities);
        let mut physical = Box::new(loaded(&physical, scales)?);
        physical.set_motion(Some(Motion::Moving));
        Ok(Self { model, scales, random: Random(1), quantities, physical })
    }

    pub(super) fn scales(&self) -> Scales {
        self.scales
    }

    /// The place of every axis of the model among the hub's six.
    pub(super) fn channels(&self) -> Vec<u8> {
        self.model.axes.iter().filter_map(|axis| channel(axis.parameters.axis)).map(|c| c as u8).collect()
    }

    /// The quantities that neither thermometer nor axes measure.
    pub(super) fn given(&self) -> Vec<u8> {
        (0..self.model.quantities.len())
            .filter(|index| self.is_given(*index))
            .map(|index| index as u8)
            .collect()
    }

    fn is_given(&self, index: usize) -> bool {
        is_given(self.model.quantities[index].quantity)
    }

    pub(super) fn schedule(&self) -> Vec<Kind> {
        let axes = &self.model.axes;
        let longest_lag = longest_lag(self.model);
        let gap_limit = |axis: &FittedAxis| u32::from(axis.parameters.gap_limit_samples);
        let longest_gap = axes.iter().map(gap_limit).max().unwrap_or(0);
        let absent = (0..self.quantities.len())
            .filter(|index| !matches!(self.model.quantities[*index].quantity, Quantity::Measured(_)))
            .flat_map(|index| [Kind::Absent(index), Kind::Still]);

        let mut kinds = vec![Kind::Still; longest_lag + 30];
        kinds.extend([Kind::Below, Kind::Still, Kind::Above, Kind::Still]);
        kinds.extend(absent);
        kinds.extend([Kind::Saturated, Kind::Still, Kind::FullScale, Kind::Still]);
        kinds.extend([Kind::Moving; 8]);
        kinds.extend([Kind::Still, Kind::After(3), Kind::Still]);
        kinds.push(Kind::After(longest_gap + 1000));
        kinds.resize(kinds.len() + longest_lag + 8, Kind::Still);
        kinds
    }

    /// A sample, and the quantities that the application gives before it.
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

    /// Codes of the axes of the model: reference, physical part as it is now, and a remainder.
    fn place_axes(&mut self, kind: Kind, sample: &mut TestSample, given: &[f32]) {
        for (nth, value) in given.iter().enumerate() {
            self.physical.give_application(nth, *value);
        }
        let predicted = {
            let output = self.physical.update(&sample.raw());
            let difference = |channel: usize| output.measured[channel] - output.corrected[channel];
            std::array::from_fn::<f32, AXES, _>(difference)
        };
        for axis in &self.model.axes {
            let Some(channel) = channel(axis.parameters.axis) else { continue };
            let parameters = &axis.parameters;
            let (low, width) = (parameters.range.low, parameters.range.high - parameters.range.low);
            let share = match kind {
                // beyond where the remainder is limited, half a width outside
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
                    // at the limit or one code beyond it
                    rounded((parameters.full_scale / code).ceil())
                }
                _ => rounded(value / code + moved),
            };
        }
        if kind == Kind::Saturated {
            sample.codes = [SATURATED; AXES];
        }
    }

    /// What a code of a channel stands for, in its unit.
    fn code(&self, channel: usize) -> f64 {
        f64::from(if channel < 3 { self.scales.accel_mps2 } else { self.scales.gyro_rads })
    }
}

/// Samples that a history must hold before every term means anything.
pub(super) fn longest_lag(model: &UnitModel) -> usize {
    let terms = model.axes.iter().flat_map(|axis| axis.physical.iter().chain(&axis.stochastic));
    let lags = terms.flat_map(|term| &term.factors).map(|factor| usize::from(factor.lag));
    lags.max().unwrap_or(0)
}

/// A logged quantity that wanders through its fitted range, in steps from 0.03 % to 30 % of its width: slow enough for a
/// filtered rate to stay within its own range, and far enough to cross a backlash.
#[derive(Debug, Clone)]
struct Wander {
    low: f64,
    high: f64,
    now: f64,
}

impl Wander {
    fn new((low, high): (f64, f64)) -> Self {
        Self { low, high, now: 0.5 * (low + high) }
    }

    fn width(&self) -> f64 {
        self.high - self.low
    }

    fn next(&mut self, kind: Kind, random: &mut Random) -> f64 {
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

/// The fitted range of a quantity, in its unit: that of the first input which is computed from it.
fn quantity_range(model: &UnitModel, index: usize) -> (f64, f64) {
    let mut inputs = model.inputs.iter().map(|named| &named.input);
    let Some(input) = inputs.find(|input| input.source == Source::Quantity(index as u8)) else {
        return (0.0, 1.0);
    };
    let at = |x: f64| input.centre + input.scale * x;
    let (low, high) = (at(input.source_range.low), at(input.source_range.high));
    // a quantity that did not vary while fitting varies here all the same
    if low < high { (low, high) } else { (low, low + input.scale) }
}

/// Scales at which the model's ranges span some hundred codes, with two decimal digits.
fn scales(model: &UnitModel, quantities: &[Wander]) -> Scales {
    let of_triad = |first: usize, without: f64| {
        let is_in = |axis: &Axis| channel(*axis).is_some_and(|channel| channel / 3 == first / 3);
        let modelled = model.axes.iter().filter(|axis| is_in(&axis.parameters.axis)).map(|axis| {
            let p = &axis.parameters;
            let (low, high) = (p.scale * p.range.low, p.scale * p.range.high);
            let size = (p.reference + p.offset).abs() + 3.0 * low.abs().max(high.abs());
            (high - low, size, p.full_scale)
        });
        let logged = model.quantities.iter().zip(quantities).filter_map(|(logged, range)| {
            let Quantity::Measured(axis) = logged.quantity else { return None };
            let size = range.low.abs().max(range.high.abs()) + range.width();
            is_in(&axis).then_some((range.width(), size, 0.0))
        });
        let (mut narrowest, mut largest, mut full_scale) = (f64::INFINITY, 0.0_f64, 0.0_f64);
        for (width, size, limit) in modelled.chain(logged) {
            narrowest = if width > 0.0 { narrowest.min(width) } else { narrowest };
            (largest, full_scale) = (largest.max(size), full_scale.max(limit));
        }
        if narrowest.is_infinite() {
            return without;
        }
        let fine = (narrowest / CODES_OF_AN_AXIS).max(largest / LARGEST_CODE);
        // full scale too, if that costs no more than two thirds of the codes
        let reaching = full_scale / LARGEST_CODE;
        two_digits(if reaching <= 3.0 * fine { reaching.max(fine) } else { fine })
    };
    let temperature = model.quantities.iter().position(|logged| logged.quantity == Quantity::Temperature);
    let zero_c = 25.0;
    let temperature_k = temperature.map_or(1.0 / 256.0, |index| {
        let range = &quantities[index];
        let size = (range.low - zero_c).abs().max((range.high - zero_c).abs()) + range.width();
        two_digits((range.width() / CODES_OF_TEMPERATURE).max(size / LARGEST_CODE))
    });
    Scales {
        accel_mps2: of_triad(0, 0.0012) as f32,
        gyro_rads: of_triad(3, 0.0003) as f32,
        temperature_k: temperature_k as f32,
        temperature_zero_c: zero_c as f32,
        period_s: model.period_s,
        values: model.fitted_on,
    }
}

/// Rounded up to two significant digits, so that any compiler reads the same f32.
fn two_digits(value: f64) -> f64 {
    format!("{:.1e}", 1.05 * value).parse().unwrap_or(value)
}

fn rounded(code: f64) -> i16 {
    code.round().clamp(-LARGEST_CODE - 700.0, LARGEST_CODE + 700.0) as i16
}

/// Place of an axis among the hub's six.
fn channel(axis: Axis) -> Option<usize> {
    SIX.iter().position(|six| *six == axis)
}

/// x ← 1664525·x + 1013904223 modulo 2³² (Press et al., Numerical Recipes, `ranqd1`): nothing more is needed, and everyone can
/// repeat it.
#[derive(Debug, Clone)]
struct Random(u32);

impl Random {
    /// Evenly from 0 up to 1, 24 bits.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1 << 24)
    }
}

//! The places: the tracking and the coasting predictor, every transform over each of its possible sources, the monitor, the
//! hub; each with the requirements that follow from its model.

use fos_core::image::encode;
use fos_core::{
    AxisModel, AxisParameters, FittedOn, Info, Input, Model, Monitor, Quantity, Range, Source, Term,
    Transform, u,
};
use fos_embedded::hub::{AXES, Hub};
use fos_embedded::raw::RawSample;

use super::correctors::{Corrector, POLL, Predicting, Roomy, quiet};
use super::faults::{Fault, On, SWING, Strikes};
use crate::models::{PHYSICAL, SCALES, SIX, STOCHASTIC, TestHub, limits, parameters};

/// A place at which a fault occurs.
pub(crate) struct Place {
    pub(crate) name: &'static str,
    pub(crate) column: Column,
    pub(crate) make: Box<dyn Fn() -> Box<dyn Corrector>>,
    /// Largest predicted error of an axis, in its unit.
    pub(crate) bound: [f32; AXES],
    /// Tolerance of the predicted error after recovery, in scaled units; 0 for bit by bit.
    pub(crate) tolerance: f32,
    /// Largest recovery time after a fault, samples.
    pub(crate) limit: Box<dyn Fn(&Fault) -> usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Column {
    Track,
    Coast,
    OverQuantity,
    OverClock,
    OverRemainder,
    Monitor,
    Hub,
}

impl Column {
    pub(crate) const ALL: [(Self, &'static str); 7] = [
        (Self::Track, "track"),
        (Self::Coast, "coast"),
        (Self::OverQuantity, "inputs over a quantity"),
        (Self::OverClock, "inputs over the clock"),
        (Self::OverRemainder, "inputs over the remainder"),
        (Self::Monitor, "monitor"),
        (Self::Hub, "hub and C interface"),
    ];

    /// True if the fault can occur there; otherwise the cell has a dash.
    pub(crate) fn meets(self, on: On, strikes: Strikes) -> bool {
        let of_axes = on == On::Axes || strikes == Strikes::Axes;
        let of_quantities = on == On::Temperature || strikes == Strikes::Quantities;
        match self {
            // a predictor counts samples and reads no clock
            Self::Track | Self::Coast | Self::Monitor => on != On::Clock,
            Self::OverQuantity => on != On::Clock && !of_axes,
            // no measured value enters it
            Self::OverClock => matches!(on, On::Gap | On::Reset),
            Self::OverRemainder => on != On::Clock && !of_quantities,
            // a code is always finite
            Self::Hub => !(on == On::NotInCodes && strikes == Strikes::Axes),
        }
    }
}

const PERIOD_S: f64 = 0.005;

/// Time constant of all transforms that have one, s.
const TAU_S: f64 = 0.5;

/// Tolerance after recovery for transforms with a memory, as a share of their range.
const SHARE: f64 = 1e-3;

/// Samples until a deviation `from`, which decays with [`TAU_S`], is `to`.
fn decay_samples(from: f64, to: f64) -> usize {
    (TAU_S / PERIOD_S * (from / to).ln()).ceil() as usize
}

fn with_model<T>(
    inputs: &[Input<f32>],
    physical: &[Term<f32>],
    stochastic: &[Term<f32>],
    user: impl FnOnce(&Model<'_, f32>) -> T,
) -> T {
    let axes = SIX.map(|axis| AxisModel { parameters: parameters(axis), physical, stochastic });
    user(&Model {
        period_s: PERIOD_S,
        fitted_on: FittedOn::Raw,
        stillness: Some(limits()),
        calibration: None,
        quantities: &[Quantity::Temperature, Quantity::Supply],
        inputs,
        axes: &axes,
    })
}

fn predictor(inputs: &[Input<f32>], physical: &[Term<f32>], stochastic: &[Term<f32>]) -> Roomy {
    let mut predictor = with_model(inputs, physical, stochastic, Roomy::new).expect("a model");
    let raw = RawSample { accel: [i16::MAX; 3], gyro: [i16::MAX; 3], ..RawSample::default() };
    for (axis, full_scale) in SCALES.measured(&raw).into_iter().enumerate() {
        predictor.limit_full_scale(axis, full_scale);
    }
    predictor
}

/// |offset| + scale·(Σ|c|·Π|u| + limit of the remainder), with rounding.
fn bound(inputs: &[Input<f32>], physical: &[Term<f32>], stochastic: &[Term<f32>]) -> [f32; AXES] {
    let reach = |range: Range<f32>, share: f32| {
        range.low.abs().max(range.high.abs()) + share * (range.high - range.low)
    };
    let of_inputs: f32 = physical
        .iter()
        .map(|term| {
            let factors = term.factors().iter().map(|factor| match factor.channel {
                fos_core::Channel::Input(input) => reach(inputs[usize::from(input)].range, 0.05),
                fos_core::Channel::Output => f32::INFINITY,
            });
            term.coefficient.abs() * factors.product::<f32>()
        })
        .sum();
    SIX.map(|axis| {
        let AxisParameters { offset, scale, range, .. } = parameters(axis);
        let remainder = if stochastic.is_empty() { 0.0 } else { reach(range, 0.5) };
        (offset.abs() + scale * (of_inputs + remainder)) * 1.000_01
    })
}

fn input(source: Source, transform: Transform<f32>, low: f32, high: f32) -> Input<f32> {
    let reach = if matches!(source, Source::Remainder(_)) { 5.0 } else { 2.0 };
    // quantities in 10 K around 25 °C, time in 100 s
    let (centre, scale) = match source {
        Source::Quantity(_) => (25.0, 10.0),
        Source::Clock => (0.0, 100.0),
        Source::Remainder(_) => (0.0, 1.0),
    };
    Input {
        source,
        transform,
        centre,
        scale,
        source_range: Range::new(-reach, reach),
        range: Range::new(low, high),
    }
}

/// Image of the hub's model: low-passed temperature, and supply voltage.
pub(crate) fn image() -> Vec<u8> {
    let info = Info { quantities: "temp_c °C\nsupply_v V", ..Info::default() };
    with_model(&hub_inputs(), &PHYSICAL, &STOCHASTIC, |model| {
        encode(model, &info, &mut [0; 4096]).expect("it fits").to_vec()
    })
}

fn hub_inputs() -> [Input<f32>; 2] {
    let supply =
        Input { centre: 3.3, scale: 0.1, ..input(Source::Quantity(1), Transform::Identity, -2.0, 2.0) };
    [input(Source::Quantity(0), Transform::LowPass { tau_s: TAU_S as f32 }, -2.0, 2.0), supply]
}

/// Longest lag of [`STOCHASTIC`], samples.
pub(crate) const DEPTH: usize = 2;

/// Two windows of the hub's rate measurement, and one reading of the clock, samples.
const RATE: usize = 4000 + POLL;

/// Samples until stillness is detected again: two complete windows, and a third that may be incomplete.
const STILLNESS: usize = 3 * 100;

pub(crate) fn places() -> Vec<Place> {
    let temperature = [input(Source::Quantity(0), Transform::Identity, -2.0, 2.0)];
    let physical = [Term::new(0.5, &[u(0, 0)])];
    let measured = |monitored: bool, name: &'static str, column| Place {
        name,
        column,
        make: Box::new(move || {
            let monitors = monitored.then(|| SIX.map(|axis| Monitor::new(&parameters(axis), PERIOD_S)));
            Box::new(Predicting {
                predictor: predictor(&temperature, &physical, &STOCHASTIC),
                reads: |tick| tick.axes,
                monitors,
            })
        }),
        bound: bound(&temperature, &physical, &STOCHASTIC),
        tolerance: 0.0,
        limit: Box::new(|_| DEPTH),
    };
    let mut places = vec![
        measured(false, "track", Column::Track),
        measured(false, "coast", Column::Coast),
        measured(true, "monitor", Column::Monitor),
    ];

    let tau_s = TAU_S as f32;
    // over a quantity: name, transform, range, largest deviation at the end of a fault (0 without a memory)
    let width = 2.0 * 2.2;
    let wide = width * width;
    let over_quantity = [
        ("identity", Transform::Identity, -2.0, 2.0, 0.0),
        ("low-pass", Transform::LowPass { tau_s }, -2.0, 2.0, width),
        ("rate", Transform::Rate { tau_s }, -8.0, 8.0, width / TAU_S),
        // v ← q·v + g·(2cd + d²) with |c|, |d| ≤ W·qⁿ: at most qⁿ·W²·(1 + 3ng), ng ≤ 15
        ("variance", Transform::Variance { tau_s }, 0.0, 4.0, 46.0 * wide),
        ("backlash", Transform::Backlash { half_width: 1.0 }, -2.0, 2.0, f64::INFINITY),
        ("abs", Transform::Absolute, 0.0, 2.0, 0.0),
    ];
    for (name, transform, low, high, off) in over_quantity {
        let tolerance = SHARE * f64::from(high - low);
        // backlash recovers once the quantity has passed through the whole play
        let limit = if off.is_infinite() {
            SWING
        } else if off > 0.0 {
            decay_samples(off, tolerance)
        } else {
            0
        };
        places.push(over(
            Source::Quantity(0),
            name,
            transform,
            [low, high],
            limit,
            off > 0.0 && off.is_finite(),
        ));
    }
    let wide = 11.0 * 11.0;
    let over_remainder = [
        ("identity", Transform::Identity, -5.0, 5.0, 0.0),
        ("low-pass", Transform::LowPass { tau_s }, -5.0, 5.0, 11.0),
        ("rate", Transform::Rate { tau_s }, -20.0, 20.0, 11.0 / TAU_S),
        ("variance", Transform::Variance { tau_s }, 0.0, 25.0, 46.0 * wide),
        ("backlash", Transform::Backlash { half_width: 0.2 }, -1.0, 1.0, f64::INFINITY),
        ("abs", Transform::Absolute, 0.0, 5.0, 0.0),
    ];
    for (name, transform, low, high, off) in over_remainder {
        let tolerance = SHARE * f64::from(high - low);
        // three of four steps of the noise exceed the play: none of 20 does with a probability of 10⁻¹²
        let limit = if off.is_infinite() {
            20
        } else if off > 0.0 {
            decay_samples(off, tolerance)
        } else {
            0
        };
        // the remainder is delayed by one sample
        places.push(over(
            Source::Remainder(3),
            name,
            transform,
            [low, high],
            limit + 1,
            off > 0.0 && off.is_finite(),
        ));
    }
    // not bit by bit: a gap is computed by one rotation or product instead of many
    for (name, transform, low, high) in [
        ("decay", Transform::Decay { tau_s: 30.0 }, 0.0, 1.0),
        ("time", Transform::Time, 0.0, 1.0),
        ("sine", Transform::Sine { frequency_hz: 16.37 }, -1.0, 1.0),
        ("cosine", Transform::Cosine { frequency_hz: 16.37 }, -1.0, 1.0),
    ] {
        places.push(over(Source::Clock, name, transform, [low, high], 0, true));
    }

    let low_pass = f64::from(PHYSICAL[0].coefficient) * width;
    places.push(Place {
        name: "hub",
        column: Column::Hub,
        make: Box::new(|| {
            let mut hub: TestHub = Hub::new(SCALES);
            hub.load(&image()).expect("a model for this sensor");
            Box::new(hub)
        }),
        // plus the rounding of measured minus corrected, both up to 40
        bound: bound(&hub_inputs(), &PHYSICAL, &STOCHASTIC).map(|bound| bound + 1e-5),
        tolerance: SHARE as f32,
        limit: Box::new(move |fault| match fault.on {
            On::Clock => RATE,
            _ => (STILLNESS + DEPTH).max(decay_samples(low_pass, SHARE)),
        }),
    });
    places
}

/// A model with a single input.
fn over(
    source: Source,
    name: &'static str,
    transform: Transform<f32>,
    [low, high]: [f32; 2],
    limit: usize,
    has_memory: bool,
) -> Place {
    let inputs = [input(source, transform, low, high)];
    let term = [Term::new(0.5, &[u(0, 0)])];
    let remainder = matches!(source, Source::Remainder(_));
    let (physical, stochastic) = if remainder { (&[][..], &term[..]) } else { (&term[..], &[][..]) };
    let column = match source {
        Source::Quantity(_) => Column::OverQuantity,
        Source::Clock => Column::OverClock,
        Source::Remainder(_) => Column::OverRemainder,
    };
    Place {
        name,
        column,
        bound: bound(&inputs, physical, stochastic),
        make: Box::new(move || {
            let term = [Term::new(0.5, &[u(0, 0)])];
            let (physical, stochastic) = if remainder { (&[][..], &term[..]) } else { (&term[..], &[][..]) };
            Box::new(Predicting {
                predictor: predictor(&inputs, physical, stochastic),
                reads: match source {
                    Source::Remainder(_) => |tick| tick.axes,
                    // the axes are undisturbed
                    _ => quiet,
                },
                monitors: None,
            })
        }),
        tolerance: if has_memory { 0.5 * SHARE as f32 * (high - low) } else { 0.0 },
        limit: Box::new(move |_| limit),
    }
}

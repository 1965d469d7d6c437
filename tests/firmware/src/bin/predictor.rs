//! A model of six axes over every kind of input, and every fault: the same source on the board and on the host, to the
//! same bits.
//!
//! Prints the number of samples, a digest of all corrections and one of the innovations, the cost of a step (board only)
//! and the memory of the model.
#![cfg_attr(target_os = "none", no_std, no_main)]

use fos_core::image::encode;
use fos_core::{
    Axis, AxisModel, AxisParameters, FittedOn, Image, Info, InnovationStatistics, Input, Model, Predictor,
    Quantity, Range, Sample, Source, Term, Transform, u, y,
};
use fos_embedded::test_log::PredictorDigest;
use fos_firmware::{Instructions, Tally, fail, println};

/// Capacities for six axes, 16 inputs, 128 terms in all, and 256 values of history.
type Device = Predictor<f32, 6, 16, 128, 256>;

const SAMPLES: u32 = 100_000;

const fn input(source: Source, transform: Transform<f32>, centre: f32, scale: f32) -> Input<f32> {
    let range = Range::new(-3.0, 3.0);
    Input { source, transform, centre, scale, source_range: range, range }
}

const INPUTS: [Input<f32>; 8] = [
    input(Source::Quantity(0), Transform::Identity, 25.0, 5.0),
    input(Source::Quantity(0), Transform::LowPass { tau_s: 61.0 }, 25.0, 5.0),
    input(Source::Quantity(0), Transform::Backlash { half_width: 0.4 }, 25.0, 5.0),
    input(Source::Quantity(1), Transform::Rate { tau_s: 2.0 }, 3.3, 0.1),
    input(Source::Remainder(0), Transform::LowPass { tau_s: 30.0 }, 0.0, 1.0),
    input(Source::Clock, Transform::Decay { tau_s: 120.0 }, 0.0, 1.0),
    input(Source::Clock, Transform::Sine { frequency_hz: 16.4 }, 0.0, 1.0),
    input(Source::Quantity(1), Transform::Variance { tau_s: 5.0 }, 3.3, 0.1),
];

const PHYSICAL: [Term<f32>; 6] = [
    Term::new(0.3, &[u(0, 0)]),
    Term::new(0.2, &[u(1, 0)]),
    Term::new(-0.1, &[u(2, 0)]),
    Term::new(0.05, &[u(3, 0), u(0, 1)]),
    Term::new(0.1, &[u(6, 0)]),
    Term::new(0.02, &[u(5, 0), u(0, 0), u(7, 0)]),
];

const STOCHASTIC: [Term<f32>; 10] = [
    Term::new(0.4, &[y(1)]),
    Term::new(0.2, &[y(2)]),
    Term::new(0.1, &[y(5)]),
    Term::new(0.05, &[y(10)]),
    Term::new(0.1, &[u(4, 0)]),
    Term::new(0.01, &[y(1), y(2)]),
    Term::new(-0.01, &[y(3), y(7)]),
    Term::new(0.01, &[y(1), u(0, 2)]),
    Term::new(0.002, &[y(1), y(1), y(4)]),
    Term::new(-0.002, &[y(2), y(6), u(1, 0)]),
];

const AXES: [Axis; 6] = [Axis::Ax, Axis::Ay, Axis::Az, Axis::Gx, Axis::Gy, Axis::Gz];

fn parameters(axis: usize) -> AxisParameters<f32> {
    let gravity = if axis == 2 { 9.80665 } else { 0.0 };
    AxisParameters {
        axis: AXES[axis],
        reference: gravity,
        offset: 0.01 * axis as f32 - 0.02,
        scale: if axis < 3 { 0.02 } else { 0.003 },
        constant: 0.01,
        range: Range::new(-4.0, 4.0),
        // narrow: p is sometimes limited
        physical_range: Range::new(-0.05, 0.06),
        full_scale: if axis < 3 { 39.2 } else { 8.7 },
        stuck_after_repeats: 8,
        gap_limit_samples: 20,
        coast_limit_s: 2.0,
        innovation: InnovationStatistics { mean: 0.0, variance: 0.5, lag_1_correlation: 0.0 },
    }
}

/// Uniform in 0 … 1 (a linear congruential generator, Knuth's constants).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / 16_777_216.0
    }
}

/// A sample of the simulated device.
struct Step {
    skipped: u32,
    still: bool,
    measured: [f32; 6],
    /// Temperature and supply voltage.
    quantities: [f32; 2],
}

fn step(n: u32, random: &mut Random) -> Step {
    // still, moving, moving for longer than was validated
    let still = !(n % 5000 > 4000 || n % 40_000 > 35_000);
    let fault = random.next();
    let mut measured = [0.0; 6];
    for (axis, value) in measured.iter_mut().enumerate() {
        let parameters = parameters(axis);
        let noise = random.next() + random.next() + random.next() - 1.5;
        let motion = if still { 0.0 } else { 3.0 * (random.next() - 0.5) };
        *value = parameters.reference + parameters.offset + 3.0 * parameters.scale * noise + motion;
        if n % 9000 > 8985 {
            *value = 0.125;
        }
    }
    if fault < 0.001 {
        let values = [f32::NAN, f32::INFINITY, 1e38, -39.2, 8.7, 5.0];
        measured[(fault * 6e3) as usize] = values[(random.next() * 6.0) as usize];
    }
    let temperature = 25.0 + n as f32 * 1e-5 + 0.1 * random.next();
    let supply = 3.3 + 0.05 * (random.next() - 0.5);
    let quantities = if fault > 0.999 { [f32::NAN, 9.0] } else { [temperature, supply] };
    let skipped = match random.next() {
        few if few < 0.0005 => (few * 40_000.0) as u32,
        many if many > 0.9999 => 1000,
        _ => 0,
    };
    Step { skipped, still, measured, quantities }
}

fn run() {
    let axes: [AxisModel<'_, f32>; 6] = core::array::from_fn(|axis| AxisModel {
        parameters: parameters(axis),
        physical: &PHYSICAL,
        stochastic: &STOCHASTIC,
    });
    let model = Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities: &[Quantity::Temperature, Quantity::Supply],
        inputs: &INPUTS,
        axes: &axes,
    };
    let mut buffer = [0; 16_384];
    let encoded = encode(&model, &Info::default(), &mut buffer);
    let Ok(image) = encoded.map_err(drop).and_then(|bytes| Image::parse(bytes).map_err(drop)) else {
        fail(format_args!("the image is not its model"));
    };
    let mut predictor: Device = match image.predictor() {
        Ok(predictor) => predictor,
        Err(error) => fail(format_args!("image: {error}")),
    };
    let (mut digest, mut cost) = (PredictorDigest::default(), Tally::default());
    let (mut instructions, mut random, mut skipped) = (Instructions::start(), Random(1), 0_u64);
    for n in 0..SAMPLES {
        let step = step(n, &mut random);
        skipped += u64::from(step.skipped);
        let mut corrections = &[][..];
        cost.add(instructions.of(|| {
            if step.skipped > 0 {
                let _ = predictor.skip(step.skipped);
            }
            let sample = Sample { measured: &step.measured, quantities: &step.quantities };
            corrections = if step.still { predictor.track(&sample) } else { predictor.coast(&sample) };
        }));
        digest.update(corrections);
    }
    println!("samples {SAMPLES} skipped {skipped}");
    println!("corrections {:016x}", digest.corrections());
    println!("innovations {:016x}", digest.innovations());
    if cost.mean().is_finite() {
        println!("instructions a sample: {cost}");
    }
    println!("bytes: predictor {}", size_of::<Device>());
}

fos_firmware::firmware!(run);

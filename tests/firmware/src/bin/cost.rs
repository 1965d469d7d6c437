//! Cost of a hub: instructions and stack on an emulated Cortex-M, and RAM, part by part, compared with present
//! corrections.
//!
//! ```text
//! cost [profile]
//! ```
//!
//! Prints tables in Markdown. With `profile` it processes samples at rest between two marks, for a trace of the emulator
//! (`.ci/device profile`). On the host it runs without counting; sizes are those of the machine it runs on.
#![cfg_attr(target_os = "none", no_std, no_main)]

use core::hint::black_box;

use fos_core::image::encode;
use fos_core::{
    Axis, AxisModel, AxisParameters, Calibration, FittedOn, Fixed, Info, InnovationStatistics, Input, Model,
    Monitor, Predictor, Quantity, Range, Sample, Scalar, Source, StillnessDetector, StillnessLimits, Term,
    Transform, TriadCalibration, u, y,
};
use fos_embedded::hub::Hub;
use fos_embedded::raw::{RawSample, Scales};
use fos_embedded::telemetry::{Frame, HUB_AXES, Snapshot, StartFrame, VERSION, encode as encode_frame};
use fos_firmware::{Instructions, Tally, argument, fail, println, stack_of};

const PERIOD_S: f64 = 0.005;
const STEPS: u32 = 2000;
const AXES: [Axis; 6] = [Axis::Ax, Axis::Ay, Axis::Az, Axis::Gx, Axis::Gy, Axis::Gz];

/// Ten lags, for six axes of ten terms each.
static LINEAR: [Term<f32>; 10] = [
    Term::new(0.3, &[y(1)]),
    Term::new(0.2, &[y(2)]),
    Term::new(0.1, &[y(3)]),
    Term::new(0.05, &[y(4)]),
    Term::new(0.05, &[y(5)]),
    Term::new(0.02, &[y(6)]),
    Term::new(0.02, &[y(7)]),
    Term::new(0.02, &[y(8)]),
    Term::new(0.02, &[y(9)]),
    Term::new(0.02, &[y(10)]),
];

/// Typical result of a search of cross-product degree 3: half linear, the rest quadratic except for one cubic.
static MIXED: [Term<f32>; 10] = [
    Term::new(0.3, &[y(1)]),
    Term::new(0.2, &[y(2)]),
    Term::new(0.1, &[y(3)]),
    Term::new(0.05, &[y(4)]),
    Term::new(0.05, &[y(7)]),
    Term::new(0.01, &[y(1), y(2)]),
    Term::new(-0.01, &[y(3), y(3)]),
    Term::new(-0.01, &[y(4), y(10)]),
    Term::new(0.01, &[y(2), y(5)]),
    Term::new(0.001, &[y(1), y(1), y(2)]),
];

/// Terms of the temperature of the thermometer and of the die.
static PHYSICAL: [Term<f32>; 2] = [Term::new(0.2, &[u(0, 0)]), Term::new(0.1, &[u(1, 0)])];

const SCALES: Scales = Scales {
    accel_mps2: 0.001_197,
    gyro_rads: 0.000_305,
    temperature_k: 1.0 / 256.0,
    temperature_zero_c: 25.0,
    period_s: PERIOD_S,
    values: FittedOn::Raw,
};

fn parameters(axis: Axis) -> AxisParameters<f32> {
    AxisParameters {
        axis,
        reference: if axis == Axis::Az { 9.81 } else { 0.0 },
        offset: 0.0,
        scale: if matches!(axis, Axis::Ax | Axis::Ay | Axis::Az) { 0.02 } else { 0.005 },
        constant: 0.001,
        range: Range::new(-5.0, 5.0),
        physical_range: Range::new(-5.0, 5.0),
        full_scale: 0.0,
        stuck_after_repeats: 100,
        gap_limit_samples: 20,
        coast_limit_s: 60.0,
        innovation: InnovationStatistics { mean: 0.0, variance: 0.3, lag_1_correlation: 0.0 },
    }
}

const LIMITS: StillnessLimits<f32> = StillnessLimits {
    window: 100,
    accel_variance: 0.01,
    gyro_variance: 0.001,
    gyro_at_rest: [0.0; 3],
    gyro_deviation: 0.05,
};

const fn input(transform: Transform<f32>) -> Input<f32> {
    let range = Range::new(-5.0, 5.0);
    Input { source: Source::Quantity(0), transform, centre: 25.0, scale: 10.0, source_range: range, range }
}

static INPUTS: [Input<f32>; 2] = [input(Transform::Identity), input(Transform::LowPass { tau_s: 60.0 })];

/// Calls `with` on a model of six axes with these terms each.
fn with_model<T>(
    physical: &[Term<f32>],
    stochastic: &[Term<f32>],
    with: impl FnOnce(&Model<'_, f32>) -> T,
) -> T {
    let axes = AXES.map(|axis| AxisModel { parameters: parameters(axis), physical, stochastic });
    with(&Model {
        period_s: PERIOD_S,
        fitted_on: FittedOn::Raw,
        stillness: Some(LIMITS),
        calibration: None,
        quantities: if physical.is_empty() { &[] } else { &[Quantity::Temperature] },
        inputs: if physical.is_empty() { &[] } else { &INPUTS },
        axes: &axes,
    })
}

/// Codes of a device at rest that never repeat.
struct Sensor(u32);

impl Sensor {
    fn noise(&mut self) -> i16 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 28) as i16 - 8
    }

    fn sample(&mut self) -> RawSample {
        RawSample {
            accel: [self.noise(), self.noise(), 8196 + self.noise()],
            gyro: [self.noise(), self.noise(), self.noise()],
            temperature: Some(128),
            ..RawSample::default()
        }
    }
}

/// Cost of `step`, sample by sample.
fn tally(instructions: &mut Instructions, mut step: impl FnMut(&RawSample)) -> Tally {
    let (mut tally, mut sensor) = (Tally::default(), Sensor(1));
    for _ in 0..STEPS {
        let raw = sensor.sample();
        tally.add(instructions.of(|| step(black_box(&raw))));
    }
    tally
}

fn row(name: &str, tally: &Tally) {
    println!("| {name} | {} | {} |", tally.median(), tally.worst());
}

/// A hub in the still state, with its sensor and its image in the first bytes of a buffer.
fn resting_hub<const INPUTS: usize, const TERMS: usize, const HISTORY: usize, R: Scalar<Stored = f32>>(
    name: &str,
    (physical, stochastic): (&[Term<f32>], &[Term<f32>]),
) -> (Hub<INPUTS, TERMS, HISTORY, R>, Sensor, [u8; 4096], usize) {
    let mut buffer = [0; 4096];
    let image =
        with_model(physical, stochastic, |model| match encode(model, &Info::default(), &mut buffer) {
            Ok(image) => image.len(),
            Err(error) => fail(format_args!("{error}")),
        });
    let mut hub = Hub::new(SCALES);
    if let Err(error) = hub.load(&buffer[..image]) {
        fail(format_args!("{name}: {error}"));
    }
    let mut sensor = Sensor(2);
    for _ in 0..4 * LIMITS.window {
        let _ = hub.update(&sensor.sample());
    }
    if !hub.output().is_valid() {
        fail(format_args!("{name}: {:?}", hub.output()));
    }
    (hub, sensor, buffer, image)
}

/// Measurements compared with the budget.
struct Taken {
    /// Median number of instructions of a sample at rest.
    still: usize,
    /// Number of instructions for loading the model.
    loading: f64,
    load_stack: usize,
    stack: usize,
}

/// A whole hub: prints a line of the table with the cost of a sample at rest and in motion.
fn hub<const INPUTS: usize, const TERMS: usize, const HISTORY: usize, R: Scalar<Stored = f32>>(
    instructions: &mut Instructions,
    name: &str,
    terms: (&[Term<f32>], &[Term<f32>]),
) -> Taken {
    let (mut hub, mut sensor, buffer, image) = resting_hub::<INPUTS, TERMS, HISTORY, R>(name, terms);
    let bytes = &buffer[..image];
    let mut still = true;
    let tracked = tally(instructions, |raw| still &= hub.update(raw).still);
    if !still {
        fail(format_args!("{name}: not still"));
    }
    hub.set_motion(Some(fos_embedded::hub::Motion::Moving));
    let coasted = tally(instructions, |raw| {
        let _ = hub.update(raw);
    });
    hub.set_motion(None);
    // a gap uses the most stack
    let gap = RawSample { skipped: 1000, ..sensor.sample() };
    let mut other: Hub<INPUTS, TERMS, HISTORY, R> = Hub::new(SCALES);
    let mut loaded = Ok(());
    let load_stack = stack_of(|| loaded = other.load(bytes));
    let loading = instructions.of(|| loaded = other.load(bytes));
    if let Err(error) = loaded {
        fail(format_args!("{name}: {error}"));
    }
    let stack = stack_of(|| {
        let _ = hub.update(&sensor.sample());
        let _ = hub.update(&gap);
        hub.clock(1);
    });
    println!(
        "| {name} | {} | {} | {} | {} | {} | {stack} | {image} |",
        tracked.median(),
        tracked.worst(),
        coasted.median(),
        coasted.worst(),
        size_of::<Hub<INPUTS, TERMS, HISTORY, R>>(),
    );
    Taken { still: tracked.median(), loading, load_stack, stack }
}

/// Parts of a hub's sample, one by one.
fn parts(instructions: &mut Instructions) {
    println!("| part | median | worst |");
    println!("|---|---|---|");
    row(
        "codes to SI units",
        &tally(instructions, |raw| {
            black_box(SCALES.measured(raw));
        }),
    );
    let mut detector = match StillnessDetector::<f32>::new(LIMITS) {
        Ok(detector) => detector,
        Err(error) => fail(format_args!("{error}")),
    };
    let measured = |raw: &RawSample| {
        let [ax, ay, az, gx, gy, gz] = SCALES.measured(raw);
        ([ax, ay, az], [gx, gy, gz])
    };
    row(
        "and whether the unit is still",
        &tally(instructions, |raw| {
            let (accel, gyro) = measured(raw);
            black_box(detector.update(accel, gyro));
        }),
    );
    for (name, physical, stochastic) in [
        ("codes, and six axes of no terms", &[][..], &[][..]),
        ("codes, and six axes of 10 linear terms", &[], &LINEAR),
        ("codes, and six axes of 10 mixed terms", &[], &MIXED),
        ("codes, and six axes of 10 linear terms, 2 inputs", &PHYSICAL, &LINEAR),
    ] {
        let predictor = with_model(physical, stochastic, Predictor::<f32, 6, 2, 72, 128>::new);
        let mut predictor = match predictor {
            Ok(predictor) => predictor,
            Err(error) => fail(format_args!("{error}")),
        };
        row(
            name,
            &tally(instructions, |raw| {
                let sample =
                    Sample { measured: &SCALES.measured(raw), quantities: &[SCALES.temperature_c(raw)] };
                let _ = black_box(predictor.track(&sample));
            }),
        );
    }
    let mut monitor = Monitor::new(&parameters(Axis::Gx), PERIOD_S);
    let mut predictor = match with_model(&[], &[], Predictor::<f32, 6, 0, 0, 8>::new) {
        Ok(predictor) => predictor,
        Err(error) => fail(format_args!("{error}")),
    };
    let sample = Sample { measured: &SCALES.measured(&Sensor(1).sample()), quantities: &[] };
    let correction = predictor.track(&sample)[0];
    row(
        "monitor of one axis (a hub watches one at a time)",
        &tally(instructions, |_| {
            let _ = black_box(monitor.update(black_box(&correction)));
        }),
    );

    let triad = TriadCalibration {
        matrix: [[0.98, 0.01, -0.02], [0.0, 1.03, 0.005], [0.015, -0.01, 0.99]],
        bias: [0.2, -0.1, 0.05],
    };
    let calibration = black_box(Calibration { accel: triad, gyro: triad });
    row(
        "calibration of six axes",
        &tally(instructions, |raw| {
            black_box(calibration.apply(&SCALES.measured(raw)));
        }),
    );
    let in_fixed_point = calibration.convert::<Fixed>();
    row(
        "calibration of six axes in fixed point",
        &tally(instructions, |raw| {
            let measured = SCALES.measured(raw).map(Fixed::of);
            black_box(in_fixed_point.apply(&measured));
        }),
    );

    let mut hub: Hub<0, 60, 64> = Hub::new(SCALES);
    let _ = hub.update(&Sensor(1).sample());
    let mut buffer = [0; 320];
    row(
        "a frame of telemetry",
        &tally(instructions, |_| {
            let snapshot: Snapshot<1> = Snapshot::new(hub.output(), &hub.logged());
            black_box(encode_frame(&Frame::Sample(snapshot.frame()), &mut buffer));
        }),
    );
    let start = StartFrame { version: VERSION, period_s: 0.005, axes: HUB_AXES, quantities: "temp_c" };
    black_box(encode_frame(&Frame::Start(start), &mut buffer));

    let cubic = black_box([[0.01_f32, 1e-3, 1e-5, 1e-7]; 6]);
    row(
        "**today's floor**: codes, and a cubic of temperature on six axes",
        &tally(instructions, |raw| {
            black_box(cubic_correction(raw, &cubic));
        }),
    );
}

/// Correction of autopilots: a cubic of temperature, clipped to its range, subtracted from each axis.
#[inline(never)]
fn cubic_correction(raw: &RawSample, coefficients: &[[f32; 4]; 6]) -> [f32; 6] {
    let mut corrected = SCALES.measured(raw);
    let from_middle = SCALES.temperature_c(raw).clamp(-10.0, 60.0) - 25.0;
    for (value, [a, b, c, d]) in corrected.iter_mut().zip(coefficients) {
        *value -= a + from_middle * (b + from_middle * (c + from_middle * d));
    }
    corrected
}

/// Number of traced samples.
const TRACED: usize = 64;

/// Marks the begin and end of counting in a trace.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn trace_mark() {
    black_box(());
}

/// A hub at rest, ten linear terms an axis: processes [`TRACED`] samples between two marks and prints their number.
fn profile() {
    let mut hub = resting_hub::<0, 60, 64, f32>("profile", (&[], &LINEAR)).0;
    let mut sensor = Sensor(3);
    let samples: [RawSample; TRACED] = core::array::from_fn(|_| sensor.sample());
    trace_mark();
    for raw in &samples {
        let _ = black_box(hub.update(black_box(raw)));
    }
    trace_mark();
    println!("{TRACED}");
}

fn run() {
    let mut buffer = [0; 1024];
    if argument(1, &mut buffer).is_some_and(|mode| mode == c"profile") {
        return profile();
    }
    let mut instructions = Instructions::start();
    println!(
        "| hub, six axes | still, median | worst | moving, median | worst | RAM, bytes | stack, bytes | image, bytes |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let linear = hub::<0, 60, 64, f32>(&mut instructions, "10 linear terms an axis", (&[], &LINEAR));
    let fixed =
        hub::<0, 60, 64, Fixed>(&mut instructions, "fixed point: 10 linear terms an axis", (&[], &LINEAR));
    let products = if cfg!(all(feature = "products", feature = "transforms")) {
        let products = with_all_features(&mut instructions);
        println!();
        parts(&mut instructions);
        products
    } else {
        0
    };
    println!();
    let Taken { loading, load_stack, .. } = linear;
    println!(
        "loading the image of 10 linear terms an axis: {loading:.0} instructions, {load_stack} bytes of stack"
    );
    // for the budget
    println!(
        "ram {} stack {} instructions {} {products} {}",
        size_of::<Hub<0, 60, 64>>(),
        linear.stack.max(load_stack),
        linear.still,
        fixed.still
    );
}

/// The hubs that need all features; returns the instructions of a sample at rest of one whose terms are half products.
fn with_all_features(instructions: &mut Instructions) -> usize {
    let products =
        hub::<0, 60, 64, f32>(instructions, "10 terms an axis, half of them products", (&[], &MIXED));
    let _ = hub::<2, 72, 128, f32>(
        instructions,
        "10 linear terms, 2 inputs of temperature",
        (&PHYSICAL, &LINEAR),
    );
    let _ = hub::<16, 128, 256, f32>(
        instructions,
        "the same with room for 16 inputs, 128 terms",
        (&PHYSICAL, &LINEAR),
    );
    let _ = hub::<0, 60, 64, Fixed>(
        instructions,
        "fixed point: 10 terms an axis, half of them products",
        (&[], &MIXED),
    );
    let _ = hub::<2, 72, 128, Fixed>(
        instructions,
        "fixed point: 10 linear terms, 2 inputs of temperature",
        (&PHYSICAL, &LINEAR),
    );
    products.still
}

fos_firmware::firmware!(run);

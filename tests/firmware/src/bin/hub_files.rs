//! Writes the inputs of the checks of the C programs, on the host: a model image, the same as a C array, and a log of
//! raw codes that sets every flag of a hub. Prints the outputs of the hub for the log, in Rust.
//!
//! ```text
//! hub_files FOLDER        # model.fosm, model.h, log.fosh, and linear.fosm
//! ```
//!
//! linear.fosm is a model for a device without products, transforms and calibration. The log is a hub log (`fos_embedded::test_log`).

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use fos_core::image::encode;
use fos_core::{
    Axis, AxisModel, AxisParameters, Calibration, FittedOn, Info, InnovationStatistics, Input, Model,
    Quantity, Range, Source, StillnessLimits, Term, Transform, TriadCalibration, Validity, u, y,
};
use fos_embedded::hub::{Hub, Motion};
use fos_embedded::raw::{Faults, RawSample, Scales};
use fos_embedded::test_log::{HubDigest, HubLogHeader, HubLogRecord};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, folder] = &arguments[..] else {
        println!("usage: hub_files FOLDER");
        std::process::exit(2);
    };
    write(folder.as_ref())
}

const SAMPLES: u32 = 12_000;

const SCALES: Scales = Scales {
    accel_mps2: 0.001_197,
    gyro_rads: 0.000_305,
    temperature_k: 1.0 / 256.0,
    temperature_zero_c: 25.0,
    period_s: 0.005,
    values: FittedOn::Raw,
};

const fn input(source: Source, transform: Transform<f32>, centre: f32, scale: f32) -> Input<f32> {
    let range = Range::new(-3.0, 3.0);
    Input { source, transform, centre, scale, source_range: range, range }
}

const QUANTITIES: [Quantity; 4] =
    [Quantity::Temperature, Quantity::Supply, Quantity::Measured(Axis::Ax), Quantity::Other];

const NAMES: &str = "temp_c °C\nsupply_v V\nax_mps2 m/s²\nhumidity_pct %";

const INPUTS: [Input<f32>; 7] = [
    input(Source::Quantity(0), Transform::Identity, 25.0, 5.0),
    input(Source::Quantity(0), Transform::LowPass { tau_s: 61.0 }, 25.0, 5.0),
    input(Source::Quantity(1), Transform::Rate { tau_s: 2.0 }, 3.3, 0.1),
    input(Source::Quantity(2), Transform::Identity, 0.0, 5.0),
    input(Source::Quantity(3), Transform::Identity, 50.0, 20.0),
    input(Source::Remainder(3), Transform::LowPass { tau_s: 30.0 }, 0.0, 1.0),
    input(Source::Clock, Transform::Sine { frequency_hz: 16.4 }, 0.0, 1.0),
];

const PHYSICAL: [Term<f32>; 5] = [
    Term::new(0.3, &[u(0, 0)]),
    Term::new(-0.1, &[u(1, 0), u(0, 1)]),
    Term::new(0.05, &[u(2, 0)]),
    Term::new(0.02, &[u(4, 0), u(0, 0), u(3, 0)]),
    Term::new(0.1, &[u(6, 0)]),
];

const STOCHASTIC: [Term<f32>; 5] = [
    Term::new(0.2, &[y(1)]),
    Term::new(0.1, &[y(4)]),
    Term::new(0.1, &[u(5, 0)]),
    Term::new(0.01, &[y(1), y(2)]),
    Term::new(-0.002, &[y(2), y(5), u(0, 0)]),
];

// not the order of the sensor
const AXES: [Axis; 5] = [Axis::Gz, Axis::Gy, Axis::Gx, Axis::Az, Axis::Ax];

fn parameters(axis: Axis) -> AxisParameters<f32> {
    let is_accel = matches!(axis, Axis::Ax | Axis::Az);
    AxisParameters {
        axis,
        reference: if axis == Axis::Az { 9.80665 } else { 0.0 },
        offset: if is_accel { 0.03 } else { -0.004 },
        scale: if is_accel { 0.02 } else { 0.003 },
        constant: 0.01,
        range: Range::new(-4.0, 4.0),
        // narrow: p is sometimes limited
        physical_range: Range::new(-0.05, 0.06),
        full_scale: 0.0,
        stuck_after_repeats: 12,
        gap_limit_samples: 20,
        coast_limit_s: 2.0,
        innovation: InnovationStatistics { mean: 0.0, variance: 0.5, lag_1_correlation: 0.0 },
    }
}

const CALIBRATION: Calibration<f32> = Calibration {
    accel: TriadCalibration {
        matrix: [[0.98, 0.01, -0.02], [0.0, 1.03, 0.005], [0.015, -0.01, 0.99]],
        bias: [0.2, -0.1, 0.05],
    },
    gyro: TriadCalibration {
        matrix: [[1.01, -0.02, 0.0], [0.01, 0.97, 0.0], [0.0, 0.03, 1.0]],
        bias: [0.0; 3],
    },
};

/// Image of a model of these terms, with the first `n_inputs` inputs.
fn image(
    n_inputs: usize,
    physical: &[Term<f32>],
    stochastic: &[Term<f32>],
    calibration: Option<Calibration<f32>>,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let axes = AXES.map(|axis| AxisModel { parameters: parameters(axis), physical, stochastic });
    let model = Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: Some(StillnessLimits {
            window: 50,
            accel_variance: 0.01,
            gyro_variance: 0.001,
            gyro_at_rest: [0.0; 3],
            gyro_deviation: 0.1,
        }),
        calibration,
        quantities: &QUANTITIES,
        inputs: &INPUTS[..n_inputs],
        axes: &axes,
    };
    let info = Info { sensor: "simulated", quantities: NAMES, ..Info::default() };
    Ok(encode(&model, &info, &mut [0; 8192])?.to_vec())
}

/// Uniform in 0 … 1 (a linear congruential generator, Knuth's constants).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / 16_777_216.0
    }

    /// Nearly normal, of variance 1.
    fn noise(&mut self) -> f32 {
        2.0 * (self.next() + self.next() + self.next() - 1.5)
    }
}

/// Sample `n`. Its clock is 3 % fast, the second half has bus faults, and the last quarter has an offset that is not in
/// the model.
fn record<'a>(n: u32, random: &mut Random, given: &'a mut [f32; 2]) -> HubLogRecord<'a> {
    let motion = match n % 3000 {
        0..2000 => None,
        2000..2200 => Some(Motion::Moving),
        _ => Some(Motion::Still),
    };
    let moves = n % 1000 > 800 || n % 3000 > 2000 && n % 3000 < 2200;
    let drift = if n >= SAMPLES / 4 * 3 { 3.0 } else { 0.0 };
    let mut code = |unit: f32, centre: f32, noise: f32, motion: f32| {
        let moved = if moves { motion * (random.next() - 0.5) } else { 0.0 };
        ((centre + noise * (random.noise() + drift) + moved) / unit) as i16
    };
    let mut accel = [0.03, 0.0, 9.83665].map(|centre| code(SCALES.accel_mps2, centre, 0.01, 4.0));
    let mut gyro = [-0.004; 3].map(|centre| code(SCALES.gyro_rads, centre, 0.001, 1.0));
    // lies on its side for a while
    if (5000..5300).contains(&n) {
        accel.rotate_left(1);
    }
    let mut faults = Faults::empty();
    if n % 4000 > 3970 {
        (accel, gyro) = ([21, -4, 8190], [3, 4, 5]);
    }
    if n % 4000 > 3985 {
        faults |= Faults::STUCK;
    }
    let event = random.next();
    if event < 0.002 {
        gyro[1] = i16::MIN;
    }
    let skipped = match random.next() {
        few if few < 0.001 => (few * 30_000.0) as u32,
        many if many > 0.9998 => 700,
        _ => 0,
    };
    if skipped > 0 {
        faults |= Faults::GAP;
    }
    if n > SAMPLES / 2 && event > 0.999 {
        faults |= Faults::BUS | Faults::RESET;
    }
    let temperature = (event <= 0.99).then_some((n / 20) as i16);
    if temperature.is_none() {
        faults |= Faults::TEMPERATURE;
    }
    let clock_us = if n % 10 == 9 { u64::from(n + 1) * 4854 } else { 0 };
    let supply_v = if event > 0.995 { f32::NAN } else { 3.3 + 0.05 * (random.next() - 0.5) };
    let humidity_pct = 50.0 + 40.0 * (n as f32 / SAMPLES as f32);
    let raw = RawSample { skipped, accel, gyro, temperature, faults };
    *given = [supply_v, humidity_pct];
    HubLogRecord { raw, motion, clock_us, given }
}

fn write(folder: &Path) -> Result<(), Box<dyn Error>> {
    let image = image(INPUTS.len(), &PHYSICAL, &STOCHASTIC, Some(CALIBRATION))?;
    let mut hub: Hub<16, 128, 256> = Hub::new(SCALES);
    hub.load(&image)?;
    let header = HubLogHeader { scales: SCALES, n_given: 2 };
    let (mut log, mut digest, mut random) = (header.encode().to_vec(), HubDigest::default(), Random(1));
    // events so far: validity, faults; innovations, drift, still, moving
    let (mut validity, mut faults, mut seen) = (Validity::VALID, Faults::empty(), [0_u32; 4]);
    for n in 0..SAMPLES {
        let mut given = [0.0; 2];
        let record = record(n, &mut random, &mut given);
        log.extend(record.encode());
        let output = *record.step(&mut hub);
        digest.update(&output);
        for each in output.validity() {
            validity |= each;
        }
        faults |= output.faults;
        let innovation = output.innovation().iter().any(|innovation| innovation.is_finite());
        for (seen, now) in seen.iter_mut().zip([innovation, output.drift, output.still, !output.still]) {
            *seen += u32::from(now);
        }
    }
    // an event that never occurs in the log would not be checked
    let never = Validity::NOT_FINITE | Validity::MISSING;
    let always = validity | never;
    let all_faults = faults | Faults::OVERRUN | Faults::WRONG_PART;
    if always.bits() != 0x7ff || !all_faults.is_all() || seen.contains(&0) {
        return Err(format!("something never happens: {validity:?}, {faults:?}, {seen:?}").into());
    }

    let mut array = String::from("static const unsigned char model[] = {");
    for (n, byte) in image.iter().enumerate() {
        write!(array, "{}{byte}", if n == 0 { "" } else { "," })?;
    }
    array.push_str("};\n");
    fs::write(folder.join("model.fosm"), &image)?;
    fs::write(folder.join("linear.fosm"), self::image(1, &PHYSICAL[..1], &STOCHASTIC[..2], None)?)?;
    fs::write(folder.join("model.h"), array)?;
    fs::write(folder.join("log.fosh"), &log)?;
    println!("samples {SAMPLES}");
    println!("outputs {:016x}", digest.outputs());
    Ok(())
}

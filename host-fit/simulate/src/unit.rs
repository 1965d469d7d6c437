//! A simulated device: temperature, orientation, motion, errors, quantisation, timestamps.

use fos_data::column::AXES;
use fos_data::column::Column;
use fos_data::unit::{MG_MPS2, STANDARD_GRAVITY_MPS2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::noise::{Noise, NoiseSizes};

const DPS: f64 = std::f64::consts::PI / 180.0;

/// Noise of the simulated accelerometers: 180 µg/√Hz, bias instability 50 µg (BMI160 data sheet: 180 µg/√Hz; bias
/// instability as measured by users).
const ACCEL_NOISE_DENSITY: f64 = 180e-3 * MG_MPS2;
const ACCEL_BIAS_INSTABILITY: f64 = 0.05 * MG_MPS2;
/// Noise of the simulated gyros: 7 mdps/√Hz, bias instability 9 °/h (BMI160 data sheet: 0.007 °/s/√Hz).
const GYRO_NOISE_DENSITY: f64 = 0.007 * DPS;
const GYRO_BIAS_INSTABILITY: f64 = 9.0 / 3600.0 * DPS;

/// Least significant bits: 16 bits over ±4 g and ±250 °/s.
const ACCEL_LSB: f64 = 4.0 * STANDARD_GRAVITY_MPS2 / 32768.0;
const GYRO_LSB: f64 = 250.0 * DPS / 32768.0;

/// Full scales of the same ranges.
const FULL_SCALE: [f64; 6] = [
    4.0 * STANDARD_GRAVITY_MPS2,
    4.0 * STANDARD_GRAVITY_MPS2,
    4.0 * STANDARD_GRAVITY_MPS2,
    250.0 * DPS,
    250.0 * DPS,
    250.0 * DPS,
];

/// Temperature coefficient of each axis: mg/K and °/s/K of phone-class parts.
const PER_KELVIN: [f64; 6] =
    [0.5 * MG_MPS2, -0.8 * MG_MPS2, 1.0 * MG_MPS2, 0.02 * DPS, -0.03 * DPS, 0.015 * DPS];

/// Bias at 25 °C.
const BIAS: [f64; 6] = [20.0 * MG_MPS2, -15.0 * MG_MPS2, 30.0 * MG_MPS2, 0.5 * DPS, -0.3 * DPS, 0.8 * DPS];

/// Duration of a motion, and of the rest between two, s.
const MOTION_S: f64 = 30.0;
const REST_S: f64 = 60.0;

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Simulation {
    /// Duration, s.
    pub duration_s: f64,
    /// Nominal sampling rate, Hz; the true one differs by up to 1 %.
    pub rate_hz: f64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Temperature sensitivity, as a multiple of the device's; 0 for none.
    pub temperature: f64,
    /// True if the device is moved by hand for 30 s out of every 90 s in the last third of the log.
    pub motion: bool,
}

impl Default for Simulation {
    fn default() -> Self {
        Self { duration_s: 1200.0, rate_hz: 200.0, seed: 1, temperature: 1.0, motion: true }
    }
}

/// A log and the truth behind it.
#[derive(Debug, Clone)]
pub struct SimulatedLog {
    /// Columns of the log as written by a recorder: `t_s`, six axes, `temp_c`, `still`.
    pub columns: Vec<(String, Vec<f64>)>,
    /// True value of each axis, in its unit: `ref_ax_mps2` …
    pub truth: Vec<(String, Vec<f64>)>,
}

/// Simulates a log. The same arguments give the same log.
pub fn simulate(simulation: &Simulation) -> SimulatedLog {
    let mut random = ChaCha8Rng::seed_from_u64(simulation.seed);
    let rate_hz = simulation.rate_hz * (1.0 + random.random_range(-0.01..0.01));
    let period_s = 1.0 / rate_hz;
    let n = (simulation.duration_s * rate_hz) as usize;
    let mut noises: Vec<Noise> =
        (0..6).map(|axis| Noise::new(sizes(axis, rate_hz), period_s, &mut random)).collect();
    let mut time_s = Vec::with_capacity(n);
    let mut temperature = Vec::with_capacity(n);
    let mut still = Vec::with_capacity(n);
    let mut measured: [Vec<f64>; 6] = std::array::from_fn(|_| Vec::with_capacity(n));
    let mut truth: [Vec<f64>; 6] = std::array::from_fn(|_| Vec::with_capacity(n));
    let mut thermometer = f64::NAN;
    for sample in 0..n {
        let t = sample as f64 * period_s;
        let die = die_temperature(t);
        // a slow channel repeats its last value, and has its own resolution
        if sample % (rate_hz as usize / 10).max(1) == 0 {
            thermometer = (die * 64.0).round() / 64.0;
        }
        let moving = simulation.motion.then(|| motion_phase(t, simulation.duration_s)).flatten();
        let true_values = match moving {
            Some(phase) => motion(phase),
            None => [0.0, 0.0, STANDARD_GRAVITY_MPS2, 0.0, 0.0, 0.0],
        };
        for axis in 0..6 {
            let drift = simulation.temperature * PER_KELVIN[axis] * (die - 25.0);
            let error = BIAS[axis] + drift + noises[axis].next(&mut random);
            let lsb = if axis < 3 { ACCEL_LSB } else { GYRO_LSB };
            let value = (true_values[axis] + error).clamp(-FULL_SCALE[axis], FULL_SCALE[axis]);
            measured[axis].push((value / lsb).round() * lsb);
            truth[axis].push(true_values[axis]);
        }
        time_s.push(((t + 2e-4 * random.random_range(-1.0..1.0)) * 1e6).round() * 1e-6);
        temperature.push(thermometer);
        still.push(f64::from(u8::from(moving.is_none())));
    }
    let mut columns = vec![("t_s".to_owned(), time_s)];
    columns.extend(AXES.iter().map(|name| (*name).to_owned()).zip(measured));
    columns.push(("temp_c".to_owned(), temperature));
    columns.push(("still".to_owned(), still));
    let truth = AXES.iter().map(|name| Column::named(name).reference()).zip(truth).collect();
    SimulatedLog { columns, truth }
}

fn sizes(axis: usize, rate_hz: f64) -> NoiseSizes {
    let (density, instability) = if axis < 3 {
        (ACCEL_NOISE_DENSITY, ACCEL_BIAS_INSTABILITY)
    } else {
        (GYRO_NOISE_DENSITY, GYRO_BIAS_INSTABILITY)
    };
    NoiseSizes {
        // white noise of that density over half the sampling rate
        white: density * (rate_hz / 2.0).sqrt(),
        flicker: instability,
        // reaches the bias instability after a quarter of an hour
        random_walk: instability / 30.0,
    }
}

/// Die temperature, °C: warms up by 4 K with 200 s, and follows a room that oscillates by 5 K in 7 minutes.
fn die_temperature(t: f64) -> f64 {
    27.0 + 4.0 * (1.0 - (-t / 200.0).exp()) + 2.5 * (std::f64::consts::TAU * t / 420.0).sin()
}

/// Time since the begin of the present motion, s; `None` at rest.
fn motion_phase(t: f64, duration_s: f64) -> Option<f64> {
    let since = t - duration_s * 2.0 / 3.0;
    let phase = since.rem_euclid(REST_S + MOTION_S) - REST_S;
    (since >= 0.0 && phase >= 0.0).then_some(phase)
}

/// Specific force and rate of a hand that rotates the device, smooth at both ends.
fn motion(phase: f64) -> [f64; 6] {
    let envelope = (std::f64::consts::PI * phase / MOTION_S).sin().powi(2);
    let swing = |frequency_hz: f64, shift: f64| {
        envelope * (std::f64::consts::TAU * frequency_hz * phase + shift).sin()
    };
    let tilt = 0.6 * swing(0.31, 0.0);
    [
        STANDARD_GRAVITY_MPS2 * tilt.sin() + 2.0 * swing(1.3, 0.4),
        1.5 * swing(0.9, 1.1),
        STANDARD_GRAVITY_MPS2 * tilt.cos() + 1.0 * swing(1.7, 2.0),
        1.2 * swing(0.5, 0.7),
        0.9 * swing(0.8, 0.2),
        1.5 * swing(0.4, 1.9),
    ]
}

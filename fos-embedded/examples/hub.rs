//! A gyro whose bias depends on temperature: the hub removes the bias, at rest and during a rotation.
//!
//! ```text
//! cargo run -p fos-embedded --example hub                                         # here
//! cargo run -p fos-embedded --example hub --target thumbv7em-none-eabihf          # on an emulated Cortex-M4F, the same bits
//! cargo run -p fos-embedded --example hub --target riscv32imafc-unknown-none-elf  # and on RISC-V
//! ```
//!
//! The model is compiled in, in the form that `fos export --rust` writes, and the compiler checks it. A model image, from flash or over the air, is
//! loaded with [`Hub::load`].
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board;

#[cfg(target_os = "none")]
use board::println;
use fos_core::{
    Axis, AxisModel, AxisParameters, CheckedModel, FittedOn, InnovationStatistics, Input, Model, Quantity,
    Range, Source, StillnessLimits, Term, Transform, u,
};
use fos_embedded::hub::Hub;
use fos_embedded::raw::{RawSample, Scales};

/// Scales of the sensor's codes; a driver in `sample_source` provides them.
const SCALES: Scales = Scales {
    accel_mps2: 0.001_197, // ±4 g
    gyro_rads: 0.000_305,  // ±500 dps
    temperature_k: 1.0 / 256.0,
    temperature_zero_c: 25.0,
    period_s: 0.005,
    values: FittedOn::Raw,
};

/// True bias: 0.02 rad/s at 25 °C, plus 0.001 rad/s per kelvin.
fn bias_rads(celsius: f32) -> f32 {
    0.02 + 0.001 * (celsius - 25.0)
}

/// Model that a fit would find: 0.025 rad/s at 30 °C, plus one scaled unit (0.005 rad/s) per 5 K.
static GYRO_Z: AxisModel<'_, f32> = AxisModel {
    parameters: AxisParameters {
        axis: Axis::Gz,
        reference: 0.0,
        offset: 0.025,
        scale: 0.005,
        constant: 0.0,
        range: Range::new(-3.0, 3.0),
        physical_range: Range::new(-2.0, 2.0),
        full_scale: 8.7,
        stuck_after_repeats: 0,
        gap_limit_samples: 20,
        coast_limit_s: 60.0,
        innovation: InnovationStatistics { mean: 0.0, variance: 0.1, lag_1_correlation: 0.0 },
    },
    physical: &[Term::new(1.0, &[u(0, 0)])],
    stochastic: &[],
};

static TEMPERATURE: Input<f32> = Input {
    source: Source::Quantity(0),
    transform: Transform::Identity,
    centre: 30.0,
    scale: 5.0,
    source_range: Range::new(-2.0, 2.0),
    range: Range::new(-2.0, 2.0),
};

static MODEL: CheckedModel<'_> = CheckedModel::new(Model {
    period_s: 0.005,
    fitted_on: FittedOn::Raw,
    stillness: Some(StillnessLimits {
        window: 100,
        accel_variance: 0.01,
        gyro_variance: 0.001,
        gyro_at_rest: [0.0, 0.0, 0.025],
        gyro_deviation: 0.05,
    }),
    calibration: None,
    quantities: &[Quantity::Temperature],
    inputs: &[TEMPERATURE],
    axes: &[GYRO_Z],
});

/// A sample at rest or during a rotation about z, while the sensor warms from 25 °C to 35 °C in 20 s.
fn sample(n: u16, rate_rads: f32) -> RawSample {
    let celsius = 25.0 + 10.0 * f32::from(n) / 4000.0;
    RawSample {
        accel: [0, 0, 8193],
        gyro: [0, 0, ((rate_rads + bias_rads(celsius)) / SCALES.gyro_rads) as i16],
        temperature: Some(((celsius - SCALES.temperature_zero_c) / SCALES.temperature_k) as i16),
        ..RawSample::default()
    }
}

fn run() {
    // room for 1 input, 1 term, 4 values of history; may be a `static`
    let mut hub: Hub<1, 1, 4> = Hub::new(SCALES);
    hub.load_checked(&MODEL).expect("it has the room, and is of this sensor");
    let (mut measured, mut corrected) = (0.0_f32, 0.0_f32);
    for n in 0..4000 {
        let rate_rads = if n < 2000 { 0.0 } else { 0.5 };
        let output = hub.update(&sample(n, rate_rads));
        // rest is detected after two windows of half a second, a rotation at once
        assert_eq!(output.still, (199..2000).contains(&n), "sample {n}");
        measured = measured.max((output.measured[5] - rate_rads).abs());
        corrected = corrected.max((output.gyro()[2] - rate_rads).abs());
    }
    println!("largest error, rad/s: measured {measured:.4}, corrected {corrected:.4}");
    assert!(measured > 0.029, "the bias is there");
    assert!(corrected < 0.0004, "what is left is the rounding of the codes: a step is 0.0003 rad/s");
    assert!(hub.output().faults.is_empty());
}

#[cfg(not(target_os = "none"))]
fn main() {
    run();
}

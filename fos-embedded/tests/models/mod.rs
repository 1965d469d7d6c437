//! Model images for tests, and a matching sensor.
#![allow(dead_code, reason = "no test uses all of it")]

use fos_core::image::encode;
use fos_core::{
    Axis, AxisModel, AxisParameters, Calibration, FittedOn, Info, InnovationStatistics, Input, Model,
    Quantity, Range, Source, StillnessLimits, Term, Transform, u, y,
};
use fos_embedded::hub::Hub;
pub(crate) use fos_embedded::hub::SIX;
use fos_embedded::raw::{RawSample, Scales};

pub(crate) type TestHub = Hub<8, 64, 128>;

pub(crate) const SCALES: Scales = Scales {
    accel_mps2: 0.001_197,
    gyro_rads: 0.000_305,
    temperature_k: 1.0 / 256.0,
    temperature_zero_c: 25.0,
    period_s: 0.005,
    values: FittedOn::Raw,
};

/// True value at rest, level; [`SPREAD`] is the scatter of the measured values: m/s², rad/s.
pub(crate) const AT_REST: [f32; 6] = [0.0, 0.0, 9.81, 0.0, 0.0, 0.0];
pub(crate) const SPREAD: [f32; 6] = [0.01, 0.01, 0.01, 0.002, 0.002, 0.002];

/// Offset of every axis, in its unit.
pub(crate) const OFFSET: [f32; 6] = [0.02, -0.03, 0.05, 0.004, -0.006, 0.002];

pub(crate) static STOCHASTIC: [Term<f32>; 3] =
    [Term::new(0.4, &[y(1)]), Term::new(0.1, &[y(2)]), Term::new(0.01, &[y(1), y(2)])];
pub(crate) static PHYSICAL: [Term<f32>; 2] = [Term::new(0.5, &[u(0, 0)]), Term::new(0.2, &[u(1, 0)])];

pub(crate) fn parameters(axis: Axis) -> AxisParameters<f32> {
    let at = SIX.iter().position(|other| *other == axis).unwrap_or(3);
    AxisParameters {
        axis,
        reference: AT_REST[at],
        offset: OFFSET[at],
        scale: SPREAD[at],
        constant: 0.0,
        range: Range::new(-5.0, 5.0),
        physical_range: Range::unlimited(),
        full_scale: 0.0,
        stuck_after_repeats: 20,
        gap_limit_samples: 20,
        coast_limit_s: 10.0,
        innovation: InnovationStatistics { mean: 0.0, variance: 1.2, lag_1_correlation: -0.3 },
    }
}

pub(crate) fn limits() -> StillnessLimits<f32> {
    StillnessLimits {
        window: 100,
        accel_variance: 0.001,
        gyro_variance: 5e-5,
        gyro_at_rest: [OFFSET[3], OFFSET[4], OFFSET[5]],
        gyro_deviation: 0.01,
    }
}

const INPUT: Input<f32> = Input {
    source: Source::Quantity(0),
    transform: Transform::LowPass { tau_s: 30.0 },
    centre: 25.0,
    scale: 10.0,
    source_range: Range::new(-2.0, 2.0),
    range: Range::new(-2.0, 2.0),
};

/// Low-passed temperature, and supply voltage.
pub(crate) fn inputs() -> [Input<f32>; 2] {
    let supply = Input {
        source: Source::Quantity(1),
        transform: Transform::Identity,
        centre: 3.3,
        scale: 0.1,
        ..INPUT
    };
    [INPUT, supply]
}

pub(crate) struct Made<'a> {
    pub(crate) axes: &'a [Axis],
    pub(crate) quantities: &'a [Quantity],
    pub(crate) period_s: f64,
    pub(crate) fitted_on: FittedOn,
    pub(crate) stillness: Option<StillnessLimits<f32>>,
    pub(crate) calibration: Option<Calibration<f32>>,
}

pub(crate) const MADE: Made<'_> = Made {
    axes: &SIX,
    quantities: &[Quantity::Temperature, Quantity::Supply],
    period_s: 0.005,
    fitted_on: FittedOn::Raw,
    stillness: None,
    calibration: None,
};

pub(crate) fn image(made: &Made<'_>) -> Vec<u8> {
    let axes: Vec<AxisModel<'_, f32>> = made
        .axes
        .iter()
        .map(|axis| AxisModel { parameters: parameters(*axis), physical: &PHYSICAL, stochastic: &STOCHASTIC })
        .collect();
    let model = Model {
        period_s: made.period_s,
        fitted_on: made.fitted_on,
        stillness: made.stillness,
        calibration: made.calibration,
        quantities: made.quantities,
        inputs: &inputs(),
        axes: &axes,
    };
    let info = Info { quantities: "temp_c °C\nsupply_v V", ..Info::default() };
    encode(&model, &info, &mut [0; 4096]).expect("it fits").to_vec()
}

/// Reproducible uniform numbers in ±1 (a linear congruential generator with Knuth's constants).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / 8_388_608.0 - 1.0
    }

    /// A sample at rest, level, at 25 °C, with the noise `SPREAD` and the bias `OFFSET`.
    pub(crate) fn at_rest(&mut self) -> RawSample {
        let mut codes = [0; 6];
        for (axis, code) in codes.iter_mut().enumerate() {
            let lsb = if axis < 3 { SCALES.accel_mps2 } else { SCALES.gyro_rads };
            let noise = self.next() + self.next() + self.next();
            *code = ((AT_REST[axis] + OFFSET[axis] + noise * SPREAD[axis]) / lsb).round() as i16;
        }
        let [ax, ay, az, gx, gy, gz] = codes;
        RawSample { accel: [ax, ay, az], gyro: [gx, gy, gz], temperature: Some(0), ..RawSample::default() }
    }
}

/// A distinct image for every number, for a store: one axis, `provenance` bytes of provenance.
pub(crate) fn numbered(number: u32, provenance: usize) -> Vec<u8> {
    let terms = [Term::try_new(0.5 + f64::from(number) * 1e-3, &[y(1)]).expect("a term").convert::<f32>()];
    let axes = [AxisModel { parameters: parameters(Axis::Gx), physical: &[], stochastic: &terms }];
    let model = Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities: &[],
        inputs: &[],
        axes: &axes,
    };
    let provenance = "x".repeat(provenance);
    let info = Info { sensor: "simulated", provenance: &provenance, quantities: "", effects: "" };
    encode(&model, &info, &mut [0; 8192]).expect("an image").to_vec()
}

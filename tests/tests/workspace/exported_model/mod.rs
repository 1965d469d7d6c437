//! Model used by the tests of export.

use fos_core::{
    Axis, AxisParameters, Factor, FittedOn, InnovationStatistics, Input, Quantity, Range, Source,
    StillnessLimits, Transform, TriadCalibration, u, y,
};
use fos_fit::calibration::UnitCalibration;
use fos_fit::model::{FittedAxis, FittedTerm, LoggedQuantity, NamedInput, UnitModel};

fn term(coefficient: f64, factors: &[Factor]) -> FittedTerm {
    FittedTerm { coefficient, standard_error: None, factors: factors.to_vec() }
}

fn input(source: Source, transform: Transform<f64>, centre: f64, scale: f64) -> NamedInput {
    let range = Range::new(-3.0, 3.0);
    let input = Input { source, transform, centre, scale, source_range: range, range };
    NamedInput { name: String::new(), input }
}

fn logged(column: &str, quantity: Quantity) -> LoggedQuantity {
    LoggedQuantity { column: column.to_owned(), quantity }
}

/// A gyro and an accelerometer; every kind of term, every transform, every kind of quantity, and a term for every
/// input.
#[expect(unreachable_pub, reason = "a module of several tests")]
pub fn model() -> UnitModel {
    let parameters = AxisParameters {
        axis: Axis::Gx,
        reference: 0.0,
        offset: 0.0123,
        scale: 0.0021,
        constant: 0.01,
        range: Range::new(-4.5, 4.25),
        physical_range: Range::new(-8.0, 7.5),
        full_scale: 4.36,
        stuck_after_repeats: 40,
        gap_limit_samples: 20,
        coast_limit_s: 10.0,
        innovation: InnovationStatistics { mean: 0.0, variance: 0.8, lag_1_correlation: 0.01 },
    };
    let of_temperature = [
        Transform::Identity,
        Transform::LowPass { tau_s: 61.5 },
        Transform::Rate { tau_s: 10.0 },
        Transform::Variance { tau_s: 2.0 },
        Transform::Backlash { half_width: 0.5 },
        Transform::Absolute,
    ];
    let of_temperature = of_temperature.map(|transform| input(Source::Quantity(0), transform, 25.0, 2.5));
    let clocks = [
        Transform::Decay { tau_s: 120.0 },
        Transform::Time,
        Transform::Sine { frequency_hz: 16.37 },
        Transform::Cosine { frequency_hz: 16.37 },
    ];
    let clocks = clocks.map(|transform| input(Source::Clock, transform, 1.5, 2.5));
    let others = [
        input(Source::Remainder(1), Transform::LowPass { tau_s: 1.0 }, 0.0, 2.0),
        input(Source::Quantity(1), Transform::Identity, 3.3, 0.05),
        input(Source::Quantity(2), Transform::Identity, 9.85, 0.05),
    ];
    let inputs: Vec<NamedInput> = of_temperature.into_iter().chain(clocks).chain(others).collect();

    let of_inputs =
        (2..inputs.len() as u8).filter(|input| *input != 10).map(|input| term(0.1, &[u(input, 0)]));
    let gyro = FittedAxis {
        column: "gx_rads".into(),
        parameters,
        physical: [term(0.3, &[u(0, 0)]), term(-0.02, &[u(0, 0), u(1, 0)])]
            .into_iter()
            .chain(of_inputs)
            .collect(),
        stochastic: vec![
            term(0.6, &[y(1)]),
            term(1.0 / 3.0, &[y(2)]),
            term(1e-7, &[y(1), y(2), u(2, 1)]),
            term(0.05, &[u(10, 0)]),
        ],
        plain: None,
    };
    let accelerometer = FittedAxis {
        column: "az_mps2".into(),
        parameters: AxisParameters {
            axis: Axis::Az,
            reference: 9.8,
            offset: 0.05,
            scale: 0.021,
            full_scale: 39.2,
            ..parameters
        },
        physical: vec![term(0.3, &[u(0, 0)])],
        stochastic: vec![term(0.6, &[y(1)]), term(-0.2, &[y(2)])],
        plain: None,
    };
    UnitModel {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: Some(StillnessLimits {
            window: 100,
            accel_variance: 1e-3,
            gyro_variance: 1e-5,
            gyro_at_rest: [0.01, -0.02, 0.0],
            gyro_deviation: 0.02,
        }),
        calibration: Some(UnitCalibration {
            sources: Vec::new(),
            rests: 12,
            gravity_residual_mps2: [0.2, 0.01],
            temperature_c: Some(28.0),
            accel: TriadCalibration {
                matrix: [[0.98, 0.01, -0.02], [0.0, 1.03, 0.005], [0.015, -0.01, 0.99]],
                bias: [0.2, -0.1, 0.05],
            },
            gyro: Some(TriadCalibration {
                matrix: [[1.01, -0.02, 0.0], [0.01, 0.97, 0.0], [0.0, 0.03, 1.0]],
                bias: [0.01, 0.0, -0.002],
            }),
        }),
        quantities: vec![
            logged("temp_c", Quantity::Temperature),
            logged("supply_v", Quantity::Supply),
            logged("az_mps2", Quantity::Measured(Axis::Az)),
        ],
        inputs,
        axes: vec![gyro, accelerometer],
    }
}

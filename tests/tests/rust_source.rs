//! A model as Rust source compiles, and is the model of its image to the last bit.

use fos_core::{Axis, Predictor, StillnessLimits, Transform, u, y};
use fos_core::{
    AxisParameters, FittedOn, Image, InnovationStatistics, Input, Quantity, Range, Sample, Source,
};
use host_fit::export::{image, rust_source};
use host_fit::model::{FittedAxis, FittedTerm, LoggedQuantity, NamedInput, UnitModel};

#[allow(unreachable_pub, reason = "exported to be used from anywhere in a firmware")]
mod exported {
    include!("../golden/model.rs");
}

fn term(coefficient: f64, factors: &[fos_core::Factor]) -> FittedTerm {
    FittedTerm { coefficient, standard_error: None, factors: factors.to_vec() }
}

fn input(source: Source, transform: Transform<f64>) -> NamedInput {
    let range = Range::new(-3.0, 3.0);
    let input = Input { source, transform, centre: 25.0, scale: 2.5, source_range: range, range };
    NamedInput { name: String::new(), input }
}

/// Two axes, every kind of term, every transform.
fn model() -> UnitModel {
    let axis = |axis, column: &str| FittedAxis {
        column: column.to_owned(),
        parameters: AxisParameters {
            axis,
            reference: 0.0,
            offset: 0.0123,
            scale: 0.0021,
            constant: 0.01,
            range: Range::new(-4.5, 4.25),
            full_scale: 4.36,
            stuck_after: 40,
            gap_limit: 20,
            coast_limit_s: 10.0,
            innovation: InnovationStatistics { mean: 0.0, variance: 0.8, lag_1_correlation: 0.01 },
        },
        physical: vec![term(0.3, &[u(0, 0)]), term(-0.02, &[u(0, 0), u(1, 0)])],
        stochastic: vec![term(0.6, &[y(1)]), term(1.0 / 3.0, &[y(2)]), term(1e-7, &[y(1), y(2), u(2, 1)])],
    };
    let transforms = [
        Transform::Identity,
        Transform::LowPass { tau_s: 61.5 },
        Transform::Rate { tau_s: 10.0 },
        Transform::Variance { tau_s: 2.0 },
        Transform::Backlash { half_width: 0.5 },
        Transform::Absolute,
    ];
    let clocks = [
        Transform::Decay { tau_s: 120.0 },
        Transform::Time,
        Transform::Sine { frequency_hz: 16.37 },
        Transform::Cosine { frequency_hz: 16.37 },
    ];
    let logged = transforms.map(|transform| input(Source::Quantity(0), transform));
    let clocks = clocks.map(|transform| input(Source::Clock, transform));
    let memory = input(Source::Remainder(1), Transform::LowPass { tau_s: 1.0 });
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
        quantities: vec![LoggedQuantity { column: "temp_c".into(), quantity: Quantity::Temperature }],
        inputs: logged.into_iter().chain(clocks).chain([memory]).collect(),
        axes: vec![axis(Axis::Gx, "gx_rads"), axis(Axis::Gz, "gz_rads")],
    }
}

#[test]
fn the_source_is_the_golden_one() {
    let source = rust_source(&model(), "host-fit, a model for tests");
    let golden = include_str!("../golden/model.rs");
    if source != golden {
        let path = std::env::temp_dir().join("model.rs");
        std::fs::write(&path, &source).expect("the temporary folder is writable");
        panic!("the exported source has changed; if that is meant, copy {} to tests/golden", path.display());
    }
}

#[test]
fn source_and_image_are_the_same_model_to_the_last_bit() {
    type Device = Predictor<f32, 2, 16, 16, 64>;
    let bytes = image(&model(), "", "").expect("exported");
    let mut stored: Device = Image::parse(&bytes).expect("its own image").predictor().expect("fits");
    let mut compiled = Device::new(&exported::MODEL).expect("fits");
    for n in 0..5000_u32 {
        let noise = f32::from((n.wrapping_mul(40_503) >> 7) as u8) * 1e-5;
        let sample =
            Sample { measured: &[0.012 + noise, 0.013 - noise], quantities: &[24.0 + 0.001 * n as f32] };
        let (a, b) = match n % 1000 {
            0..800 => (stored.track(&sample).to_vec(), compiled.track(&sample).to_vec()),
            _ => (stored.coast(&sample).to_vec(), compiled.coast(&sample).to_vec()),
        };
        assert_eq!(a, b, "{n}");
    }
}

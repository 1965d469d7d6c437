//! Validation of models, and the precision of f32.

use fos_core::{
    Axis, AxisParameters, FittedOn, InnovationStatistics, Input, ModelError, Predictor, Quantity, Range,
    Sample, Scalar, Source, StillnessDetector, StillnessLimits, Term, Transform, u, y,
};
use fos_testkit::models::{OwnedAxis, OwnedModel, PERIOD_S, Roomy, input, plain};
use fos_testkit::noise::Noise;

/// A small valid model with inputs over a quantity, the clock and the remainder.
fn valid_model() -> OwnedModel<f64> {
    OwnedModel {
        period_s: PERIOD_S,
        stillness: None,
        calibration: None,
        quantities: vec![Quantity::Temperature],
        inputs: vec![
            input(Source::Quantity(0), Transform::LowPass { tau_s: 2.0 }, 2.0),
            input(Source::Clock, Transform::Decay { tau_s: 300.0 }, 2.0),
            input(Source::Remainder(0), Transform::LowPass { tau_s: 10.0 }, 2.0),
        ],
        axes: vec![OwnedAxis {
            parameters: plain(),
            physical: vec![Term::new(0.2, &[u(0, 0)]), Term::new(0.3, &[u(1, 0), u(0, 1)])],
            stochastic: vec![Term::new(0.5, &[y(1)]), Term::new(0.1, &[u(2, 0)])],
        }],
    }
}

/// The error of the changed model, the same in f64 and f32.
fn error(change: impl Fn(&mut OwnedModel<f64>)) -> ModelError {
    let mut model = valid_model();
    change(&mut model);
    let error = model.predictor().map(|_| ()).unwrap_err();
    assert_eq!(model.convert::<f32>().predictor().map(|_| ()).unwrap_err(), error);
    assert!(!error.to_string().is_empty());
    error
}

#[test]
fn accepts_a_valid_model() {
    assert!(valid_model().predictor().is_ok() && valid_model().convert::<f32>().predictor().is_ok());
    assert_eq!(valid_model().predictor().unwrap().n_axes(), 1);
}

#[test]
fn rejects_non_positive_periods() {
    for period_s in [0.0, -0.005, f64::NAN, f64::INFINITY] {
        assert_eq!(error(|model| model.period_s = period_s), ModelError::Period);
    }
}

#[test]
fn rejects_a_model_without_axes() {
    assert_eq!(error(|model| model.axes.clear()), ModelError::NoAxis);
}

#[test]
fn names_the_exceeded_capacity() {
    let mut model = valid_model();
    model.axes.push(model.axes[0].clone());
    let too_many = |found, capacity| ModelError::TooManyAxes { found, capacity };
    let error = model.borrow(|model| Predictor::<f64, 1, 3, 8, 16>::new(model).map(|_| ()).unwrap_err());
    assert_eq!(error, too_many(2, 1));
    let error = model.borrow(|model| Predictor::<f64, 2, 2, 8, 16>::new(model).map(|_| ()).unwrap_err());
    assert_eq!(error, ModelError::TooManyInputs { found: 3, capacity: 2 });
    let error = model.borrow(|model| Predictor::<f64, 2, 3, 7, 16>::new(model).map(|_| ()).unwrap_err());
    assert_eq!(error, ModelError::TooManyTerms { capacity: 7 });
    // capacities that fit exactly: u_0(n − 1) lies 5 + 3 values back
    assert!(model.borrow(Predictor::<f64, 2, 3, 8, 8>::new).is_ok());
    let error = model.borrow(|model| Predictor::<f64, 2, 3, 8, 4>::new(model).map(|_| ()).unwrap_err());
    assert!(matches!(error, ModelError::LagTooDeep { capacity: 4, needed: 5.., .. }), "{error:?}");
}

#[test]
fn uses_the_history_to_its_last_value() {
    // lag 8 of one axis in a history of 8: its oldest value
    let model = OwnedModel::autoregressive(plain(), vec![Term::new(0.5_f64, &[y(8)])]);
    let mut predictor = model.borrow(Predictor::<f64, 1, 0, 1, 8>::new).unwrap();
    for n in 0..40 {
        let value = f64::from(n % 11) / 11.0;
        let correction = predictor.track(&Sample { measured: &[value], quantities: &[] })[0];
        if n >= 8 {
            assert_eq!(correction.predicted, 0.5 * f64::from((n - 8) % 11) / 11.0);
        }
    }
    let deeper = OwnedModel::autoregressive(plain(), vec![Term::new(0.5_f64, &[y(9)])]);
    let error = deeper.borrow(|model| Predictor::<f64, 1, 0, 1, 8>::new(model).map(|_| ()).unwrap_err());
    assert_eq!(error, ModelError::LagTooDeep { axis: 0, needed: 9, capacity: 8 });
    let deepest = OwnedModel::autoregressive(plain(), vec![Term::new(0.5_f64, &[y(u16::MAX)])]);
    assert!(matches!(deepest.predictor(), Err(ModelError::LagTooDeep { axis: 0, needed: 65535, .. })));
}

#[test]
fn rejects_non_finite_coefficients() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let expected = |term| ModelError::CoefficientNotFinite { axis: 0, term };
        assert_eq!(error(|model| model.axes[0].physical[1] = Term::new(bad, &[u(0, 0)])), expected(1));
        assert_eq!(error(|model| model.axes[0].stochastic[1] = Term::new(bad, &[y(1)])), expected(3));
    }
}

#[test]
fn rejects_invalid_axis_parameters() {
    type Change = fn(&mut AxisParameters<f64>, f64);
    let finite: [Change; 6] = [
        |axis, value| axis.reference = value,
        |axis, value| axis.offset = value,
        |axis, value| axis.constant = value,
        |axis, value| axis.innovation.mean = value,
        |axis, value| axis.range.low = value,
        |axis, value| axis.physical_range.high = value,
    ];
    let not_negative: [Change; 2] =
        [|axis, value| axis.full_scale = value, |axis, value| axis.coast_limit_s = value];
    let positive: [Change; 2] =
        [|axis, value| axis.scale = value, |axis, value| axis.innovation.variance = value];
    let not_finite = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let cases = [(&finite[..], &not_finite[..]), (&not_negative, &[-1.0]), (&positive, &[-1.0, 0.0])];
    for (changes, values) in cases {
        for change in changes {
            for &value in values.iter().chain(&not_finite) {
                let found = error(|model| change(&mut model.axes[0].parameters, value));
                assert_eq!(found, ModelError::AxisParameter { axis: 0 }, "{value}");
            }
        }
    }
    for correlation in [1.01, -1.01, f64::NAN] {
        let found = error(|model| model.axes[0].parameters.innovation.lag_1_correlation = correlation);
        assert_eq!(found, ModelError::AxisParameter { axis: 0 });
    }
    type Set = fn(&mut AxisParameters<f64>, Range<f64>);
    let wrong_way: [Set; 2] = [|axis, range| axis.range = range, |axis, range| axis.physical_range = range];
    for change in wrong_way {
        let found = error(|model| change(&mut model.axes[0].parameters, Range::new(1.0, -1.0)));
        assert_eq!(found, ModelError::AxisParameter { axis: 0 });
    }
}

#[test]
fn rejects_scales_with_overflowing_inverse() {
    // with such a scale every sample would be infinite and flagged as not finite
    let parameters = AxisParameters { scale: 1e-40_f32, ..plain() };
    let found = OwnedModel::autoregressive(parameters, vec![]).predictor().map(|_| ()).unwrap_err();
    assert_eq!(found, ModelError::AxisParameter { axis: 0 });
    let mut model = valid_model().convert::<f32>();
    model.inputs[0].scale = 1e-40;
    assert_eq!(model.predictor().map(|_| ()).unwrap_err(), ModelError::InputParameter { input: 0 });
}

#[test]
fn rejects_unknown_inputs() {
    let unknown = |term| ModelError::UnknownInput { axis: 0, term };
    assert_eq!(error(|model| model.axes[0].physical[0] = Term::new(1.0, &[u(3, 0)])), unknown(0));
    assert_eq!(error(|model| model.axes[0].stochastic[0] = Term::new(1.0, &[y(1), u(255, 0)])), unknown(2));
}

#[test]
fn rejects_outputs_in_the_physical_part() {
    let refused = ModelError::OutputInPhysicalPart { axis: 0, term: 0 };
    assert_eq!(error(|model| model.axes[0].physical[0] = Term::new(1.0, &[y(1)])), refused);
    assert_eq!(error(|model| model.axes[0].physical[0] = Term::new(1.0, &[u(0, 0), u(2, 0)])), refused);
}

#[test]
fn rejects_invalid_input_parameters() {
    let refused = ModelError::InputParameter { input: 1 };
    let changed = |change: fn(&mut Input<f64>)| error(|model| change(&mut model.inputs[1]));
    assert_eq!(changed(|input| input.centre = f64::NAN), refused);
    assert_eq!(changed(|input| input.scale = 0.0), refused);
    assert_eq!(changed(|input| input.scale = -1.0), refused);
    assert_eq!(changed(|input| input.scale = f64::INFINITY), refused);
    assert_eq!(changed(|input| input.range = Range::new(1.0, 0.0)), refused);
    assert_eq!(changed(|input| input.source_range = Range::new(f64::NAN, 0.0)), refused);
    assert_eq!(changed(|input| input.source_range = Range::new(0.0, 1e16)), refused);
    let nonsense = [
        Transform::LowPass { tau_s: 0.0 },
        Transform::LowPass { tau_s: f64::NAN },
        Transform::Rate { tau_s: -1.0 },
        Transform::Variance { tau_s: f64::INFINITY },
        Transform::Decay { tau_s: 0.0 },
        Transform::Backlash { half_width: -0.1 },
        Transform::Sine { frequency_hz: 0.0 },
        Transform::Cosine { frequency_hz: f64::NAN },
    ];
    for transform in nonsense {
        assert_eq!(error(|model| model.inputs[1].transform = transform), refused, "{transform:?}");
    }
}

#[test]
fn rejects_missing_or_unsuitable_sources() {
    let changed = |index: usize, source| error(|model| model.inputs[index].source = source);
    let refused = |input| ModelError::InputSource { input };
    assert_eq!(changed(0, Source::Quantity(1)), refused(0));
    assert_eq!(changed(0, Source::Clock), refused(0));
    assert_eq!(changed(1, Source::Quantity(0)), refused(1));
    assert_eq!(changed(1, Source::Remainder(0)), refused(1));
    assert_eq!(changed(2, Source::Remainder(1)), refused(2));
}

#[test]
fn rejects_non_positive_stillness_limits() {
    let limits = StillnessLimits {
        window: 100,
        accel_variance: 1e-4,
        gyro_variance: 1e-6,
        gyro_at_rest: [0.0; 3],
        gyro_deviation: 0.01,
    };
    assert!(StillnessDetector::<f64>::new(limits).is_ok());
    let bad = [
        StillnessLimits { window: 1, ..limits },
        StillnessLimits { window: 0, ..limits },
        StillnessLimits { accel_variance: 0.0, ..limits },
        StillnessLimits { gyro_variance: f64::NAN, ..limits },
        StillnessLimits { gyro_at_rest: [0.0, f64::INFINITY, 0.0], ..limits },
        StillnessLimits { gyro_deviation: -1.0, ..limits },
    ];
    for bad in bad {
        assert_eq!(StillnessDetector::<f64>::new(bad).map(|_| ()).unwrap_err(), ModelError::Stillness);
        assert_eq!(error(|model| model.stillness = Some(bad)), ModelError::Stillness);
    }
}

#[test]
fn rejects_axes_that_could_overflow() {
    let found = error(|model| model.axes[0].stochastic[0] = Term::new(1e35, &[y(1)]));
    assert_eq!(found, ModelError::Unbounded { axis: 0 });
}

#[test]
fn rejects_invalid_terms() {
    assert!(Term::try_new(1.0, &[]).is_none());
    assert!(Term::try_new(1.0, &[y(1); 4]).is_none());
    for factors in [&[y(0)][..], &[u(0, 0), y(0)], &[y(1), u(0, 0), y(0)]] {
        assert!(Term::try_new(1.0, factors).is_none(), "{factors:?}");
    }
    assert_eq!(Term::try_new(1.0, &[u(0, 0), y(1)]).unwrap().factors(), [u(0, 0), y(1)]);
}

/// Runs the same series through both scalars; returns the largest difference of the predictions.
fn difference(model: &OwnedModel<f64>, samples: u32, mut series: impl FnMut(u32) -> (f32, f32)) -> f64 {
    let mut single: Roomy<f32> = model.convert().predictor().unwrap();
    // the same numbers, so that only the arithmetic differs
    let mut double: Roomy<f64> = model.convert::<f32>().convert().predictor().unwrap();
    let mut worst = 0.0_f64;
    for n in 0..samples {
        let (measured, quantity) = series(n);
        let a = single.track(&Sample { measured: &[measured], quantities: &[quantity] })[0];
        let b = double.track(&Sample { measured: &[measured.into()], quantities: &[quantity.into()] })[0];
        worst = worst.max((f64::from(a.predicted) - b.predicted).abs());
        assert_eq!(a.validity, b.validity, "{n}");
    }
    worst
}

#[test]
fn f32_and_f64_agree_over_a_hundred_thousand_samples() {
    let mut noise = Noise::new(1);
    let series = |n: u32| {
        let temperature = 0.8 * (f64::from(n) * PERIOD_S / 60.0).sin() + 0.01 * noise.normal();
        (0.2 * noise.normal() as f32, temperature as f32)
    };
    // values up to 1 through some ten roundings of 6e-8 each
    let worst = difference(&valid_model(), 100_000, series);
    assert!(worst > 0.0 && worst < 6e-7, "{worst:e}");
}

#[test]
fn error_of_a_line_in_f32_is_that_of_its_rotation() {
    let mut model = valid_model();
    model.inputs.push(input(Source::Clock, Transform::Sine { frequency_hz: 31.7 }, 2.0));
    model.axes[0].physical = vec![Term::new(1.0, &[u(3, 0)])];
    model.axes[0].parameters.range = Range::new(-2.0, 2.0);
    // 6e-8 rad per sample in the worst case; the error of the product grows with the root of their number
    let mut noise = Noise::new(1);
    let worst = difference(&model, 100_000, |_| (0.2 * noise.normal() as f32, 0.0));
    assert!(worst < 0.006 + 1e-4, "{worst:e}");
}

#[test]
fn gravity_costs_no_precision_in_f32() {
    // 9.81 has a unit in the last place of 1e-6; noise and error are 1e-4 and must keep their own digits
    let parameters = AxisParameters {
        axis: Axis::Az,
        reference: 9.81,
        offset: 0.031,
        scale: 1e-4,
        range: Range::new(-8.0, 8.0),
        innovation: InnovationStatistics { mean: 0.0, variance: 0.5, lag_1_correlation: 0.0 },
        ..plain()
    };
    let terms = vec![Term::new(0.6, &[y(1)]), Term::new(0.3, &[y(2)]), Term::new(0.01, &[y(1), y(3)])];
    let model = OwnedModel::autoregressive(parameters, terms);
    let mut noise = Noise::new(1);
    let worst = difference(&model, 100_000, |_| ((9.841 + 1e-4 * noise.normal()) as f32, 0.0));
    // predicted: offset + scale·r̂, r̂ up to 8 with roundings of 2e-7 each, offset with half a unit of 0.031: 2e-9
    assert!(worst < 5e-9, "{worst:e}");
}

#[test]
fn conversion_keeps_the_model() {
    let mut model = valid_model();
    model.axes[0].parameters = AxisParameters {
        axis: Axis::Ay,
        reference: 1.0,
        offset: 2.0,
        scale: 3.0,
        constant: 4.0,
        range: Range::new(5.0, 6.0),
        physical_range: Range::new(-2.5, 1.25),
        full_scale: 7.0,
        stuck_after_repeats: 8,
        gap_limit_samples: 9,
        coast_limit_s: 10.0,
        innovation: InnovationStatistics { mean: 11.0, variance: 12.0, lag_1_correlation: 0.13 },
    };
    model.stillness = Some(StillnessLimits {
        window: 14,
        accel_variance: 15.0,
        gyro_variance: 16.0,
        gyro_at_rest: [17.0, 18.0, 19.0],
        gyro_deviation: 20.0,
    });
    let twice: OwnedModel<f64> = model.convert();
    assert_eq!(format!("{model:?}"), format!("{twice:?}"));
    let single: OwnedModel<f32> = model.convert();
    assert_eq!(f64::from(single.axes[0].physical[0].coefficient), f64::from(0.2_f32));
    let transforms = [
        Transform::Identity,
        Transform::Absolute,
        Transform::Time,
        Transform::Rate { tau_s: 1.5 },
        Transform::Variance { tau_s: 1.5 },
        Transform::Decay { tau_s: 1.5 },
        Transform::Backlash { half_width: 1.5 },
        Transform::Sine { frequency_hz: 1.5 },
        Transform::Cosine { frequency_hz: 1.5 },
        Transform::LowPass { tau_s: 1.5 },
    ];
    for transform in transforms {
        let same: Transform<f64> = transform.convert::<f32>().convert();
        assert_eq!(same, transform);
    }
    assert!(<f64 as Scalar>::from_f64(0.1) == 0.1 && FittedOn::Raw != FittedOn::FactoryCorrected);
}

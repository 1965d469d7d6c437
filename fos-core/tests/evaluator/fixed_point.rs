//! Fixed point agrees with f64 within the bound of docs/MATHS.md, for any input.

use fos_core::{
    AxisParameters, Correction, Fixed, Input, ModelError, Predictor, Quantity, Range, Sample, Scalar, Source,
    Term, Transform, Validity, u, y,
};
use fos_testkit::models::{Draw, OwnedAxis, OwnedModel, PERIOD_S, Roomy, cases, input, models, plain};
use fos_testkit::noise::Noise;
use proptest::prelude::*;

use bound::{Bound, STEP, bounds};

mod bound;

/// The model of a device, in f32, and the same numbers in f64 for comparison, so that only the arithmetic differs.
fn as_stored(model: &OwnedModel<f64>) -> (OwnedModel<f32>, OwnedModel<f64>) {
    let stored = model.convert::<f32>();
    let exact = stored.convert();
    (stored, exact)
}

fn in_fixed(model: &OwnedModel<f32>) -> Result<Roomy<Fixed>, ModelError> {
    model.borrow(Predictor::new)
}

/// Runs one sample through both; values with at most 23 fraction bits are exact in both.
fn step<'c>(
    exact: &'c mut Roomy<f64>,
    fixed: &'c mut Roomy<Fixed>,
    tracked: bool,
    measured: &[f64],
    quantities: &[f64],
) -> (&'c [Correction<f64>], &'c [Correction<Fixed>]) {
    let mask = if tracked { u32::MAX } else { 0 };
    let a = exact.track_some(&Sample { measured, quantities }, mask);
    let fixed_point = |values: &[f64]| values.iter().map(|&value| Fixed::from_f64(value)).collect::<Vec<_>>();
    let (measured, quantities) = (fixed_point(measured), fixed_point(quantities));
    let b = fixed.track_some(&Sample { measured: &measured, quantities: &quantities }, mask);
    (a, b)
}

/// Rounds to a value that a sensor may give and both scalars can represent.
fn given(value: f64) -> f64 {
    (value * 1024.0).round() / 1024.0
}

/// Largest difference of predicted errors and innovations, as a share of the bound.
#[derive(Debug, Default)]
struct Worst {
    predicted: f64,
    innovation: f64,
}

impl Worst {
    fn update(&mut self, a: &Correction<f64>, b: &Correction<Fixed>, bound: &Bound) {
        self.predicted = self.predicted.max((a.predicted - b.predicted.to_f64()).abs() / bound.predicted);
        if let (Some(left), Some(b), false) =
            (a.innovation, b.innovation, a.validity.contains(Validity::OWN_HISTORY))
        {
            self.innovation = self.innovation.max((left - b.to_f64()).abs() / bound.innovation);
        }
    }
}

/// Six axes with a long memory, over inputs with the transforms used for temperature.
fn hour_model() -> OwnedModel<f64> {
    let temperature = |transform| Input {
        centre: 25.0,
        scale: 8.0,
        source_range: Range::new(-2.0, 2.0),
        ..input(Source::Quantity(0), transform, 2.5)
    };
    let inputs = vec![
        temperature(Transform::Identity),
        temperature(Transform::LowPass { tau_s: 1000.0 }),
        temperature(Transform::Rate { tau_s: 30.0 }),
        input(Source::Clock, Transform::Decay { tau_s: 300.0 }, 1.2),
        Input { centre: 1800.0, scale: 1000.0, ..input(Source::Clock, Transform::Time, 2.0) },
    ];
    let axes = (0..6).map(|axis| {
        let size = 1.0 + f64::from(axis);
        OwnedAxis {
            parameters: AxisParameters {
                reference: if axis == 2 { 9.806_65 } else { 0.0 },
                offset: 0.01 * size,
                scale: if axis < 3 { 0.02 } else { 0.002 },
                range: Range::new(-6.0, 6.0),
                physical_range: Range::new(-10.0, 10.0),
                coast_limit_s: 60.0,
                full_scale: 39.0,
                ..plain()
            },
            physical: vec![
                Term::new(0.8 * size, &[u(0, 0)]),
                Term::new(-1.3, &[u(1, 0)]),
                Term::new(0.4, &[u(2, 0)]),
                Term::new(0.2, &[u(3, 0)]),
                Term::new(0.1, &[u(4, 0)]),
                Term::new(0.15, &[u(0, 0), u(0, 0)]),
            ],
            stochastic: vec![
                Term::new(0.9, &[y(1)]),
                Term::new(0.25, &[y(2)]),
                Term::new(-0.18, &[y(3)]),
                Term::new(0.02, &[y(10)]),
            ],
        }
    });
    OwnedModel {
        period_s: PERIOD_S,
        stillness: None,
        calibration: None,
        quantities: vec![Quantity::Temperature],
        inputs,
        axes: axes.collect(),
    }
}

#[test]
fn an_hour_of_rest_and_motion_stays_within_the_bound() {
    let (stored, exact_model) = as_stored(&hour_model());
    let (mut exact, mut fixed) =
        (exact_model.predictor().expect("a model"), in_fixed(&stored).expect("it fits"));
    let samples = (3600.0 / PERIOD_S) as u32;
    let bounds = bounds(&exact_model, samples);
    let (mut noise, mut worst) = (Noise::new(11), Worst::default());
    let mut state = [0.0; 6];
    for n in 0..samples {
        let temperature = 25.0 + 12.0 * (f64::from(n) * 2e-5).sin();
        let mut measured = [0.0; 6];
        for ((value, state), axis) in measured.iter_mut().zip(&mut state).zip(&exact_model.axes) {
            *state = 0.97 * *state + 0.2 * noise.normal();
            let parameters = &axis.parameters;
            // the measured value is a code
            let error = parameters.offset + parameters.scale * (*state + 0.1 * (temperature - 25.0));
            *value = ((parameters.reference + error) * 4096.0).round() / 4096.0;
        }
        // 20 s of rest, 10 s of motion
        let tracked = n % 6000 < 4000;
        let (a, b) = step(&mut exact, &mut fixed, tracked, &measured, &[given(temperature)]);
        for ((a, b), bound) in a.iter().zip(b).zip(&bounds) {
            assert_eq!(a.validity, b.validity, "sample {n}");
            worst.update(a, b, bound);
        }
    }
    println!("of the bound: {worst:?}; the bound, in the axis' unit: {:?}", bounds.first());
    assert!(worst.predicted < 1.0 && worst.innovation < 1.0, "{worst:?}");
    // a bound that is far too wide would prove nothing
    assert!(worst.innovation > 0.02, "{worst:?}");
}

/// Values that a sensor may give, and some that none should.
fn any_value() -> impl Strategy<Value = f64> {
    prop_oneof![
        20 => (-16.0..16.0).prop_map(given),
        1 => prop_oneof![
            Just(f64::NAN),
            Just(f64::INFINITY),
            Just(f64::NEG_INFINITY),
            Just(1e30),
            Just(-300.0),
            Just(256.0),
            Just(-256.0),
        ],
    ]
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn any_tracked_model_stays_within_the_bound(
        model in models(Draw::Contracting),
        samples in prop::collection::vec((prop::collection::vec((-12.0..12.0).prop_map(given), 6), prop::collection::vec((-2.0..2.0).prop_map(given), 3)), 80),
    ) {
        let (stored, exact_model) = as_stored(&model);
        let mut fixed = match in_fixed(&stored) {
            Ok(fixed) => fixed,
            Err(error) => {
                let known = matches!(
                    error,
                    ModelError::AxisNotInFixedPoint { .. } | ModelError::InputNotInFixedPoint { .. }
                );
                prop_assert!(known, "{error}");
                return Ok(());
            }
        };
        let mut exact = exact_model.predictor().expect("a model");
        let bounds = bounds(&exact_model, samples.len() as u32);
        let n_axes = exact_model.axes.len();
        for (measured, quantities) in &samples {
            let (a, b) = step(&mut exact, &mut fixed, true, &measured[..n_axes], quantities);
            for ((a, b), bound) in a.iter().zip(b).zip(&bounds) {
                // a value on the edge of a limit may be inside it in only one of the two
                let edge = Validity::OUTPUT_OUT_OF_RANGE | Validity::INPUT_OUT_OF_RANGE;
                prop_assert_eq!(a.validity - edge, b.validity - edge);
                let predicted = (a.predicted - b.predicted.to_f64()).abs();
                prop_assert!(predicted <= bound.predicted, "{predicted:e} of {:e}", bound.predicted);
                if let (Some(a), Some(b)) = (a.innovation, b.innovation) {
                    prop_assert!((a - b.to_f64()).abs() <= bound.innovation, "{a} {b:?} {:e}", bound.innovation);
                }
            }
        }
    }

    #[test]
    fn output_is_bounded_and_flagged_as_in_f32_for_any_input(
        model in models(Draw::Contracting),
        samples in prop::collection::vec((any::<bool>(), prop::collection::vec(any_value(), 6), prop::collection::vec(any_value(), 3)), 60),
    ) {
        let (stored, _) = as_stored(&model);
        let Ok(mut fixed) = in_fixed(&stored) else { return Ok(()) };
        let mut single = stored.predictor().expect("a model");
        let n_axes = stored.axes.len();
        for (tracked, measured, quantities) in &samples {
            let float = |values: &[f64]| values.iter().map(|&value| value as f32).collect::<Vec<_>>();
            let (measured, quantities) = (float(&measured[..n_axes]), float(quantities));
            let mask = if *tracked { u32::MAX } else { 0 };
            let a: Vec<_> = single.track_some(&Sample { measured: &measured, quantities: &quantities }, mask).to_vec();
            let fixed_point = |values: &[f32]| values.iter().map(|&value| Fixed::of(value)).collect::<Vec<_>>();
            let (in_measured, in_quantities) = (fixed_point(&measured), fixed_point(&quantities));
            let b = fixed.track_some(&Sample { measured: &in_measured, quantities: &in_quantities }, mask);
            for ((a, b), measured) in a.iter().zip(b).zip(&measured) {
                prop_assert!(b.predicted.is_finite() && b.corrected.is_finite());
                prop_assert!(b.innovation.is_none_or(Fixed::is_finite));
                prop_assert_eq!(a.validity.contains(Validity::NOT_FINITE), b.validity.contains(Validity::NOT_FINITE) || measured.is_infinite());
                // values beyond 256 are at full scale, and flagged
                if measured.abs() >= 256.0 {
                    prop_assert!(b.validity.intersects(Validity::SATURATED | Validity::NOT_FINITE), "{measured}: {b:?}");
                }
            }
        }
    }
}

#[test]
fn rejects_models_beyond_the_range() {
    let model = |parameters, inputs: Vec<Input<f32>>, term: Term<f32>| OwnedModel {
        period_s: PERIOD_S,
        stillness: None,
        calibration: None,
        quantities: vec![Quantity::Supply],
        inputs,
        axes: vec![OwnedAxis { parameters, physical: vec![], stochastic: vec![term] }],
    };
    let term = Term::new(0.5, &[y(1)]);
    let parameters = AxisParameters { physical_range: Range::new(-1.0, 1.0), ..plain() };
    assert!(in_fixed(&model(parameters, vec![], term)).is_ok());
    let refused = |model: &OwnedModel<f32>| {
        assert!(model.predictor().is_ok(), "f32 has it");
        in_fixed(model).map(|_| ()).unwrap_err()
    };
    let axis = ModelError::AxisNotInFixedPoint { axis: 0 };
    for parameters in [
        AxisParameters { reference: 260.0, ..parameters },
        AxisParameters { offset: -300.0, ..parameters },
        AxisParameters { range: Range::new(-150.0, 150.0), ..parameters },
        AxisParameters { scale: 100.0, ..parameters },
    ] {
        assert_eq!(refused(&model(parameters, vec![], term)), axis, "{parameters:?}");
    }
    assert_eq!(refused(&model(parameters, vec![], Term::new(300.0, &[y(1)]))), axis);
    let of = |transform| input(Source::Quantity(0), transform, 1.0);
    for input in [
        Input { centre: 1013.0, ..of(Transform::Identity) },
        Input { scale: 300.0, ..of(Transform::Identity) },
        Input { source_range: Range::new(-300.0, 300.0), ..of(Transform::Identity) },
        Input { range: Range::new(0.0, 256.0), ..of(Transform::Identity) },
        of(Transform::Backlash { half_width: 300.0 }),
        Input { centre: 1e6, ..input(Source::Clock, Transform::Time, 1.0) },
    ] {
        let found = refused(&model(parameters, vec![input], term));
        assert_eq!(found, ModelError::InputNotInFixedPoint { input: 0 }, "{input:?}");
    }
}

#[test]
fn conversion_from_float_rounds_once() {
    let mut noise = Noise::new(5);
    let mut values =
        vec![0.0_f32, -0.0, STEP as f32, 1e-30, f32::MIN_POSITIVE, 255.99998, -255.99998, 1.0, 0.1];
    values.extend((0..20_000).map(|n| (noise.normal() * 2f64.powi(n % 40 - 32)) as f32));
    for value in values {
        let expected = (f64::from(value) / STEP).abs().add_half_and_cut() * f64::from(value).signum() * STEP;
        assert_eq!(Fixed::of(value).to_f64(), expected.clamp(-256.0 + STEP, 256.0 - STEP), "{value:e}");
        assert_eq!(Fixed::from_f64(f64::from(value)).to_f64(), Fixed::of(value).to_f64(), "{value:e}");
        assert_eq!(Fixed::of(value).stored(), Fixed::of(value).to_f64() as f32);
    }
    for value in [f32::INFINITY, 256.0, 1e38] {
        assert_eq!((Fixed::of(value), Fixed::of(-value)), (Fixed::MAX, -Fixed::MAX));
    }
    assert!(Fixed::of(f32::NAN).stored().is_nan() && Fixed::from_f64(f64::NAN).to_f64().is_nan());
    assert!(!Fixed::NAN.is_finite() && !Fixed::NAN.abs().is_finite() && !(-Fixed::NAN).is_finite());
}

/// Rounding to nearest, halves upwards.
trait AddHalf {
    fn add_half_and_cut(self) -> f64;
}

impl AddHalf for f64 {
    fn add_half_and_cut(self) -> f64 {
        (self + 0.5).floor()
    }
}

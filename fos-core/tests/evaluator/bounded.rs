//! Coasting stays bounded for all coefficients; models that could overflow are rejected.

mod any_model;

use fos_core::{AxisParameters, InnovationStatistics, ModelError, Range, Real, Sample, Term, Validity, y};
use fos_testkit::models::{Draw, OwnedModel, PERIOD_S, Roomy, cases, models, plain};
use fos_testkit::noise::Noise;
use proptest::prelude::*;

fn coast<R: Real>(predictor: &mut Roomy<R>, measured: &[R]) -> (f64, Validity) {
    let correction = predictor.coast(&Sample { measured, quantities: &[] })[0];
    (correction.predicted.to_f64(), correction.validity)
}

/// Fills the history with ±`r`, scaled.
fn warm_up<R: Real>(predictor: &mut Roomy<R>, parameters: &AxisParameters<R>) {
    let mut noise = Noise::new(1);
    for _ in 0..20 {
        let r = if noise.uniform() < 0.5 { 1.0 } else { -0.9 };
        let measured = parameters.offset.to_f64() + parameters.scale.to_f64() * r;
        let _ = predictor.track(&Sample { measured: &[R::from_f64(measured)], quantities: &[] });
    }
}

/// Checks |predicted − offset| ≤ scale·2·1 for a range of −1 … 1, up to rounding.
fn assert_within_twice_the_range<R: Real>(model: &OwnedModel<R>, samples: u32) {
    let parameters = &model.axes[0].parameters;
    let mut predictor = match model.predictor() {
        Ok(predictor) => predictor,
        Err(ModelError::Unbounded { axis: 0 } | ModelError::Innovation { axis: 0 }) => return,
        Err(error) => panic!("{error}"),
    };
    warm_up(&mut predictor, parameters);
    let (offset, scale) = (parameters.offset.to_f64(), parameters.scale.to_f64());
    for n in 0..samples {
        let (predicted, validity) = coast(&mut predictor, &[R::ZERO]);
        let r = (predicted - offset) / scale;
        assert!(r.abs() <= 2.0 * (1.0 + 1e-6), "{n}: {r} {validity:?}");
    }
}

#[test]
fn unstable_models_stay_within_twice_their_range_for_a_million_samples() {
    let sets: [&[Term<f64>]; 7] = [
        &[Term::new(1.0000001, &[y(1)])],
        &[Term::new(2.0, &[y(1)])],
        &[Term::new(-1.5, &[y(1)]), Term::new(0.9, &[y(2)])],
        &[Term::new(1.0, &[y(1), y(1)]), Term::new(1.0, &[y(2), y(2), y(2)])],
        &[Term::new(3.9, &[y(1)]), Term::new(-3.9, &[y(1), y(1)])],
        &[Term::new(1e12, &[y(1), y(2), y(3)]), Term::new(-1e12, &[y(2)])],
        &[Term::new(1e28, &[y(1)]), Term::new(-1e28, &[y(2)])],
    ];
    for set in sets {
        let parameters = AxisParameters { offset: 0.01, scale: 0.1, ..plain() };
        let model = OwnedModel::autoregressive(parameters, set.to_vec());
        assert!(model.predictor().is_ok());
        assert_within_twice_the_range(&model.convert::<f32>(), 1_000_000);
        assert_within_twice_the_range(&model, 100_000);
    }
}

#[test]
fn flags_a_limited_unstable_model() {
    let model = OwnedModel::autoregressive(plain::<f32>(), vec![Term::new(2.0, &[y(1)])]);
    let mut predictor = model.predictor().unwrap();
    warm_up(&mut predictor, &model.axes[0].parameters);
    let validities: Vec<Validity> = (0..10).map(|_| coast(&mut predictor, &[0.0]).1).collect();
    assert!(validities[2..].iter().all(|v| v.contains(Validity::OUTPUT_OUT_OF_RANGE)), "{validities:?}");
}

#[test]
fn rejects_models_that_could_overflow() {
    let refused = |parameters: AxisParameters<f32>, terms: Vec<Term<f32>>| {
        let result = OwnedModel::autoregressive(parameters, terms).predictor();
        assert_eq!(result.err(), Some(ModelError::Unbounded { axis: 0 }));
    };
    refused(plain(), vec![Term::new(1e30, &[y(1)])]);
    refused(plain(), vec![Term::new(f32::MAX, &[y(1)])]);
    refused(plain(), vec![Term::new(4e29, &[y(1)]), Term::new(4e29, &[y(2)])]);
    refused(AxisParameters { scale: 1e20, ..plain() }, vec![Term::new(1e10, &[y(1)])]);
    refused(AxisParameters { constant: 1e30, ..plain() }, vec![]);
    refused(AxisParameters { offset: -1e30, ..plain() }, vec![]);
    refused(AxisParameters { reference: 1e30, ..plain() }, vec![]);
    refused(AxisParameters { range: Range::new(-1e30, 0.0), ..plain() }, vec![]);
    // a p of 0 would be limited to this value
    refused(AxisParameters { physical_range: Range::new(1e30, 1e30), ..plain() }, vec![]);
    refused(AxisParameters { physical_range: Range::new(-1e30, -1e30), ..plain() }, vec![]);
    refused(AxisParameters { range: Range::new(-f32::MAX, f32::MAX), ..plain() }, vec![]);
    // r up to 2e10: its cube times one
    let range = Range::new(-1e10, 1e10);
    refused(AxisParameters { range, ..plain() }, vec![Term::new(1.0, &[y(1), y(1), y(1)])]);
}

#[test]
fn stochastic_part_fades_out_beyond_the_coast_limit() {
    // a sustained oscillation, a slow decay, a divergence and a constant
    let sets: [(f64, &[Term<f64>]); 4] = [
        (0.0, &[Term::new(1.9, &[y(1)]), Term::new(-1.0, &[y(2)])]),
        (0.0, &[Term::new(0.99999, &[y(1)])]),
        (0.0, &[Term::new(1.7, &[y(1)])]),
        (0.7, &[]),
    ];
    for (constant, set) in sets {
        let coast_limit_s = 2.0;
        let parameters = AxisParameters { offset: 0.01, scale: 0.1, constant, coast_limit_s, ..plain() };
        let model = OwnedModel::autoregressive(parameters, set.to_vec()).convert::<f32>();
        let mut predictor = model.predictor().unwrap();
        warm_up(&mut predictor, &model.axes[0].parameters);
        for n in 1..=20_000 {
            let (predicted, validity) = coast(&mut predictor, &[0.0]);
            let beyond = f64::from(n - 400);
            assert_eq!(validity.contains(Validity::COASTING_TOO_LONG), n > 400, "{n}");
            // as e^(−t/coast limit)
            let limit = 0.2 * (-(beyond * PERIOD_S / coast_limit_s).max(0.0)).exp() * 1.001 + 1e-9;
            let faded = predicted - f64::from(0.01_f32);
            assert!(faded.abs() <= limit, "{n}: {faded} {limit}");
            // e^(−13.9) = 1e-6: 27.6 s
            if n > 400 + 5540 {
                assert_eq!(predicted, f64::from(0.01_f32), "{n}");
            }
        }
    }
}

#[test]
fn zero_coast_limit_leaves_only_the_physical_part() {
    for coast_limit_s in [0.0, -0.0] {
        let parameters = AxisParameters { coast_limit_s, offset: 0.25, constant: 0.7, ..plain() };
        let model = OwnedModel::autoregressive(parameters, vec![Term::new(0.9_f32, &[y(1)])]);
        let mut predictor = model.predictor().unwrap();
        warm_up(&mut predictor, &model.axes[0].parameters);
        assert_eq!(coast(&mut predictor, &[1.0]).0, 0.25);
    }
}

#[test]
fn stable_model_converges_to_the_fixed_point_of_its_recursion() {
    // coasting from any history: r(∞) = a0/(1 − Σa)
    let innovation = InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 };
    let parameters = AxisParameters { constant: 0.05, innovation, ..plain() };
    let terms = vec![Term::new(1.2, &[y(1)]), Term::new(-0.3, &[y(2)])];
    let mut predictor = OwnedModel::autoregressive(parameters, terms).predictor().unwrap();
    warm_up(&mut predictor, &parameters);
    let last = (0..1000).map(|_| coast(&mut predictor, &[0.0]).0).last().unwrap();
    assert!((last - 0.5_f64).abs() < 1e-12, "{last}");
}

fn adversarial() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -3.0..3.0,
        2 => (-45.0..38.0_f64).prop_map(|exponent| 10.0_f64.powf(exponent)),
        1 => Just(f64::from(f32::MAX)),
        1 => Just(-1.0),
        1 => Just(1.0 + f64::from(f32::EPSILON)),
    ]
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn any_coefficients_are_rejected_or_bounded(
        picks in prop::collection::vec((adversarial(), prop::collection::vec(1_u16..=6, 1..=3)), 0..=12),
        scale in adversarial().prop_map(f64::abs), constant in adversarial(),
    ) {
        let lags = |lags: Vec<u16>| lags.into_iter().map(y).collect::<Vec<_>>();
        let terms = picks.into_iter().map(|(coefficient, factors)| Term::new(coefficient, &lags(factors)));
        let parameters = AxisParameters { scale, constant, ..plain() };
        let model = OwnedModel::autoregressive(parameters, terms.collect()).convert::<f32>();
        if f32::is_normal(1.0 / model.axes[0].parameters.scale) {
            assert_within_twice_the_range(&model, 100_000);
        }
    }

    #[test]
    fn any_model_with_inputs_is_rejected_or_bounded(model in models(Draw::Exact), seed in any::<u64>()) {
        let model = model.convert::<f32>();
        let mut predictor = model.predictor().unwrap();
        let mut noise = Noise::new(seed);
        for n in 0..10_000 {
            let measured: Vec<f32> = model.axes.iter().map(|axis| axis.parameters.reference + 0.01 * n as f32 % 3.0).collect();
            let quantities = [0; 3].map(|_| noise.normal() as f32);
            let sample = Sample { measured: &measured, quantities: &quantities };
            let found = if n < 30 { predictor.track(&sample) } else { predictor.coast(&sample) };
            for found in found {
                prop_assert!(found.predicted.abs() <= 0.1 + 2.0 * (2.0 + 8.0 * 3.3_f32.powi(3)), "{}: {:?}", n, found);
            }
        }
    }
}

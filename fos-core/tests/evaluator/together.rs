//! The limit of the physical part: terms that cancel only within the data of the fit must not diverge.

use fos_core::{AxisParameters, Quantity, Range, Sample, Source, Term, Transform, Validity, u};
use fos_testkit::models::{OwnedAxis, OwnedModel, PERIOD_S, Roomy, input, plain};
use proptest::prelude::*;

/// A model with two inputs, which are the logged quantities.
fn model(terms: Vec<Term<f64>>, physical_range: Range<f64>) -> OwnedModel<f64> {
    let of = |quantity| input(Source::Quantity(quantity), Transform::Identity, 3.0);
    let parameters = AxisParameters { offset: 0.25, scale: 0.5, physical_range, ..plain() };
    OwnedModel {
        period_s: PERIOD_S,
        stillness: None,
        calibration: None,
        quantities: vec![Quantity::Temperature, Quantity::Supply],
        inputs: vec![of(0), of(1)],
        axes: vec![OwnedAxis { parameters, physical: terms, stochastic: vec![] }],
    }
}

/// Coefficients of ±1.3 over inputs that varied together in the data of the fit, so that p was hardly more than noise.
fn cancelling() -> OwnedModel<f64> {
    model(vec![Term::new(1.3, &[u(0, 0)]), Term::new(-1.3, &[u(1, 0)])], Range::new(-0.04, 0.06))
}

/// p and its validity; coasting and tracking must subtract the same.
fn p(predictor: &mut Roomy<f64>, quantities: &[f64]) -> (f64, Validity) {
    let sample = Sample { measured: &[0.3], quantities };
    let coasted = predictor.coast(&sample)[0];
    let tracked = predictor.track(&sample)[0];
    assert_eq!((coasted.predicted, coasted.validity), (tracked.predicted, tracked.validity));
    // without a stochastic part the innovation is the measured error minus p
    assert!((tracked.innovation.unwrap() - (0.3 - tracked.predicted)).abs() < 1e-12);
    ((tracked.predicted - 0.25) / 0.5, tracked.validity)
}

#[test]
fn p_is_limited_to_three_widths_and_flagged() {
    let mut predictor = cancelling().predictor().unwrap();
    for (quantities, expected) in [([2.0, 2.0], 0.0), ([2.0, 1.9], 0.13), ([-2.0, -1.9], -0.13)] {
        let (found, validity) = p(&mut predictor, &quantities);
        assert!((found - expected).abs() < 1e-12 && validity.is_valid(), "{found}: {validity:?}");
    }
    for (quantities, limit) in [([2.0, 0.0], 0.16), ([0.0, 2.0], -0.14), ([9.0, -9.0], 0.16)] {
        let (found, validity) = p(&mut predictor, &quantities);
        assert!((found - limit).abs() < 1e-12, "{found}, {limit}");
        assert_eq!(validity, Validity::INPUT_OUT_OF_RANGE);
    }
    // the flag ends with the limitation
    let (found, validity) = p(&mut predictor, &[1.0, 1.0]);
    assert!(found == 0.0 && validity.is_valid(), "{found}: {validity:?}");
}

#[test]
fn only_the_limited_axis_is_flagged() {
    let mut model = cancelling();
    let one = vec![Term::new(0.3, &[u(0, 0)])];
    let parameters = AxisParameters { physical_range: Range::new(-0.9, 0.9), ..plain() };
    let without = OwnedAxis { parameters, physical: vec![], stochastic: vec![] };
    model.axes.push(OwnedAxis { physical: one, ..without.clone() });
    // a range that excludes 0, the p of an axis without physical terms
    let physical_range = Range::new(5.0, 6.0);
    model.axes.push(OwnedAxis { parameters: AxisParameters { physical_range, ..parameters }, ..without });
    let mut predictor = model.predictor().unwrap();
    let found = predictor.coast(&Sample { measured: &[0.3; 3], quantities: &[2.0, 0.0] }).to_vec();
    assert_eq!(found[0].validity, Validity::INPUT_OUT_OF_RANGE);
    assert!(found[1].validity.is_valid() && found[2].validity.is_valid(), "{found:?}");
    assert!((found[1].predicted - 0.6).abs() < 1e-12 && found[2].predicted == 0.0, "{found:?}");
}

fn coefficients() -> impl Strategy<Value = Vec<Term<f64>>> {
    let factors = prop_oneof![
        Just(vec![u(0, 0)]),
        Just(vec![u(1, 0)]),
        Just(vec![u(0, 1), u(1, 0)]),
        Just(vec![u(0, 0), u(0, 0), u(1, 2)])
    ];
    prop::collection::vec((-3.0..3.0, factors).prop_map(|(c, factors)| Term::new(c, &factors)), 1..6)
}

fn anything() -> impl Strategy<Value = [f64; 2]> {
    let one = || prop_oneof![8 => -4.0..4.0, 1 => Just(f64::NAN), 1 => Just(1e300), 1 => Just(f64::INFINITY)];
    [one(), one()]
}

proptest! {
    #[test]
    fn p_stays_within_its_limits_for_any_input(
        terms in coefficients(),
        (low, width) in (-2.0..2.0, 0.0..2.0),
        logged in prop::collection::vec(anything(), 1..20),
    ) {
        let model = model(terms, Range::new(low, low + width));
        let (mut predictor, mut free) = (model.predictor().unwrap(), {
            let mut free = model.clone();
            free.axes[0].parameters.physical_range = Range::unlimited();
            free.predictor().unwrap()
        });
        let limits = model.axes[0].parameters.physical_limits();
        for quantities in &logged {
            let sample = Sample { measured: &[0.3], quantities };
            let (found, unlimited) = (predictor.coast(&sample)[0], free.coast(&sample)[0]);
            let p = (unlimited.predicted - 0.25) / 0.5;
            let expected = 0.25 + 0.5 * p.clamp(limits.low, limits.high);
            prop_assert!((found.predicted - expected).abs() <= 1e-12 * (1.0 + p.abs()), "{found:?}, {expected}");
            if found.predicted == unlimited.predicted {
                prop_assert_eq!(found.validity, unlimited.validity);
            } else {
                prop_assert_eq!(found.validity, unlimited.validity | Validity::INPUT_OUT_OF_RANGE);
            }
        }
    }

    /// A single input reaches its own limit first; the limit of p matters only for several.
    #[test]
    fn single_input_gives_the_same_bits_with_and_without_the_limit(
        coefficient in -3.0..3.0,
        logged in prop::collection::vec(anything(), 1..20),
    ) {
        let ends: [f64; 2] = [-3.0 * coefficient, 3.0 * coefficient];
        let fitted = Range::new(ends[0].min(ends[1]), ends[0].max(ends[1]));
        let run = |range| -> Vec<(u64, Validity)> {
            let mut predictor = model(vec![Term::new(coefficient, &[u(0, 0)])], range).predictor().unwrap();
            let outputs = logged.iter().map(|quantities| {
                let found = predictor.coast(&Sample { measured: &[0.3], quantities })[0];
                (found.predicted.to_bits(), found.validity)
            });
            outputs.collect()
        };
        prop_assert_eq!(run(fitted), run(Range::unlimited()));
    }
}

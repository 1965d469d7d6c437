//! Bad samples, gaps and restarts: the output stays finite and is flagged, and their effect vanishes.

use fos_core::{
    AxisParameters, Correction, Evaluator, Fixed, Input, Predictor, Quantity, Range, Real, Sample, Scalar,
    Source, Term, Transform, Validity, u, y,
};
use fos_testkit::models::{Draw, OwnedAxis, OwnedModel, PERIOD_S, Roomy, cases, input, models, plain};
use fos_testkit::noise::Noise;
use proptest::prelude::*;

const DEPTH: usize = 3;
const FULL_SCALE: f64 = 30.0;
const OFFSET: f64 = 0.5;

/// Two axes like an accelerometer's, physical part over the temperature and its low-pass, three lags.
fn model<R: Real>(inputs: Vec<Input<f64>>, extra: Vec<Term<f64>>) -> OwnedModel<R> {
    let parameters = AxisParameters {
        reference: 9.81,
        offset: OFFSET,
        scale: 0.1,
        range: Range::new(-5.0, 5.0),
        full_scale: FULL_SCALE,
        stuck_after_repeats: 8,
        gap_limit_samples: 5,
        coast_limit_s: 60.0,
        ..plain()
    };
    let physical: Vec<_> = (0..inputs.len() as u8)
        .filter(|&index| !matches!(inputs[usize::from(index)].source, Source::Remainder(_)))
        .map(|index| Term::new(0.3, &[u(index, 0)]))
        .collect();
    let mut stochastic =
        vec![Term::new(0.5, &[y(1)]), Term::new(0.2, &[y(3)]), Term::new(-0.05, &[y(1), y(2)])];
    stochastic.extend(extra);
    OwnedModel {
        period_s: PERIOD_S,
        stillness: None,
        calibration: None,
        quantities: vec![Quantity::Temperature],
        inputs,
        axes: vec![OwnedAxis { parameters, physical, stochastic }; 2],
    }
    .convert()
}

fn with_temperature<R: Real>() -> OwnedModel<R> {
    model(vec![input(Source::Quantity(0), Transform::Identity, 2.0)], vec![])
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    Track,
    Coast,
}

fn step<R: Real>(
    predictor: &mut Roomy<R>,
    mode: Mode,
    measured: &[R],
    quantities: &[R],
) -> Vec<Correction<R>> {
    let sample = Sample { measured, quantities };
    match mode {
        Mode::Track => predictor.track(&sample).to_vec(),
        Mode::Coast => predictor.coast(&sample).to_vec(),
    }
}

fn noisy<R: Real>(noise: &mut Noise) -> [R; 2] {
    [0, 1].map(|_| R::from_f64(9.81 + OFFSET + 0.1 * noise.normal()))
}

fn numbers<R: Real>(correction: &Correction<R>) -> [f64; 3] {
    let innovation = correction.innovation.map_or(0.0, Scalar::to_f64);
    [correction.predicted.to_f64(), correction.corrected.to_f64(), innovation]
}

/// |predicted| of [`with_temperature`]: offset + scale·(p + r̂), |p| ≤ 0.3·2.2, |r̂| ≤ 10.
const BOUND: f64 = OFFSET + 0.1 * (0.66 + 10.0) + 1e-5;

fn assert_bad_measurements_are_flagged_and_vanish<R: Real>() {
    let high = R::MAX.to_f64();
    // name, value, expected flag
    let faults = [
        ("NaN", f64::NAN, Validity::NOT_FINITE),
        ("inf", f64::INFINITY, Validity::NOT_FINITE),
        ("-inf", f64::NEG_INFINITY, Validity::NOT_FINITE),
        ("huge", high, Validity::SATURATED),
        ("-huge", -high, Validity::SATURATED),
        ("at full scale", FULL_SCALE, Validity::SATURATED),
        ("at negative full scale", -FULL_SCALE, Validity::SATURATED),
        ("nearly full scale", 29.9, Validity::VALID),
        ("subnormal", 1e-40, Validity::VALID),
    ];
    for (name, value, flag) in faults {
        for mode in [Mode::Track, Mode::Coast] {
            let clean = with_temperature::<R>().predictor().unwrap();
            let (mut clean, mut faulty) = (clean.clone(), clean);
            let mut noise = Noise::new(7);
            let temperature = [R::from_f64(0.7)];
            for n in 0..60 {
                let measured = noisy::<R>(&mut noise);
                let wrong = (20..24).contains(&n);
                let mode = if (20..24).contains(&n) { mode } else { Mode::Track };
                let bad = if wrong { [R::from_f64(value), measured[1]] } else { measured };
                let expected = step(&mut clean, mode, &measured, &temperature);
                let found = step(&mut faulty, mode, &bad, &temperature);
                let place = format!("{name} {mode:?} {n}: {found:?}");
                assert!(found.iter().flat_map(numbers).all(f64::is_finite), "{place}");
                assert!(found.iter().all(|axis| axis.predicted.to_f64().abs() <= BOUND), "{place}");
                // the other axis is not affected
                assert_eq!(found[1], expected[1], "{place}");
                if wrong {
                    assert!(found[0].validity.contains(flag), "{place}");
                    if flag == Validity::NOT_FINITE {
                        assert!(found[0].corrected.to_f64().abs() < 20.0, "{place}");
                    }
                    if mode == Mode::Track && flag.is_valid() {
                        assert!(found[0].validity.contains(Validity::OUTPUT_OUT_OF_RANGE), "{place}");
                    }
                    if !flag.is_valid() {
                        assert_eq!(found[0].innovation, None, "{place}");
                    }
                }
                if n >= 24 + DEPTH {
                    assert_eq!(found, expected, "{place}");
                    assert!(found[0].validity.is_valid(), "{place}");
                }
            }
        }
    }
}

#[test]
fn bad_measurement_is_flagged_and_vanishes_after_the_longest_lag_in_f32() {
    assert_bad_measurements_are_flagged_and_vanish::<f32>();
}

#[test]
fn bad_measurement_is_flagged_and_vanishes_after_the_longest_lag_in_f64() {
    assert_bad_measurements_are_flagged_and_vanish::<f64>();
}

#[test]
fn faulty_sample_does_not_enter_the_history() {
    // after any fault the output equals that after a missing sample
    let run = |bad: Option<f64>| {
        let mut predictor = with_temperature::<f64>().predictor().unwrap();
        let mut noise = Noise::new(3);
        (0..40)
            .map(|n| {
                let measured: [f64; 2] = noisy(&mut noise);
                let measured = match bad {
                    None if n == 20 => vec![],
                    Some(bad) if n == 20 => vec![bad; 2],
                    _ => measured.to_vec(),
                };
                step(&mut predictor, Mode::Track, &measured, &[0.0])[0].predicted
            })
            .collect::<Vec<f64>>()
    };
    let missing = run(None);
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, FULL_SCALE, f64::MAX] {
        assert_eq!(run(Some(bad)), missing, "{bad}");
    }
}

#[test]
fn stuck_axis_is_flagged_and_recovers() {
    for mode in [Mode::Track, Mode::Coast] {
        let clean = with_temperature::<f32>().predictor().unwrap();
        let (mut clean, mut stuck) = (clean.clone(), clean);
        let mut noise = Noise::new(11);
        let mut held = [0.0; 2];
        // 8 repetitions are tolerated, then 4 more are coasted: fewer than the gap limit
        for n in 0..80 {
            let measured: [f32; 2] = noisy(&mut noise);
            let mode = if (20..33).contains(&n) { mode } else { Mode::Track };
            held = if (20..33).contains(&n) { if n == 20 { measured } else { held } } else { measured };
            let expected = step(&mut clean, mode, &measured, &[0.0]);
            let found = step(&mut stuck, mode, &held, &[0.0]);
            assert_eq!(
                found[0].validity.contains(Validity::STUCK),
                (28..33).contains(&n),
                "{mode:?} {n}: {found:?}"
            );
            if n >= 33 + DEPTH {
                assert_eq!(found, expected, "{n}");
            }
        }
    }
}

#[test]
fn bad_quantity_is_held_and_flagged() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38, -3e38, 1e-40] {
        let clean = with_temperature::<f32>().predictor().unwrap();
        let (mut clean, mut faulty) = (clean.clone(), clean);
        let mut noise = Noise::new(5);
        for n in 0..60 {
            let measured: [f32; 2] = noisy(&mut noise);
            let wrong = (20..30).contains(&n);
            let expected = step(&mut clean, Mode::Track, &measured, &[0.7]);
            let found = step(&mut faulty, Mode::Track, &measured, &[if wrong { bad } else { 0.7 }]);
            assert!(found.iter().flat_map(numbers).all(f64::is_finite), "{bad} {n}: {found:?}");
            assert!(found[0].predicted.to_f64().abs() <= BOUND, "{bad} {n}: {found:?}");
            let flag = match bad {
                bad if !bad.is_finite() => Validity::INPUT_NOT_FINITE,
                bad if bad.abs() > 2.2 => Validity::INPUT_OUT_OF_RANGE,
                _ => Validity::VALID,
            };
            if wrong {
                assert!(found[0].validity.contains(flag), "{bad} {n}: {found:?}");
                if flag == Validity::INPUT_NOT_FINITE {
                    // the quantity had not changed, so holding it is exact
                    assert_eq!(found[0].predicted, expected[0].predicted, "{bad} {n}");
                }
            } else if n >= 30 + DEPTH {
                assert_eq!(found, expected, "{bad} {n}");
            }
        }
    }
}

#[test]
fn absent_quantity_is_not_finite_and_absent_axis_missing() {
    let mut predictor = with_temperature::<f32>().predictor().unwrap();
    let found = step(&mut predictor, Mode::Track, &[9.8], &[]);
    assert!(found[0].validity.contains(Validity::INPUT_NOT_FINITE), "{found:?}");
    assert!(found[1].validity.contains(Validity::MISSING), "{found:?}");
}

#[test]
fn outlier_of_a_quantity_decays_with_the_low_pass() {
    let tau_s = 0.5;
    let inputs = vec![input(Source::Quantity(0), Transform::LowPass { tau_s }, 2.0)];
    let clean = model::<f32>(inputs, vec![]).predictor().unwrap();
    let (mut clean, mut faulty) = (clean.clone(), clean);
    for n in 0..1000 {
        let wrong = n == 100;
        let expected = step(&mut clean, Mode::Coast, &[9.8; 2], &[0.7])[0].predicted;
        let found = step(&mut faulty, Mode::Coast, &[9.8; 2], &[if wrong { 1e30 } else { 0.7 }])[0].predicted;
        if n >= 100 {
            // the sample was limited to 2.2: scale · coefficient · gain · (2.2 − 0.7), then it decays
            let decay = (-f64::from(n - 100) * PERIOD_S / f64::from(tau_s as f32)).exp();
            let bound = 0.1 * 0.3 * (PERIOD_S / tau_s) * 1.5 * decay;
            let error = f64::from((found - expected).abs());
            assert!(error <= bound + 1e-7, "{n}: {error} {bound}");
        }
    }
}

#[test]
fn largest_values_give_finite_innovations() {
    // near 1/scale = 2⁻¹²⁶ and beyond it products of the two are off by more than a rounding
    for scale in [1e-3_f32, 0.3, 3.0, 7.0, 1e3, 1e30, 8e37, 2.485_602_6e38] {
        let reach = (1.0 / scale).min(1.0_f32);
        let parameters = AxisParameters::<f32> { scale, range: Range::new(-reach, reach), ..plain() };
        // with larger scales a term would not be bounded
        let terms = if scale < 1e29 { vec![Term::new(0.5, &[y(1)])] } else { vec![] };
        let mut predictor = OwnedModel::autoregressive(parameters, terms).predictor().unwrap();
        for measured in [0.1, f32::MAX, -f32::MAX, f32::MAX.next_down(), -f32::MAX.next_down(), 1e38, 0.2] {
            let found = step(&mut predictor, Mode::Track, &[measured], &[]);
            assert!(found.iter().flat_map(numbers).all(f64::is_finite), "{scale} {measured:e}: {found:?}");
        }
        for reference in [f32::MAX, -f32::MAX, f32::NAN, f32::INFINITY] {
            let sample = Sample { measured: &[-1e38], quantities: &[] };
            let found = predictor.track_against(&sample, &[reference]);
            assert!(found.iter().flat_map(numbers).all(f64::is_finite), "{scale} {reference:e}: {found:?}");
        }
    }
}

#[test]
fn gap_is_coasted_up_to_its_limit_then_warms_up() {
    for ticks in 1..12_u32 {
        let clean = with_temperature::<f64>().predictor().unwrap();
        let (mut skipped, mut stepped) = (clean.clone(), clean);
        let mut noise = Noise::new(2);
        for _ in 0..20 {
            let measured = noisy(&mut noise);
            step(&mut skipped, Mode::Track, &measured, &[0.0]);
            step(&mut stepped, Mode::Track, &measured, &[0.0]);
        }
        let at_once = skipped.skip(ticks).to_vec();
        let mut one_by_one = vec![];
        for _ in 0..ticks {
            one_by_one = step(&mut stepped, Mode::Track, &[], &[]);
        }
        assert_eq!(at_once, one_by_one, "{ticks}");
        let lost = ticks > 5;
        let validity = at_once[0].validity;
        assert!(validity.contains(Validity::MISSING), "{ticks}: {validity:?}");
        assert_eq!(validity.contains(Validity::OWN_HISTORY), !lost, "{ticks}: {validity:?}");
        for n in 0..6 {
            let found = step(&mut skipped, Mode::Track, &noisy(&mut noise), &[0.0]);
            let expected = match (n < DEPTH, lost) {
                (true, true) => Validity::WARMING_UP,
                (true, false) => Validity::OWN_HISTORY,
                (false, _) => Validity::VALID,
            };
            assert_eq!(found[0].validity, expected, "{ticks}, then {n}");
            assert_eq!(found[0].innovation.is_none(), n < DEPTH && lost);
        }
    }
}

#[test]
fn faded_part_stays_faded_after_lost_samples() {
    // no lags, so that the axis needs no history to be ready
    let parameters = AxisParameters { constant: 0.7, coast_limit_s: 1.0, gap_limit_samples: 20, ..plain() };
    let mut moved = OwnedModel::autoregressive(parameters, vec![]).predictor().unwrap();
    let coast = |predictor: &mut Roomy<f64>| step(predictor, Mode::Coast, &[0.0], &[])[0];
    assert_eq!(coast(&mut moved).predicted, 0.7);
    for _ in 0..1000 {
        let _ = coast(&mut moved);
    }
    for lost in [21, 5000] {
        let mut moved = moved.clone();
        let _ = moved.skip(lost);
        let found = coast(&mut moved);
        assert_eq!((found.predicted, found.validity), (0.0, Validity::COASTING_TOO_LONG), "{lost}");
        assert_eq!(step(&mut moved, Mode::Track, &[0.7], &[])[0].predicted, 0.7);
        assert_eq!(coast(&mut moved).predicted, 0.7, "known again");
    }
    // longer without a sample than a coast was validated for
    let mut lost = OwnedModel::autoregressive(parameters, vec![]).predictor().unwrap();
    let _ = lost.skip(1000);
    assert_eq!(coast(&mut lost).predicted, 0.0);
}

#[test]
fn disabled_stuck_test_stays_disabled() {
    // regression: with a limit of 65535 in place of 0, the axis was flagged as stuck after 5 minutes of equal values
    // and lost its history
    let parameters = AxisParameters::<f32> { stuck_after_repeats: 0, ..plain() };
    let model = OwnedModel::autoregressive(parameters, vec![Term::new(0.5, &[y(1)])]);
    let mut predictor = model.predictor().unwrap();
    for n in 0..70_000 {
        let validity = step(&mut predictor, Mode::Track, &[0.25], &[])[0].validity;
        assert!(n == 0 || validity.is_valid(), "{n}: {validity:?}");
    }
}

#[test]
fn first_sample_is_not_a_repetition() {
    // regression: with a previous value of 0, a gyro that began with exactly 0 was stuck one sample early
    let parameters = AxisParameters::<f32> { stuck_after_repeats: 3, ..plain() };
    let model = OwnedModel::autoregressive(parameters, vec![Term::new(0.5, &[y(1)])]);
    for value in [0.0, -0.0, 0.25] {
        let mut predictor = model.predictor().unwrap();
        let stuck: Vec<bool> = (0..5)
            .map(|_| step(&mut predictor, Mode::Track, &[value], &[])[0].validity.contains(Validity::STUCK))
            .collect();
        assert_eq!(stuck, [false, false, false, true, true], "{value}");
    }
}

/// Without lags, so that a forecast is valid; with a full scale and the stuck test.
fn without_lags<S: Scalar<Stored = f32>>() -> Predictor<S, 1, 0, 1, 1> {
    let parameters = AxisParameters::<f32> {
        reference: 9.81,
        offset: 0.5,
        full_scale: 30.0,
        stuck_after_repeats: 3,
        gap_limit_samples: 5,
        ..plain()
    };
    OwnedModel::autoregressive(parameters, vec![]).borrow(Predictor::new).unwrap()
}

fn assert_forecasts_show_the_fault_of_the_latest_sample<S: Scalar<Stored = f32>>() {
    let number = |value: f32| S::of(value);
    let near = |found: &Correction<S>, expected: f64| (found.corrected.to_f64() - expected).abs() < 1e-5;
    let mut predictor = without_lags::<S>();
    let fresh = predictor.forecast(&[])[0];
    assert!(
        near(&fresh, 9.81) && fresh.validity == Validity::NOT_FINITE,
        "before the first sample: {fresh:?}"
    );
    let missing = predictor.skip(1)[0];
    assert!(near(&missing, 9.81) && missing.validity.contains(Validity::MISSING), "{missing:?}");
    for (value, flag) in [
        (f32::NAN, Validity::NOT_FINITE),
        (f32::INFINITY, Validity::SATURATED),
        (f32::NEG_INFINITY, Validity::SATURATED),
        (30.0, Validity::SATURATED),
    ] {
        let mut predictor = without_lags::<S>();
        let track = |predictor: &mut Predictor<S, 1, 0, 1, 1>, value| {
            predictor.track(&Sample { measured: &[number(value)], quantities: &[] })[0]
        };
        assert_eq!(track(&mut predictor, 10.0).validity, Validity::VALID);
        let valid = predictor.forecast(&[])[0];
        assert!(near(&valid, 9.5) && valid.validity == Validity::VALID, "{valid:?}");
        let _ = track(&mut predictor, value);
        for n in 0..20 {
            let found = predictor.forecast(&[])[0];
            assert!(
                found.corrected.is_finite() && found.corrected.abs() <= number(256.0),
                "{value} {n}: {found:?}"
            );
            assert!(found.validity.contains(flag), "{value} {n}: {found:?}");
            if value.is_nan() {
                assert!(near(&found, 9.5), "{n}: the last corrected value: {found:?}");
            }
        }
        let missing = predictor.skip(1)[0];
        assert!(missing.corrected.is_finite(), "{value}: {missing:?}");
        assert_eq!(track(&mut predictor, 10.1).validity, Validity::VALID);
        let recovered = predictor.forecast(&[])[0];
        assert!(near(&recovered, 9.6) && recovered.validity == Validity::VALID, "{recovered:?}");
        for _ in 0..3 {
            let _ = track(&mut predictor, 10.1);
        }
        assert_eq!(predictor.forecast(&[])[0].validity, Validity::STUCK);
        predictor.reset();
        let found = predictor.forecast(&[])[0];
        assert!(near(&found, 9.81) && found.validity == Validity::NOT_FINITE, "after a reset: {found:?}");
    }
}

#[test]
fn forecast_without_a_usable_sample_is_finite_and_flagged() {
    assert_forecasts_show_the_fault_of_the_latest_sample::<f32>();
}

#[test]
fn forecast_without_a_usable_sample_is_finite_and_flagged_in_fixed_point() {
    assert_forecasts_show_the_fault_of_the_latest_sample::<Fixed>();
}

#[test]
fn evaluator_does_nothing_without_room_for_the_corrections() {
    let model = with_temperature::<f32>();
    let mut evaluator = Evaluator::<f32, 2, 1, 16, 32>::empty();
    model.borrow(|model| evaluator.load(model)).unwrap();
    let mut noise = Noise::new(13);
    let mut room = [Correction::NONE; 2];
    for _ in 0..20 {
        let measured = noisy(&mut noise);
        evaluator.track_some(&Sample { measured: &measured, quantities: &[0.7] }, u32::MAX, &mut room);
    }
    let mut untouched = evaluator.clone();
    let mut short = [Correction::NONE; 1];
    let measured = noisy(&mut noise);
    for ticks in [1, 5, 6, 7, 1000, u32::MAX] {
        evaluator.skip(ticks, &mut short);
        evaluator.forecast(&[0.1], &mut short);
        evaluator.track_some(&Sample { measured: &measured, quantities: &[0.1] }, 1, &mut short);
        assert_eq!(short, [Correction::NONE; 1]);
    }
    for n in 0..5 {
        let measured = noisy(&mut noise);
        let sample = Sample { measured: &measured, quantities: &[0.7] };
        let mut expected = room;
        evaluator.track_some(&sample, u32::MAX, &mut room);
        untouched.track_some(&sample, u32::MAX, &mut expected);
        assert_eq!(room, expected, "{n}");
        assert!(room[0].validity.is_valid(), "{n}: {room:?}");
    }
}

#[test]
fn skipping_no_ticks_shows_no_corrections_of_an_earlier_model() {
    let model = with_temperature::<f32>();
    let mut predictor = model.predictor().unwrap();
    step(&mut predictor, Mode::Track, &[9.81; 2], &[0.0]);
    let latest = predictor.corrections().to_vec();
    assert_eq!(predictor.skip(0), latest);
    model.borrow(|model| predictor.load(model)).unwrap();
    assert_eq!(predictor.skip(0), []);
    assert_eq!(predictor.skip(1).len(), 2);
    predictor.reset();
    assert_eq!(predictor.corrections(), []);
}

#[test]
fn long_memory_of_a_lost_axis_decays() {
    // regression: a low-pass of the remainder continued with the last r before the gap, one sample of mostly white
    // noise, and had converged to it when the axis recovered
    let memory = input(Source::Remainder(0), Transform::LowPass { tau_s: 1.0 }, 10.0);
    let model: OwnedModel<f64> = model(vec![memory], vec![Term::new(0.3, &[u(0, 0)])]);
    let lose: [fn(&mut Roomy<f64>); 3] = [
        |predictor| (0..2000).for_each(|_| drop(step(predictor, Mode::Track, &[f64::NAN; 2], &[0.0]))),
        |predictor| (0..2000).for_each(|_| drop(step(predictor, Mode::Track, &[40.0; 2], &[0.0]))),
        |predictor| {
            let _ = predictor.skip(2000);
        },
    ];
    for lose in lose {
        let mut predictor = model.predictor().unwrap();
        // undisturbed except for the last sample, which is off by 4 (0.4 in the axis' unit)
        for n in 0..50 {
            let r = if n == 49 { 4.0 } else { 0.0 };
            step(&mut predictor, Mode::Track, &[9.81 + OFFSET + 0.1 * r; 2], &[0.0]);
        }
        lose(&mut predictor);
        for _ in 0..=DEPTH {
            step(&mut predictor, Mode::Track, &[9.81 + OFFSET; 2], &[0.0]);
        }
        let predicted = step(&mut predictor, Mode::Track, &[9.81 + OFFSET; 2], &[0.0])[0].predicted;
        // e⁻¹⁰ of 4·0.3·0.1 is 5e-6
        assert!((predicted - OFFSET).abs() < 1e-5, "{predicted}");
    }
}

#[test]
fn long_memory_holds_no_single_sample_before_the_warm_up() {
    let memory = input(Source::Remainder(0), Transform::LowPass { tau_s: 1.0 }, 10.0);
    let model: OwnedModel<f64> = model(vec![memory], vec![Term::new(0.3, &[u(0, 0)])]);
    let mut predictor = model.predictor().unwrap();
    // one sample at rest, then motion
    step(&mut predictor, Mode::Track, &[9.81 + OFFSET + 0.4; 2], &[0.0]);
    (0..2000).for_each(|_| drop(step(&mut predictor, Mode::Coast, &[9.0; 2], &[0.0])));
    for _ in 0..=DEPTH {
        step(&mut predictor, Mode::Track, &[9.81 + OFFSET; 2], &[0.0]);
    }
    let predicted = step(&mut predictor, Mode::Track, &[9.81 + OFFSET; 2], &[0.0])[0].predicted;
    assert!((predicted - OFFSET).abs() < 1e-5, "{predicted}");
}

#[test]
fn long_skip_equals_missing_samples() {
    let clock = |transform| {
        let mut clock: Input<f64> = input(Source::Clock, transform, 2.0);
        clock.scale = 1000.0;
        clock
    };
    let inputs = vec![
        clock(Transform::Decay { tau_s: 100.0 }),
        clock(Transform::Time),
        clock(Transform::Sine { frequency_hz: 3.7 }),
        clock(Transform::Cosine { frequency_hz: 3.7 }),
    ];
    let mut model: OwnedModel<f64> = model(inputs, vec![]);
    // lagged inputs too: with a wrong age, the first samples after the gap would be wrong without a flag
    model.axes[0].physical.extend([Term::new(0.4, &[u(2, 3)]), Term::new(0.2, &[u(0, 5), u(3, 7)])]);
    for ticks in [1, 100, 255, 256, 257, 1000, 100_000] {
        let mut skipped = model.predictor().unwrap();
        let mut stepped = skipped.clone();
        let _ = skipped.skip(ticks);
        for _ in 0..ticks {
            step(&mut stepped, Mode::Track, &[], &[]);
        }
        let mut noise = Noise::new(1);
        for n in 0..20 {
            let measured = noisy(&mut noise);
            let found = step(&mut skipped, Mode::Track, &measured, &[0.0])[0];
            let expected = step(&mut stepped, Mode::Track, &measured, &[0.0])[0];
            // 10⁵ roundings of 1.1e-16
            assert!((found.predicted - expected.predicted).abs() < 2e-11, "{ticks}, then {n}");
            assert_eq!(found.validity, expected.validity, "{ticks}, then {n}");
        }
    }
}

#[test]
fn huge_range_is_rejected_or_a_huge_quantity_decays() {
    // regression: a windowed variance squares its input, and inf − inf made the input NaN until the next reset
    let wide = |transform, reach: f32| {
        let mut wide: Input<f32> = input(Source::Quantity(0), transform, 2.0);
        wide.source_range = Range::new(-reach, reach);
        let parameters = plain::<f32>();
        OwnedModel {
            period_s: PERIOD_S,
            stillness: None,
            calibration: None,
            quantities: vec![Quantity::Other],
            inputs: vec![wide],
            axes: vec![OwnedAxis {
                parameters,
                physical: vec![Term::new(1.0, &[u(0, 0)])],
                stochastic: vec![],
            }],
        }
    };
    let tau_s = 0.02;
    for transform in [
        Transform::Identity,
        Transform::LowPass { tau_s },
        Transform::Rate { tau_s },
        Transform::Variance { tau_s },
        Transform::Backlash { half_width: 0.1 },
        Transform::Absolute,
    ] {
        for reach in [1e3, 1e12, 1e18, 1e22, f32::MAX] {
            let Ok(mut predictor) = wide(transform, reach).predictor() else { continue };
            let mut fresh = predictor.clone();
            step(&mut predictor, Mode::Coast, &[0.0], &[0.5]);
            step(&mut predictor, Mode::Coast, &[0.0], &[f32::MAX]);
            step(&mut predictor, Mode::Coast, &[0.0], &[-f32::MAX]);
            // 5000 samples are 1250 time constants
            let mut last = (f32::NAN, f32::NAN);
            for _ in 0..5000 {
                let run =
                    |predictor: &mut Roomy<f32>| step(predictor, Mode::Coast, &[0.0], &[0.5])[0].predicted;
                last = (run(&mut predictor), run(&mut fresh));
            }
            // backlash depends on the direction of approach
            let same = (last.0 - last.1).abs()
                <= if matches!(transform, Transform::Backlash { .. }) { 0.2 } else { 1e-6 };
            assert!(same, "{transform:?} within {reach:e}: {last:?}");
        }
    }
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn reset_equals_a_new_predictor(
        model in models(Draw::Contracting), seed in any::<u64>(), ticks in 0_u32..600
    ) {
        let fresh = model.convert::<f32>().predictor().unwrap();
        let mut used = fresh.clone();
        let mut noise = Noise::new(seed);
        let n_axes = model.axes.len();
        let draw = |noise: &mut Noise| -> (Vec<f32>, Vec<f32>) {
            // few distinct values, so that repetitions across the reset would be counted
            let mut coarse = |_| (2.0 * noise.normal()).round() as f32;
            ((0..n_axes).map(&mut coarse).collect(), (0..3).map(&mut coarse).collect())
        };
        for _ in 0..50 {
            let (measured, quantities) = draw(&mut noise);
            step(&mut used, Mode::Track, &measured, &quantities);
        }
        let _ = used.skip(ticks);
        let last = draw(&mut noise);
        step(&mut used, Mode::Track, &last.0, &last.1);
        used.reset();
        let mut fresh = fresh;
        for n in 0..60 {
            let (measured, quantities) = if n == 0 { last.clone() } else { draw(&mut noise) };
            let mode = if noise.uniform() < 0.7 { Mode::Track } else { Mode::Coast };
            let found = step(&mut used, mode, &measured, &quantities);
            prop_assert_eq!(found, step(&mut fresh, mode, &measured, &quantities), "{}", n);
        }
    }

    #[test]
    fn output_is_finite_and_bounded_for_any_input(
        model in models(Draw::Exact), seed in any::<u64>()
    ) {
        let model = model.convert::<f32>();
        let mut predictor = model.predictor().unwrap();
        let mut noise = Noise::new(seed);
        let n_axes = model.axes.len();
        for n in 0..300 {
            let mut any = || match noise.bits() % 4 {
                0 => f32::from_bits(noise.bits() as u32),
                1 => [f32::NAN, f32::MAX, -f32::MAX, f32::INFINITY, 0.0, -0.0, 1e-45][noise.bits() as usize % 7],
                _ => noise.normal() as f32,
            };
            let measured: Vec<f32> = (0..n_axes).map(|_| any()).collect();
            let reference: Vec<f32> = (0..n_axes).map(|_| any()).collect();
            let quantities: Vec<f32> = (0..3).map(|_| any()).collect();
            let sample = Sample { measured: &measured, quantities: &quantities };
            let found = match n % 3 {
                0 => predictor.track(&sample),
                1 => predictor.coast(&sample),
                _ => predictor.track_against(&sample, &reference),
            };
            for (found, axis) in found.iter().zip(&model.axes) {
                prop_assert!(numbers(found).into_iter().all(f64::is_finite), "{}: {:?}", n, found);
                // |r̂| ≤ 2·reach ≤ 2; |p|: 8 terms of coefficient 1 over up to three inputs of at most 3.3
                let bound = 0.1 + 2.0 * (2.0 + 8.0 * 3.3_f64.powi(3));
                prop_assert!(found.predicted.to_f64().abs() <= bound, "{}: {:?} {:?}", n, found, axis);
            }
        }
    }
}

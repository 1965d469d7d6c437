//! The hub compared with its predictor, and under the conditions of a product.

use crate::models::{self, MADE, Made, OFFSET, Random, SCALES, SIX, TestHub, image, limits, parameters};
use fos_core::{
    Axis, AxisModel, AxisParameters, Calibration, Correction, FittedOn, Image, ImageError, Info, Input,
    Model, Predictor, Quantity, Range, Sample, Source, StillnessDetector, Term, Transform, TriadCalibration,
    Validity, u, y,
};
use fos_embedded::hub::{Hub, HubError, Motion, Output};
use fos_embedded::raw::{Faults, RawSample, Scales, SiSample};

fn loaded(made: &Made<'_>) -> TestHub {
    let mut hub = Hub::new(SCALES);
    hub.load(&image(made)).expect("a model for this sensor");
    hub.give(Quantity::Supply, 3.3);
    hub
}

fn still(made: &Made<'_>) -> TestHub {
    let mut hub = loaded(made);
    hub.set_motion(Some(Motion::Still));
    hub
}

fn same(output: &Output, corrections: &[Correction<f32>]) {
    for (axis, correction) in corrections.iter().enumerate() {
        assert_eq!(output.corrected()[axis].to_bits(), correction.corrected.to_bits());
        assert_eq!(
            (output.measured[axis] - output.predicted()[axis]).to_bits(),
            correction.corrected.to_bits()
        );
        assert_eq!(output.validity()[axis], correction.validity);
        let innovation = output.innovation()[axis];
        assert_eq!((!innovation.is_nan()).then_some(innovation), correction.innovation);
    }
}

const CALIBRATION: Calibration<f32> = Calibration {
    accel: TriadCalibration {
        matrix: [[0.98, 0.01, -0.02], [0.0, 1.03, 0.005], [0.015, -0.01, 0.99]],
        bias: [0.2, -0.1, 0.05],
    },
    gyro: TriadCalibration {
        matrix: [[1.01, -0.02, 0.0], [0.01, 0.97, 0.0], [0.0, 0.03, 1.0]],
        bias: [0.0, 0.0, 0.01],
    },
};

#[test]
fn calibrates_values_without_the_predicted_error() {
    let mut plain = still(&MADE);
    let mut calibrated = still(&Made { calibration: Some(CALIBRATION), ..MADE });
    let mut random = Random(11);
    for _ in 0..500 {
        let raw = random.at_rest();
        let before = *plain.update(&raw);
        let after = calibrated.update(&raw);
        assert_eq!((before.predicted(), before.validity()), (after.predicted(), after.validity()));
        let corrected = before.corrected();
        for (triad, TriadCalibration { matrix, bias }) in [(0, CALIBRATION.accel), (3, CALIBRATION.gyro)] {
            for (axis, row) in matrix.iter().enumerate() {
                let expected: f64 = (0..3)
                    .map(|j| f64::from(row[j]) * (f64::from(corrected[triad + j]) - f64::from(bias[j])))
                    .sum();
                let value = f64::from(after.corrected()[triad + axis]);
                // roundings of six operations near 10 m/s²
                assert!((value - expected).abs() < 4e-6, "{triad} {axis}: {value} {expected}");
            }
        }
    }
    // without a model nothing is calibrated
    calibrated.load(&image(&MADE)).expect("a model");
    let raw = random.at_rest();
    plain.load(&image(&MADE)).expect("a model");
    assert_eq!(plain.update(&raw).corrected(), calibrated.update(&raw).corrected());
}

#[test]
fn wrong_axis_is_flagged_in_its_calibrated_triad() {
    let mut hub = still(&Made { calibration: Some(CALIBRATION), ..MADE });
    let mut random = Random(12);
    for _ in 0..50 {
        let _ = hub.update(&random.at_rest());
    }
    let mut raw = random.at_rest();
    raw.gyro[1] = i16::MAX;
    let output = hub.update(&raw);
    let is_saturated = |axis: usize| output.validity()[axis].contains(Validity::SATURATED);
    assert_eq!([0, 1, 2, 3, 4, 5].map(is_saturated), [false, false, false, true, true, true]);
    let [ax, _, az, ..] = SCALES.measured(&raw);
    let mut sample = SiSample {
        skipped: 0,
        accel: [ax, f32::NAN, az],
        gyro: [0.0; 3],
        temperature_c: 25.0,
        faults: Faults::empty(),
    };
    let output = hub.update_si(&sample);
    let is_missing = |axis: usize| output.validity()[axis].contains(Validity::NOT_FINITE);
    assert_eq!([0, 1, 2, 3, 4, 5].map(is_missing), [true, true, true, false, false, false]);
    assert!(output.corrected().iter().all(|value| value.is_finite()));
    // the largest values overflow neither the sum nor the state
    for value in [f32::MAX, -f32::MAX] {
        sample.accel = [value; 3];
        assert!(hub.update_si(&sample).corrected().iter().all(|value| value.is_finite()));
    }
}

#[test]
fn output_equals_the_predictor_bit_for_bit() {
    let bytes = image(&Made { stillness: Some(limits()), ..MADE });
    let parsed = Image::parse(&bytes).expect("an image");
    let mut predictor: Predictor<f32, 6, 8, 64, 128> = parsed.predictor().expect("it fits");
    let mut detector = StillnessDetector::new(limits()).expect("limits");
    let mut hub = loaded(&Made { stillness: Some(limits()), ..MADE });
    let mut random = Random(5);
    let (mut tracked, mut skips) = (0, 0);
    for n in 0..20_000_u32 {
        let mut raw = random.at_rest();
        if n % 4000 > 3000 {
            raw.gyro[1] += (3000.0 * random.next()) as i16;
        }
        if random.next() > 0.999 {
            raw.skipped = 1 + (40.0 * (1.0 + random.next())) as u32;
        }
        if random.next() > 0.99 {
            raw.temperature = None;
        }
        let output = *hub.update(&raw);

        if raw.skipped > 0 {
            skips += 1;
            let _ = predictor.skip(raw.skipped);
            detector.disturbed();
        }
        let measured = SCALES.measured(&raw);
        let [ax, ay, az, gx, gy, gz] = measured;
        let is_still = detector.update([ax, ay, az], [gx, gy, gz]);
        let quantities = [SCALES.temperature_c(&raw), 3.3];
        let sample = Sample { measured: &measured, quantities: &quantities };
        let corrections = if is_still { predictor.track(&sample) } else { predictor.coast(&sample) };
        same(&output, corrections);
        assert_eq!(output.still, is_still);
        tracked += u32::from(is_still);
    }
    assert!((8_000..16_000).contains(&tracked) && skips > 5, "{tracked} tracked, {skips} gaps");
}

/// The sample in SI units.
fn si(raw: &RawSample) -> SiSample {
    let [ax, ay, az, gx, gy, gz] = SCALES.measured(raw);
    SiSample {
        skipped: raw.skipped,
        accel: [ax, ay, az],
        gyro: [gx, gy, gz],
        temperature_c: SCALES.temperature_c(raw),
        faults: raw.faults,
    }
}

/// Bits of all numbers, so that absent values (NaN) compare equal.
fn bits(output: &Output) -> Vec<u32> {
    let numbers = [output.measured, output.corrected(), output.innovation()].concat();
    let numbers = numbers.iter().chain([&output.temperature_c]).map(|value| value.to_bits());
    let rest = output.validity().into_iter().map(|validity| u32::from(validity.bits()));
    let flags =
        u32::from(output.faults.bits()) << 16 | u32::from(output.still) << 1 | u32::from(output.drift);
    numbers.chain(rest).chain([output.tick, flags]).collect()
}

#[test]
fn si_values_and_codes_give_the_same_bits() {
    let made = Made { stillness: Some(limits()), ..MADE };
    let [mut by_codes, mut by_values] = [loaded(&made), loaded(&made)];
    let mut random = Random(6);
    for n in 0..5_000_u32 {
        let mut raw = random.at_rest();
        raw.skipped = if random.next() > 0.999 { 3 } else { 0 };
        raw.temperature = raw.temperature.filter(|_| random.next() < 0.98);
        raw.faults = if n % 700 == 5 { Faults::BUS } else { Faults::empty() };
        raw.gyro[2] = if n % 900 < 5 { i16::MAX } else { raw.gyro[2] };
        let codes = bits(by_codes.update(&raw));
        assert_eq!(codes, bits(by_values.update_si(&si(&raw))), "sample {n}");
        assert_eq!(
            by_codes.output().predicted().map(f32::to_bits),
            by_values.output().predicted().map(f32::to_bits)
        );
    }
}

#[test]
fn any_values_give_finite_and_flagged_output() {
    let wild =
        [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e20, -0.0, f32::MIN_POSITIVE];
    let scales = Scales::of_full_scale(f32::MAX, f32::MAX, SCALES.period_s, SCALES.values);
    let some = Made { axes: &[Axis::Ax, Axis::Ay, Axis::Az, Axis::Gy], ..MADE };
    for (made, motion) in [(&MADE, Motion::Still), (&MADE, Motion::Moving), (&some, Motion::Still)] {
        let mut hub = TestHub::new(scales);
        hub.load(&image(made)).expect("a model for this sensor");
        hub.set_motion(Some(motion));
        let mut random = Random(12);
        for n in 0..20_000_usize {
            let mut sample = si(&random.at_rest());
            let mut pick = |value: &mut f32| {
                let chosen = (wild.len() as f32 * random.next().abs()) as usize;
                *value = if random.next() > 0.8 { wild[chosen.min(wild.len() - 1)] } else { *value };
            };
            sample.accel.iter_mut().chain(&mut sample.gyro).for_each(&mut pick);
            pick(&mut sample.temperature_c);
            let given = [sample.accel, sample.gyro].concat();
            let output = *hub.update_si(&sample);
            assert!(
                output.corrected().iter().chain(&hub.output().predicted()).all(|value| value.is_finite()),
                "sample {n}"
            );
            assert!(output.temperature_c.is_finite() || output.temperature_c.is_nan());
            for (axis, given) in given.into_iter().enumerate() {
                if !given.is_finite() {
                    assert!(
                        output.validity()[axis].contains(Validity::NOT_FINITE),
                        "sample {n}, axis {axis}"
                    );
                }
            }
        }
        for _ in 0..200 {
            hub.give(Quantity::Supply, 3.3);
            let _ = hub.update_si(&si(&random.at_rest()));
        }
        let recovered = hub.output().validity();
        assert!(recovered.iter().all(|validity| !validity.contains(Validity::NOT_FINITE)), "{recovered:?}");
    }
}

#[test]
fn stillness_restarts_after_unobserved_time() {
    let limits = limits();
    let to_stillness = 2 * usize::from(limits.window);
    let mut hub = loaded(&Made { stillness: Some(limits), ..MADE });
    let mut random = Random(7);
    let mut still_after = |hub: &mut TestHub| {
        (1..=3 * to_stillness).find(|_| hub.update(&random.at_rest()).still).expect("still again")
    };
    assert_eq!(still_after(&mut hub), to_stillness);
    assert_eq!(still_after(&mut hub), 1, "it stays so");
    hub.set_motion(Some(Motion::Moving));
    hub.update(&RawSample::default());
    hub.set_motion(None);
    assert_eq!(still_after(&mut hub), to_stillness, "the application no longer says that it moves");
    hub.update(&RawSample { faults: Faults::STUCK, ..Random(8).at_rest() });
    assert_eq!(still_after(&mut hub), to_stillness, "codes stood still");
}

/// Loads a model of gyro x with a warm-up alone.
fn load_warm_up(hub: &mut TestHub) {
    let warm_up = Input {
        source: Source::Clock,
        transform: Transform::Decay { tau_s: 5.0 },
        centre: 0.0,
        scale: 1.0,
        source_range: Range::new(0.0, 0.0),
        range: Range::new(0.0, 1.0),
    };
    let physical = [Term::new(0.5, &[u(0, 0)])];
    let axes = [AxisModel { parameters: parameters(Axis::Gx), physical: &physical, stochastic: &[] }];
    let model = Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities: &[],
        inputs: &[warm_up],
        axes: &axes,
    };
    hub.load_model(&model).expect("a model");
}

#[test]
fn model_loaded_later_has_the_phase_of_the_warm_up() {
    let [mut early, mut late] = [TestHub::new(SCALES), TestHub::new(SCALES)];
    load_warm_up(&mut early);
    let mut random = Random(9);
    for _ in 0..2000 {
        let raw = random.at_rest();
        let [early, late] = [&mut early, &mut late].map(|hub| hub.update(&raw).corrected()[3]);
        assert!(early != late, "one is without a model");
    }
    load_warm_up(&mut late);
    for _ in 0..500 {
        let raw = random.at_rest();
        let [early, late] = [&mut early, &mut late].map(|hub| *hub.update(&raw));
        // one factor per tick, or one for all ticks
        assert!((early.corrected()[3] - late.corrected()[3]).abs() < 1e-7);
        assert!(late.validity()[3].is_valid());
    }
}

/// Regression: the count of ticks wrapped, and a model loaded after 248 days at 200 Hz began with a full warm-up.
#[test]
fn model_loaded_after_the_tick_counter_wrapped_has_no_warm_up() {
    let mut hub = TestHub::new(SCALES);
    let mut random = Random(9);
    // the counter is then at its largest value, at 0, and beyond
    for (skipped, tick) in [(u32::MAX - 2, u32::MAX - 2), (0, u32::MAX - 1), (0, u32::MAX), (0, 0), (0, 1)] {
        let output = *hub.update(&RawSample { skipped, ..random.at_rest() });
        assert_eq!(output.tick, tick, "telemetry wraps");
        let mut late = hub.clone();
        load_warm_up(&mut late);
        let output = *late.update(&random.at_rest());
        assert!(output.validity()[3].is_valid());
        assert!((output.predicted()[3] - OFFSET[3]).abs() < 1e-7, "{tick}: {}", output.predicted()[3]);
    }
}

#[test]
fn gap_with_axes_out_of_order_gives_the_bits_of_the_predictor() {
    let made = Made { axes: &[Axis::Gz, Axis::Ay], ..MADE };
    let mut predictor: Predictor<f32, 2, 8, 64, 128> =
        Image::parse(&image(&made)).expect("an image").predictor().expect("it fits");
    let mut hub = loaded(&made);
    hub.set_motion(Some(Motion::Moving));
    let mut random = Random(6);
    for n in 0..200 {
        let raw = RawSample { skipped: if n % 50 == 49 { 1 + n / 10 } else { 0 }, ..random.at_rest() };
        let output = *hub.update(&raw);
        assert_eq!(output.faults.contains(Faults::GAP), raw.skipped > 0, "{n}");
        let _ = predictor.skip(raw.skipped);
        let measured = SCALES.measured(&raw);
        let quantities = [SCALES.temperature_c(&raw), 3.3];
        let sample = Sample { measured: &[measured[5], measured[1]], quantities: &quantities };
        let [gz, ay] = predictor.coast(&sample) else { panic!("two axes") };
        assert_eq!((output.corrections[5], output.corrections[1]), (*gz, *ay), "{n}");
        for axis in [0, 2, 3, 4] {
            assert_eq!((output.predicted()[axis], output.corrected()[axis]), (0.0, measured[axis]), "{n}");
            assert_eq!(output.validity()[axis], Validity::NOT_MODELLED, "{n}");
            assert!(output.innovation()[axis].is_nan(), "{n}");
        }
    }
}

#[test]
fn hub_has_the_output_of_a_new_one_after_a_refused_model() {
    let mut hub = still(&MADE);
    let _ = hub.update(&Random(7).at_rest());
    assert!(hub.load(&[]).is_err());
    // as text, for NaN differs from itself
    assert_eq!(format!("{:?}", hub.output()), format!("{:?}", TestHub::new(SCALES).output()));
    assert_eq!(hub.output().predicted(), [0.0; 6]);
}

#[test]
fn passes_measured_values_without_a_model() {
    let mut hub = TestHub::new(SCALES);
    let raw = Random(1).at_rest();
    let output = hub.update(&raw);
    assert_eq!(output.corrected(), SCALES.measured(&raw));
    assert!(output.validity().iter().all(|validity| *validity == Validity::NOT_MODELLED));
    assert!(!output.is_valid());
}

#[test]
fn rejects_models_for_other_values_rates_and_sensors() {
    let mut hub = still(&MADE);
    let factory = Made { fitted_on: FittedOn::FactoryCorrected, ..MADE };
    let refused = HubError::FittedOn { model: FittedOn::FactoryCorrected, sensor: FittedOn::Raw };
    assert_eq!(hub.load(&image(&factory)), Err(refused));
    let slow = Made { period_s: 0.01, ..MADE };
    assert_eq!(hub.load(&image(&slow)), Err(HubError::Period { model_s: 0.01, sensor_s: 0.005 }));
    let other = Made { axes: &[Axis::Gx, Axis::Other], ..MADE };
    assert_eq!(hub.load(&image(&other)), Err(HubError::Axis(1)));
    let twice = Made { axes: &[Axis::Gx, Axis::Gx], ..MADE };
    assert_eq!(hub.load(&image(&twice)), Err(HubError::Axis(1)));
    let elsewhere = Made { quantities: &[Quantity::Temperature, Quantity::Measured(Axis::Other)], ..MADE };
    assert_eq!(hub.load(&image(&elsewhere)), Err(HubError::Quantity(1)));
    let mut damaged = image(&MADE);
    damaged[30] ^= 1;
    assert!(matches!(hub.load(&damaged), Err(HubError::Image(ImageError::Checksum { .. }))));

    // afterwards there is no model, and the next valid one runs like the first
    let mut random = Random(3);
    let raw = random.at_rest();
    assert_eq!(hub.update(&raw).corrected(), SCALES.measured(&raw));
    hub.load(&image(&MADE)).expect("a good one");
    hub.give(Quantity::Supply, 3.3);
    let mut fresh = still(&MADE);
    for _ in 0..100 {
        let raw = random.at_rest();
        let (ours, theirs) = (*hub.update(&raw), *fresh.update(&raw));
        assert_eq!((ours.corrected(), ours.validity()), (theirs.corrected(), theirs.validity()));
    }
}

#[test]
fn flags_a_clock_error_of_three_percent() {
    for (true_hz, flagged) in [(206.0, true), (194.0, true), (200.0, false), (201.0, false)] {
        let mut hub = still(&MADE);
        let mut random = Random(4);
        for n in 0..5000_u32 {
            let _ = hub.update(&random.at_rest());
            if n % 10 == 9 {
                hub.clock((f64::from(n) * 1e6 / true_hz) as u64 + 17);
            }
        }
        let rate_hz = hub.rate_hz().expect("a rate");
        assert!((f64::from(rate_hz) - true_hz).abs() < 0.3, "{rate_hz}");
        assert_eq!(hub.output().faults.contains(Faults::RATE), flagged, "{true_hz}");
    }
}

#[test]
fn gravity_in_another_orientation_is_not_a_bias() {
    let mut hub = still(&MADE);
    let mut random = Random(6);
    for _ in 0..100 {
        let _ = hub.update(&random.at_rest());
    }
    assert!(hub.output().is_valid());
    // on its side: gravity along x
    let on_its_side = |random: &mut Random| {
        let mut raw = random.at_rest();
        raw.accel.swap(0, 2);
        raw
    };
    for n in 0..2000 {
        let output = hub.update(&on_its_side(&mut random));
        for (axis, truth) in [(0, 9.81), (2, 0.0)] {
            assert!((output.corrected()[axis] - truth).abs() < 0.25, "{n}: {:?}", output.corrected());
            assert!(n == 0 || output.validity()[axis].contains(Validity::OWN_HISTORY));
        }
        assert!(output.validity()[3].is_valid(), "gyros do not mind");
    }
    for _ in 0..100 {
        let _ = hub.update(&random.at_rest());
    }
    assert!(hub.output().is_valid(), "level again: {:?}", hub.output().validity());
}

/// Regression: a model fitted to two orientations takes half of their difference for an error, and fits. The corrected |a|
/// was 3 m/s² instead of 9.8 m/s², with all axes valid.
#[test]
fn flags_models_that_lead_away_from_gravity() {
    static FOLLOWS: [Term<f32>; 1] = [Term::new(0.97, &[y(1)])];
    // level and on its side: the mean of both as the reference, half of the difference as the scale
    let of_two_orientations = |axes: &[Axis]| {
        let model = |axis: &Axis| {
            let parameters = match axis {
                Axis::Ax | Axis::Az => {
                    AxisParameters { reference: 4.9, offset: 0.0, scale: 4.9, ..parameters(*axis) }
                }
                _ => parameters(*axis),
            };
            AxisModel { parameters, physical: &[], stochastic: &FOLLOWS }
        };
        let axes: Vec<AxisModel<'_, f32>> = axes.iter().map(model).collect();
        let model = Model {
            period_s: 0.005,
            fitted_on: FittedOn::Raw,
            stillness: None,
            calibration: None,
            quantities: &[],
            inputs: &[],
            axes: &axes,
        };
        let mut hub: TestHub = Hub::new(SCALES);
        hub.load_model(&model).expect("a model for this sensor");
        hub.set_motion(Some(Motion::Still));
        hub
    };
    let away = |hub: &TestHub| hub.output().validity().map(|v| v.contains(Validity::AWAY_FROM_GRAVITY));
    const ACCELEROMETERS: [bool; 6] = [true, true, true, false, false, false];
    let mut random = Random(8);
    let mut hub = of_two_orientations(&SIX);
    let mut run = |hub: &mut TestHub, samples: usize| {
        for _ in 0..samples {
            let _ = hub.update(&random.at_rest());
        }
    };
    run(&mut hub, 400);
    assert_eq!(away(&hub), [false; 6], "no verdict before 2.5 s of rest");
    run(&mut hub, 200);
    assert_eq!(away(&hub), ACCELEROMETERS);
    let [x, y, z] = hub.output().accel();
    assert!(((x * x + y * y + z * z).sqrt() - 9.8).abs() > 2.0, "{x} {y} {z}");
    assert!(hub.output().faults.is_empty() && !hub.output().drift, "no other flag is set");
    hub.set_motion(Some(Motion::Moving));
    run(&mut hub, 2000);
    assert_eq!(away(&hub), ACCELEROMETERS, "motion does not change the verdict");
    hub.load(&image(&MADE)).expect("a sound model");
    hub.give(Quantity::Supply, 3.3);
    hub.set_motion(Some(Motion::Still));
    run(&mut hub, 2000);
    assert_eq!(away(&hub), [false; 6]);
    // regression: a source that loses every other sample, and was never on a checked tick
    let mut hub = of_two_orientations(&SIX);
    let mut random = Random(9);
    for _ in 0..600 {
        let _ = hub.update(&RawSample { skipped: 1, ..random.at_rest() });
    }
    assert_eq!(away(&hub), ACCELEROMETERS);
    // two accelerometers do not determine the magnitude of gravity
    let mut hub = of_two_orientations(&[Axis::Ax, Axis::Az, Axis::Gx]);
    run(&mut hub, 2000);
    assert_eq!(away(&hub), [false; 6]);
}

#[test]
fn full_scale_and_stuck_samples_do_not_enter_the_history() {
    let (mut hub, mut clean) = (still(&MADE), still(&MADE));
    let mut random = Random(7);
    for n in 0..300 {
        let raw = random.at_rest();
        let mut hit = raw;
        if n == 200 {
            hit.gyro[0] = i16::MIN;
            hit.accel[1] = i16::MAX;
        }
        if n == 220 {
            hit.faults = Faults::STUCK;
        }
        let (output, _) = (*hub.update(&hit), clean.update(&raw));
        let expected = [n == 200, n == 200];
        assert_eq!(output.validity()[1].contains(Validity::SATURATED), expected[0]);
        assert_eq!(output.validity()[3].contains(Validity::SATURATED), expected[1]);
        assert_eq!(output.faults.contains(Faults::SATURATED), n == 200);
        assert_eq!(output.validity()[4].contains(Validity::STUCK), n == 220);
        assert!(output.corrected().iter().all(|value| value.is_finite()));
    }
    let off = (hub.output().corrected()[3] - clean.output().corrected()[3]).abs();
    assert!(off < 1e-6 && hub.output().is_valid(), "{off}");
}

#[test]
fn uses_given_quantities_and_flags_absent_ones() {
    let mut hub = TestHub::new(SCALES);
    hub.load(&image(&MADE)).expect("a model");
    let mut random = Random(8);
    assert!(hub.update(&random.at_rest()).validity()[0].contains(Validity::INPUT_NOT_FINITE));
    assert!(
        !hub.give(Quantity::Load, 3.0)
            && !hub.give(Quantity::Temperature, 3.0)
            && !hub.give_application(1, 3.0)
    );
    assert!(hub.give(Quantity::Supply, 3.3));
    let raw = random.at_rest();
    assert!(!hub.update(&raw).validity()[0].contains(Validity::INPUT_NOT_FINITE));
    let before = hub.output().corrected()[3];
    assert!(hub.give_application(0, 3.4));
    let change = hub.update(&raw).corrected()[3] - before;
    // 0.1 V is one scaled unit of supply: 0.2 scaled units of error, 0.0004 rad/s
    assert!((change + 0.0004).abs() < 1e-5, "{change}");
    assert_eq!(hub.logged().as_slice(), [25.0, 3.4]);
    let bytes = image(&MADE);
    let info = Image::parse(&bytes).expect("an image").info();
    assert_eq!(hub.columns::<32>(&info).as_deref(), Some("temp_c\nsupply_v"));
    assert_eq!(hub.columns::<8>(&info), None);
}

/// Regression: at most 17 values were logged, but all names were, and the host rejected every sample.
#[test]
fn logs_as_many_values_as_names_for_the_largest_model() {
    const LARGEST: usize = 32;
    let mut hub = Hub::<LARGEST, 8, 64>::new(SCALES);
    let axes = [AxisModel { parameters: parameters(Axis::Gx), physical: &[], stochastic: &[] }];
    let model = Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities: &[Quantity::Other; LARGEST],
        inputs: &[],
        axes: &axes,
    };
    hub.load_model(&model).expect("a model for this sensor");
    for index in 0..LARGEST {
        assert!(hub.give_application(index, index as f32));
    }
    let _ = hub.update(&Random(1).at_rest());
    let columns = hub.columns::<512>(&Info::default()).expect("room");
    let logged = hub.logged();
    assert_eq!(logged.len(), columns.lines().count());
    assert!(logged.iter().skip(1).copied().eq((0..LARGEST).map(|index| index as f32)), "{logged:?}");
}

#[test]
fn drift_is_detected_on_its_axis_and_cleared_by_restart() {
    let mut hub = still(&MADE);
    let mut random = Random(9);
    for _ in 0..20_000 {
        assert!(!hub.update(&random.at_rest()).drift);
    }
    let shifted = |random: &mut Random| {
        let mut raw = random.at_rest();
        raw.gyro[2] += (0.004 / SCALES.gyro_rads) as i16;
        raw
    };
    let detected_after =
        (0..1400).position(|_| hub.update(&shifted(&mut random)).drift).expect("it is noticed");
    assert!(detected_after < 1200 + 160, "six seconds and some: {detected_after}");
    let drifted = SIX.map(|axis| hub.drift(axis).is_some_and(|drift| drift.mean || drift.variance));
    assert_eq!(drifted, [false, false, false, false, false, true]);
    assert!(hub.statistics(Axis::Gz).is_some() && hub.statistics(Axis::Other).is_none());
    hub.restart_watch();
    for _ in 0..5000 {
        assert!(!hub.update(&random.at_rest()).drift);
    }
}

#[test]
fn output_is_finite_and_bounded_for_any_codes() {
    let mut hub = loaded(&Made { stillness: Some(limits()), ..MADE });
    let mut random = Random(10);
    let full = [32_768.0 * SCALES.accel_mps2, 32_768.0 * SCALES.gyro_rads];
    for n in 0..200_000_u32 {
        if n % 5000 == 0 {
            hub.set_motion([None, Some(Motion::Still), Some(Motion::Moving)][n as usize / 5000 % 3]);
        }
        let mut code = || (random.next() * 40_000.0).clamp(-32_768.0, 32_767.0) as i16;
        let raw = RawSample {
            accel: [code(), code(), code()],
            gyro: [code(), code(), code()],
            temperature: (n % 7 > 0).then(&mut code),
            skipped: if n % 997 == 0 { u32::from(code().unsigned_abs()) * 100_000 } else { 0 },
            faults: Faults::from_bits_truncate(if n % 31 == 0 { code() as u16 } else { 0 }),
        };
        hub.give(Quantity::Supply, [f32::NAN, f32::INFINITY, 1e38, 3.3][n as usize % 4]);
        let output = hub.update(&raw);
        for (axis, value) in output.corrected().iter().enumerate() {
            let correction = OFFSET[axis].abs() + 22.0 * models::SPREAD[axis];
            assert!(value.abs() <= full[axis / 3] + correction, "{n}, axis {axis}: {value}");
        }
    }
}

//! Effects outside the gate's short calibration are found under their own names, and not as their rivals.

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_simulate::{Axis, CasePlan, Durations, Effect, Plant, Setup, Simulation, simulate, simulate_case};
use fos_testkit::noise::{Noise, white_noise};

use super::{Diagnosis, Question, Verdict, diagnose};
use crate::case::question_of_logs;
use crate::effects::Library;

/// Diagnoses a simulated log with this effect.
fn answer(effect: &str, parameter: Option<f64>, setup: Setup, seed: u64) -> Diagnosis {
    let mut plan = CasePlan::new(seed, "lsm6dso", setup, Axis::Gx);
    plan.planted = vec![Plant { effect: Effect::named(effect).expect("an effect"), parameter, size: 60.0 }];
    plan.durations = Durations { reference_s: 300.0, log_s: 900.0, evaluation_s: 60.0 };
    let case = simulate_case(&plan).expect("a case");
    let [reference, field, _] = case.recordings().expect("recordings");
    diagnose(&question_of_logs(&case.meta, &field, Some(&reference), None, &Library::built_in()))
        .expect("an answer")
}

fn first(diagnosis: &Diagnosis) -> &str {
    diagnosis.findings.first().map_or("nothing", |finding| finding.effect.as_str())
}

#[test]
fn identifies_creep_telegraph_noise_noise_level_and_dead_zone() {
    for (effect, setup, parameter) in [
        ("log_creep", Setup::Bench, Some(10.0)),
        ("random_telegraph", Setup::Desk, Some(30.0)),
        ("noise_temperature", Setup::Bench, None),
        ("dead_zone", Setup::RateTable, Some(0.5)),
    ] {
        let found = answer(effect, parameter, setup, 31);
        assert_eq!((found.verdict, first(&found)), (Verdict::Missing, effect), "{}", found.sentence);
        let corrects = !found.findings[0].correction.is_empty();
        assert_eq!(corrects, effect == "log_creep", "{effect}");
    }
}

/// A last block of a single sample has no difference, and the noise level was not tested at all.
#[test]
fn noise_level_is_tested_whatever_the_length_of_the_last_block() {
    for rows in [60_000, 60_001, 60_100, 60_249] {
        let temperature: Vec<f64> = (0..rows).map(|row| 25.0 + 10.0 * (f64::from(row) / 9e3).sin()).collect();
        let noise = white_noise(61, rows as usize);
        let values = noise.iter().zip(&temperature).map(|(noise, temperature)| noise * 4e-5 * temperature);
        let columns = vec![("gx_rads".to_owned(), values.collect()), ("temp_c".to_owned(), temperature)];
        let options = LoadOptions { rate_hz: Some(100.0), ..LoadOptions::default() };
        let log = Recording::from_columns(Source::made_by("test"), columns, &options).expect("a log");
        let found = diagnose(&Question::new(&log, "gx", &Library::built_in())).expect("an answer");
        assert_eq!(first(&found), "noise_temperature", "{rows} rows: {}", found.sentence);
    }
}

/// The drift of the scale factor fits as well with the same number of separable coefficients if the temperature hardly
/// changes, and was preferred as the first effect of temperature.
#[test]
fn scale_factor_error_at_one_temperature_is_no_drift_of_the_scale_factor() {
    for seed in [41, 43] {
        let found = answer("sf_error", None, Setup::RateTable, seed);
        assert_eq!(first(&found), "sf_error", "seed {seed}: {}", found.sentence);
    }
}

/// Its band on another axis held more than the noise floor by chance, and the line was attributed to motion of both.
#[test]
fn wandering_line_of_one_axis_is_no_motion() {
    for seed in [11, 47] {
        let found = answer("drifting_line", None, Setup::RateTable, seed);
        assert_eq!(first(&found), "drifting_line", "seed {seed}: {}", found.sentence);
    }
}

/// In block means of 2.5 s it is an oscillation with a period of 9.2 s.
#[test]
fn line_below_a_hertz_is_no_slow_oscillation() {
    let found = answer("spectral_line", Some(0.6917), Setup::Desk, 50);
    assert_eq!((found.verdict, first(&found)), (Verdict::Missing, "spectral_line"), "{:?}", found.leads);
}

/// The fit started at a far smaller deviation and ended as a random walk.
#[test]
fn gauss_markov_noise_of_seconds_is_no_random_walk() {
    for seed in [23, 24] {
        let found = answer("gauss_markov", Some(7.0), Setup::RateTable, seed);
        assert_eq!(first(&found), "gauss_markov", "seed {seed}: {}", found.sentence);
    }
}

#[test]
fn switching_by_a_logged_channel_is_not_random() {
    for seed in [51, 53] {
        let found = answer("outside:threshold", None, Setup::PoseRig, seed);
        let names: Vec<&str> = found.findings.iter().map(|finding| finding.effect.as_str()).collect();
        assert!(!names.contains(&"random_telegraph"), "seed {seed}: {}", found.sentence);
    }
}

#[test]
fn measures_levels_and_dwells_of_telegraph_noise() {
    let found = answer("random_telegraph", Some(30.0), Setup::Bench, 32);
    let sizes = &found.findings[0].sizes;
    for (size, unit) in sizes.iter().zip(["dps", "s", "s", "1"]) {
        assert_eq!(size.unit, unit, "{size:?}");
    }
    for dwell in &sizes[1..3] {
        assert!((dwell.interval[0]..dwell.interval[1]).contains(&30.0), "{dwell:?}");
    }
    // 900 s in dwells of 30 s
    assert!((18.0..45.0).contains(&sizes[3].value), "{:?}", sizes[3]);
}

#[test]
fn step_warm_up_and_noise_are_not_mistaken_for_telegraph_noise() {
    for (effect, parameter) in [
        ("bias_step", Some(400.0)),
        ("warmup_exp", Some(60.0)),
        ("gauss_markov", Some(20.0)),
        ("outside:oscillation", Some(90.0)),
    ] {
        let found = answer(effect, parameter, Setup::Bench, 33);
        let wrong = ["random_telegraph", "log_creep", "dead_zone"].contains(&first(&found));
        assert!(!wrong, "{effect}: {}", found.sentence);
    }
}

/// A dip of the supply shifts all axes at once, as motion does; the logged voltage explains it.
#[test]
fn finds_supply_sensitivity_of_all_axes_with_and_without_motion() {
    let simulation =
        Simulation { duration_s: 900.0, rate_hz: 50.0, seed: 6, temperature: 0.0, motion: false };
    let reference = simulate(&simulation).columns;
    let time = reference[0].1.clone();
    let dip = |time: &f64| 0.3 * f64::from(u8::from(time.rem_euclid(70.0) < 5.0 && *time > 30.0));
    for shift in [0.007, 0.017] {
        let mut columns = reference.clone();
        for (name, values) in &mut columns {
            let shift = if name.starts_with('g') { shift } else { 10.0 * shift };
            if name.ends_with("_rads") || name.ends_with("_mps2") {
                values.iter_mut().zip(&time).for_each(|(value, time)| *value -= shift * dip(time));
            }
        }
        columns.push(("supply_v".to_owned(), time.iter().map(|time| 3.3 - dip(time)).collect()));
        for keep_moved in [false, true] {
            let options = LoadOptions { keep_moved, ..LoadOptions::default() };
            let log =
                Recording::from_columns(Source::made_by("test"), columns.clone(), &options).expect("a log");
            let library = Library::built_in();
            let answer = diagnose(&Question::new(&log, "gx", &library)).expect("an answer");
            let found: Vec<&str> = answer.findings.iter().map(|finding| finding.effect.as_str()).collect();
            assert_eq!(
                (answer.verdict, &found[..]),
                (Verdict::Missing, &["supply_sensitivity"][..]),
                "{}",
                answer.sentence
            );
            let size = answer.findings[0].correction[0].coefficient;
            assert!((size / shift - 1.0).abs() < 0.1, "{size} rad/s/V of {shift}");
        }
    }
}

/// One warm-up by 58 K in 20 min without a reference log: the accelerometer drifts by `slope` m/s²/K, with white noise
/// and a random walk of usual size.
fn warm_up(seed: u64, slope: f64) -> Diagnosis {
    let n = 12_000;
    let (time_s, dt): (Vec<f64>, f64) = ((0..n).map(|row| 0.1 * f64::from(row)).collect(), 0.1);
    let temperature: Vec<f64> = time_s.iter().map(|t| 45.0 - 58.0 * (-t / 400.0).exp()).collect();
    let (white, mut steps, mut walk) = (white_noise(seed, n as usize), Noise::new(seed + 100), 0.0);
    let values = temperature.iter().zip(&white).map(|(temperature, white)| {
        walk += 1e-4 * dt.sqrt() * steps.normal();
        9.8 + slope * (temperature - 25.0) + walk + 0.03 * white
    });
    let columns = [("ax_mps2", values.collect()), ("t_s", time_s), ("temp_c", temperature.clone())];
    let columns: Vec<_> = columns.map(|(name, values)| (name.to_owned(), values)).into();
    let log = Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default());
    diagnose(&Question::new(&log.expect("a log"), "ax", &Library::built_in())).expect("an answer")
}

#[test]
fn finds_weak_drift_in_one_warm_up_without_false_alarm() {
    for seed in 1..=2 {
        let found = warm_up(seed, 6.4e-4);
        assert!(["temp_linear", "temp_poly"].contains(&first(&found)), "seed {seed}: {}", found.sentence);
        let none = warm_up(seed, 0.0);
        assert_eq!(none.verdict, Verdict::NothingMissing, "seed {seed}: {}", none.sentence);
    }
}

//! Estimates of several effects together, and the reductions that are predicted from them.

use std::f64::consts::TAU;

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_testkit::noise::white_noise;

use super::{Question, diagnose, diagnose_and_measure, estimate, with_measured_reduction};
use crate::compare_tests::lagging;
use crate::effects::{Effect, Library};

/// A gyro at `rate_hz` with white noise of 0.0015 rad/s, and a temperature of 25 ± 5 °C that begins at `phase`. `error`
/// gives the error in rad/s at a time in s and a temperature in °C.
fn log(name: &str, (seconds, rate_hz, phase): (f64, f64, f64), error: impl Fn(f64, f64) -> f64) -> Recording {
    let n = (seconds * rate_hz) as usize;
    let time_s: Vec<f64> = (0..n).map(|row| row as f64 / rate_hz).collect();
    let temperature: Vec<f64> = time_s.iter().map(|t| 25.0 + 5.0 * (t / 60.0 + phase).sin()).collect();
    let noise = white_noise(name.len() as u64, n);
    let gyro = (0..n).map(|row| error(time_s[row], temperature[row]) + 0.0015 * noise[row]).collect();
    let columns = [("t_s", time_s), ("gx_rads", gyro), ("temp_c", temperature)];
    let columns = columns.map(|(name, values)| (name.to_owned(), values)).into();
    Recording::from_columns(Source::made_by(name), columns, &LoadOptions::default()).expect("a log")
}

/// The drift with temperature was taken about 0 °C, as 25 times its coefficient: 36 % were
/// predicted where 70 % were measured.
#[test]
fn predicted_reduction_of_a_step_matches_the_measured_one_beside_a_drift() {
    let error = |is_after: bool, temperature: f64| 0.003 * f64::from(u8::from(is_after)) + 2e-4 * temperature;
    let fitted = log("log", (900.0, 20.0, 0.0), |time, temperature| error(time > 400.0, temperature));
    let evaluation = log("evaluation", (600.0, 20.0, 1.0), |_, temperature| error(true, temperature));
    let library = Library::built_in();
    let question = Question { evaluation: Some(&evaluation), ..Question::new(&fitted, "gx", &library) };
    let diagnosis = diagnose(&question).expect("a diagnosis");
    let diagnosis = with_measured_reduction(diagnosis, &fitted, &evaluation, &(0..evaluation.n_rows()))
        .expect("a measured reduction");
    let effects: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.effect.as_str()).collect();
    assert_eq!(effects, ["bias_step", "temp_linear"], "{}", diagnosis.sentence);
    for finding in &diagnosis.findings {
        let (predicted, measured) =
            (finding.predicted_reduction, finding.measured_reduction.expect("measured"));
        println!("{}: predicted {predicted:.3}, measured {measured:.3}", finding.effect);
        assert!((predicted - measured).abs() < 0.05, "{}: {predicted} for {measured}", finding.effect);
    }
}

/// A log in two files: in the second the lag restarted, at the temperature of its first row, and its error counted about
/// another mean.
#[test]
fn lag_continues_in_an_evaluation_log_that_follows() {
    let part = |rows, shift_s| lagging(10.0, 0.0015, rows, shift_s);
    let library = Library::built_in();
    let fitted = part(0..9000, 0.0);
    let lag = |shift_s: f64| {
        let evaluation = part(9000..15_000, shift_s);
        let question = Question { evaluation: Some(&evaluation), ..Question::new(&fitted, "gx", &library) };
        let mut findings = diagnose_and_measure(&question).expect("a diagnosis").findings;
        let place = findings.iter().position(|finding| finding.effect == "thermal_lag").expect("the lag");
        findings.swap_remove(place)
    };
    let (follows, restarts) = (lag(0.0), lag(-900.0));
    let [low, high] = follows.predicted_reduction_interval;
    let (measured, other) = (follows.measured_reduction, restarts.measured_reduction);
    let (measured, other) = (measured.expect("measured"), other.expect("measured"));
    println!("measured {measured:.3}, predicted {low:.3} … {high:.3}; with restarted lags {other:.3}");
    assert!(measured > 0.9 && measured > other && (low..high).contains(&measured));
}

/// The columns of the evaluation log were compared with those of the fitted log about their mean: this log went "263 times
/// further".
#[test]
fn evaluation_log_in_the_fitted_range_is_not_beyond_it() {
    let error = |_, temperature: f64| 2e-4 * (temperature - 25.0) + 1e-4 * (temperature - 25.0).powi(2);
    let fitted = log("log", (900.0, 20.0, 0.0), error);
    let evaluation = log("evaluation", (600.0, 20.0, 1.0), error);
    let library = Library::built_in();
    let question = Question { evaluation: Some(&evaluation), ..Question::new(&fitted, "gx", &library) };
    let findings = estimate(&question, &["temp_poly".to_owned()]).expect("an estimate");
    assert_eq!(findings[0].doubt, None);
    assert!(findings[0].predicted_reduction > 0.8, "{}", findings[0].predicted_reduction);
}

/// The search for the weaker line discarded the stronger one, which comes first.
#[test]
fn estimates_two_kinds_of_lines_in_any_order() {
    let sine = |hz: f64, time: f64| (TAU * hz * time).sin();
    let fitted = log("log", (120.0, 200.0, 0.0), |time, _| 3e-3 * sine(50.0, time) + 1e-3 * sine(16.4, time));
    let mut library = Library::built_in();
    let mut hum =
        Effect { id: "mains_hum".to_owned(), ..library.get("spectral_line").expect("built in").clone() };
    let range = hum.parameter.as_mut().expect("a frequency");
    (range.low, range.high) = (49.0, 51.0);
    library.add(hum);
    let question = Question::new(&fitted, "gx", &library);
    for (effects, wanted) in
        [(["mains_hum", "spectral_line"], [50.0, 16.4]), (["spectral_line", "mains_hum"], [16.4, 50.0])]
    {
        let findings = estimate(&question, &effects.map(str::to_owned)).expect("both lines");
        for ((finding, effect), hz) in findings.iter().zip(effects).zip(wanted) {
            assert_eq!(finding.effect, effect);
            assert!((finding.params.values().next().expect("a frequency") - hz).abs() < 0.01, "{finding:?}");
        }
    }
}

/// Temperature in °C of a chamber that cools from 52 °C to −18 °C in 2400 s and heats to 74 °C in 4200 s.
fn chamber(time_s: f64) -> f64 {
    if time_s < 2400.0 { 52.0 - 70.0 * time_s / 2400.0 } else { -18.0 + 92.0 * (time_s - 2400.0) / 4200.0 }
}

/// The step was searched for only under the noise levels of the prior, under which a step elsewhere explains more of the
/// lag, and none was reported.
#[test]
fn finds_step_beside_lag_in_a_chamber() {
    let n = 6600;
    let (mut delayed, mut walk) = (chamber(0.0), 0.0);
    let (white, steps) = (white_noise(1, n), white_noise(2, n));
    let (mut error, mut temperature) = (Vec::new(), Vec::new());
    for row in 0..n {
        let now = chamber(row as f64);
        delayed += (now - delayed) / 1500.0;
        walk += 0.001 * steps[row];
        let bent = (now - 28.0) / 40.0;
        let drift = -0.6 * bent + 0.45 * bent.powi(2) - 0.08 * bent.powi(3) + 0.02 * (4.0 * bent).sin();
        let step = 0.03 * f64::from(u8::from(row > 2020));
        error.push(drift - 0.006 * delayed - step + walk + 0.0046 * white[row]);
        temperature.push(now);
    }
    let time_s = (0..n).map(|row| row as f64).collect();
    let columns = [("t_s", time_s), ("gx_rads", error), ("temp_c", temperature)];
    let columns = columns.map(|(name, values)| (name.to_owned(), values)).into();
    let log =
        Recording::from_columns(Source::made_by("chamber"), columns, &LoadOptions::default()).expect("a log");
    let library = Library::built_in();
    let diagnosis = diagnose(&Question::new(&log, "gx", &library)).expect("a diagnosis");
    let found: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.effect.as_str()).collect();
    assert_eq!(found, ["temp_poly", "bias_step"], "{}", diagnosis.sentence);
    let time_s = diagnosis.findings[1].params["time_s"];
    // one block of 11 s
    assert!((time_s - 2020.5).abs() < 11.0, "{time_s}");
}

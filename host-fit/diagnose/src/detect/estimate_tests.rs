//! Estimates of several effects together.

use std::f64::consts::TAU;

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_testkit::noise::white_noise;

use super::{Question, estimate};
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

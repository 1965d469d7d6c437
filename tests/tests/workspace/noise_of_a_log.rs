//! N, B and K of logs with known truth, from the log's rows to the intervals.

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::stillness;
use fos_fit::noise::{AxisNoise, AxisNoiseError, Level, axis_noise};
use fos_simulate::Colour;
use fos_testkit::is_thorough;

pub(super) const RATE_HZ: f64 = 20.0;
pub(super) const N: f64 = 1.2e-4;
pub(super) const B: f64 = 4e-5;
pub(super) const K: f64 = 4e-6;

/// A gyro of `n` samples at rest, with other columns.
pub(super) fn log(values: Vec<f64>, others: Vec<(String, Vec<f64>)>) -> Recording {
    let time: Vec<f64> = (0..values.len()).map(|row| row as f64 / RATE_HZ).collect();
    let mut columns = vec![("t_s".to_owned(), time), ("gx_rads".to_owned(), values)];
    columns.extend(others);
    let options = LoadOptions { rate_hz: Some(RATE_HZ), ..LoadOptions::default() };
    Recording::from_columns(Source::made_by("a test"), columns, &options).expect("a recording")
}

fn simulated(walk: f64, n: usize, seed: u64) -> Vec<f64> {
    // a data sheet's density is one-sided: √2·N
    fos_simulate::AxisNoise::new(2.0_f64.sqrt() * N, B, walk, Colour::WHITE, RATE_HZ).simulate(n, seed)
}

pub(super) fn noise_of(recording: &Recording) -> Result<AxisNoise, AxisNoiseError> {
    axis_noise(recording, &stillness::find(recording), "gx")
}

pub(super) fn holds(level: Level, truth: f64) -> bool {
    level.low.is_none_or(|low| low <= truth) && truth <= level.high
}

#[test]
fn intervals_of_an_hour_hold_the_truth_in_nine_of_ten_logs() {
    let logs = if is_thorough() { 40 } else { 5 };
    let mut held = [0_u64; 3];
    let mut seen = 0_u64;
    for seed in 0..logs {
        let noise = noise_of(&log(simulated(K, 72_000, seed), Vec::new())).expect("long enough").levels;
        let truths = [(noise.white, N), (noise.flicker, B), (noise.walk, K)];
        for (held, (level, truth)) in held.iter_mut().zip(truths) {
            *held += u64::from(holds(level, truth));
        }
        seen += u64::from(noise.walk.value.is_some());
    }
    println!("held {held:?}, K seen {seen} of {logs}");
    // 36 ± 1.9 of 40, 4.5 ± 0.7 of 5: three standard deviations
    let fewest = if is_thorough() { 30 } else { 3 };
    assert!(held.iter().all(|held| (fewest..=logs).contains(held)), "{held:?} of {logs}");
    assert!(4 * seen > 3 * logs, "{seen} of {logs}");
}

/// A warm-up by 15 K drifts the bias by 250 times its random walk over a second; the sensor lags behind the thermometer.
#[test]
fn a_drift_with_temperature_is_no_random_walk() {
    let n = 24_000;
    let temperature: Vec<f64> = (0..n).map(|row| 40.0 - 15.0 * (-(row as f64) / 6_000.0).exp()).collect();
    let (mut of_sensor, late) = (temperature[0], 1.0 / (30.0 * RATE_HZ));
    let drift: Vec<f64> = temperature
        .iter()
        .map(|measured| {
            of_sensor += late * (measured - of_sensor);
            1.2e-4 * (of_sensor - 25.0) + 3e-6 * (of_sensor - 25.0).powi(2)
        })
        .collect();
    // also with a thermometer of steps of 0.5 K and a value in every third row
    let coarse = |(row, measured): (usize, &f64)| {
        if row % 3 == 0 { (measured / 0.5).round() * 0.5 } else { f64::NAN }
    };
    let coarse: Vec<f64> = temperature.iter().enumerate().map(coarse).collect();
    for (walk, logged) in [(0.0, &temperature), (K, &coarse)] {
        let mut held = 0;
        for seed in 200..205 {
            let values = simulated(walk, n, seed).into_iter().zip(&drift).map(|(value, drift)| value + drift);
            let log = log(values.collect(), vec![("temp_c".to_owned(), logged.clone())]);
            let noise = noise_of(&log).expect("long enough");
            let truths = [(noise.levels.white, N), (noise.levels.flicker, B), (noise.levels.walk, walk)];
            held += usize::from(truths.iter().all(|(level, truth)| holds(*level, *truth)));
            assert!(noise.levels.walk.high < 5.0 * K, "K at most {}", noise.levels.walk.high);
            let removed = noise.thermal_drift.expect("a drift");
            assert!((5e-4..1.5e-3).contains(&removed.rms), "{removed:?}");
        }
        // all three 90 % intervals: 3.6 ± 1 of 5
        assert!(held >= 2, "{held} of 5");
    }
}

#[test]
fn invisible_random_walk_gives_a_limit_and_a_log_length() {
    let (mut named, mut held) = (0, 0);
    let logs = if is_thorough() { 30 } else { 5 };
    for seed in 100..100 + logs {
        let noise = noise_of(&log(simulated(B / 200.0, 12_000, seed), Vec::new())).expect("long enough");
        named += usize::from(noise.levels.walk.value.is_some());
        held += usize::from(holds(noise.levels.walk, B / 200.0));
        let needs = noise.walk_needs_s.is_some_and(|needed| needed > 2.0 * noise.span_s - 1.0);
        assert!(needs || noise.levels.walk.value.is_some(), "{noise:?}");
    }
    println!("named {named}, held {held} of {logs}");
    // 5 % of the logs show a random walk by chance: 1.5 ± 1.2 of 30
    let (most_named, fewest_held) = if is_thorough() { (5, 24) } else { (1, 4) };
    assert!(named <= most_named && held >= fewest_held, "{named} named, {held} held, of {logs}");
}

#[test]
fn motion_and_outliers_have_no_influence() {
    let quiet = simulated(K, 72_000, 7);
    let mut shaken = quiet.clone();
    let mut still = vec![1.0; quiet.len()];
    for row in 20_000..24_000 {
        shaken[row] += 0.5 * (row as f64 * 0.3).sin();
        still[row] = 0.0;
    }
    for row in [1000, 40_000, 60_123] {
        shaken[row] = 30.0;
    }
    let with = noise_of(&log(shaken, vec![("still".to_owned(), still.clone())])).expect("long enough");
    let without = noise_of(&log(quiet, vec![("still".to_owned(), still)])).expect("long enough");
    assert_eq!(with.left_out, 3);
    for (a, b) in [(with.levels.white, without.levels.white), (with.levels.flicker, without.levels.flicker)] {
        let (a, b) = (a.value.unwrap(), b.value.unwrap());
        assert!((a / b - 1.0).abs() < 0.01, "{a} {b}"); // three of 68 000 samples are not there
    }
    let furthest = with.allan.iter().map(|point| point.deviation).fold(0.0, f64::max);
    assert!(furthest < 6e-4, "nothing of the motion: {furthest}"); // one sample: N·√20
}

#[test]
fn rejects_short_and_noiseless_logs_with_a_remedy() {
    let short = noise_of(&log(simulated(0.0, 300, 1), Vec::new())).unwrap_err().to_string();
    assert!(
        short.contains("15.0 s at rest in stretches") && short.contains("help: record a longer log"),
        "{short}"
    );
    let constant = noise_of(&log(vec![0.25; 12_000], Vec::new())).unwrap_err().to_string();
    assert!(constant.contains("gx_rads repeats one value, 0.25"), "{constant}");
}

//! Accuracy of the noise levels of simulated logs against the Cramér-Rao bound, and coverage of their intervals: the figures
//! of docs/imu-yaml.md. Hundreds of logs each: `.ci/release long` runs them.

use fos_data::recording::{LoadOptions, load};
use fos_fit::noise::{AxisNoise, Level, NoiseLevels, log_deviations, seconds_for_walk_within};
use fos_fit::signal::allan::allan_deviation;
use fos_simulate::{Colour, GaussMarkov};
use fos_testkit::outside;
use fos_testkit::reference::{self, numbers};
use rayon::prelude::*;

use super::noise_of_a_log::{RATE_HZ, holds, log, noise_of};

/// Number of simulated logs of each kind, and the seed of the first: rules were chosen on others.
const LOGS: u64 = 200;
const FIRST_SEED: u64 = 40_000;

/// Levels N, B, K: flicker noise that hides the random walk, and a random walk that shows.
const MIXES: [[f64; 3]; 2] = [[1.2e-4, 4e-5, 4e-6], [1.2e-4, 1e-5, 1e-5]];

/// Lengths of logs, s.
const LENGTHS_S: [f64; 3] = [600.0, 3600.0, 28_800.0];

/// Largest expected deviation of a logarithm from which on an estimate is compared with the bound, which holds for
/// accurate estimates.
const ACCURATE: f64 = 0.25;

/// Results of `of` for `count` seeds, on all cores.
fn in_parallel<T: Send>(count: u64, of: impl Fn(u64) -> T + Sync) -> Vec<T> {
    (0..count).into_par_iter().map(|seed| of(FIRST_SEED + seed)).collect()
}

fn simulated([white, flicker, walk]: [f64; 3], seconds: f64, seed: u64) -> Vec<f64> {
    let noise = fos_simulate::AxisNoise::new(2.0_f64.sqrt() * white, flicker, walk, Colour::WHITE, RATE_HZ);
    noise.simulate((seconds * RATE_HZ) as usize, seed)
}

fn levels_of(noise: &AxisNoise) -> [Level; 3] {
    [noise.levels.white, noise.levels.flicker, noise.levels.walk]
}

/// Accuracy of a level over many logs.
struct Accuracy {
    /// RMS of ln(value/truth) over the logs that state a value.
    rms: f64,
    /// Share of intervals and limits that hold the truth.
    held: f64,
    /// Share that should: 90 % of intervals, 95 % of limits.
    stated: f64,
}

fn accuracy(levels: &[Level], truth: f64) -> Accuracy {
    let mean = |of: &dyn Fn(&Level) -> f64| levels.iter().map(of).sum::<f64>() / levels.len() as f64;
    let off: Vec<f64> =
        levels.iter().filter_map(|level| level.value).map(|value| (value / truth).ln()).collect();
    let square = off.iter().map(|off| off * off).sum::<f64>() / off.len().max(1) as f64;
    Accuracy {
        rms: square.sqrt(),
        held: mean(&|level| f64::from(u8::from(holds(*level, truth)))),
        stated: mean(&|level| if level.low.is_some() { 0.9 } else { 0.95 }),
    }
}

#[test]
#[ignore = "statistics of 1200 logs: .ci/release runs it"]
fn levels_are_at_the_bound_and_their_intervals_hold() {
    let (mut held, mut stated) = ([0.0; 3], [0.0; 3]);
    for (mix, seconds) in MIXES.iter().flat_map(|mix| LENGTHS_S.map(|seconds| (mix, seconds))) {
        let found = in_parallel(LOGS, |seed| {
            levels_of(&noise_of(&log(simulated(*mix, seconds, seed), Vec::new())).unwrap())
        });
        let [white, flicker, walk] = *mix;
        let levels = NoiseLevels { white, flicker, walk, gauss_markov: None };
        // the length of the block means that the estimate uses
        let bounds = log_deviations(&levels, seconds, (seconds / 6000.0).max(0.5));
        for (at, name) in ["N", "B", "K"].into_iter().enumerate() {
            let of_level: Vec<Level> = found.iter().map(|levels| levels[at]).collect();
            let found = accuracy(&of_level, mix[at]);
            held[at] += found.held / 6.0;
            stated[at] += found.stated / 6.0;
            let (rms, bound) = (found.rms, bounds[at]);
            println!(
                "{seconds} s, {name} {:.1e}: {rms:.4}, bound {bound:.4}; held {:.3}, stated {:.3}",
                mix[at], found.held, found.stated
            );
            // the RMS of 200 values has a standard error of 5 %
            assert!(bound > ACCURATE || rms < 1.2 * bound, "{name}: {rms} for {bound}");
        }
    }
    println!("held, N B K: {held:.3?}, stated {stated:.3?}");
    // the share of 1200 logs has a standard error of 1 %
    assert!(held.iter().zip(stated).all(|(held, stated)| (held - stated).abs() < 0.03), "{held:?}");
}

#[test]
#[ignore = "statistics of 200 logs: .ci/release runs it"]
fn a_gauss_markov_process_of_530_s_is_at_the_bound() {
    // σ 1.15e-6·√(530/2) rad/s beside N 9.97e-5 in 12 h: the bound of ln τ is 0.224 (Whittle)
    let (white, tau_s, bound) = (9.97e-5, 530.0, 0.224);
    let sigma = 1.15e-6 * (tau_s / 2.0_f64).sqrt();
    let found = in_parallel(LOGS, |seed| {
        let mut noise =
            fos_simulate::AxisNoise::new(2.0_f64.sqrt() * white, 0.0, 0.0, Colour::WHITE, RATE_HZ);
        noise.flicker = vec![GaussMarkov { sigma, tau_s }];
        let values = noise.simulate((43_200.0 * RATE_HZ) as usize, seed);
        noise_of(&log(values, Vec::new())).unwrap().levels.gauss_markov
    });
    let preferred: Vec<_> = found.into_iter().flatten().collect();
    for (name, truth, level) in [
        ("N", white, preferred.iter().map(|found| found.white).collect::<Vec<_>>()),
        ("σ", sigma, preferred.iter().map(|found| found.deviation).collect()),
        ("τ", tau_s, preferred.iter().map(|found| found.tau_s).collect()),
    ] {
        let Accuracy { rms, held, .. } = accuracy(&level, truth);
        println!("{name}: {rms:.4}, held {held:.3} of {} logs", level.len());
        assert!(held > 0.83, "{name}: {held}");
        assert!(name != "τ" || rms < 1.15 * bound, "{rms}");
    }
    let within =
        preferred.iter().filter_map(|found| found.tau_s.value).filter(|tau| (tau - tau_s).abs() < 120.0);
    println!("τ within 120 s in {} of {} logs", within.count(), preferred.len());
    assert!(preferred.len() as u64 > LOGS * 9 / 10, "{}", preferred.len());
}

/// Length of the log that the recording time is predicted from, and the levels, also without flicker noise; the time said is
/// several times as long.
const SHORT_LOGS: [(f64, [f64; 3]); 4] = [
    (1800.0, [1.2e-4, 1e-5, 1e-5]),
    (3600.0, [1.2e-4, 2e-5, 6e-6]),
    (1800.0, [1.2e-4, 0.0, 1e-5]),
    (3600.0, [1.2e-4, 4e-5, 1e-5]),
];

#[test]
#[ignore = "statistics of 200 long logs: .ci/release runs it"]
fn the_recording_time_said_for_k_suffices_and_is_not_much_too_long() {
    let (mut said, mut reached) = (0, 0);
    for (at, (seconds, levels)) in SHORT_LOGS.into_iter().enumerate() {
        let [white, flicker, walk] = levels;
        let truth = NoiseLevels { white, flicker, walk, gauss_markov: None };
        let expected_s = seconds_for_walk_within(&truth, 1.2, seconds, 1.0).expect("a time");
        let found = in_parallel(LOGS / 4, |seed| {
            // the longest time said is below 25 times the log
            let values = simulated(levels, 30.0 * seconds, seed + LOGS * at as u64);
            let of = |seconds: f64| {
                let rows = ((seconds * RATE_HZ) as usize).min(values.len());
                noise_of(&log(values[..rows].to_vec(), Vec::new())).unwrap().levels
            };
            let needed = of(seconds).walk_within_20_percent_s?;
            let Level { low, high, .. } = of(1.2 * needed).walk;
            Some((needed / expected_s, low.is_some_and(|low| high / low < 1.2 * 1.2)))
        });
        let mut found: Vec<(f64, bool)> = found.into_iter().flatten().collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (ratio, enough) =
            (found[found.len() / 2].0, found.iter().filter(|(_, is_reached)| *is_reached).count());
        println!(
            "{levels:?}: {enough} of {}, median {ratio:.2} times the time for the true levels",
            found.len()
        );
        assert!((0.9..2.0).contains(&ratio), "{ratio}");
        said += found.len();
        reached += enough;
    }
    println!("K within ±20 % at 1.2 times the time said: {reached} of {said}");
    assert!(said > 150 && 10 * reached >= 9 * said, "{reached} of {said}");
}

#[test]
#[ignore = "statistics of 200 logs: .ci/release runs it"]
fn a_thermal_trend_leaves_k_within_its_interval() {
    let [white, flicker, walk] = MIXES[0];
    let n = (3600.0 * RATE_HZ) as usize;
    let temp_c: Vec<f64> =
        (0..n).map(|row| 40.0 - 15.0 * (-(row as f64) / (600.0 * RATE_HZ)).exp()).collect();
    let found = in_parallel(LOGS, |seed| {
        let noise = simulated([white, flicker, walk], 3600.0, seed);
        let with_drift = noise.iter().zip(&temp_c).map(|(noise, temp_c)| noise + 1.2e-4 * (temp_c - 25.0));
        let recording = log(with_drift.collect(), vec![("temp_c".to_owned(), temp_c.clone())]);
        levels_of(&noise_of(&recording).unwrap())[2]
    });
    let Accuracy { rms, held, .. } = accuracy(&found, walk);
    println!("K under a trend of 1.8e-3 rad/s: {rms:.3}, held {held:.3}");
    assert!((0.85..=0.95).contains(&held), "{held}");
}

/// Values computed with the R package avar from the same log, in °/s and g.
#[test]
#[ignore = "a log of a million rows: .ci/release runs it"]
fn allan_variances_of_an_adis16405_are_those_of_avar() {
    let references = reference::outside("allan_adis_av");
    let Some((reference, log)) = references.zip(outside::path("data/adis16405_static_run1_100hz.csv.gz"))
    else {
        return;
    };
    let recording = load(log, &LoadOptions::default()).expect("a log");
    let mut most = 0.0_f64;
    for (letter, axis) in ["X", "Y", "Z"].into_iter().zip(["x", "y", "z"]) {
        for (name, column, unit) in [
            ("Gyro.", format!("g{axis}_rads"), 1.0_f64.to_radians()),
            ("Accel.", format!("a{axis}_mps2"), 9.806_65),
        ] {
            let of_avar = &reference.answers["axes"][format!("{name} {letter}")];
            let (taus_s, expected) = (numbers(&of_avar["levels"]), numbers(&of_avar["allan"]));
            let values = &recording.axis(&column).expect("a column").values;
            let found = allan_deviation(&[values], 0.01, &taus_s);
            assert_eq!((found.len(), taus_s.len()), (18, 18));
            for (point, expected) in found.iter().zip(expected) {
                most = most.max(((point.deviation / unit).powi(2) / expected - 1.0).abs());
            }
        }
    }
    println!("Allan variances of six axes at 18 averaging times: within {most:.1e} of those of avar");
    // the digits of the log
    assert!(most < 1e-5, "{most}");
}

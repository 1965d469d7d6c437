//! Faults in simulated data are found with their true size, and not found in data without faults.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use statrs::distribution::{ContinuousCDF, Normal};

use super::faults::{Converter, Fault, find};
use fos_data::recording::{LoadOptions, Recording, Source};

const UNKNOWN: Converter = Converter { full_scale: None, lsb: None };

fn recording(values: Vec<f64>) -> Recording {
    let ticks = 0..values.len();
    recording_at(ticks, values)
}

fn recording_at(ticks: impl Iterator<Item = usize>, values: Vec<f64>) -> Recording {
    let time = ticks.map(|tick| tick as f64 * 0.005).collect();
    let columns = vec![("t_s".to_owned(), time), ("ax_mps2".to_owned(), values)];
    Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).expect("a recording")
}

fn faults(values: Vec<f64>) -> Vec<Fault> {
    find(&recording(values), None, "ax_mps2", &UNKNOWN)
}

/// Faults except coarse steps.
fn stops(values: Vec<f64>) -> Vec<Fault> {
    faults(values).into_iter().filter(|fault| !matches!(fault, Fault::Coarse { .. })).collect()
}

fn noise(random: &mut ChaCha8Rng, deviation: f64, length: usize) -> Vec<f64> {
    let normal = |random: &mut ChaCha8Rng| -> f64 { StandardNormal.sample(random) };
    (0..length).map(|_| deviation * normal(random)).collect()
}

fn round(values: &mut [f64], step: f64) {
    values.iter_mut().for_each(|value| *value = step * (*value / step).round());
}

/// Noise of unit variance with this share clipped, rounded to `step` as are its limits; and the expected fault.
fn clipped(seed: u64, share: f64, sides: (bool, bool), step: Option<f64>) -> (Vec<f64>, Fault) {
    const LENGTH: usize = 120_000;
    let unit = Normal::new(0.0, 1.0).expect("a distribution");
    let rounded = |value: f64| step.map_or(value, |step| step * (value / step).round());
    let each = if sides == (true, true) { share / 2.0 } else { share };
    let low = sides.0.then(|| rounded(unit.inverse_cdf(each)));
    let high = sides.1.then(|| rounded(unit.inverse_cdf(1.0 - each)));
    let mut values = noise(&mut ChaCha8Rng::seed_from_u64(seed), 1.0, LENGTH);
    let mut at_stops = 0_u32;
    for value in &mut values {
        *value = rounded(*value);
        if let Some(low) = low.filter(|low| *value <= *low) {
            (*value, at_stops) = (low, at_stops + 1);
        } else if let Some(high) = high.filter(|high| *value >= *high) {
            (*value, at_stops) = (high, at_stops + 1);
        }
    }
    (values, Fault::Saturation { share: f64::from(at_stops) / LENGTH as f64, limits: (low, high) })
}

const SIDES: [(bool, bool); 3] = [(true, false), (false, true), (true, true)];

#[test]
fn finds_share_of_clipped_noise() {
    for (seed, share) in [1e-3, 1e-2, 0.2].into_iter().enumerate() {
        for sides in SIDES {
            for step in [None, Some(0.05)] {
                let (values, wanted) = clipped(seed as u64, share, sides, step);
                assert_eq!(faults(values), [wanted], "{share} at {sides:?}, step {step:?}");
            }
        }
    }
}

#[test]
fn finds_clipping_at_full_scale_of_coarse_converter() {
    for (seed, share) in [1e-3, 1e-2, 0.2].into_iter().enumerate() {
        let (values, wanted) = clipped(seed as u64, share, (false, true), Some(0.5));
        let Fault::Saturation { limits: (None, full_scale), .. } = wanted else { panic!("{wanted:?}") };
        let converter = Converter { full_scale, lsb: None };
        assert_eq!(find(&recording(values), None, "ax_mps2", &converter), [wanted], "{share}");
    }
}

#[test]
fn finds_clipping_of_a_fifth_of_the_samples() {
    // at 0.8 with clipping on both sides, a tenth each is as much as a tail of noise leaves at such a code
    let missed: Vec<(f64, (bool, bool))> = [0.3, 0.4, 0.5]
        .into_iter()
        .flat_map(|step| SIDES.map(|sides| (step, sides)))
        .filter(|(step, sides)| {
            let (values, wanted) = clipped(1, 0.2, *sides, Some(*step));
            faults(values) != [wanted]
        })
        .collect();
    assert!(missed.is_empty(), "step in standard deviations, stops: {missed:?}");
}

#[test]
fn unclipped_noise_is_not_saturated() {
    for seed in 0..300 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut values = noise(&mut random, 1.0, 20_000);
        // from continuous to six standard deviations a step, which leaves two or three codes
        let step = match seed % 3 {
            0 => None,
            1 => Some(random.random_range(0.02..1.0)),
            _ => Some(random.random_range(1.0..6.0)),
        };
        let offset = random.random_range(-10.0..10.0);
        values.iter_mut().for_each(|value| *value += offset);
        if let Some(step) = step {
            round(&mut values, step);
        }
        assert_eq!(stops(values), [], "seed {seed}, step {step:?}, offset {offset}");
    }
}

/// Noise of unit variance about levels that are held for a while, as by an accelerometer in several orientations.
fn dwells(seed: u64, step: f64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut values = Vec::new();
    for _ in 0..random.random_range(2..8) {
        let level = random.random_range(-400.0..400.0);
        let held = random.random_range(2000..4000);
        values.extend(noise(&mut random, 1.0, held).iter().map(|value| value + level));
    }
    round(&mut values, step);
    values
}

#[test]
fn held_levels_are_not_clipping() {
    for seed in 0..300 {
        let step = [0.05, 0.3, 1.0][seed as usize % 3];
        assert_eq!(faults(dwells(seed, step)), [], "seed {seed}, step {step}");
    }
}

#[test]
fn coarse_held_levels_are_not_clipping() {
    let wrong: Vec<(u64, Vec<Fault>)> = (0..300)
        .map(|seed| (seed, stops(dwells(seed, [2.5, 4.0, 8.0][seed as usize % 3]))))
        .filter(|(_, found)| !found.is_empty())
        .collect();
    assert!(wrong.is_empty(), "{} of 300 logs, the first {:?}", wrong.len(), wrong[0]);
}

/// Without a reference log and a data sheet the specified step is unknown, but the steps hide the noise all the same.
#[test]
fn finds_coarse_steps_of_unknown_converter() {
    for seed in 0..20 {
        let mut values = noise(&mut ChaCha8Rng::seed_from_u64(seed), 1.0, 20_000);
        values.iter_mut().enumerate().for_each(|(row, value)| *value += 0.001 * row as f64);
        round(&mut values, 5.0);
        let found = faults(values);
        let [Fault::Coarse { multiple, step }] = found[..] else { panic!("{seed}: {found:?}") };
        assert!(multiple.is_nan() && (step - 5.0).abs() < 1e-9, "{seed}: {step}");
    }
}

fn dropped(found: &[Fault]) -> Option<f64> {
    found.iter().find_map(|fault| match fault {
        Fault::Dropped { share } => Some(*share),
        _ => None,
    })
}

/// A log in which every sample is missing with this probability, in runs of `run`; and the actual share.
fn with_gaps(seed: u64, probability: f64, run: usize) -> (Recording, f64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut ticks = vec![0];
    let mut tick = 1;
    while tick < 20_000 {
        if random.random_bool(probability / run as f64) {
            tick += run;
        } else {
            ticks.push(tick);
            tick += 1;
        }
    }
    let all = ticks[ticks.len() - 1] + 1;
    let share = 1.0 - ticks.len() as f64 / all as f64;
    let values = noise(&mut random, 1.0, ticks.len());
    (recording_at(ticks.into_iter(), values), share)
}

#[test]
fn dropped_samples_are_counted() {
    for (probability, run) in [(2e-3, 1), (1e-2, 1), (5e-2, 1), (1e-2, 7), (0.2, 50)] {
        for seed in 0..5 {
            let (log, share) = with_gaps(seed, probability, run);
            let found = dropped(&find(&log, None, "ax_mps2", &UNKNOWN)).expect("dropped");
            assert!((found - share).abs() < 1e-12, "{probability}, {run}: {found} for {share}");
            let (reference, _) = with_gaps(100 + seed, probability, run);
            let compared = find(&log, Some(&reference), "ax_mps2", &UNKNOWN);
            assert_eq!(dropped(&compared), None, "{probability}, {run}: the reference log drops as many");
        }
    }
    let whole = recording(noise(&mut ChaCha8Rng::seed_from_u64(1), 1.0, 20_000));
    assert_eq!(find(&whole, None, "ax_mps2", &UNKNOWN), []);
}

#[test]
fn coarse_steps_are_whole_multiples() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for lsb in [1.0, 1.2e-3, 9.81 / 2048.0] {
        // standard deviation of the noise in steps of the reference log
        for noise_steps in [0.7, 3.0, 12.0] {
            let log = |random: &mut ChaCha8Rng, step: f64| {
                let mut values = noise(random, noise_steps * lsb, 20_000);
                values.iter_mut().for_each(|value| *value += 9.81);
                round(&mut values, step);
                recording(values)
            };
            let reference = log(&mut random, lsb);
            let converter = Converter { lsb: Some(lsb), ..UNKNOWN };
            for multiple in [1.0, 2.0, 3.0, 4.0, 5.0, 8.0, 16.0] {
                // with noise far below a step all samples have one code
                if multiple > 5.0 * noise_steps {
                    continue;
                }
                let field = log(&mut random, multiple * lsb);
                for found in [
                    find(&field, Some(&reference), "ax_mps2", &UNKNOWN),
                    find(&field, None, "ax_mps2", &converter),
                ] {
                    match found[..] {
                        [] => assert_eq!(multiple, 1.0, "lsb {lsb}, {noise_steps} steps"),
                        [Fault::Coarse { multiple: estimated, step }] => {
                            assert_eq!(estimated, multiple, "lsb {lsb}, {noise_steps} steps");
                            // 9.81 leaves a rounding error of 2e-15
                            assert!((step / (multiple * lsb) - 1.0).abs() < 1e-9, "{step}");
                        }
                        _ => panic!("lsb {lsb}, {noise_steps} steps, {multiple}: {found:?}"),
                    }
                }
            }
        }
    }
}

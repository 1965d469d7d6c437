//! N, B and K of simulated noise: the intervals have their stated coverage, and undetectable processes are not
//! reported.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::blocks::Blocks;
use super::estimate::{Level, NoiseEstimate, estimate};
use super::levels::UnknownLevels;
use super::model::{GaussMarkov, NoiseLevels};
use super::noise_tests::blocks_of;

fn simulated(levels: &NoiseLevels, blocks: &Blocks, seed: u64) -> [Level; 3] {
    let y = levels.simulate(blocks, &mut ChaCha8Rng::seed_from_u64(seed));
    let ones = vec![1.0; blocks.len()];
    let found = estimate(blocks, &y, &[&ones]).unwrap();
    [found.white, found.flicker, found.walk]
}

fn holds(level: &Level, truth: f64) -> bool {
    level.low.is_none_or(|low| low <= truth) && truth <= level.high
}

#[test]
fn intervals_have_their_stated_coverage() {
    // an hour in blocks of 0.8 s, some missing
    let counts: Vec<usize> = (0..1500).map(|block| if (700..760).contains(&block) { 0 } else { 8 }).collect();
    let blocks = blocks_of(&counts);
    let (white, flicker, walk) = (1.0_f64, 0.4, 0.06);
    let (with_faster, faster) = blocks.faster_flicker(white, flicker);
    let levels = NoiseLevels { white: with_faster, flicker, walk, gauss_markov: Some(faster) };
    let mut held = [0; 3];
    let mut below = [0; 3];
    for seed in 0..100 {
        let found = simulated(&levels, &blocks, seed);
        for (held, (level, truth)) in held.iter_mut().zip(found.iter().zip([white, flicker, walk])) {
            *held += usize::from(holds(level, truth));
        }
        for (below, (level, truth)) in below.iter_mut().zip(found.iter().zip([white, flicker, walk])) {
            *below += usize::from(level.high < truth);
        }
    }
    println!("{held:?} of 100, too low {below:?}");
    // 90 ± 3 by the binomial distribution; three of them
    assert!(held.iter().all(|held| (81..=99).contains(held)), "{held:?} of 100");
}

#[test]
fn undetected_process_gives_a_limit() {
    let blocks = blocks_of(&[8; 600]);
    let levels = NoiseLevels { white: 1.0, flicker: 0.0, walk: 0.0, gauss_markov: None };
    let mut named = [0; 3];
    for seed in 0..60 {
        for (named, level) in named.iter_mut().zip(simulated(&levels, &blocks, 500 + seed)) {
            *named += usize::from(level.value.is_some());
            assert_eq!(level.value.is_some(), level.low.is_some(), "{level:?}");
        }
    }
    println!("named {named:?} of 60");
    // one-sided at 5 %: for the other half of the samples zero is the most likely value; 3 ± 1.7
    assert_eq!(named[0], 60);
    assert!(named[1] <= 8 && named[2] <= 8, "{named:?}");
}

#[test]
fn rejects_constant_series_and_too_few_blocks() {
    let blocks = blocks_of(&[8; 60]);
    let ones = vec![1.0; 60];
    assert_eq!(estimate(&blocks, &ones, &[&ones]), Err(UnknownLevels));
    let few = blocks_of(&[8; 20]);
    let y: Vec<f64> = (0..20).map(|n| f64::from(n % 3)).collect();
    assert_eq!(estimate(&few, &y, &[&ones[..20]]), Err(UnknownLevels));
}

#[test]
fn undetected_walk_requires_a_longer_log() {
    let blocks = blocks_of(&[8; 600]);
    let levels = NoiseLevels { white: 1.0, flicker: 0.3, walk: 0.0, gauss_markov: None };
    let y = levels.simulate(&blocks, &mut ChaCha8Rng::seed_from_u64(3));
    let ones = vec![1.0; blocks.len()];
    let found = estimate(&blocks, &y, &[&ones]).unwrap();
    assert_eq!(found.walk.value, None);
    let factor = found.seconds_for_walk(480.0).unwrap() / 480.0;
    // half the walk equals white noise after twice the time, flicker after four times
    assert!((2.0..=4.0).contains(&factor), "{factor}");
}

#[test]
fn predicts_a_recording_time_only_for_a_walk_known_within_a_factor_of_three() {
    let known = |value: f64, low: f64, high: f64| Level { value: Some(value), low: Some(low), high };
    let estimate = NoiseEstimate {
        white: known(0.01, 0.0099, 0.0101),
        flicker: Level { value: None, low: None, high: 1e-4 },
        walk: known(3.16e-5, 1.5e-5, 5e-5),
        gauss_markov: None,
    };
    let needed = estimate.seconds_for_accurate_walk(3600.0).expect("a time");
    assert!(needed > 3600.0);
    assert_eq!(estimate.seconds_for_accurate_walk(1.01 * needed), None, "long enough");
    // flicker that may be there hides a part of the walk
    let more = NoiseEstimate { flicker: Level { value: None, low: None, high: 1e-3 }, ..estimate };
    assert!(more.seconds_for_accurate_walk(3600.0).expect("a time") > 1.2 * needed);
    let hardly = NoiseEstimate { walk: known(3.16e-5, 0.3e-5, 9e-5), ..estimate };
    assert_eq!(hardly.seconds_for_accurate_walk(3600.0), None, "hardly seen");
}

/// A Gauss-Markov process of 25 s, in an hour of blocks of 0.8 s.
const PROCESS: GaussMarkov = GaussMarkov { deviation: 0.8, tau_s: 25.0 };

#[test]
fn a_gauss_markov_process_is_estimated_with_intervals_that_hold() {
    let blocks = blocks_of(&[8; 4500]);
    let levels = NoiseLevels { white: 1.0, flicker: 0.0, walk: 0.0, gauss_markov: Some(PROCESS) };
    let ones = vec![1.0; blocks.len()];
    let (mut preferred, mut held) = (0, [0; 3]);
    for seed in 0..4 {
        let y = levels.simulate(&blocks, &mut ChaCha8Rng::seed_from_u64(seed));
        let Some(found) = estimate(&blocks, &y, &[&ones]).unwrap().gauss_markov else { continue };
        preferred += 1;
        let truths = [(found.white, 1.0), (found.deviation, 0.8), (found.tau_s, 25.0)];
        for (held, (level, truth)) in held.iter_mut().zip(truths) {
            *held += u32::from(holds(&level, truth));
        }
        assert!(found.tau_s.low.is_some() && found.tau_s.high < 250.0, "{found:?}");
    }
    println!("preferred {preferred} of 4, held {held:?}");
    // 3.6 ± 0.6 of 4 hold
    assert!(preferred >= 2 && held.iter().all(|held| *held + 2 >= preferred), "{preferred}: {held:?}");
}

#[test]
fn flicker_noise_and_a_random_walk_are_no_gauss_markov_process() {
    let blocks = blocks_of(&[8; 1500]);
    let levels = NoiseLevels { white: 1.0, flicker: 0.4, walk: 0.02, gauss_markov: None };
    let ones = vec![1.0; blocks.len()];
    let is_preferred = |seed: &u64| {
        let y = levels.simulate(&blocks, &mut ChaCha8Rng::seed_from_u64(*seed));
        estimate(&blocks, &y, &[&ones]).unwrap().gauss_markov.is_some()
    };
    let preferred = (0..20).filter(is_preferred).count();
    assert!(preferred <= 1, "{preferred} of 20");
}

//! Calibration: false alarm rate under noise alone, and detection rate of a dependence of known size.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use statrs::distribution::{Binomial, DiscreteCDF};

use super::channel::Noise;
use super::likelihood::BlockResidual;
use super::{bands, channel, lag};
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_fit::noise::{Blocks, Gls, LevelPrior, NoiseLevels};

const BLOCKS: usize = 600;
const BLOCK_S: f64 = 2.0;

/// White noise of one; usual flicker with little random walk, and more flicker with a strong walk.
const NOISE: [NoiseLevels; 2] = [
    NoiseLevels { white: 1.0, flicker: 0.35, walk: 0.012, gauss_markov: None },
    NoiseLevels { white: 1.0, flicker: 0.5, walk: 0.05, gauss_markov: None },
];

const KNOWN: Noise<'_> = Noise { levels: &NOISE[0], effective_samples: 1e6, coefficients: 0 };

fn rows(n: usize, period_s: f64) -> Recording {
    let columns = vec![("gx_rads".to_owned(), vec![0.0; n])];
    let options = LoadOptions { rate_hz: Some(1.0 / period_s), ..LoadOptions::default() };
    Recording::from_columns(Source::made_by("test"), columns, &options).unwrap()
}

/// A log of noise, a channel, and the prior from a reference log of the same noise.
struct Log {
    means: Vec<f64>,
    channel: Vec<f64>,
    prior: LevelPrior,
}

impl Log {
    fn new(blocks: &Blocks, noise: &NoiseLevels, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let reference = noise.simulate(blocks, &mut random);
        let prior = LevelPrior::of_log(blocks, &reference)
            .learnt(blocks, &reference, &[vec![1.0; blocks.len()]])
            .unwrap();
        let channel = temperature(blocks.len(), &mut random);
        Self { means: noise.simulate(blocks, &mut random), channel, prior }
    }

    fn remainder<'a>(&'a self, blocks: &'a Blocks) -> BlockResidual<'a> {
        BlockResidual { blocks, means: &self.means, prior: &self.prior }
    }
}

/// A random walk plus a sine.
fn temperature(n: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    let (turns, phase) = (random.random_range(0.7..4.0), random.random_range(0.0..std::f64::consts::TAU));
    let mut walk = 0.0;
    let mut next = |i: usize| {
        let step: f64 = StandardNormal.sample(random);
        walk += 0.05 * step;
        walk + (std::f64::consts::TAU * turns * i as f64 / n as f64 + phase).sin()
    };
    (0..n).map(&mut next).collect()
}

/// Returns true if `alarms` of `tried` lies in the central 95 % of a binomial distribution with a rate of 5 %.
fn is_five_percent(alarms: usize, tried: usize) -> bool {
    let nominal = Binomial::new(0.05, tried as u64).unwrap();
    (nominal.inverse_cdf(0.025)..=nominal.inverse_cdf(0.975)).contains(&(alarms as u64))
}

fn count(of: impl Iterator<Item = bool>) -> usize {
    of.filter(|is| *is).count()
}

#[test]
fn false_alarm_rate_of_dependence_is_as_stated() {
    let blocks = Blocks::new(&rows(BLOCKS, BLOCK_S), BLOCK_S, vec![true; BLOCKS]);
    let ones = vec![1.0; BLOCKS];
    let delays = lag::Delays::new(&rows(BLOCKS, BLOCK_S));
    // (curve, lag, curve under white noise, bars that exclude zero, bars)
    let outcomes: Vec<(bool, bool, bool, usize, usize)> = (0..200_u64)
        .into_par_iter()
        .map(|seed| {
            let log = Log::new(&blocks, &NOISE[seed as usize % 2], seed);
            let remainder = log.remainder(&blocks);
            let null = remainder.constant();
            let (curve, fitted) = channel::curve(&remainder, &null, &log.channel).unwrap();
            let profile =
                lag::profile(&remainder, (&null, &fitted.levels), &delays.means(&blocks, &log.channel))
                    .unwrap();
            let bins = channel::bins(&remainder, Noise::of(&curve, &fitted), &log.channel, false).all;
            let beside = count(bins.iter().map(|bin| bin.level.abs() > bin.half_width));
            let spread = fos_fit::signal::variance(&[&log.means]).sqrt();
            let white =
                NoiseLevels { white: spread * BLOCK_S.sqrt(), flicker: 1e-9, walk: 1e-9, gauss_markov: None };
            let columns = channel::natural_curve(&log.channel);
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            let naive = Gls::new(&blocks, &white, &log.means, &[&ones]).gain(&columns).0 > 9.49;
            (curve.p < 0.05, profile.p < 0.05, naive, beside, bins.len())
        })
        .collect();
    let tried = outcomes.len();
    let curves = count(outcomes.iter().map(|outcome| outcome.0));
    let lags = count(outcomes.iter().map(|outcome| outcome.1));
    let naive = count(outcomes.iter().map(|outcome| outcome.2));
    let (beside, bars) = outcomes.iter().fold((0, 0), |sum, o| (sum.0 + o.3, sum.1 + o.4));
    println!(
        "alarms of {tried}: curve {curves}, lag {lags}, white {naive}; bars beside zero {beside} of {bars}"
    );
    assert!(is_five_percent(curves, tried), "{curves} of {tried}");
    // neighbouring delays are strongly correlated, so that Bonferroni's bound is not reached
    assert!(lags <= tried / 20 + 9, "{lags} of {tried}; 9 are three σ");
    // motivation of the test: textbook errors report most of these drifts as a dependence
    assert!(naive > tried / 2, "{naive} of {tried}");
    // bars of one log are correlated, as if there were three independent ones: σ = √(0.05·0.95/1200) = 0.6 %
    let share = beside as f64 / bars as f64;
    assert!((0.03..0.07).contains(&share), "{share}");
}

#[test]
fn finds_dependence_of_five_standard_errors() {
    let blocks = Blocks::new(&rows(BLOCKS, BLOCK_S), BLOCK_S, vec![true; BLOCKS]);
    let ones = vec![1.0; BLOCKS];
    let found: Vec<bool> = (0..100)
        .into_par_iter()
        .map(|seed| {
            let noise = &NOISE[seed as usize % 2];
            let mut log = Log::new(&blocks, noise, 1000 + seed);
            let gls = Gls::new(&blocks, noise, &log.means, &[&ones, &log.channel]);
            let slope = 5.0 * gls.covariance()[(1, 1)].sqrt();
            log.means.iter_mut().zip(&log.channel).for_each(|(mean, channel)| *mean += slope * channel);
            let remainder = log.remainder(&blocks);
            channel::curve(&remainder, &remainder.constant(), &log.channel).unwrap().0.p < 0.05
        })
        .collect();
    let found = count(found.into_iter());
    println!("found {found} of 100");
    assert!(found >= 95, "{found} of 100");
}

#[test]
fn recovers_delay_and_slope() {
    let recording = rows(BLOCKS, BLOCK_S);
    let blocks = Blocks::new(&recording, BLOCK_S, vec![true; BLOCKS]);
    let delays = lag::Delays::new(&recording);
    let mut log = Log::new(&blocks, &NOISE[0], 5);
    let slope = 3.0;
    // a block has one row; this is the delay of 30 s
    let [_, _, _, _, delayed, ..] = delays.means(&blocks, &log.channel);
    log.means.iter_mut().zip(delayed).for_each(|(mean, channel)| *mean += slope * channel);
    let remainder = log.remainder(&blocks);
    let null = remainder.constant();
    let (_, fitted) = channel::curve(&remainder, &null, &log.channel).unwrap();
    let found =
        lag::profile(&remainder, (&null, &fitted.levels), &delays.means(&blocks, &log.channel)).unwrap();
    assert_eq!((found.best_s, found.possible_s), (30.0, (30.0, 30.0)));
    let best = found.delays.iter().find(|delay| delay.delay_s == 30.0).unwrap();
    assert!((best.slope - slope).abs() < 4.0 * best.slope_error, "{best:?}");
    assert!(best.slope_error < 0.2 * slope && found.p < 1e-6, "{found:?}");
}

#[test]
fn hysteresis_separates_rising_and_falling_bins() {
    let blocks = Blocks::new(&rows(BLOCKS, BLOCK_S), BLOCK_S, vec![true; BLOCKS]);
    let mut log = Log::new(&blocks, &NOISE[0], 6);
    log.channel =
        (0..BLOCKS).map(|i| (std::f64::consts::TAU * 3.0 * i as f64 / BLOCKS as f64).sin()).collect();
    for i in 1..BLOCKS {
        log.means[i] += if log.channel[i] > log.channel[i - 1] { 2.0 } else { -2.0 };
    }
    let found = channel::bins(&log.remainder(&blocks), KNOWN, &log.channel, true);
    // 50 each, except for equal values
    assert!(found.all.len() == 12 && found.all.iter().all(|bin| (49..=51).contains(&bin.blocks)));
    // away from the reversals
    for (rising, falling) in found.rising.iter().zip(&found.falling).skip(2).take(8) {
        assert!(
            rising.level - rising.half_width > falling.level + falling.half_width,
            "{rising:?} {falling:?}"
        );
    }
}

#[test]
fn equal_values_share_a_bin() {
    let blocks = Blocks::new(&rows(BLOCKS, BLOCK_S), BLOCK_S, vec![true; BLOCKS]);
    let mut log = Log::new(&blocks, &NOISE[0], 7);
    log.channel = (0..BLOCKS).map(|i| f64::from(u8::from(i % 100 < 40))).collect();
    let remainder = log.remainder(&blocks);
    let bins = channel::bins(&remainder, KNOWN, &log.channel, false).all;
    assert_eq!(
        bins.iter().map(|bin| (bin.channel, bin.blocks)).collect::<Vec<_>>(),
        [(0.0, 360), (1.0, 240)]
    );
    assert_eq!(channel::curve(&remainder, &remainder.constant(), &log.channel).unwrap().0.terms, 1);
    log.channel.fill(21.5);
    let remainder = log.remainder(&blocks);
    assert!(channel::curve(&remainder, &remainder.constant(), &log.channel).is_none());
}

/// 600 s at 10 Hz.
const SAMPLES: usize = 6000;
const PERIOD_S: f64 = 0.1;

/// White noise, and a walk that dominates the lower half of the octaves.
const FAST_NOISE: [NoiseLevels; 2] = [
    NoiseLevels { white: 1.0, flicker: 0.1, walk: 0.01, gauss_markov: None },
    NoiseLevels { white: 1.0, flicker: 0.1, walk: 5.0, gauss_markov: None },
];

#[test]
fn false_alarm_rate_of_power_map_is_as_stated() {
    let recording = rows(SAMPLES, PERIOD_S);
    let blocks = Blocks::new(&recording, PERIOD_S, vec![true; SAMPLES]);
    for noise in &FAST_NOISE {
        let alarms: Vec<bool> = (0..100_u64)
            .into_par_iter()
            .map(|seed| {
                let mut residual = noise.simulate(&blocks, &mut ChaCha8Rng::seed_from_u64(seed));
                // handling, so that pieces of several lengths are combined
                for row in (0..SAMPLES).filter(|row| row % 1000 > 900) {
                    residual[row] = f64::NAN;
                }
                let map = bands::power_map(&recording, 0..SAMPLES, &residual);
                assert!(map.cells.len() >= 80, "{}", map.cells.len());
                !map.worst().is_empty()
            })
            .collect();
        let alarms = count(alarms.into_iter());
        println!("logs with a cell, of 100: {alarms}");
        assert!(is_five_percent(alarms, 100), "{alarms} of 100 under {noise:?}");
    }
}

#[test]
fn finds_time_band_and_power_of_shaking() {
    let recording = rows(SAMPLES, PERIOD_S);
    let blocks = Blocks::new(&recording, PERIOD_S, vec![true; SAMPLES]);
    // white noise of N = 1 has the two-sided density 1: a line of power 24/30 s in one stretch is 25 times as much in
    // its ordinate
    let found: Vec<bool> = (0..100_u64)
        .into_par_iter()
        .map(|seed| {
            let mut residual = FAST_NOISE[0].simulate(&blocks, &mut ChaCha8Rng::seed_from_u64(seed));
            let shaken = 2100..2400;
            for row in shaken {
                // a band of 2.13 Hz about 3.2 Hz holds white noise of power 2·2.13; five times that is added
                residual[row] += (2.0_f64 * 5.0 * 4.27).sqrt()
                    * (std::f64::consts::TAU * 3.2 * row as f64 * PERIOD_S).sin();
            }
            let map = bands::power_map(&recording, 0..SAMPLES, &residual);
            let worst = map.worst();
            worst.first().is_some_and(|cell| {
                (cell.begin_s - 210.0).abs() < 0.2
                    && (cell.end_s - 240.0).abs() < 0.2
                    && (cell.low_hz..cell.high_hz).contains(&3.2)
                    // 6 times; the usual is uncertain by 1.25·√(2/ν)/√20 = 6 %, and the cell itself by √(2/ν) of 1
                    && (4.5..7.5).contains(&cell.times)
            })
        })
        .collect();
    let found = count(found.into_iter());
    println!("found {found} of 100");
    assert!(found >= 95, "{found} of 100");
}

//! White noise N, bias instability B and random walk K of an axis at rest, each with its 90 % interval.
//!
//! Values maximise the restricted likelihood of the block means (of their part orthogonal to the constants). Intervals
//! are those of its profile: every value at which −2 ln L, minimised over the other two, is at most 2.71 above its
//! minimum (χ² with one degree of freedom, 90 %). If that holds down to zero, the process was not detected and only its
//! upper limit is known (95 %).

use serde::Serialize;

use super::blocks::Blocks;
use super::gauss_markov::{GaussMarkovNoise, gauss_markov};
use super::information::{density_slopes, frequencies, seconds_for_walk_within};
pub use super::level::Level;
use super::level::restricted_deviance;
use super::levels::{LevelPrior, LogLevels, Regression, UnknownLevels};
use super::model::NoiseLevels;
use super::profile::{Interval, Profile};

/// Least number of blocks for an estimate of three levels.
pub(super) const FEWEST_BLOCKS: usize = 40;

/// Standard deviation of an uninformative prior, in logarithms.
const UNINFORMATIVE: f64 = 100.0;

/// Largest ratio of a random walk to the lower end of its interval from which a recording time is predicted.
const MAX_WALK_FACTOR: f64 = 3.0;

/// Weight of the lower end of K in the time that is stated: with it nine of ten logs need at most 1.2 times as long.
const CAUTION: f64 = 0.75;

/// Ratio of the ends of an accurate interval to the value.
const ACCURATE: f64 = 1.2;

/// Allan deviation of flicker noise of unit bias instability: √(2 ln 2/π) (IEEE Std 952).
pub const FLICKER_FLOOR: f64 = 0.664_282_9;

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NoiseEstimate {
    /// N, unit·√s, which is unit/√Hz of a two-sided spectrum: the mean over t seconds has variance N²/t.
    pub white: Level,
    /// B, the axis' unit: the Allan deviation is flat at 0.664·B.
    pub flicker: Level,
    /// K, unit/√s, which is unit/s/√Hz: the bias moves by K·√t in t seconds.
    pub walk: Level,
    /// White noise and a Gauss-Markov process, if they describe the axis better than N, B and K do.
    pub gauss_markov: Option<GaussMarkovNoise>,
    /// Time at rest, s, after which the 90 % interval of K is expected to be within ±20 %; nine of ten logs need at most 1.2
    /// times as long. None where it is that narrow already, or the walk not known within a factor of 3.
    pub walk_within_20_percent_s: Option<f64>,
}

/// Estimates the levels from `y`, block means of an axis at rest, and `regressors`, which include a constant.
///
/// # Errors
///
/// There are fewer than 40 blocks, or the means do not change.
pub fn estimate(blocks: &Blocks, y: &[f64], regressors: &[&[f64]]) -> Result<NoiseEstimate, UnknownLevels> {
    if blocks.beyond_levels() < FEWEST_BLOCKS
        || super::gls::dot(y, y).is_nan()
        || is_constant(&blocks.about_levels(y, 0..y.len()))
    {
        return Err(UnknownLevels);
    }
    let start = LevelPrior::of_log(blocks, y).mean;
    let flat = LevelPrior::independent(start, [UNINFORMATIVE; 3]);
    let regression = Regression { blocks, y, regressors, prior: &flat };
    let seconds = blocks.samples() as f64 * blocks.period_s;
    let profile = Profile {
        deviance: |logs: &LogLevels| deviance(&regression, logs),
        slopes: |logs: &LogLevels, frequency_hz: f64| {
            density_slopes(&NoiseLevels::from_logs(logs), frequency_hz)
        },
        frequencies: frequencies(seconds, blocks.length_s),
    };
    // flicker and walk may be mistaken for each other: start with more of either
    let best = profile.best(&[start, [start[0], start[1] - 3.0, start[2] + 2.0]]);
    let intervals = [0, 1, 2].map(|parameter| profile.interval(parameter, &best));
    let level = |parameter: usize| {
        let Interval { low, high, .. } = intervals[parameter];
        Level { value: low.map(|_| best.logs[parameter].exp()), low, high }
    };
    let levels = NoiseEstimate {
        white: level(0),
        flicker: level(1),
        walk: level(2),
        gauss_markov: None,
        walk_within_20_percent_s: seconds_for_accurate_walk(&best.logs, &intervals[2], seconds),
    };
    let gauss_markov = gauss_markov(
        &regression,
        [levels.white, levels.flicker, levels.walk],
        |averaging_s| levels.allan_deviation(averaging_s),
        best.deviance,
    );
    Ok(NoiseEstimate { gauss_markov, ..levels })
}

/// −2 ln L of N, B and K, with flicker noise as fast as the samples.
pub(super) fn deviance(regression: &Regression<'_>, logs: &LogLevels) -> f64 {
    restricted_deviance(regression, regression.blocks.with_faster_flicker(logs.map(f64::exp)))
}

fn is_constant(y: &[f64]) -> bool {
    y.iter().all(|value| *value == y[0])
}

impl NoiseEstimate {
    /// Returns the Allan deviation of such noise at an averaging time, unit: √(N²/τ + (0.664·B)² + K²·τ/3), without
    /// undetected processes.
    pub fn allan_deviation(&self, tau_s: f64) -> f64 {
        let [white, flicker, walk] =
            [self.white, self.flicker, self.walk].map(|level| level.value.unwrap_or(0.0));
        (white * white / tau_s + (FLICKER_FLOOR * flicker).powi(2) + walk * walk * tau_s / 3.0).sqrt()
    }

    /// Returns the length of a log, s, that would show a random walk half as large as the limit from a log of
    /// `seconds`, or halve the limit; none if the walk is known.
    ///
    /// A walk is detected if its Allan deviation exceeds that of the other noise at averaging times up to some share of
    /// the log. The share follows from the limit itself: K²·τ/3 = N²/τ + (0.664·B)², τ = length/share.
    pub fn seconds_for_walk(&self, seconds: f64) -> Option<f64> {
        if self.walk.value.is_some() {
            return None;
        }
        let (white, floor) = (self.white.at_most(), FLICKER_FLOOR * self.flicker.at_most());
        // τ at which a walk equals the other noise: from the quadratic K²·τ²/3 − floor²·τ − N² = 0
        let meets = |walk: f64| {
            let third = walk * walk / 3.0;
            let half = 0.5 * floor * floor;
            (half + (half * half + third * white * white).sqrt()) / third
        };
        Some(seconds * meets(0.5 * self.walk.high) / meets(self.walk.high))
    }
}

/// Returns the time at rest that is stated after `seconds` with these most likely levels. Its logarithm lies between those
/// of the time that these levels need, and of the time for the lower end of K, at which the other levels are those that are
/// most likely there. Where flicker noise was not detected, that is as much of it as may hide the walk.
pub(super) fn seconds_for_accurate_walk(likeliest: &LogLevels, walk: &Interval, seconds: f64) -> Option<f64> {
    let at_low = walk.at_low?;
    let [low, high] = [at_low[2], walk.high.ln()];
    // a walk that was hardly seen is too large on average, and a time based on it too short
    if likeliest[2] - low > MAX_WALK_FACTOR.ln() || high - low < 2.0 * ACCURATE.ln() {
        return None;
    }
    // a walk shows in means over seconds; finer ones add nothing
    let [expected, longer] = [likeliest, &at_low]
        .map(|logs| seconds_for_walk_within(&NoiseLevels::from_logs(logs), ACCURATE, seconds, 1.0));
    Some((expected?.powf(1.0 - CAUTION) * longer?.powf(CAUTION)).max(seconds))
}

//! White noise N, bias instability B and random walk K of an axis at rest, each with its 90 % interval.
//!
//! Values maximise the restricted likelihood of the block means (of their part orthogonal to the constants). Intervals
//! are those of its profile: every value at which −2 ln L, minimised over the other two, is at most 2.71 above its
//! minimum (χ² with one degree of freedom, 90 %). If that holds down to zero, the process was not detected and only its
//! upper limit is known (95 %).

use serde::Serialize;

use super::blocks::Blocks;
use super::gauss_markov::{GaussMarkovNoise, gauss_markov};
use super::information::seconds_for_walk_deviation;
pub use super::level::Level;
use super::level::restricted_deviance;
use super::levels::{LevelPrior, LogLevels, Regression, UnknownLevels};
use super::model::NoiseLevels;
use super::profile::{Interval, Profile, RISE};

/// Least number of blocks for an estimate of three levels.
pub(super) const FEWEST_BLOCKS: usize = 40;

/// Standard deviation of an uninformative prior, in logarithms.
const UNINFORMATIVE: f64 = 100.0;

/// Largest ratio of a random walk to the lower end of its interval from which a recording time is predicted.
const MAX_WALK_FACTOR: f64 = 3.0;

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
    let profile = Profile::new(|logs: &LogLevels| {
        let [white, flicker, walk] = logs.map(f64::exp);
        let (white, faster) = blocks.faster_flicker(white, flicker);
        restricted_deviance(&regression, NoiseLevels { white, flicker, walk, gauss_markov: Some(faster) })
    });
    // flicker and walk may be mistaken for each other: start with more of either
    let best = profile.best(&[start, [start[0], start[1] - 3.0, start[2] + 2.0]]);
    let level = |parameter: usize| {
        let Interval { low, high } = profile.interval(parameter, &best);
        Level { value: low.map(|_| best.logs[parameter].exp()), low, high }
    };
    let levels = NoiseEstimate { white: level(0), flicker: level(1), walk: level(2), gauss_markov: None };
    let gauss_markov = gauss_markov(
        &regression,
        [levels.white, levels.flicker, levels.walk],
        |averaging_s| levels.allan_deviation(averaging_s),
        best.deviance,
    );
    Ok(NoiseEstimate { gauss_markov, ..levels })
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

    /// Time at rest, s, after which the 90 % interval of a random walk is expected to be ±20 %; none where the walk is not
    /// known within a factor of 3, or where `seconds` at rest suffice.
    pub(super) fn seconds_for_accurate_walk(&self, seconds: f64) -> Option<f64> {
        // a walk that was hardly seen is too large on average, and a time based on it too short
        let walk = self.walk.value.zip(self.walk.low).filter(|(walk, low)| *walk < MAX_WALK_FACTOR * low)?.0;
        // flicker that was not seen may still hide the walk
        let [white, flicker] = [self.white.at_most(), self.flicker.at_most()];
        let levels = NoiseLevels { white, flicker, walk, gauss_markov: None };
        let deviation = 1.2_f64.ln() / RISE.sqrt();
        // a walk shows in means over seconds; finer ones add nothing
        let needed = seconds_for_walk_deviation(&levels, deviation, 1.0)?;
        (needed > seconds).then_some(needed)
    }
}

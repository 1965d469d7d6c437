//! White noise N, bias instability B and random walk K of an axis at rest, each with its 90 % interval.
//!
//! Values maximise the restricted likelihood of the block means (of their part orthogonal to the constants). Intervals
//! are those of its profile: every value at which −2 ln L, minimised over the other two, is at most 2.71 above its
//! minimum (χ² with one degree of freedom, 90 %). If that holds down to zero, the process was not detected and only its
//! upper limit is known (95 %).

use serde::Serialize;

use super::blocks::Blocks;
use super::information::seconds_for_walk_deviation;
use super::levels::{LevelPrior, LogLevels, Regression, UnknownLevels, minimise};
use super::model::NoiseLevels;

/// Increase of −2 ln L at the ends of an interval: the 90 % quantile of χ² with one degree of freedom.
const RISE: f64 = 2.705_543;

/// Least number of blocks for an estimate of three levels.
pub(super) const FEWEST_BLOCKS: usize = 40;

/// Distance below the estimate, in logarithms, at which a process counts as absent: if the profile is within [`RISE`]
/// there, the process was not detected.
const ABSENT_BELOW: f64 = 12.0;

/// Largest distance of an interval's end from the value, in logarithms.
const MAX_DISTANCE: f64 = 16.0;

/// Accuracy of an interval's end, in its logarithm.
const EXACT: f64 = 0.005;

/// Second derivative of −2 ln L that the search expects, of a level known to 20 %; and the longest unit of its steps.
const USUAL_CURVATURE: f64 = 50.0;
const LONGEST_UNIT: f64 = 6.0;

/// Standard deviation of an uninformative prior, in logarithms.
const UNINFORMATIVE: f64 = 100.0;

/// Largest ratio of a random walk to the lower end of its interval from which a recording time is predicted.
const MAX_WALK_FACTOR: f64 = 3.0;

/// Allan deviation of flicker noise of unit bias instability: √(2 ln 2/π) (IEEE Std 952).
pub const FLICKER_FLOOR: f64 = 0.664_282_9;

/// Estimate of one level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Level {
    /// Most likely value; none if the interval includes zero.
    pub value: Option<f64>,
    /// Lower end of the 90 % interval; none if it includes zero.
    pub low: Option<f64>,
    /// Upper end of the 90 % interval, which is also the 95 % limit if there is no lower end.
    pub high: f64,
}

impl Level {
    /// Returns the value, or its upper limit if there is none.
    pub fn at_most(&self) -> f64 {
        self.value.unwrap_or(self.high)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NoiseEstimate {
    /// N, unit·√s, which is unit/√Hz of a two-sided spectrum: the mean over t seconds has variance N²/t.
    pub white: Level,
    /// B, the axis' unit: the Allan deviation is flat at 0.664·B.
    pub flicker: Level,
    /// K, unit/√s, which is unit/s/√Hz: the bias moves by K·√t in t seconds.
    pub walk: Level,
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
    let likelihood = Likelihood { regression: Regression { blocks, y, regressors, prior: &flat } };
    let best = likelihood.best(start);
    Ok(NoiseEstimate {
        white: likelihood.level(0, &best),
        flicker: likelihood.level(1, &best),
        walk: likelihood.level(2, &best),
    })
}

fn is_constant(y: &[f64]) -> bool {
    y.iter().all(|value| *value == y[0])
}

/// −2 ln L as a function of ln N, ln B, ln K.
struct Likelihood<'a> {
    regression: Regression<'a>,
}

/// Position of the minimum, and step sizes for the search around it.
struct Best {
    logs: LogLevels,
    deviance: f64,
    units: LogLevels,
}

impl Likelihood<'_> {
    fn at(&self, logs: &LogLevels) -> f64 {
        let [white, flicker, walk] = logs.map(f64::exp);
        // flicker noise below the shortest time constant of the ladder: Σ 3^(−k) of processes of variance B²·ln 3/π and
        // density 2·variance·τ, which is white in the blocks but not part of N
        let faster =
            3.0_f64.ln() / std::f64::consts::PI * flicker * flicker * self.regression.blocks.flicker_from_s;
        let white = (white * white + faster).sqrt();
        let levels = NoiseLevels { white, flicker, walk, gauss_markov: None };
        let gls = self.regression.at(levels).gls;
        gls.deviance() + gls.log_determinant_of_information()
    }

    fn best(&self, start: LogLevels) -> Best {
        // flicker and walk may be mistaken for each other: start with more of either
        let starts = [start, [start[0], start[1] - 3.0, start[2] + 2.0]];
        let found = starts.map(|start| minimise(start, |logs| self.at(logs)));
        let (logs, _) = found.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("there are two");
        let units = self.units(&logs);
        let (logs, deviance) = minimise_in(&units, logs, |logs| self.at(logs));
        Best { logs, deviance, units: self.units(&logs) }
    }

    /// Step sizes of the search: a poorly determined level needs long steps.
    fn units(&self, logs: &LogLevels) -> LogLevels {
        const STEP: f64 = 0.1;
        let middle = self.at(logs);
        std::array::from_fn(|level| {
            let moved = |by: f64| {
                let mut logs = *logs;
                logs[level] += by;
                self.at(&logs)
            };
            let curvature = (moved(STEP) - 2.0 * middle + moved(-STEP)) / (STEP * STEP);
            (USUAL_CURVATURE / curvature.max(f64::MIN_POSITIVE)).sqrt().clamp(0.5, LONGEST_UNIT)
        })
    }

    /// Returns −2 ln L at a value of one level, minimised over the other two, starting from `others`.
    fn profile(&self, level: usize, log: f64, others: &mut [f64; 2], units: &LogLevels) -> f64 {
        let with = |others: &[f64; 2]| {
            let mut logs = [log; 3];
            for (index, other) in (0..3).filter(|index| *index != level).zip(others) {
                logs[index] = *other;
            }
            logs
        };
        let units = without(level, units);
        let (place, deviance) = minimise_in(&units, *others, |others| self.at(&with(others)));
        *others = place;
        deviance
    }

    fn level(&self, level: usize, best: &Best) -> Level {
        let others = without(level, &best.logs);
        let centre = best.logs[level];
        let rise = |log: f64, others: &mut [f64; 2]| {
            self.profile(level, log, others, &best.units) - best.deviance - RISE
        };
        let end = |direction: f64| -> Option<f64> {
            let mut others = others;
            let (mut inside, mut step) = (centre, 0.05);
            let mut below = -RISE;
            // terminates: the step doubles
            let (mut outside, mut above) = loop {
                let log = inside + direction * step;
                if (log - centre).abs() > MAX_DISTANCE {
                    return None;
                }
                let there = rise(log, &mut others);
                if there > 0.0 {
                    break (log, there);
                }
                (inside, below) = (log, there);
                step *= 2.0;
            };
            // terminates: the bracket shrinks by at least a tenth
            while (outside - inside).abs() > EXACT {
                let share = (-below / (above - below)).clamp(0.1, 0.9);
                let log = inside + share * (outside - inside);
                match rise(log, &mut others) {
                    there if there > 0.0 => (outside, above) = (log, there),
                    there => (inside, below) = (log, there),
                }
            }
            Some(0.5 * (inside + outside))
        };
        let high = end(1.0).unwrap_or(centre + MAX_DISTANCE).exp();
        let may_be_none = self.profile(level, centre - ABSENT_BELOW, &mut others.clone(), &best.units)
            - best.deviance
            <= RISE;
        if may_be_none {
            return Level { value: None, low: None, high };
        }
        Level { value: Some(centre.exp()), low: end(-1.0).map(f64::exp), high }
    }
}

fn without(level: usize, levels: &LogLevels) -> [f64; 2] {
    match level {
        0 => [levels[1], levels[2]],
        1 => [levels[0], levels[2]],
        _ => [levels[0], levels[1]],
    }
}

/// Runs [`minimise`] in units of these step sizes.
fn minimise_in<const D: usize>(
    units: &[f64; D],
    start: [f64; D],
    f: impl Fn(&[f64; D]) -> f64,
) -> ([f64; D], f64) {
    let whole = |scaled: &[f64; D]| std::array::from_fn(|i| units[i] * scaled[i]);
    let (place, least) = minimise(std::array::from_fn(|i| start[i] / units[i]), |scaled| f(&whole(scaled)));
    (whole(&place), least)
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

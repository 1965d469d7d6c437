//! Estimation of noise levels: the most probable ones under a prior.

use std::cmp::Ordering;

use nalgebra::Matrix3;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use super::blocks::Blocks;
use super::gls::Gls;
use super::model::{GaussMarkov, NoiseLevels};

/// Natural logarithms of white, flicker and walk.
pub type LogLevels = [f64; 3];

/// Prior of noise levels: a normal distribution of their logarithms, except for the random walk.
///
/// A reference log hardly constrains a random walk too small to be detected in it, and excludes one too large: the
/// logarithm of its likelihood is flat below and steep above, unlike a normal distribution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LevelPrior {
    /// Means of the logarithms.
    pub mean: LogLevels,
    /// Inverse of the covariance of the logarithms.
    pub precision: [[f64; 3]; 3],
    /// −2 ln of the reference log's likelihood, minimised over the other levels, for walks of e^(k/2) times the mean, k
    /// = 1, 2, …; none without a reference log.
    pub random_walk_likelihood: Option<[f64; WALK_VALUES]>,
}

/// Number of values of the random-walk likelihood, and their distance in the logarithm of the walk.
const WALK_VALUES: usize = 8;
const WALK_STEP: f64 = 0.5;

/// Noise levels fitted to data together with a regression.
#[derive(Debug, Clone)]
pub struct Fitted {
    pub levels: NoiseLevels,
    /// Regression under these levels.
    pub gls: Gls,
    /// −2 ln of likelihood times prior density, up to a constant that depends on neither regressors nor levels.
    pub deviance: f64,
}

/// Largest distance of an optimum, in logarithms: a factor of 150.
const REACH: f64 = 5.0;

/// Step of the numerical derivatives, in logarithms: the deviance is smooth, and a change of 1 % in a level changes it
/// by less than 1 and by far more than rounding.
const STEP: f64 = 0.02;

/// Ratio of the width of the proposal distribution to that of the posterior.
const WIDER: f64 = 1.3;

/// Largest number of restarts of the search at its end point, and the least improvement that justifies one.
const MAX_RESTARTS: usize = 4;
const RESTARTED: f64 = 0.1;

const MAX_ROUNDS: usize = 20;
const DONE: f64 = 0.005;

impl LevelPrior {
    /// Returns a prior of independent logarithms with these standard deviations.
    pub fn independent(mean: LogLevels, deviations: [f64; 3]) -> Self {
        Self {
            mean,
            precision: diagonal(deviations.map(|deviation| deviation.powi(-2))),
            random_walk_likelihood: None,
        }
    }

    /// Returns −2 ln of the density, up to a constant.
    pub fn deviance(&self, levels: &LogLevels) -> f64 {
        let mut off: Vec<f64> = levels.iter().zip(&self.mean).map(|(level, mean)| level - mean).collect();
        let mut walled = 0.0;
        if let Some(random_walk_likelihood) = &self.random_walk_likelihood
            && off[2] > 0.0
        {
            walled = at_walk(random_walk_likelihood, off[2]);
            off[2] = 0.0;
        }
        let quadratic: f64 = (0..3)
            .flat_map(|i| (0..3).map(move |j| (i, j)))
            .map(|(i, j)| off[i] * self.precision[i][j] * off[j])
            .sum();
        quadratic + walled
    }

    /// Returns the prior with the covariance widened by these variances, since levels differ slightly between logs.
    pub fn widened(&self, variances: [f64; 3]) -> Result<Self, UnknownLevels> {
        let wider = self.covariance()? + Matrix3::from_diagonal(&variances.into());
        Ok(Self { precision: rows_of(&inverse(wider)?), ..*self })
    }

    /// Returns the prior without its information on the random walk, except for a wide scale of `deviation`.
    pub fn with_free_walk(&self, deviation: f64) -> Result<Self, UnknownLevels> {
        let mut freed = self.covariance()?;
        for i in 0..2 {
            freed[(i, 2)] = 0.0;
            freed[(2, i)] = 0.0;
        }
        freed[(2, 2)] = deviation * deviation;
        Ok(Self { precision: rows_of(&inverse(freed)?), random_walk_likelihood: None, ..*self })
    }

    /// Covariance of the logarithms.
    fn covariance(&self) -> Result<Matrix3<f64>, UnknownLevels> {
        inverse(Matrix3::from_fn(|i, j| self.precision[i][j]))
    }
}

/// The levels are not identifiable: the precision of their logarithms is not positive definite, for example because
/// data are not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the noise levels are not identifiable from this log: the precision of their logarithms is not positive definite\nhelp: use a longer log at rest, without outliers"
)]
pub struct UnknownLevels;

/// Inverse of a positive definite matrix, by its Cholesky factor.
fn inverse(matrix: Matrix3<f64>) -> Result<Matrix3<f64>, UnknownLevels> {
    Ok(matrix.cholesky().ok_or(UnknownLevels)?.inverse())
}

fn rows_of(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
}

impl NoiseLevels {
    /// Returns the levels for these logarithms, without a further process.
    pub fn from_logs(logs: &LogLevels) -> Self {
        Self { white: logs[0].exp(), flicker: logs[1].exp(), walk: logs[2].exp(), gauss_markov: None }
    }

    pub fn logs(&self) -> LogLevels {
        [self.white.ln(), self.flicker.ln(), self.walk.ln()]
    }
}

/// A regression of block means, with everything that does not depend on the noise levels.
#[derive(Debug, Clone, Copy)]
pub struct Regression<'a> {
    /// Blocks of equal length; those with too few data are excluded.
    pub blocks: &'a Blocks,
    pub y: &'a [f64],
    pub regressors: &'a [&'a [f64]],
    /// Prior of the levels.
    pub prior: &'a LevelPrior,
}

impl Regression<'_> {
    pub fn at(&self, levels: NoiseLevels) -> Fitted {
        let gls = Gls::new(self.blocks, &levels, self.y, self.regressors);
        let deviance = gls.deviance() + self.prior.deviance(&levels.logs());
        Fitted { levels, gls, deviance }
    }

    /// Fits the most probable levels, starting from `start`; a further Gauss-Markov process is held fixed.
    pub fn fit(&self, start: NoiseLevels) -> Fitted {
        let extra = start.gauss_markov;
        let at = |logs: &LogLevels| {
            self.at(NoiseLevels { gauss_markov: extra, ..NoiseLevels::from_logs(logs) }).deviance
        };
        let (mut logs, mut deviance) = minimise(start.logs(), at);
        // an effect that is not in the model yet may have to be fitted as noise far from the start
        for _ in 0..MAX_RESTARTS {
            let (next, there) = minimise(logs, at);
            let gained = deviance - there;
            (logs, deviance) = (next, there);
            if gained < RESTARTED {
                break;
            }
        }
        self.at(NoiseLevels { gauss_markov: extra, ..NoiseLevels::from_logs(&logs) })
    }

    /// Fits the levels with a further Gauss-Markov process of unknown size and correlation time, starting from `start`.
    pub fn fit_gauss_markov(&self, levels: NoiseLevels, start: GaussMarkov) -> Fitted {
        let with = |logs: &[f64; 5]| NoiseLevels {
            gauss_markov: Some(GaussMarkov { deviation: logs[3].exp(), tau_s: logs[4].exp() }),
            ..NoiseLevels::from_logs(&[logs[0], logs[1], logs[2]])
        };
        let [white, flicker, walk] = levels.logs();
        let start = [white, flicker, walk, start.deviation.ln(), start.tau_s.ln()];
        let (logs, _) = minimise(start, |logs| self.at(with(logs)).deviance);
        self.at(with(&logs))
    }

    /// Returns the posterior of the levels: normal about the optimum, with the curvature there (Laplace).
    pub fn posterior(&self, fitted: &Fitted) -> LevelPrior {
        let centre = fitted.levels.logs();
        let hessian = hessian(centre, |logs| {
            let levels =
                NoiseLevels { gauss_markov: fitted.levels.gauss_markov, ..NoiseLevels::from_logs(logs) };
            self.at(levels).deviance
        });
        // −2 ln density = offᵀ·precision·off
        let precision = hessian.map(|row| row.map(|entry| entry / 2.0));
        Self::made_positive(LevelPrior { mean: centre, precision, random_walk_likelihood: None }, self.prior)
    }

    /// Draws levels from their posterior: from the normal distribution about the optimum, resampled with weights from
    /// the deviance (Rubin 1988), because the logarithm of an undetected walk is not normal.
    pub fn draws(
        &self,
        fitted: &Fitted,
        count: usize,
        random: &mut impl Rng,
    ) -> Result<Vec<NoiseLevels>, UnknownLevels> {
        let posterior = self.posterior(fitted);
        let factor = WIDER * posterior.covariance()?.cholesky().ok_or(UnknownLevels)?.l();
        let proposals: Vec<(NoiseLevels, f64)> = (0..count)
            .map(|_| {
                let unit = nalgebra::Vector3::from_fn(|_, _| -> f64 { StandardNormal.sample(random) });
                let off = factor * unit;
                let logs = std::array::from_fn(|i| posterior.mean[i] + off[i]);
                let levels =
                    NoiseLevels { gauss_markov: fitted.levels.gauss_markov, ..NoiseLevels::from_logs(&logs) };
                let deviance = self.at(levels).deviance - fitted.deviance;
                (levels, (-0.5 * (deviance - unit.norm_squared())).exp())
            })
            .collect();
        let total: f64 = proposals.iter().map(|(_, weight)| weight).sum();
        if !total.is_finite() || total <= 0.0 {
            return Ok(vec![fitted.levels; count]);
        }
        // systematic resampling: every proposal as often as its weight, to within one
        let mut next = random.random_range(0.0..1.0) * total / count as f64;
        let (mut sum, mut drawn) = (0.0, Vec::with_capacity(count));
        for (levels, weight) in proposals {
            sum += weight;
            while drawn.len() < count && next < sum {
                drawn.push(levels);
                next += total / count as f64;
            }
        }
        drawn.resize(count, fitted.levels);
        Ok(drawn)
    }

    /// Returns −2 ln of likelihood and prior, relative to `fitted`, for walks above the fitted one, minimised over the
    /// other levels.
    pub fn random_walk_likelihood(&self, fitted: &Fitted) -> [f64; WALK_VALUES] {
        let [white, flicker, walk] = fitted.levels.logs();
        let mut start = [white, flicker];
        std::array::from_fn(|k| {
            let above = walk + WALK_STEP * (k + 1) as f64;
            let (place, deviance) = minimise(start, |[white, flicker]| {
                self.at(NoiseLevels::from_logs(&[*white, *flicker, above])).deviance
            });
            start = place;
            (deviance - fitted.deviance).max(0.0)
        })
    }

    /// A level that the data do not determine has no curvature; that of the prior is then the minimum.
    fn made_positive(mut posterior: LevelPrior, prior: &LevelPrior) -> LevelPrior {
        let matrix = Matrix3::from_fn(|i, j| posterior.precision[i][j]);
        if matrix.cholesky().is_none() {
            let least = |i: usize| posterior.precision[i][i].max(prior.precision[i][i]);
            posterior.precision = diagonal(std::array::from_fn(least));
        }
        posterior
    }
}

fn diagonal(entries: [f64; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { entries[i] } else { 0.0 }))
}

/// Interpolates the random-walk likelihood, and continues it beyond its end with the last slope.
fn at_walk(random_walk_likelihood: &[f64; WALK_VALUES], above: f64) -> f64 {
    let place = above / WALK_STEP;
    let next = (place as usize).min(WALK_VALUES - 1);
    let before = if next == 0 { 0.0 } else { random_walk_likelihood[next - 1] };
    before + (place - next as f64) * (random_walk_likelihood[next] - before)
}

/// Second derivatives of a function of logarithms, from differences over 0.1.
fn hessian<const D: usize>(centre: [f64; D], f: impl Fn(&[f64; D]) -> f64) -> [[f64; D]; D] {
    let step = 5.0 * STEP;
    let at = |moves: &[(usize, f64)]| {
        let mut place = centre;
        moves.iter().for_each(|(i, by)| place[*i] += by * step);
        f(&place)
    };
    let middle = at(&[]);
    let own = |i: usize| (at(&[(i, 1.0)]) - 2.0 * middle + at(&[(i, -1.0)])) / (step * step);
    let mixed = |i: usize, j: usize| {
        let corner = |a: f64, b: f64| at(&[(i, a), (j, b)]);
        (corner(1.0, 1.0) - corner(1.0, -1.0) - corner(-1.0, 1.0) + corner(-1.0, -1.0)) / (4.0 * step * step)
    };
    let lower: [[f64; D]; D] = std::array::from_fn(|i| {
        std::array::from_fn(|j| match i.cmp(&j) {
            Ordering::Equal => own(i),
            Ordering::Greater => mixed(i, j),
            Ordering::Less => 0.0,
        })
    });
    std::array::from_fn(|i| std::array::from_fn(|j| lower[i.max(j)][i.min(j)]))
}

/// Minimises a smooth function of a few logarithms near `start`.
pub fn minimise<const D: usize>(start: [f64; D], f: impl Fn(&[f64; D]) -> f64) -> ([f64; D], f64) {
    // a level known to 20 % has curvature 2/0.2²
    let usual = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 0.02 } else { 0.0 }));
    minimise_from(start, usual, 0.0, f)
}

/// Minimises a smooth function of a few logarithms near `start`: BFGS (Nocedal and Wright 2006, eq. 6.17) with numerical
/// derivatives, steps of at most 1, and `inverse` as the inverse of the second derivatives at first. Ends where a step
/// gains less than `enough`.
pub(super) fn minimise_from<const D: usize>(
    start: [f64; D],
    mut inverse: [[f64; D]; D],
    enough: f64,
    f: impl Fn(&[f64; D]) -> f64,
) -> ([f64; D], f64) {
    let gradient = |place: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|i| {
            let (mut up, mut down) = (*place, *place);
            up[i] += STEP;
            down[i] -= STEP;
            (f(&up) - f(&down)) / (2.0 * STEP)
        })
    };
    let mut place = start;
    let mut value = f(&place);
    let mut slope = gradient(&place);
    // terminates after MAX_ROUNDS; in each the value decreases (Armijo), or the search ends
    for _ in 0..MAX_ROUNDS {
        fos_data::interrupt::check();
        let mut step: [f64; D] =
            std::array::from_fn(|i| -(0..D).map(|j| inverse[i][j] * slope[j]).sum::<f64>());
        let longest = step.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
        if longest > 1.0 {
            step.iter_mut().for_each(|s| *s /= longest);
        }
        let expected: f64 = step.iter().zip(&slope).map(|(s, g)| s * g).sum();
        if expected.abs() < DONE.max(enough) {
            break;
        }
        let mut share = 1.0;
        // terminates: four shares are tried
        let moved = loop {
            let next: [f64; D] = std::array::from_fn(|i| {
                (place[i] + share * step[i]).clamp(start[i] - REACH, start[i] + REACH)
            });
            let there = f(&next);
            if there < value + 1e-4 * share * expected {
                break Some((next, there));
            }
            share *= 0.3;
            if share < 0.02 {
                break None;
            }
        };
        let Some((next, there)) = moved else { break };
        if value - there < enough {
            return (next, there);
        }
        let new_slope = gradient(&next);
        let s: [f64; D] = std::array::from_fn(|i| next[i] - place[i]);
        let y: [f64; D] = std::array::from_fn(|i| new_slope[i] - slope[i]);
        let sy: f64 = s.iter().zip(&y).map(|(s, y)| s * y).sum();
        if sy > 1e-9 {
            inverse = bfgs_update(&inverse, &s, &y, sy);
        }
        (place, value, slope) = (next, there, new_slope);
    }
    (place, value)
}

/// (I − s yᵀ/yᵀs)·H·(I − y sᵀ/yᵀs) + s sᵀ/yᵀs.
fn bfgs_update<const D: usize>(h: &[[f64; D]; D], s: &[f64; D], y: &[f64; D], sy: f64) -> [[f64; D]; D] {
    let hy: [f64; D] = std::array::from_fn(|i| (0..D).map(|j| h[i][j] * y[j]).sum());
    let yhy: f64 = y.iter().zip(&hy).map(|(y, hy)| y * hy).sum();
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            h[i][j] + (1.0 + yhy / sy) * s[i] * s[j] / sy - (s[i] * hy[j] + hy[i] * s[j]) / sy
        })
    })
}

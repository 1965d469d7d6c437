//! Noise levels from data: the most probable ones, given what was known before.

use serde::{Deserialize, Serialize};

use super::blocks::Blocks;
use super::gls::Gls;
use super::noise::{GaussMarkov, NoiseLevels};

/// Natural logarithms of white, flicker and walk.
pub type LogLevels = [f64; 3];

/// What is known of noise levels before the data: a normal distribution of their logarithms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LevelPrior {
    /// Means of the logarithms.
    pub mean: LogLevels,
    /// Inverse of their covariance.
    pub precision: [[f64; 3]; 3],
}

/// Noise levels fitted to data together with a regression.
#[derive(Debug, Clone)]
pub(crate) struct Fitted {
    /// The levels.
    pub(crate) levels: NoiseLevels,
    /// The regression under them.
    pub(crate) gls: Gls,
    /// −2 ln of likelihood times prior density, up to a constant that depends on neither regressors nor levels.
    pub(crate) deviance: f64,
}

/// How far an optimum is looked for, in logarithms: a factor of 150.
const REACH: f64 = 5.0;

/// Step of the numerical derivatives, in logarithms: the deviance is smooth, and a change of 1 % in a level moves it by
/// less than 1 and far more than rounding.
const STEP: f64 = 0.02;

const MAX_ROUNDS: usize = 8;
const DONE: f64 = 0.02;

impl LevelPrior {
    /// Independent logarithms with these standard deviations.
    pub fn independent(mean: LogLevels, deviations: [f64; 3]) -> Self {
        let mut precision = [[0.0; 3]; 3];
        for i in 0..3 {
            precision[i][i] = 1.0 / (deviations[i] * deviations[i]);
        }
        Self { mean, precision }
    }

    /// −2 ln of the density, up to a constant.
    pub fn deviance(&self, levels: &LogLevels) -> f64 {
        let off: Vec<f64> = levels.iter().zip(&self.mean).map(|(level, mean)| level - mean).collect();
        (0..3)
            .flat_map(|i| (0..3).map(move |j| (i, j)))
            .map(|(i, j)| off[i] * self.precision[i][j] * off[j])
            .sum()
    }

    /// The same with the covariance widened by these variances: levels are not quite the same in another log.
    pub fn widened(&self, variances: [f64; 3]) -> Self {
        let precision = nalgebra::Matrix3::from_fn(|i, j| self.precision[i][j]);
        let covariance = precision.try_inverse().unwrap_or_else(nalgebra::Matrix3::identity);
        let wider = covariance + nalgebra::Matrix3::from_diagonal(&variances.into());
        let precision = wider.try_inverse().unwrap_or(precision);
        Self {
            mean: self.mean,
            precision: std::array::from_fn(|i| std::array::from_fn(|j| precision[(i, j)])),
        }
    }

    /// The prior without what it says of the random walk, but for a very wide scale about `walk`.
    pub fn with_free_walk(&self, deviation: f64) -> Self {
        let precision = nalgebra::Matrix3::from_fn(|i, j| self.precision[i][j]);
        let covariance = precision.try_inverse().unwrap_or_else(nalgebra::Matrix3::identity);
        let mut freed = covariance;
        for i in 0..2 {
            freed[(i, 2)] = 0.0;
            freed[(2, i)] = 0.0;
        }
        freed[(2, 2)] = deviation * deviation;
        let precision = freed.try_inverse().unwrap_or(precision);
        Self {
            mean: self.mean,
            precision: std::array::from_fn(|i| std::array::from_fn(|j| precision[(i, j)])),
        }
    }
}

impl NoiseLevels {
    /// From logarithms, without a further process.
    pub fn from_logs(logs: &LogLevels) -> Self {
        Self { white: logs[0].exp(), flicker: logs[1].exp(), walk: logs[2].exp(), gauss_markov: None }
    }

    /// Logarithms.
    pub fn logs(&self) -> LogLevels {
        [self.white.ln(), self.flicker.ln(), self.walk.ln()]
    }
}

/// A regression of block means with everything that does not change from one set of noise levels to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Regression<'a> {
    /// The blocks.
    pub(crate) blocks: &'a Blocks,
    /// The output.
    pub(crate) y: &'a [f64],
    /// The regressors.
    pub(crate) regressors: &'a [&'a [f64]],
    /// What is known of the levels.
    pub(crate) prior: &'a LevelPrior,
}

impl Regression<'_> {
    /// Under given levels.
    pub(super) fn at(&self, levels: NoiseLevels) -> Fitted {
        let gls = Gls::new(self.blocks, &levels, self.y, self.regressors);
        let deviance = gls.deviance() + self.prior.deviance(&levels.logs());
        Fitted { levels, gls, deviance }
    }

    /// Under the most probable levels, looked for from `start`; a further Gauss-Markov process stays as it is.
    pub(crate) fn fit(&self, start: NoiseLevels) -> Fitted {
        let extra = start.gauss_markov;
        let at = |logs: &LogLevels| {
            self.at(NoiseLevels { gauss_markov: extra, ..NoiseLevels::from_logs(logs) }).deviance
        };
        let (logs, _) = minimise(start.logs(), at);
        self.at(NoiseLevels { gauss_markov: extra, ..NoiseLevels::from_logs(&logs) })
    }

    /// The same with a further Gauss-Markov process of unknown size and correlation time, from `start` of it.
    pub(super) fn fit_gauss_markov(&self, levels: NoiseLevels, start: GaussMarkov) -> Fitted {
        let with = |logs: &[f64; 5]| NoiseLevels {
            gauss_markov: Some(GaussMarkov { deviation: logs[3].exp(), tau_s: logs[4].exp() }),
            ..NoiseLevels::from_logs(&[logs[0], logs[1], logs[2]])
        };
        let [white, flicker, walk] = levels.logs();
        let start = [white, flicker, walk, start.deviation.ln(), start.tau_s.ln()];
        let (logs, _) = minimise(start, |logs| self.at(with(logs)).deviance);
        self.at(with(&logs))
    }

    /// What the data and the prior together say of the levels: normal about the optimum, with the curvature there
    /// (Laplace).
    pub(crate) fn posterior(&self, fitted: &Fitted) -> LevelPrior {
        let centre = fitted.levels.logs();
        let hessian = hessian(centre, |logs| {
            let levels =
                NoiseLevels { gauss_markov: fitted.levels.gauss_markov, ..NoiseLevels::from_logs(logs) };
            self.at(levels).deviance
        });
        // −2 ln density = offᵀ·precision·off
        let mut precision = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                precision[i][j] = hessian[i][j] / 2.0;
            }
        }
        Self::made_positive(LevelPrior { mean: centre, precision }, self.prior)
    }

    /// A level that the data say nothing of has no curvature; the prior's is then the least.
    fn made_positive(mut posterior: LevelPrior, prior: &LevelPrior) -> LevelPrior {
        let matrix = nalgebra::Matrix3::from_fn(|i, j| posterior.precision[i][j]);
        if matrix.cholesky().is_none() {
            let mut diagonal = [[0.0; 3]; 3];
            for i in 0..3 {
                diagonal[i][i] = posterior.precision[i][i].max(prior.precision[i][i]);
            }
            posterior.precision = diagonal;
        }
        posterior
    }
}

fn hessian<const D: usize>(centre: [f64; D], f: impl Fn(&[f64; D]) -> f64) -> [[f64; D]; D] {
    let step = 5.0 * STEP;
    let at = |moves: &[(usize, f64)]| {
        let mut place = centre;
        moves.iter().for_each(|(i, by)| place[*i] += by * step);
        f(&place)
    };
    let middle = at(&[]);
    let mut hessian = [[0.0; D]; D];
    for i in 0..D {
        hessian[i][i] = (at(&[(i, 1.0)]) - 2.0 * middle + at(&[(i, -1.0)])) / (step * step);
        for j in 0..i {
            let mixed = at(&[(i, 1.0), (j, 1.0)]) - at(&[(i, 1.0), (j, -1.0)]) - at(&[(i, -1.0), (j, 1.0)])
                + at(&[(i, -1.0), (j, -1.0)]);
            hessian[i][j] = mixed / (4.0 * step * step);
            hessian[j][i] = hessian[i][j];
        }
    }
    hessian
}

/// The least value of a smooth function of a few logarithms, near `start`: BFGS (Nocedal and Wright 2006, eq. 6.17) with
/// numerical derivatives and steps of at most 1.
fn minimise<const D: usize>(start: [f64; D], f: impl Fn(&[f64; D]) -> f64) -> ([f64; D], f64) {
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
    // a level known to 20 % has curvature 2/0.2²
    let mut inverse: [[f64; D]; D] =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 0.02 } else { 0.0 }));
    for _ in 0..MAX_ROUNDS {
        let mut step: [f64; D] =
            std::array::from_fn(|i| -(0..D).map(|j| inverse[i][j] * slope[j]).sum::<f64>());
        let longest = step.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
        if longest > 1.0 {
            step.iter_mut().for_each(|s| *s /= longest);
        }
        let expected: f64 = step.iter().zip(&slope).map(|(s, g)| s * g).sum();
        if expected.abs() < DONE {
            break;
        }
        let mut share = 1.0;
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

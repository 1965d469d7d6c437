//! Noise of an inertial sensor at rest: white, flicker (bias instability) and random walk; and whitening.
//!
//! Flicker noise is modelled as a sum of Gauss-Markov processes with time constants in powers of three (Barnes and
//! Allan 1966 approximate 1/f by such ladders). With variance B²·ln 3/π each, the sum has the one-sided spectrum
//! B²/(πf) that IEEE Std 952 calls bias instability B, and the Allan deviation is flat at 0.664 B. The whole noise is
//! then a state-space model with a diagonal transition, and a Kalman filter whitens n blocks in O(n): its normalised
//! innovations are the whitened data, and the product of their variances is exactly the determinant of the covariance.

use pulp::{Arch, Simd, WithSimd};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use super::blocks::Blocks;

/// Rungs of the flicker ladder: 3⁷ = 2187 times the shortest, beyond most logs.
const RUNGS: usize = 8;

/// Rungs below the ladder that count as white noise: the next would add 10⁻⁵ of their sum.
const FASTER_RUNGS: i32 = 10;

/// States: the ladder, the random walk, one further Gauss-Markov process.
const STATES: usize = RUNGS + 2;

/// Noise levels of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct NoiseLevels {
    /// White noise (angle or velocity random walk coefficient N), unit·√s: its mean over t seconds has variance N²/t.
    pub white: f64,
    /// Flicker noise: bias instability B, the axis' unit.
    pub flicker: f64,
    /// Random walk of the bias (rate random walk coefficient K), unit/√s.
    pub walk: f64,
    /// A further Gauss-Markov process in addition to those of the flicker noise.
    pub gauss_markov: Option<GaussMarkov>,
}

/// A first-order Gauss-Markov process.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct GaussMarkov {
    /// Standard deviation, the axis' unit.
    pub deviation: f64,
    /// Correlation time, s.
    pub tau_s: f64,
}

/// Whitened columns; noise of the stated levels has unit variance.
#[derive(Debug, Clone)]
pub struct Whitened {
    /// Columns in the given order, one value per block.
    pub columns: Vec<Vec<f64>>,
    /// Squares of each column that the levels of [`Blocks::restarts`] account for, in units of the noise's
    /// contribution.
    pub taken: Vec<f64>,
    /// ln det of the covariance; with unknown levels L the restricted form ln det C + ln det LᵀC⁻¹L (Patterson and
    /// Thompson 1971).
    pub log_determinant: f64,
}

/// A Gauss-Markov process in block means. The means of blocks k ≥ 1 apart have exactly the covariance
/// σ²·((1 − e^(−x))/x)²·e^(−(k−1)x), x = T/τ, as a sampled process of a larger variance has. The variance of one mean,
/// σ²·2(x − 1 + e^(−x))/x², is smaller, and the difference acts as (negative) white noise.
struct Rung {
    decay: f64,
    variance: f64,
    white: f64,
}

/// Limit of T/τ: means two blocks apart then share less than e^(−10) of the covariance of neighbours, so that the limit
/// costs nothing and preserves digits.
const LONGEST: f64 = 10.0;

impl Rung {
    fn new(process: GaussMarkov, length_s: f64) -> Self {
        let x = length_s / process.tau_s;
        let variance = process.deviation * process.deviation;
        let neighbours = variance * ((-x).exp_m1() / x).powi(2);
        let decay = (-x.min(LONGEST)).exp();
        let sampled = neighbours / decay;
        Self { decay, variance: sampled, white: variance * variance_of_mean(x) - sampled }
    }
}

/// Variance of the mean of a Gauss-Markov process of unit variance over a time of `x` correlation times.
fn variance_of_mean(x: f64) -> f64 {
    // 1 − x/3 + x²/12 where the difference would cancel
    if x > 1e-4 { 2.0 * (x + (-x).exp_m1()) / (x * x) } else { 1.0 - x / 3.0 }
}

/// Variance of each process of the ladder for flicker noise of unit bias instability.
fn rung_variance() -> f64 {
    3.0_f64.ln() / std::f64::consts::PI
}

impl Blocks {
    /// Returns the levels in block means of white noise N, unit·√s, flicker noise B, unit, that continues below the ladder,
    /// and a random walk K, unit/√s. The further process is the next faster rung; all rungs below it are nearly white in
    /// block means and add their variance to the white noise.
    pub(super) fn with_faster_flicker(&self, [white, flicker, walk]: [f64; 3]) -> NoiseLevels {
        let variance = flicker * flicker * rung_variance();
        let tau_s = |rung: i32| self.flicker_from_s * 3.0_f64.powi(-rung);
        let means: f64 = (2..=FASTER_RUNGS).map(|rung| variance_of_mean(self.length_s / tau_s(rung))).sum();
        let next = GaussMarkov { deviation: variance.sqrt(), tau_s: tau_s(1) };
        let white = (white * white + variance * means * self.length_s).sqrt();
        NoiseLevels { white, flicker, walk, gauss_markov: Some(next) }
    }
}

impl NoiseLevels {
    /// Whitens columns of block means. The bias at the start belongs to the constant, so the random walk starts at 0.
    pub fn whiten(&self, blocks: &Blocks, columns: &[&[f64]]) -> Whitened {
        self.whitening(blocks).whiten(columns)
    }

    /// Returns the filter that whitens columns of these blocks.
    pub fn whitening(&self, blocks: &Blocks) -> Whitening {
        Arch::new().dispatch(Filtering { levels: self, blocks, restarts: blocks.restarts() })
    }

    /// Returns a realisation of the noise in block means.
    pub fn simulate(&self, blocks: &Blocks, random: &mut impl Rng) -> Vec<f64> {
        let units: Vec<f64> = (0..blocks.len()).map(|_| StandardNormal.sample(random)).collect();
        self.realisation(blocks, &units)
    }

    /// Returns the realisation for independent standard normal values, one for each block.
    pub fn realisation(&self, blocks: &Blocks, units: &[f64]) -> Vec<f64> {
        // inverse of whitening: innovations with the filter's variances, run backwards through its gains
        let filter = Arch::new().dispatch(Filtering { levels: self, blocks, restarts: &[] });
        let mut states = [[0.0]; STATES];
        filter
            .steps
            .iter()
            .zip(units)
            .map(|(step, unit)| {
                let innovation = unit / step.weight;
                let [predicted] = predicted(&states);
                step.advance(&mut states, &[innovation]);
                predicted + innovation
            })
            .collect()
    }

    /// Computes the gains of the filter, which depend only on the levels and the blocks. At `restarts` the variance of
    /// the random walk becomes infinite: in the limit the innovation there determines the level only, so an unknown
    /// level costs one block and no regressor (diffuse initialisation; de Jong 1991).
    #[inline(always)]
    fn filter(&self, blocks: &Blocks, restarts: &[usize]) -> Whitening {
        let length_s = blocks.length_s;
        let ladder_deviation = self.flicker * rung_variance().sqrt();
        let mut decay = [1.0; STATES];
        let mut stationary = [0.0; STATES];
        let mut white = 0.0;
        let extra = self.gauss_markov;
        let rungs = (0..RUNGS).map(|rung| {
            Some(GaussMarkov {
                deviation: ladder_deviation,
                tau_s: blocks.flicker_from_s * 3.0_f64.powi(rung as i32),
            })
        });
        for (state, process) in rungs.chain([None, extra]).enumerate() {
            if let Some(process) = process {
                let rung = Rung::new(process, length_s);
                (decay[state], stationary[state]) = (rung.decay, rung.variance);
                white += rung.white;
            }
        }
        // means of a walk over blocks k apart differ by K²T·(k − ⅓): as a walk that is sampled once per block and a negative
        // white noise of K²T/6 do; it starts at 0 when the first block begins
        let walk_per_block = self.walk * self.walk * length_s;
        white -= walk_per_block / 6.0;
        let mut covariance = [[0.0; STATES]; STATES];
        for state in 0..STATES {
            covariance[state][state] = stationary[state];
        }
        covariance[RUNGS][RUNGS] = walk_per_block / 2.0;
        let mut variances = Vec::with_capacity(blocks.len());
        let mut restarts = restarts.iter().copied().peekable();
        let mut steps = Vec::with_capacity(blocks.len());
        for (at, block) in blocks.blocks.iter().enumerate() {
            let seconds = block.count as f64 * blocks.period_s;
            // negative if short processes and the walk inside a block outweigh the white noise; the variance of the
            // innovation is always positive
            let own = self.white * self.white * block.noise / seconds + white;
            // sum of each row; by symmetry all are added up at once
            let mut gain = [0.0; STATES];
            for row in &covariance {
                for (gain, value) in gain.iter_mut().zip(row) {
                    *gain += value;
                }
            }
            let variance: f64 = gain.iter().sum::<f64>() + own;
            let inverse = 1.0 / variance;
            let blocks_ahead = blocks.blocks.get(at + 1).map_or(1, |next| next.index - block.index);
            let over: [f64; STATES] = match blocks_ahead {
                1 => decay,
                many => decay.map(|decay| decay.powi(many.min(1 << 30) as i32)),
            };
            let is_restart = restarts.next_if_eq(&at).is_some();
            if is_restart {
                // P + κ·e·eᵀ updated with gain (P·h + κ·e)/(variance + κ), κ → ∞; e is the walk, h sums all states
                for i in 0..STATES {
                    covariance[i][RUNGS] -= gain[i];
                    covariance[RUNGS][i] -= gain[i];
                }
                covariance[RUNGS][RUNGS] += variance;
                let mut level = [0.0; STATES];
                level[RUNGS] = 1.0;
                steps.push(Step { decay: over, gain: level, weight: 0.0, taken: inverse });
            } else {
                variances.push(variance);
                steps.push(Step {
                    decay: over,
                    gain: gain.map(|gain| gain * inverse),
                    weight: inverse.sqrt(),
                    taken: 0.0,
                });
            }
            let update = if is_restart { 0.0 } else { inverse };
            for i in 0..STATES {
                for j in 0..STATES {
                    let updated = covariance[i][j] - gain[i] * gain[j] * update;
                    covariance[i][j] = over[i] * over[j] * updated;
                }
                covariance[i][i] += stationary[i] * (1.0 - over[i] * over[i]);
            }
            covariance[RUNGS][RUNGS] += walk_per_block * blocks_ahead as f64;
        }
        // one logarithm for four: it would take longer than the gains
        let log_determinant = variances.chunks(4).map(|four| four.iter().product::<f64>().ln()).sum();
        Whitening { steps, log_determinant }
    }
}

/// Runs [`NoiseLevels::filter`] with the widest vectors of the processor.
struct Filtering<'a> {
    levels: &'a NoiseLevels,
    blocks: &'a Blocks,
    restarts: &'a [usize],
}

impl WithSimd for Filtering<'_> {
    type Output = Whitening;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Whitening {
        self.levels.filter(self.blocks, self.restarts)
    }
}

/// Gains of a Kalman filter for noise of given levels over given blocks.
#[derive(Debug)]
pub struct Whitening {
    steps: Vec<Step>,
    log_determinant: f64,
}

/// Number of columns that are whitened at once.
const LANES: usize = 8;

impl Whitening {
    /// Whitens columns of block means.
    pub fn whiten(&self, columns: &[&[f64]]) -> Whitened {
        let mut whitened = Vec::with_capacity(columns.len());
        let mut taken = Vec::with_capacity(columns.len());
        let mut left = columns;
        while !left.is_empty() {
            // no more lanes than columns
            let lanes = match left.len() {
                LANES.. => self.side_by_side::<LANES>(left, &mut whitened, &mut taken),
                4.. => self.side_by_side::<4>(left, &mut whitened, &mut taken),
                2.. => self.side_by_side::<2>(left, &mut whitened, &mut taken),
                _ => self.side_by_side::<1>(left, &mut whitened, &mut taken),
            };
            left = &left[lanes..];
        }
        Whitened { columns: whitened, taken, log_determinant: self.log_determinant }
    }

    /// Whitens the first `N` columns; returns their number.
    fn side_by_side<const N: usize>(
        &self,
        columns: &[&[f64]],
        whitened: &mut Vec<Vec<f64>>,
        taken: &mut Vec<f64>,
    ) -> usize {
        let mut into = [const { Vec::new() }; N];
        into.iter_mut().for_each(|into| into.reserve_exact(self.steps.len()));
        let squares = Arch::new().dispatch(SideBySide { steps: &self.steps, columns, into: &mut into });
        taken.extend(squares);
        whitened.extend(into);
        N
    }
}

/// One pass over the blocks for `N` columns.
struct SideBySide<'a, const N: usize> {
    steps: &'a [Step],
    columns: &'a [&'a [f64]],
    into: &'a mut [Vec<f64>; N],
}

impl<const N: usize> WithSimd for SideBySide<'_, N> {
    type Output = [f64; N];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; N] {
        let Self { steps, columns, into } = self;
        let mut taken = [0.0; N];
        let mut states = [[0.0; N]; STATES];
        let lengths = columns.iter().map(|column| column.len());
        let n = lengths.fold(steps.len(), usize::min);
        for (block, step) in steps.iter().enumerate().take(n) {
            let mut innovations = predicted(&states);
            for lane in 0..N {
                innovations[lane] = columns[lane][block] - innovations[lane];
                into[lane].push(innovations[lane] * step.weight);
                taken[lane] += step.taken * innovations[lane] * innovations[lane];
            }
            step.advance(&mut states, &innovations);
        }
        taken
    }
}

#[derive(Debug)]
struct Step {
    decay: [f64; STATES],
    gain: [f64; STATES],
    /// 0 if the innovation determines a level.
    weight: f64,
    /// Inverse variance of an innovation that determines a level; else 0.
    taken: f64,
}

impl Step {
    /// Advances the states of all columns to the next block, given the innovations.
    #[inline(always)]
    fn advance<const N: usize>(&self, states: &mut [[f64; N]; STATES], innovations: &[f64; N]) {
        for ((state, decay), gain) in states.iter_mut().zip(&self.decay).zip(&self.gain) {
            for lane in 0..N {
                state[lane] = decay * (state[lane] + gain * innovations[lane]);
            }
        }
    }
}

/// Predicts each column at this block from the states.
#[inline(always)]
fn predicted<const N: usize>(states: &[[f64; N]; STATES]) -> [f64; N] {
    let mut predicted = [0.0; N];
    for state in states {
        for lane in 0..N {
            predicted[lane] += state[lane];
        }
    }
    predicted
}

//! By how much an error should fall: from the size of the effect on the inputs of the log that is to be judged, and from the
//! noise, without looking at what was measured there.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::blocks::Blocks;
use super::noise::NoiseLevels;

/// Draws of noise and coefficients.
const DRAWS: usize = 300;

/// Seed of the draws.
const SEED: u64 = 0x0f05;

/// Share of the variance of block means that goes with a correction: median, 5 % and 95 % quantile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fall {
    pub(super) median: f64,
    pub(super) interval: [f64; 2],
}

/// A slow correction on the blocks of a log: its regressors there and what is known of their coefficients.
pub(super) struct SlowCorrection<'a> {
    pub(super) blocks: &'a Blocks,
    pub(super) columns: &'a [Vec<f64>],
    pub(super) coefficients: &'a [f64],
    pub(super) covariance: &'a DMatrix<f64>,
    /// Draws of the noise levels: what is known of them.
    pub(super) levels: &'a super::levels::LevelPrior,
    pub(super) extra: Option<super::noise::GaussMarkov>,
    /// Regressors of later findings, which are still in the error.
    pub(super) still_missing: &'a [f64],
}

impl SlowCorrection<'_> {
    /// The fall.
    pub(super) fn fall(&self) -> Fall {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let n = self.blocks.len();
        let k = self.coefficients.len();
        let factor = self.covariance.clone().cholesky().map_or_else(|| DMatrix::zeros(k, k), |c| c.l());
        let precision = nalgebra::Matrix3::from_fn(|i, j| self.levels.precision[i][j]);
        let level_factor = precision
            .try_inverse()
            .and_then(|covariance| covariance.cholesky())
            .map_or_else(nalgebra::Matrix3::zeros, |c| c.l());
        let mut falls: Vec<f64> = (0..DRAWS)
            .map(|_| {
                let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                let off = level_factor * nalgebra::Vector3::from_fn(|_, _| normal());
                let logs = std::array::from_fn(|i| self.levels.mean[i] + off[i]);
                let levels = NoiseLevels { gauss_markov: self.extra, ..NoiseLevels::from_logs(&logs) };
                let error = &factor * DVector::from_fn(k, |_, _| normal());
                let noise = levels.simulate(self.blocks, &mut random);
                let rest =
                    |block: usize| noise[block] + self.still_missing.get(block).copied().unwrap_or(0.0);
                let dot = |weights: &dyn Fn(usize) -> f64, block: usize| -> f64 {
                    (0..k).map(|j| weights(j) * self.columns[j][block]).sum()
                };
                let before: Vec<f64> =
                    (0..n).map(|b| rest(b) + dot(&|j| self.coefficients[j] + error[j], b)).collect();
                let after: Vec<f64> = (0..n).map(|b| rest(b) + dot(&|j| error[j], b)).collect();
                1.0 - crate::signal::variance(&[&after]) / crate::signal::variance(&[&before])
            })
            .collect();
        falls.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| falls[(share * (falls.len() - 1) as f64).round() as usize];
        Fall { median: at(0.5), interval: [at(0.05), at(0.95)] }
    }
}

//! Likelihood test of a dependence: does a regression with sensor noise as error need further regressors?

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use fos_fit::noise::{Blocks, Gls, LevelPrior, NoiseLevels};
use fos_fit::noise::{Fitted, Regression};

/// Step in the logarithm of a level for numerical derivatives.
const STEP: f64 = 0.1;

/// Number of effective samples above which the noise counts as known.
const MAX_EFFECTIVE: f64 = 1e6;

/// Residual of an axis in block means, and the prior of its noise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockResidual<'a> {
    pub(crate) blocks: &'a Blocks,
    pub(crate) means: &'a [f64],
    pub(crate) prior: &'a LevelPrior,
}

/// Test whether further regressors explain more than noise does.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Test {
    pub terms: usize,
    /// 2Δ ln L with the noise levels fitted with and without the regressors.
    pub gain: f64,
    /// Gain minus `terms`·ln(blocks), the penalty of coefficients (Schwarz 1978).
    pub score: f64,
    /// Number of independent samples equivalent to the data and the prior, for the noise in the directions of the
    /// regressors.
    pub effective_samples: f64,
    /// Probability of such a gain without any dependence.
    pub p: f64,
}

impl BlockResidual<'_> {
    fn regression<'r>(&'r self, regressors: &'r [&'r [f64]]) -> Regression<'r> {
        Regression { blocks: self.blocks, y: self.means, regressors, prior: self.prior }
    }

    /// Fits the residual as a constant and noise.
    pub(crate) fn constant(&self) -> Fitted {
        let ones = vec![1.0; self.blocks.len()];
        self.regression(&[&ones]).fit(NoiseLevels::from_logs(&self.prior.mean))
    }

    /// Fits the residual with further `columns`; `null` is the result of [`Self::constant`]. `None` if all columns are
    /// constant.
    pub(crate) fn test(&self, null: &Fitted, columns: &[Vec<f64>]) -> Option<(Test, Fitted)> {
        let ones = vec![1.0; self.blocks.len()];
        let mut regressors: Vec<&[f64]> = vec![&ones];
        regressors.extend(columns.iter().map(Vec::as_slice));
        let regression = self.regression(&regressors);
        let fitted = regression.fit(null.levels);
        let terms = fitted.gls.kept.len().saturating_sub(1);
        if terms == 0 {
            return None;
        }
        let gain = (null.deviance - fitted.deviance).max(0.0);
        let effective_samples = effective_samples(&regression, &fitted);
        let p = tail(gain, terms, effective_samples);
        let score = gain - terms as f64 * (self.blocks.len() as f64).ln();
        Some((Test { terms, gain, score, effective_samples, p }, fitted))
    }
}

/// Information on the noise in the directions of the regressors beyond the constant, as a number of independent
/// samples. The covariance C = L·Lᵀ of their k coefficients depends on the logarithms θ of the levels; relative to
/// itself it changes by M_a = L⁻¹·∂C/∂θ_a·L⁻ᵀ. With W the covariance of θ, Σ W_ab·tr(M_a·M_b)/k (A₂/k of Kenward and
/// Roger 1997) is the variance of the logarithm of a coefficient's variance, averaged over directions. It is 2/n if n
/// independent samples alone determine the noise (Satterthwaite 1946).
fn effective_samples(regression: &Regression<'_>, fitted: &Fitted) -> f64 {
    let covariance = |logs: &[f64; 3]| -> DMatrix<f64> {
        let levels = NoiseLevels::from_logs(logs);
        let gls = Gls::new(regression.blocks, &levels, regression.y, regression.regressors);
        let all = gls.covariance();
        let terms = all.nrows() - 1;
        all.view((1, 1), (terms, terms)).into_owned()
    };
    let centre = fitted.levels.logs();
    let Some(root) = covariance(&centre).cholesky() else { return MAX_EFFECTIVE };
    let root = root.l();
    let moves: [Option<DMatrix<f64>>; 3] = std::array::from_fn(|level| {
        let moved = |by: f64| {
            let mut logs = centre;
            logs[level] += by;
            covariance(&logs)
        };
        let (up, down) = (moved(STEP), moved(-STEP));
        // a nearly collinear column may be dropped under other noise
        let is_same = up.shape() == root.shape() && down.shape() == root.shape();
        let slope = is_same.then(|| (up - down) / (2.0 * STEP))?;
        root.solve_lower_triangular(&root.solve_lower_triangular(&slope)?.transpose())
    });
    let precision = regression.posterior(fitted).precision;
    let known = nalgebra::Matrix3::from_fn(|i, j| precision[i][j]).try_inverse();
    let ([Some(white), Some(flicker), Some(walk)], Some(known)) = (&moves, known) else {
        return MAX_EFFECTIVE;
    };
    let moves = [white, flicker, walk];
    let sum: f64 = (0..3)
        .flat_map(|a| (0..3).map(move |b| (a, b)))
        .map(|(a, b)| known[(a, b)] * moves[a].dot(moves[b]))
        .sum();
    (2.0 * root.nrows() as f64 / sum).clamp(1.0, MAX_EFFECTIVE)
}

/// Probability of a gain. In a regression with n independent errors of one unknown size, the gain is exactly
/// n·ln(1 + terms·F/m) with m = n − terms − 1, where F has terms and m degrees of freedom; for a known size (n → ∞) it
/// is χ².
fn tail(gain: f64, terms: usize, effective_samples: f64) -> f64 {
    let k = terms as f64;
    let left = (effective_samples - k - 1.0).max(1.0);
    let f = (gain / effective_samples).exp_m1() * left / k;
    FisherSnedecor::new(k, left).map_or(1.0, |distribution| distribution.sf(f))
}

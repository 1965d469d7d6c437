//! By how much an error should fall: from the size of the effect on the inputs of the log that is to be judged, and
//! from the noise, without looking at what was measured there.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::error_in_blocks::ErrorInBlocks;
use super::slow::{Found, SlowResult};
use fos_fit::noise::{Fitted, Regression, UnknownLevels};

/// Draws of noise and coefficients.
const DRAWS: usize = 300;

/// Seed of the draws.
const SEED: u64 = 0x0f05;

/// Share of the variance of block means that goes with a correction: median, 5 % and 95 % quantile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PredictedReduction {
    pub(super) median: f64,
    pub(super) interval: [f64; 2],
    /// How many times further than where its coefficients were learnt the log goes in some combination of its inputs.
    pub(super) beyond: Option<f64>,
}

/// The coefficients of an effect, one per regressor; those that could not be estimated are 0.
pub(super) struct Estimate {
    pub(super) coefficients: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
    /// Which of them could be estimated; of the others the covariance is 0.
    estimated: Vec<usize>,
}

impl Estimate {
    /// Of an effect that was found.
    pub(super) fn of(found: &Found, slow: &SlowResult) -> Self {
        let (all, covariance) = (slow.fitted.gls.coefficients(), slow.fitted.gls.covariance());
        let kept = |place: usize| slow.fitted.gls.kept.iter().position(|index| *index == place);
        let places: Vec<usize> = found.place.clone().collect();
        Self {
            coefficients: DVector::from_iterator(places.len(), places.iter().map(|place| all[*place])),
            covariance: DMatrix::from_fn(places.len(), places.len(), |i, j| {
                kept(places[i]).zip(kept(places[j])).map_or(0.0, |(i, j)| covariance[(i, j)])
            }),
            estimated: (0..places.len()).filter(|at| kept(places[*at]).is_some()).collect(),
        }
    }

    /// The Cholesky factor L of the covariance, L·Lᵀ, of those that could be estimated; rows and columns of the others
    /// are 0. `None` if that is no covariance, as of data that are not finite.
    pub(super) fn factor(&self) -> Option<DMatrix<f64>> {
        let (estimated, k) = (&self.estimated, self.coefficients.len());
        let of_estimated = DMatrix::from_fn(estimated.len(), estimated.len(), |i, j| {
            self.covariance[(estimated[i], estimated[j])]
        });
        let lower = of_estimated.cholesky()?.l();
        let mut factor = DMatrix::zeros(k, k);
        for (i, row) in estimated.iter().enumerate() {
            for (j, column) in estimated.iter().enumerate() {
                factor[(*row, *column)] = lower[(i, j)];
            }
        }
        Some(factor)
    }
}

/// A slow effect on the blocks of a log.
pub(super) struct SlowEffect {
    /// It is a constant in every later log: its error is no variance but a square about the bias of the log it was
    /// found in.
    pub(super) is_step: bool,
    /// One column for each regressor.
    pub(super) columns: Vec<Vec<f64>>,
    /// The same as a correction takes them, kept inside limits.
    pub(super) corrected: Vec<Vec<f64>>,
    pub(super) coefficients: DVector<f64>,
    /// Their scatter: normal numbers times it have the covariance of the coefficients.
    pub(super) factor: DMatrix<f64>,
}

impl SlowEffect {
    /// The sum of `columns` with these coefficients.
    fn sum(columns: &[Vec<f64>], coefficients: &DVector<f64>, blocks: usize) -> Vec<f64> {
        let mut sum = vec![0.0; blocks];
        for (column, coefficient) in columns.iter().zip(coefficients.iter()) {
            sum.iter_mut().zip(column).for_each(|(sum, value)| *sum += coefficient * value);
        }
        sum
    }
}

/// What is known of the log that is to be judged.
pub(super) struct PredictedReductions<'a> {
    pub(super) log: &'a ErrorInBlocks,
    /// The regression that says what is known of the noise levels.
    pub(super) regression: &'a Regression<'a>,
    pub(super) fitted: &'a Fitted,
}

impl PredictedReductions<'_> {
    /// The reduction that goes with `effect`, those of `later` findings still in the error.
    ///
    /// # Errors
    ///
    /// The noise levels cannot be told.
    pub(super) fn of(
        &self,
        effect: &SlowEffect,
        later: &[SlowEffect],
    ) -> Result<PredictedReduction, UnknownLevels> {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let blocks = &self.log.blocks;
        let (n, k) = (blocks.len(), effect.coefficients.len());
        let mut missing = vec![0.0; n];
        for other in later {
            let own = SlowEffect::sum(&other.columns, &other.coefficients, n);
            missing.iter_mut().zip(own).for_each(|(sum, value)| *sum += value);
        }
        let correction = SlowEffect::sum(&effect.corrected, &effect.coefficients, n);
        let levels = self.regression.draws(self.fitted, DRAWS, &mut random)?;
        let mut falls: Vec<f64> = levels
            .iter()
            .map(|levels| {
                fos_data::interrupt::check();
                let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                let coefficients =
                    &effect.coefficients + &effect.factor * DVector::from_fn(k, |_, _| normal());
                let noise = levels.simulate(blocks, &mut random);
                let truth = SlowEffect::sum(&effect.columns, &coefficients, n);
                let before: Vec<f64> = (0..n).map(|b| noise[b] + missing[b] + truth[b]).collect();
                let after: Vec<f64> = (0..n).map(|b| before[b] - correction[b]).collect();
                let error = |left: &[f64]| match effect.is_step {
                    true => left.iter().map(|value| value * value).sum::<f64>() / n as f64,
                    false => self.log.variance_in(left, 0..n),
                };
                1.0 - error(&after) / error(&before)
            })
            .collect();
        falls.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| falls[(share * (falls.len() - 1) as f64).round() as usize];
        Ok(PredictedReduction { median: at(0.5), interval: [at(0.05), at(0.95)], beyond: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of three coefficients, some of which could be estimated.
    fn estimate(estimated: Vec<usize>, covariance: DMatrix<f64>) -> Estimate {
        Estimate { coefficients: DVector::from_element(3, 1.0), covariance, estimated }
    }

    fn covariance() -> DMatrix<f64> {
        DMatrix::from_row_slice(3, 3, &[4.0, 1.2, -0.4, 1.2, 9.0, 0.7, -0.4, 0.7, 2.5])
    }

    #[test]
    fn all_estimated_scatter_by_the_factor_of_their_covariance() {
        let factor = estimate(vec![0, 1, 2], covariance()).factor();
        assert_eq!(factor, covariance().cholesky().map(|cholesky| cholesky.l()));
    }

    #[test]
    fn a_coefficient_that_could_not_be_estimated_does_not_take_the_scatter_of_the_others() {
        let mut known = covariance();
        known.row_mut(1).fill(0.0);
        known.column_mut(1).fill(0.0);
        let factor = estimate(vec![0, 2], known.clone()).factor().expect("a covariance of the others");
        assert!((&factor * factor.transpose() - known).amax() < 1e-14);
        assert!(factor[(2, 2)] > 0.0);
    }

    /// They were taken for exact: the interval of the reduction was that of the noise alone.
    #[test]
    fn what_is_no_covariance_has_no_factor() {
        let mut indefinite = covariance();
        (indefinite[(0, 1)], indefinite[(1, 0)]) = (7.0, 7.0);
        assert_eq!(estimate(vec![0, 1, 2], indefinite).factor(), None);
        let mut not_finite = covariance();
        not_finite[(2, 2)] = f64::NAN;
        assert_eq!(estimate(vec![0, 1, 2], not_finite).factor(), None);
    }
}

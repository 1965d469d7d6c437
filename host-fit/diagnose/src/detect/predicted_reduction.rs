//! By how much an error should fall: from the size of the effect on the inputs of the log that is to be judged, and from the
//! noise, without looking at what was measured there.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::slow::{Found, SlowResult};
use fos_fit::noise::Blocks;
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
}

/// The coefficients of an effect, one per regressor; those that could not be estimated are 0.
pub(super) struct Estimate {
    pub(super) coefficients: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
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
        }
    }
}

/// A slow effect on the blocks of a log.
pub(super) struct SlowEffect {
    /// It is a constant in every later log: its error is no variance but a square about the bias of the log it was found in.
    pub(super) is_step: bool,
    /// One column for each regressor.
    pub(super) columns: Vec<Vec<f64>>,
    /// The same as a correction takes them, kept inside limits.
    pub(super) corrected: Vec<Vec<f64>>,
    pub(super) coefficients: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
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
    pub(super) blocks: &'a Blocks,
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
        let (n, k) = (self.blocks.len(), effect.coefficients.len());
        let mut missing = vec![0.0; n];
        for other in later {
            let own = SlowEffect::sum(&other.columns, &other.coefficients, n);
            missing.iter_mut().zip(own).for_each(|(sum, value)| *sum += value);
        }
        let correction = SlowEffect::sum(&effect.corrected, &effect.coefficients, n);
        let factor = effect.covariance.clone().cholesky().map_or_else(|| DMatrix::zeros(k, k), |c| c.l());
        let levels = self.regression.draws(self.fitted, DRAWS, &mut random)?;
        let mut falls: Vec<f64> = levels
            .iter()
            .map(|levels| {
                fos_data::interrupt::check();
                let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                let coefficients = &effect.coefficients + &factor * DVector::from_fn(k, |_, _| normal());
                let noise = levels.simulate(self.blocks, &mut random);
                let truth = SlowEffect::sum(&effect.columns, &coefficients, n);
                let before: Vec<f64> = (0..n).map(|b| noise[b] + missing[b] + truth[b]).collect();
                let after: Vec<f64> = (0..n).map(|b| before[b] - correction[b]).collect();
                let error = |left: &[f64]| match effect.is_step {
                    true => left.iter().map(|value| value * value).sum::<f64>() / n as f64,
                    false => fos_fit::signal::variance(&[left]),
                };
                1.0 - error(&after) / error(&before)
            })
            .collect();
        falls.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| falls[(share * (falls.len() - 1) as f64).round() as usize];
        Ok(PredictedReduction { median: at(0.5), interval: [at(0.05), at(0.95)] })
    }
}

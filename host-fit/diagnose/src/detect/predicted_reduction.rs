//! Prediction of the error reduction from the size of an effect, the inputs of the evaluation log and the noise. The
//! error of that log is not used.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::error_in_blocks::ErrorInBlocks;
use fos_data::interrupt::{self, in_parallel};
use fos_data::recording::{Recording, RecordingError};
use fos_fit::evaluate::SLOW_BLOCK_S;
use fos_fit::noise::{Fitted, Regression, UnknownLevels, combination};

/// Number of draws of noise and coefficients.
const DRAWS: usize = 300;

/// Largest number of blocks in a draw. For a longer log the error is drawn in means of several seconds, and the white
/// noise that this averages out of the slow error is added to its variance; a slow effect is the same in both.
const MAX_BLOCKS: f64 = 4096.0;

const SEED: u64 = 0x0f05;

/// Share of the variance of block means that a correction removes: median, 5 % and 95 % quantile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PredictedReduction {
    pub(super) median: f64,
    pub(super) interval: [f64; 2],
    /// Ratio by which the log exceeds the range of the fitted coefficients in some combination of its inputs.
    pub(super) beyond: Option<f64>,
}

/// A slow effect in the blocks of a log.
pub(super) struct SlowEffect {
    /// True if its error is a mean square about the bias of the log it was found in rather than a variance: the
    /// evaluation continues that log, or the effect is a constant in every later one.
    pub(super) is_about_fit: bool,
    /// The finding.
    pub(super) found: Truth,
    /// Alternatives to the finding.
    pub(super) alternatives: Vec<Truth>,
    /// Columns of the finding as a correction uses them: with clamped inputs, about the means of the fitted log.
    pub(super) corrected: Vec<Vec<f64>>,
}

/// A possible cause in the blocks of a log.
pub(super) struct Truth {
    /// Columns, one per regressor, about their means in the fitted log.
    pub(super) columns: Vec<Vec<f64>>,
    pub(super) coefficients: DVector<f64>,
    /// Cholesky factor of the covariance of the coefficients: times standard normal numbers it gives their scatter.
    pub(super) factor: DMatrix<f64>,
    /// Odds relative to the finding.
    pub(super) odds: f64,
}

impl SlowEffect {
    /// Draws the finding or an alternative, in proportion to their odds.
    fn draw(&self, random: &mut ChaCha8Rng) -> &Truth {
        let all = || std::iter::once(&self.found).chain(&self.alternatives);
        let mut left = random.random::<f64>() * all().map(|truth| truth.odds).sum::<f64>();
        let drawn = all().find(|truth| {
            left -= truth.odds;
            left < 0.0
        });
        drawn.unwrap_or(&self.found)
    }
}

/// The evaluation log and the noise model.
pub(super) struct PredictedReductions<'a> {
    pub(super) log: &'a ErrorInBlocks,
    /// Regression that determines the noise levels.
    pub(super) regression: &'a Regression<'a>,
    pub(super) fitted: &'a Fitted,
    /// Duration of the log that was fitted, s, if the evaluation continues it.
    pub(super) continues_s: Option<f64>,
}

impl PredictedReductions<'_> {
    /// Returns the blocks in which the error of a log is drawn, from row `from` on.
    pub(super) fn blocks(
        log: &Recording,
        column: &str,
        from: usize,
    ) -> Result<ErrorInBlocks, RecordingError> {
        let seconds = (log.duration_s() / SLOW_BLOCK_S / MAX_BLOCKS).ceil().max(1.0);
        ErrorInBlocks::in_blocks_from(log, column, seconds * SLOW_BLOCK_S, from)
    }

    /// Predicts the reduction by `effect` while those of `later` findings are still in the error.
    pub(super) fn of(
        &self,
        effect: &SlowEffect,
        later: &[SlowEffect],
    ) -> Result<PredictedReduction, UnknownLevels> {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let blocks = &self.log.blocks;
        let n = blocks.len();
        let mut missing = vec![0.0; n];
        for other in later {
            let own = combination(&other.found.columns, other.found.coefficients.as_slice(), n);
            missing.iter_mut().zip(own).for_each(|(sum, value)| *sum += value);
        }
        let correction = combination(&effect.corrected, effect.found.coefficients.as_slice(), n);
        let levels = self.regression.draws(self.fitted, DRAWS, &mut random)?;
        // random numbers are drawn in sequence, so that the parallel part does not change them
        let drawn: Vec<_> = levels
            .iter()
            .map(|levels| {
                let drawn = effect.draw(&mut random);
                let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                let scatter = DVector::from_fn(drawn.coefficients.len(), |_, _| normal());
                let units: Vec<f64> = (0..n).map(|_| normal()).collect();
                // a random walk over T ends with a variance of T/3 about its mean
                let drift = self.continues_s.map_or(0.0, |seconds| (seconds / 3.0).sqrt() * normal());
                (levels, drawn, scatter, units, drift)
            })
            .collect();
        let mut reductions: Vec<f64> = in_parallel(drawn, |(levels, drawn, scatter, units, drift)| {
            interrupt::check();
            let coefficients = &drawn.coefficients + &drawn.factor * scatter;
            let mut noise = levels.realisation(blocks, &units);
            noise.iter_mut().for_each(|value| *value += levels.walk * drift);
            let truth = combination(&drawn.columns, coefficients.as_slice(), n);
            let before: Vec<f64> = (0..n).map(|b| noise[b] + missing[b] + truth[b]).collect();
            let after: Vec<f64> = (0..n).map(|b| before[b] - correction[b]).collect();
            let within = levels.white.powi(2) * (1.0 / SLOW_BLOCK_S - 1.0 / blocks.length_s).max(0.0);
            let error = |left: &[f64]| match effect.is_about_fit {
                true => within + left.iter().map(|value| value * value).sum::<f64>() / n as f64,
                false => within + self.log.variance_in(left, 0..n),
            };
            1.0 - error(&after) / error(&before)
        });
        reductions.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| reductions[(share * (reductions.len() - 1) as f64).round() as usize];
        Ok(PredictedReduction { median: at(0.5), interval: [at(0.05), at(0.95)], beyond: None })
    }
}

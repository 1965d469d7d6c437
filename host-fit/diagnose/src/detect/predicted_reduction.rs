//! By how much an error should fall: from the size of the effect on the inputs of the log that is to be judged, and
//! from the noise, without looking at what was measured there.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::error_in_blocks::ErrorInBlocks;
use fos_data::interrupt::{self, in_parallel};
use fos_data::recording::{Recording, RecordingError};
use fos_fit::evaluate::SLOW_BLOCK_S;
use fos_fit::noise::{Fitted, Regression, UnknownLevels, combination};

/// Draws of noise and coefficients.
const DRAWS: usize = 300;

/// Most blocks of a draw: the error of a longer log is drawn in means of several seconds, and the white noise that such a
/// mean takes out of the slow error is added to its variance. A slow effect is the same in both.
const MAX_BLOCKS: f64 = 4096.0;

const SEED: u64 = 0x0f05;

/// Share of the variance of block means that goes with a correction: median, 5 % and 95 % quantile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PredictedReduction {
    pub(super) median: f64,
    pub(super) interval: [f64; 2],
    /// How many times further than where its coefficients were learnt the log goes in some combination of its inputs.
    pub(super) beyond: Option<f64>,
}

/// A slow effect on the blocks of a log.
pub(super) struct SlowEffect {
    /// It is a constant in every later log: its error is no variance but a square about the bias of the log it was
    /// found in.
    pub(super) is_step: bool,
    /// What it was found to be.
    pub(super) found: Truth,
    /// What it may be instead.
    pub(super) alternatives: Vec<Truth>,
    /// The columns of what it was found to be as a correction takes them, kept inside limits.
    pub(super) corrected: Vec<Vec<f64>>,
}

/// What an effect may be, on the blocks of a log.
pub(super) struct Truth {
    /// One column for each regressor.
    pub(super) columns: Vec<Vec<f64>>,
    pub(super) coefficients: DVector<f64>,
    /// Their scatter: normal numbers times it have the covariance of the coefficients.
    pub(super) factor: DMatrix<f64>,
    /// Odds against what was found.
    pub(super) odds: f64,
}

impl SlowEffect {
    /// What it may be, each as often as its odds say.
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

/// What is known of the log that is to be judged.
pub(super) struct PredictedReductions<'a> {
    pub(super) log: &'a ErrorInBlocks,
    /// The regression that says what is known of the noise levels.
    pub(super) regression: &'a Regression<'a>,
    pub(super) fitted: &'a Fitted,
}

impl PredictedReductions<'_> {
    /// The blocks that the error of a log is drawn in.
    ///
    /// # Errors
    ///
    /// There is no such column.
    pub(super) fn blocks(log: &Recording, column: &str) -> Result<ErrorInBlocks, RecordingError> {
        let seconds = (log.duration_s() / SLOW_BLOCK_S / MAX_BLOCKS).ceil().max(1.0);
        ErrorInBlocks::in_blocks_of(log, column, &[], seconds * SLOW_BLOCK_S)
    }

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
        let n = blocks.len();
        let mut missing = vec![0.0; n];
        for other in later {
            let own = combination(&other.found.columns, other.found.coefficients.as_slice(), n);
            missing.iter_mut().zip(own).for_each(|(sum, value)| *sum += value);
        }
        let correction = combination(&effect.corrected, effect.found.coefficients.as_slice(), n);
        let levels = self.regression.draws(self.fitted, DRAWS, &mut random)?;
        // what is random is drawn one after the other, what comes of it is computed beside one another
        let drawn: Vec<_> = levels
            .iter()
            .map(|levels| {
                let drawn = effect.draw(&mut random);
                let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                let scatter = DVector::from_fn(drawn.coefficients.len(), |_, _| normal());
                let units: Vec<f64> = (0..n).map(|_| normal()).collect();
                (levels, drawn, scatter, units)
            })
            .collect();
        let mut falls: Vec<f64> = in_parallel(drawn, |(levels, drawn, scatter, units)| {
            interrupt::check();
            let coefficients = &drawn.coefficients + &drawn.factor * scatter;
            let noise = levels.realisation(blocks, &units);
            let truth = combination(&drawn.columns, coefficients.as_slice(), n);
            let before: Vec<f64> = (0..n).map(|b| noise[b] + missing[b] + truth[b]).collect();
            let after: Vec<f64> = (0..n).map(|b| before[b] - correction[b]).collect();
            let within = levels.white.powi(2) * (1.0 / SLOW_BLOCK_S - 1.0 / blocks.length_s).max(0.0);
            let error = |left: &[f64]| match effect.is_step {
                true => within + left.iter().map(|value| value * value).sum::<f64>() / n as f64,
                false => within + self.log.variance_in(left, 0..n),
            };
            1.0 - error(&after) / error(&before)
        });
        falls.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| falls[(share * (falls.len() - 1) as f64).round() as usize];
        Ok(PredictedReduction { median: at(0.5), interval: [at(0.05), at(0.95)], beyond: None })
    }
}

//! A log reduced to the input of a diagnosis: the rows used, the error in them and its block means.

use std::ops::Range;
use std::sync::Arc;

use super::faults::Fault;
use fos_data::observed::ObservedAxis;
use fos_data::recording::{Recording, RecordingError};
use fos_data::statistics::median;
use fos_fit::evaluate::SLOW_BLOCK_S;
use fos_fit::noise::{Blocks, length_for, length_with_levels_for};
use fos_fit::signal;

/// Rows within this many standard deviations of a clipping limit are excluded: noise that is clipped on one side has a
/// different mean.
const STOP_MARGIN: f64 = 4.0;

#[derive(Debug, Clone)]
pub struct ErrorInBlocks {
    /// Error of the axis, one value per row, in its unit.
    pub error: Vec<f64>,
    /// Blocks of the rows used.
    pub blocks: Arc<Blocks>,
    /// Block means of the error.
    pub means: Vec<f64>,
    /// True if most samples lie near a clipping limit: the few others do not show the bias.
    pub clipped_through: bool,
}

impl ErrorInBlocks {
    /// Reduces `column` of a recording without known faults.
    pub fn of(recording: &Recording, column: &str) -> Result<Self, RecordingError> {
        Self::new(recording, column, &[])
    }

    /// Reduces `column` without the rows that `faults` affect.
    pub(crate) fn new(recording: &Recording, column: &str, faults: &[Fault]) -> Result<Self, RecordingError> {
        Self::in_blocks_of(recording, column, faults, length_s(recording, column))
    }

    /// Reduces `column` to the rows that `inputs_known` marks, without those that `faults` affect.
    pub(super) fn where_known(
        recording: &Recording,
        column: &str,
        faults: &[Fault],
        inputs_known: &[bool],
    ) -> Result<Self, RecordingError> {
        Self::over(recording, column, faults, length_s(recording, column), |row| inputs_known[row])
    }

    /// Reduces `column` in the blocks of the slow error.
    pub fn in_slow_blocks(recording: &Recording, column: &str) -> Result<Self, RecordingError> {
        Self::in_blocks_of(recording, column, &[], SLOW_BLOCK_S)
    }

    /// Reduces `column` in blocks of `length_s`.
    pub(crate) fn in_blocks_of(
        recording: &Recording,
        column: &str,
        faults: &[Fault],
        length_s: f64,
    ) -> Result<Self, RecordingError> {
        Self::over(recording, column, faults, length_s, |_| true)
    }

    /// Reduces `column` from row `from` on in blocks of `length_s`.
    pub(super) fn in_blocks_from(
        recording: &Recording,
        column: &str,
        length_s: f64,
        from: usize,
    ) -> Result<Self, RecordingError> {
        Self::over(recording, column, &[], length_s, |row| row >= from)
    }

    fn over(
        recording: &Recording,
        column: &str,
        faults: &[Fault],
        length_s: f64,
        counts: impl Fn(usize) -> bool,
    ) -> Result<Self, RecordingError> {
        let observed = ObservedAxis::stated(recording, column)?;
        let measured = &recording.channel(column)?.values;
        let limits = faults.iter().find_map(|fault| match fault {
            Fault::Saturation { limits, .. } => Some(*limits),
            _ => None,
        });
        let margin =
            if limits.is_some() { STOP_MARGIN * fast_deviation(&observed.error.values) } else { 0.0 };
        let inside = |value: f64| match limits {
            None => true,
            Some((low, high)) => {
                low.is_none_or(|low| value > low + margin) && high.is_none_or(|high| value < high - margin)
            }
        };
        let all: Vec<bool> =
            observed.known.iter().enumerate().map(|(row, known)| *known && counts(row)).collect();
        let known: Vec<bool> =
            all.iter().zip(measured.iter()).map(|(known, value)| *known && inside(*value)).collect();
        let unclipped = known.iter().filter(|known| **known).count();
        let clipped_through = 2 * unclipped < all.iter().filter(|known| **known).count();
        let counts = if clipped_through { all } else { known };
        let blocks = Blocks::with_levels(recording, length_s, counts, &observed.turns);
        let means = blocks.means(&observed.error.values);
        let (error, blocks) = (observed.error.values.into_owned(), Arc::new(blocks));
        Ok(Self { error, blocks, means, clipped_through })
    }

    /// Weights each block by the noise of the shaking in it.
    pub(super) fn shaken(self) -> Self {
        let blocks = Arc::unwrap_or_clone(self.blocks).with_noise_of(&self.error);
        Self { blocks: Arc::new(blocks), ..self }
    }

    /// Returns the standard deviation of the noise, from the differences of adjacent samples.
    pub fn fast_deviation(&self) -> f64 {
        let known = self.blocks.known();
        let pairs = self.error.windows(2).zip(known.windows(2)).filter(|(_, known)| known[0] && known[1]);
        let (sum, count) =
            pairs.fold((0.0, 0_u32), |(sum, count), (v, _)| (sum + (v[1] - v[0]).powi(2), count + 1));
        (sum / f64::from(count.max(1)) / 2.0).sqrt()
    }

    /// Returns the variance of values, one per block, about the mean of their level, over `blocks`.
    pub(super) fn variance_in(&self, values: &[f64], blocks: Range<usize>) -> f64 {
        signal::variance(&[&self.blocks.about_levels(values, blocks)])
    }

    /// Returns the variance of the block means of a residual, over the blocks that begin in `rows`, about a separate
    /// mean for each dwell if gravity may have turned.
    pub fn slow_variance(&self, residual: &[f64], rows: &Range<usize>) -> f64 {
        let begins_before = |row: usize| self.blocks.blocks.partition_point(|block| block.rows.start < row);
        self.variance_in(&self.blocks.means(residual), begins_before(rows.start)..begins_before(rows.end))
    }

    /// Returns the mean of the block means of a residual, over the blocks that begin in `rows`.
    pub fn slow_mean(&self, residual: &[f64], rows: &Range<usize>) -> f64 {
        let means = self.blocks.means(residual);
        let inside =
            self.blocks.blocks.iter().zip(means).filter(|(block, _)| rows.contains(&block.rows.start));
        signal::mean(&[&inside.map(|(_, mean)| mean).collect::<Vec<f64>>()])
    }

    /// Returns the mean square of the block means of a residual about `bias`, over the blocks that begin in `rows`.
    pub(crate) fn slow_mean_square(&self, residual: &[f64], rows: &Range<usize>, bias: f64) -> f64 {
        self.slow_variance(residual, rows) + (self.slow_mean(residual, rows) - bias).powi(2)
    }

    /// Returns the variance of the samples of a residual, over the used rows in `rows`.
    pub fn wide_variance(&self, residual: &[f64], rows: &Range<usize>) -> f64 {
        let counts = |row: &usize| self.blocks.known()[*row] && residual[*row].is_finite();
        signal::variance(&[&rows.clone().filter(counts).map(|row| residual[row]).collect::<Vec<f64>>()])
    }
}

/// Returns the block length that suits a column of a recording, s.
fn length_s(recording: &Recording, column: &str) -> f64 {
    match recording.turns.is_empty() || recording.is_bias_known(column) {
        true => length_for(recording),
        false => length_with_levels_for(recording),
    }
}

/// Standard deviation of the noise from the median difference of adjacent samples, which is robust to steps and clipped
/// stretches.
fn fast_deviation(error: &[f64]) -> f64 {
    let mut steps: Vec<f64> =
        error.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|d| *d > 0.0).collect();
    median(&mut steps) / 0.6745 / 2.0_f64.sqrt()
}

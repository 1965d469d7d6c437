//! Splits a log into three consecutive parts.

use std::ops::Range;

use thiserror::Error;

use super::settings::Settings;
use fos_data::recording::Recording;
use fos_data::stillness::Stillness;

/// Ranges of rows at rest, without gaps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Split {
    /// Rows for the fit.
    pub train: Vec<Range<usize>>,
    /// Rows for the choice of a model.
    pub evaluate: Vec<Range<usize>>,
    /// Rows for the evaluation.
    pub predict: Vec<Range<usize>>,
}

/// The time at rest is too short.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "{at_rest_s:.0} s at rest; {needed_s:.0} s are needed to train, to evaluate, and to predict at least as long as that"
)]
pub struct SplitError {
    /// Time at rest, s.
    pub at_rest_s: f64,
    /// Time of the first two parts, and of the second once more, s.
    pub needed_s: f64,
}

impl Split {
    /// The parts in the order of time.
    pub fn parts(&self) -> impl Iterator<Item = &Vec<Range<usize>>> {
        [&self.train, &self.evaluate, &self.predict].into_iter()
    }

    /// Number of samples in each part.
    pub fn samples(&self) -> [usize; 3] {
        [&self.train, &self.evaluate, &self.predict].map(|part| part.iter().map(ExactSizeIterator::len).sum())
    }
}

/// Splits the rows at rest: the first `train` samples, the next `evaluate` samples, and the remainder for prediction, which must be at
/// least as long as the second part.
pub(super) fn split(
    recording: &Recording,
    stillness: &Stillness,
    values: &[f64],
    settings: &Settings,
) -> Result<Split, SplitError> {
    let rate_hz = recording.rate.true_hz;
    let stretches = recording.stretches_where(|row| stillness.still[row] && values[row].is_finite());
    let total: usize = stretches.iter().map(ExactSizeIterator::len).sum();
    let train = (settings.train_s * rate_hz).round() as usize;
    let evaluate = (settings.evaluate_s * rate_hz).round() as usize;
    let both = train.saturating_add(evaluate);
    if total < both.saturating_add(evaluate) {
        return Err(SplitError {
            at_rest_s: total as f64 / rate_hz,
            needed_s: both.saturating_add(evaluate) as f64 / rate_hz,
        });
    }
    let mut split = Split { train: Vec::new(), evaluate: Vec::new(), predict: Vec::new() };
    let mut seen = 0;
    for stretch in stretches {
        // Boundary between two parts within this stretch.
        let cut = |at: usize| stretch.start + at.saturating_sub(seen).min(stretch.len());
        let (first, second) = (cut(train), cut(both));
        for (part, range) in [
            (&mut split.train, stretch.start..first),
            (&mut split.evaluate, first..second),
            (&mut split.predict, second..stretch.end),
        ] {
            if !range.is_empty() {
                part.push(range);
            }
        }
        seen += stretch.len();
    }
    Ok(split)
}

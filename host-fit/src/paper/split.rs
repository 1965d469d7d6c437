//! Three parts of a log, one after the other in time.

use std::ops::Range;

use thiserror::Error;

use super::settings::Settings;
use fos_data::recording::Recording;
use fos_data::stillness::Stillness;

/// Gap-free ranges of rows at rest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Split {
    /// For fitting.
    pub train: Vec<Range<usize>>,
    /// For choosing.
    pub evaluate: Vec<Range<usize>>,
    /// For judging.
    pub predict: Vec<Range<usize>>,
}

/// Why a log cannot be split.
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

    /// Samples in each.
    pub fn samples(&self) -> [usize; 3] {
        [&self.train, &self.evaluate, &self.predict].map(|part| part.iter().map(ExactSizeIterator::len).sum())
    }
}

/// Splits the known rows at rest: so long to train, so long to evaluate, the rest, at least as long as the second, to
/// predict.
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
        // where within this stretch one part ends and the next begins
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

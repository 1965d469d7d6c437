//! Data of the figures: the samples, part by part, and their autocorrelation.

use std::ops::Range;

use super::result::Comparison;
use super::split::Split;
use fos_data::recording::Recording;
use fos_figures::curves::outline;
use fos_fit::signal::autocorrelation::{Autocorrelation, autocorrelation};
use fos_fit::signal::blocks::Envelope;

/// Longest lag of the autocorrelation, s.
const LONGEST_LAG_S: f64 = 5.0;

/// The samples of an axis at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// Autocorrelation over all three parts, lags of 0 … 5 s; none if there are too few samples.
    pub autocorrelation: Option<Autocorrelation>,
    /// Samples for training, evaluation and prediction: an envelope for every stretch without gaps, minus the first sample, in the
    /// axis' unit.
    pub parts: [Vec<Envelope>; 3],
}

impl Curves {
    /// Curves of `values`, a column of `recording` with the split of `comparison`.
    pub fn of(comparison: &Comparison, recording: &Recording, values: &[f64], split: &Split) -> Self {
        let everything: Vec<&[f64]> = split.parts().flatten().map(|range| &values[range.clone()]).collect();
        let lags = (LONGEST_LAG_S * comparison.rate_hz).round() as usize;
        let total: usize = comparison.samples.iter().sum();
        let first = split.train.first().map_or(0, |range| range.start);
        let origin = values.get(first).copied().unwrap_or(0.0);
        let envelopes = |ranges: &Vec<Range<usize>>| {
            let envelope = |range: &Range<usize>| {
                let stretch: Vec<f64> = values[range.clone()].iter().map(|value| value - origin).collect();
                outline(&stretch, total, recording.time_s[range.start], 1.0 / comparison.rate_hz)
            };
            ranges.iter().map(envelope).collect()
        };
        Self {
            autocorrelation: autocorrelation(&everything, lags),
            parts: [&split.train, &split.evaluate, &split.predict].map(envelopes),
        }
    }
}

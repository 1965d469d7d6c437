//! Rows of a recording that a model may be fitted to.

use std::ops::Range;

use fos_core::{Channel, Factor};
use thiserror::Error;

/// Rows n at which the target y(n) and every lagged value back to n − N₀ are present without a gap between them.
///
/// Nothing is interpolated, and nothing is joined across a gap. Models to be compared are fitted to the same `Rows`,
/// made for the largest lag among them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rows {
    ranges: Vec<Range<usize>>,
    max_lag: usize,
}

/// Reason why signals cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SignalsError {
    /// The pool or model uses an input that was not given.
    #[error("input {input} is used, but only {given} inputs were given")]
    MissingInput {
        input: usize,
        /// Number of inputs among the signals.
        given: usize,
    },
    #[error("no signals were given: the first one is the output")]
    NoOutput,
    /// A column has another length than the output.
    #[error("signal {column} has {length} samples, the output has {expected}")]
    Length {
        /// Index of the column; 0 is the output.
        column: usize,
        /// Number of its samples.
        length: usize,
        /// Number of samples of the output.
        expected: usize,
    },
    /// A segment extends beyond the data.
    #[error("segment {index} ends at sample {end}, the signals have {samples}")]
    Segment {
        /// Index of the segment.
        index: usize,
        end: usize,
        /// Number of samples of each signal.
        samples: usize,
    },
    /// The rows were made for shorter lags.
    #[error("the rows allow lags up to {allowed}, but lag {needed} is used")]
    Lag {
        /// Largest lag of the rows.
        allowed: usize,
        needed: usize,
    },
}

impl Rows {
    /// Finds the rows of gap-free `segments` at which every one of `factors` and the target are present.
    ///
    /// `signals`: column 0 is the output, column i + 1 is input i, all of equal length, one sample per row. A sample
    /// that is not finite, in the output or in a channel of `factors`, ends its segment.
    ///
    /// # Errors
    /// Signals of unequal length, a missing input, or a segment beyond the data.
    pub fn usable<'f>(
        signals: &[&[f64]],
        segments: &[Range<usize>],
        factors: impl IntoIterator<Item = &'f Factor>,
    ) -> Result<Self, SignalsError> {
        let samples = signals.first().ok_or(SignalsError::NoOutput)?.len();
        if let Some(index) = segments.iter().position(|s| s.end > samples) {
            return Err(SignalsError::Segment { index, end: segments[index].end, samples });
        }
        let mut used = vec![false; signals.len()];
        used[0] = true;
        let mut max_lag = 0;
        for factor in factors {
            let column = column(factor);
            *used.get_mut(column).ok_or_else(|| missing_input(column, signals))? = true;
            max_lag = max_lag.max(usize::from(factor.lag));
        }
        let used: Vec<&[f64]> = signals.iter().zip(used).filter(|(_, used)| *used).map(|(s, _)| *s).collect();
        check_lengths(signals)?;

        let mut ranges = Vec::new();
        for segment in segments {
            let mut rest = segment.clone();
            while rest.start < rest.end {
                let present = used.iter().map(|s| leading_finite(&s[rest.clone()])).min().unwrap_or(0);
                if present > max_lag {
                    ranges.push(rest.start + max_lag..rest.start + present);
                }
                rest.start += present + 1;
            }
        }
        Ok(Self { ranges, max_lag })
    }

    /// Ranges of target rows; every row is preceded by at least [`max_lag`](Self::max_lag) present samples.
    pub fn ranges(&self) -> &[Range<usize>] {
        &self.ranges
    }

    /// N₀: the largest lag that these rows allow, in samples.
    pub fn max_lag(&self) -> usize {
        self.max_lag
    }

    /// Number of rows, n.
    pub fn count(&self) -> usize {
        self.ranges.iter().map(ExactSizeIterator::len).sum()
    }

    /// Checks that these rows can serve products of `factors` of these signals.
    pub(crate) fn check<'f>(
        &self,
        signals: &[&[f64]],
        factors: impl IntoIterator<Item = &'f Factor>,
    ) -> Result<(), SignalsError> {
        let samples = signals.first().ok_or(SignalsError::NoOutput)?.len();
        check_lengths(signals)?;
        if let Some(index) = self.ranges.iter().position(|r| r.end > samples) {
            return Err(SignalsError::Segment { index, end: self.ranges[index].end, samples });
        }
        for factor in factors {
            if column(factor) >= signals.len() {
                return Err(missing_input(column(factor), signals));
            }
            if usize::from(factor.lag) > self.max_lag {
                return Err(SignalsError::Lag { allowed: self.max_lag, needed: factor.lag.into() });
            }
        }
        Ok(())
    }
}

/// Returns the column of the signals that holds a factor's channel.
pub(crate) fn column(factor: &Factor) -> usize {
    match factor.channel {
        Channel::Output => 0,
        Channel::Input(i) => usize::from(i) + 1,
    }
}

fn missing_input(column: usize, signals: &[&[f64]]) -> SignalsError {
    SignalsError::MissingInput { input: column - 1, given: signals.len() - 1 }
}

fn check_lengths(signals: &[&[f64]]) -> Result<(), SignalsError> {
    let expected = signals[0].len();
    match signals.iter().position(|s| s.len() != expected) {
        Some(column) => Err(SignalsError::Length { column, length: signals[column].len(), expected }),
        None => Ok(()),
    }
}

/// Number of finite samples before the first that is not.
fn leading_finite(signal: &[f64]) -> usize {
    // x·0 is 0 for a finite x and NaN otherwise, and NaN survives adding: one test per chunk vectorises,
    // one per sample does not.
    let spoiled = |chunk: &[f64]| !chunk.iter().fold(0.0, |sum, x| sum + x * 0.0).is_finite();
    const CHUNK: usize = 64;
    let clean = signal.chunks(CHUNK).take_while(|chunk| !spoiled(chunk)).map(<[f64]>::len).sum::<usize>();
    clean + signal[clean..].iter().take_while(|x| x.is_finite()).count()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::single_range_in_vec_init, reason = "a list of one segment")]

    use fos_core::{u, y};

    use super::*;

    #[test]
    fn needs_every_lag_inside_one_segment() {
        let signal = vec![0.0; 20];
        let rows = Rows::usable(&[&signal], &[0..5, 5..8, 8..20], &[y(1), y(3)]).unwrap();
        assert_eq!(rows.ranges(), [3..5, 11..20]);
        assert_eq!(rows.count(), 11);
    }

    #[test]
    fn missing_value_of_a_used_channel_ends_its_segment() {
        let mut output = vec![1.0; 300];
        let mut input = vec![1.0; 300];
        output[100] = f64::NAN;
        input[150] = f64::INFINITY;
        input[151] = f64::NAN;
        let rows = |factors: &[Factor]| Rows::usable(&[&output, &input], &[0..300], factors).unwrap();
        assert_eq!(rows(&[y(2)]).ranges(), [2..100, 103..300]);
        assert_eq!(rows(&[y(2), u(0, 0)]).ranges(), [2..100, 103..150, 154..300]);
    }

    #[test]
    fn rejects_signals_that_do_not_fit() {
        let (output, short) = (vec![0.0; 10], vec![0.0; 9]);
        let refused = |signals: &[&[f64]], segment: Range<usize>, factor: Factor| {
            Rows::usable(signals, &[segment], &[factor]).unwrap_err()
        };
        assert_eq!(refused(&[&output], 0..10, u(0, 0)), SignalsError::MissingInput { input: 0, given: 0 });
        assert_eq!(refused(&[], 0..0, y(1)), SignalsError::NoOutput);
        let length = SignalsError::Length { column: 1, length: 9, expected: 10 };
        assert_eq!(refused(&[&output, &short], 0..9, u(0, 0)), length);
        assert_eq!(
            refused(&[&output], 0..11, y(1)),
            SignalsError::Segment { index: 0, end: 11, samples: 10 }
        );
        let rows = Rows::usable(&[&output], &[0..10], &[y(2)]).unwrap();
        assert_eq!(rows.check(&[&output], &[y(3)]), Err(SignalsError::Lag { allowed: 2, needed: 3 }));
    }
}

//! Rows of a recording that a model may be fitted to.

use std::ops::Range;

use fos_core::{Channel, Factor};

/// Rows n at which the target y(n) and every lagged value back to n − N₀ are present without a gap between them.
///
/// Nothing is interpolated, and nothing is joined across a gap. Models to be compared are fitted to the same `Rows`,
/// made for the largest lag among them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rows {
    ranges: Vec<Range<usize>>,
    max_lag: usize,
}

impl Rows {
    /// Finds the rows of gap-free `segments` at which every one of `factors` and the target are present.
    ///
    /// `signals`: column 0 is the output, column i + 1 is input i, all of equal length, one sample per row. A sample
    /// that is not finite, in the output or in a channel of `factors`, ends its segment.
    ///
    /// # Panics
    /// If the signals have unequal lengths, an input is missing, or a segment extends beyond the data.
    pub fn usable<'f>(
        signals: &[&[f64]],
        segments: &[Range<usize>],
        factors: impl IntoIterator<Item = &'f Factor>,
    ) -> Self {
        assert_equal_lengths(signals);
        let mut used = vec![false; signals.len()];
        used[0] = true;
        let mut max_lag = 0;
        for factor in factors {
            used[column(factor)] = true;
            max_lag = max_lag.max(usize::from(factor.lag));
        }
        let used: Vec<&[f64]> = signals.iter().zip(used).filter(|(_, used)| *used).map(|(s, _)| *s).collect();
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
        Self { ranges, max_lag }
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

    /// # Panics
    /// If these rows cannot serve products of `factors` of these signals.
    pub(crate) fn check<'f>(&self, signals: &[&[f64]], factors: impl IntoIterator<Item = &'f Factor>) {
        assert_equal_lengths(signals);
        assert!(self.ranges.iter().all(|range| range.end <= signals[0].len()), "rows beyond the signals");
        for factor in factors {
            assert!(column(factor) < signals.len(), "{factor:?} has no signal");
            assert!(
                usize::from(factor.lag) <= self.max_lag,
                "the rows were made for shorter lags: {factor:?}"
            );
        }
    }
}

/// Returns the column of the signals that holds a factor's channel.
pub(crate) fn column(factor: &Factor) -> usize {
    match factor.channel {
        Channel::Output => 0,
        Channel::Input(i) => usize::from(i) + 1,
    }
}

fn assert_equal_lengths(signals: &[&[f64]]) {
    assert!(signals.iter().all(|signal| signal.len() == signals[0].len()), "signals of unequal lengths");
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
        let rows = Rows::usable(&[&signal], &[0..5, 5..8, 8..20], &[y(1), y(3)]);
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
        let rows = |factors: &[Factor]| Rows::usable(&[&output, &input], &[0..300], factors);
        assert_eq!(rows(&[y(2)]).ranges(), [2..100, 103..300]);
        assert_eq!(rows(&[y(2), u(0, 0)]).ranges(), [2..100, 103..150, 154..300]);
    }

    #[test]
    #[should_panic(expected = "unequal lengths")]
    fn rejects_signals_of_unequal_lengths() {
        let _ = Rows::usable(&[&[0.0; 10], &[0.0; 9]], &[0..9], &[y(1)]);
    }

    #[test]
    #[should_panic(expected = "made for shorter lags")]
    fn rejects_longer_lags() {
        Rows::usable(&[&[0.0; 10]], &[0..10], &[y(2)]).check(&[&[0.0; 10]], &[y(3)]);
    }
}

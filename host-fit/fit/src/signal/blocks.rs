//! Averages over time: the slow part of a series, and its envelope for display.

/// A series reduced for display to one entry per bucket without losing peaks: every sample lies within `low ..= high`
/// of its bucket.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Envelope {
    /// Middle of each bucket, s.
    pub time_s: Vec<f64>,
    /// Smallest sample in the bucket, unit of the series.
    pub low: Vec<f64>,
    /// Largest sample in the bucket, unit of the series.
    pub high: Vec<f64>,
    /// Moving mean at the middle of the bucket, unit of the series.
    pub mean: Vec<f64>,
}

/// Means of consecutive blocks of `samples_per_block`, in order of time.
///
/// Blocks start again with every stretch; a remainder too short for a block is omitted.
///
/// # Panics
/// If `samples_per_block` is 0.
///
/// ```
/// use fos_fit::signal::blocks::block_means;
/// assert_eq!(block_means(&[&[1.0, 3.0, 100.0], &[5.0, 7.0]], 2), [2.0, 6.0]);
/// ```
pub fn block_means(stretches: &[&[f64]], samples_per_block: usize) -> Vec<f64> {
    stretches
        .iter()
        .flat_map(|stretch| stretch.chunks_exact(samples_per_block))
        .map(|block| block.iter().sum::<f64>() / samples_per_block as f64)
        .collect()
}

/// Slow error: variance of the means of blocks lasting `block_s`, unit² (1 s in every comparison).
///
/// The block is the whole number of samples nearest to `block_s`, at least one. `None` if fewer than two blocks fit.
pub fn slow_error(stretches: &[&[f64]], sample_period_s: f64, block_s: f64) -> Option<f64> {
    let means = block_means(stretches, samples_in(block_s, sample_period_s));
    (means.len() >= 2).then(|| super::variance(&[&means]))
}

/// Envelope of one stretch in at most `buckets` entries.
///
/// `start_s` is the time of its first sample. The mean is taken over `mean_s` centred on the bucket, or over the bucket
/// if that is longer; towards the ends of the stretch over the available samples. At 200 Hz the samples hide the course
/// of the mean, and the mean hides the peaks: a display needs both.
pub fn envelope(
    stretch: &[f64],
    start_s: f64,
    sample_period_s: f64,
    buckets: usize,
    mean_s: f64,
) -> Envelope {
    let buckets = buckets.min(stretch.len());
    let mean_reach = samples_in(mean_s, sample_period_s) / 2;
    let sums = cumulative_sums(stretch);
    let mut outline = Envelope::default();
    for bucket in 0..buckets {
        // integer arithmetic: buckets differ by at most one sample in length and cover all of the stretch
        let first = bucket * stretch.len() / buckets;
        let end = (bucket + 1) * stretch.len() / buckets;
        let middle = (first + end - 1) / 2;
        let mean_first = first.min(middle.saturating_sub(mean_reach));
        let mean_end = end.max((middle + mean_reach + 1).min(stretch.len()));
        let samples = &stretch[first..end];
        outline.time_s.push(start_s + 0.5 * (first + end - 1) as f64 * sample_period_s);
        outline.low.push(samples.iter().copied().fold(f64::INFINITY, f64::min));
        outline.high.push(samples.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        outline.mean.push(stretch[0] + (sums[mean_end] - sums[mean_first]) / (mean_end - mean_first) as f64);
    }
    outline
}

impl Envelope {
    /// Returns (time, low, high) of every bucket.
    pub fn band(&self) -> Vec<(f64, f64, f64)> {
        let edges = self.time_s.iter().zip(&self.low).zip(&self.high);
        edges.map(|((time, low), high)| (*time, *low, *high)).collect()
    }
}

/// Whole number of samples nearest to a duration, at least one.
fn samples_in(duration_s: f64, sample_period_s: f64) -> usize {
    ((duration_s / sample_period_s).round() as usize).max(1)
}

/// sums\[n\] = Σ over the first n samples of (x − x\[0\]), one longer than the stretch. Subtracting the first sample
/// preserves the digits of a small signal on a large offset.
pub(super) fn cumulative_sums(stretch: &[f64]) -> Vec<f64> {
    let mut sums = Vec::with_capacity(stretch.len() + 1);
    let mut sum = 0.0;
    sums.push(sum);
    for x in stretch {
        sum += x - stretch[0];
        sums.push(sum);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::white_noise;

    #[test]
    fn block_means_reduce_white_variance_by_their_length() {
        let noise = white_noise(1, 200 * 2000);
        let slow = slow_error(&[&noise], 0.005, 1.0).unwrap();
        // 2000 independent means: relative standard error √(2/2000) = 3.2 %, four of them
        assert!((slow * 200.0 - 1.0).abs() < 0.13, "{slow}");
    }

    #[test]
    fn slow_error_needs_two_blocks() {
        assert_eq!(slow_error(&[&[1.0; 399]], 0.005, 1.0), None);
        assert_eq!(slow_error(&[], 0.005, 1.0), None);
        assert_eq!(slow_error(&[&[1.0; 400]], 0.005, 1.0), Some(0.0));
    }

    #[test]
    fn envelope_contains_every_sample() {
        for (length, buckets) in [(1, 1), (10, 3), (999, 1000), (1000, 7), (12_345, 600)] {
            let series = white_noise(length as u64, length);
            let outline = envelope(&series, 0.0, 1.0, buckets, 1.0);
            let extreme = |values: &[f64], pick: fn(f64, f64) -> f64| values.iter().copied().reduce(pick);
            assert_eq!(extreme(&outline.low, f64::min), extreme(&series, f64::min));
            assert_eq!(extreme(&outline.high, f64::max), extreme(&series, f64::max));
            assert_eq!(outline.time_s.len(), buckets.min(length));
            for spike in [0, length / 2, length - 1] {
                let mut series = vec![0.0; length];
                series[spike] = 1.0;
                let peaks = envelope(&series, 0.0, 1.0, buckets, 1.0).high;
                assert_eq!(peaks.iter().sum::<f64>(), 1.0, "a sample lies in exactly one bucket");
            }
        }
    }

    #[test]
    fn mean_line_equals_a_direct_average_over_the_window() {
        let series: Vec<f64> = white_noise(3, 500).iter().map(|x| 9.81 + x).collect();
        let outline = envelope(&series, 100.0, 0.01, 100, 0.2);
        // bucket 50 holds samples 250..255, its middle is 252, and 0.1 s on either side are ten samples
        let direct = series[242..=262].iter().sum::<f64>() / 21.0;
        assert!((outline.mean[50] - direct).abs() < 1e-12, "rounding of 500 additions");
        assert!((outline.time_s[50] - 102.52).abs() < 1e-9);
    }

    #[test]
    fn envelope_of_nothing_is_empty() {
        assert_eq!(envelope(&[], 0.0, 1.0, 100, 1.0), Envelope::default());
        assert_eq!(envelope(&[1.0], 0.0, 1.0, 0, 1.0), Envelope::default());
    }
}

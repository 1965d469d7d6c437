//! Detects samples of two devices that alternate under one name.

/// Window in which the two are compared, samples: short enough that no message is missing in most.
const WINDOW: usize = 64;

/// Number of standard errors by which the two must differ in half of the windows. For one device, the median over the
/// windows of the largest of six differences is about 1.6.
const MIN_SIGMAS: f64 = 6.0;

/// Minimum alternating difference of the intervals between timestamps, as a share of their sum, in most windows. The
/// intervals of one device that is read evenly stay below.
const MIN_ALTERNATION: f64 = 0.1;

/// Returns true if every second sample is of another device: the intervals between the timestamps alternate, short and
/// long, and so do the levels of at least one axis.
///
/// Rounded timestamps alternate as well (2 ms and 3 ms at 400 Hz), and so do values under vibration at half the sampling
/// rate; one device seldom shows both.
pub(super) fn interleaved(stamps_s: &[f64], columns: &[&[f64]]) -> bool {
    let mut uneven = Vec::new();
    let mut apart = Vec::new();
    for begin in (0..stamps_s.len().saturating_sub(WINDOW)).step_by(WINDOW) {
        let stamps = &stamps_s[begin..=begin + WINDOW];
        let steps: Vec<f64> = stamps.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let (even, odd) = by_turns(&steps);
        let (even, odd) = (mean(&even), mean(&odd));
        uneven.push((even - odd).abs() / (even.abs() + odd.abs()).max(f64::MIN_POSITIVE));
        let most = columns.iter().map(|values| difference(&values[begin..begin + WINDOW]));
        apart.push(most.fold(0.0, f64::max));
    }
    let exceeds = |mut values: Vec<f64>, limit: f64| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).is_some_and(|median| *median > limit)
    };
    // too few windows are inconclusive
    uneven.len() >= 4 && exceeds(uneven, MIN_ALTERNATION) && exceeds(apart, MIN_SIGMAS)
}

fn by_turns(values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let of = |first: usize| values.iter().copied().skip(first).step_by(2).collect();
    (of(0), of(1))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Difference between the means of even and odd samples, in standard errors.
fn difference(values: &[f64]) -> f64 {
    let (even, odd) = by_turns(values);
    let variance = |values: &[f64]| {
        let mean = mean(values);
        values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len().max(2) - 1) as f64
    };
    let error = (variance(&even) / even.len() as f64 + variance(&odd) / odd.len() as f64).sqrt();
    let apart = (mean(&even) - mean(&odd)).abs();
    // values that never change are no evidence
    if apart > 0.0 && apart.is_finite() { apart / error.max(f64::MIN_POSITIVE) } else { 0.0 }
}

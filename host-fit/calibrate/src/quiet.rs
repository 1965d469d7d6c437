//! Stretches in which no axis moves more than its noise.

use std::ops::Range;

use fos_data::statistics::median;

use crate::imu::{Axes, Imu};

/// Length of the window whose variance is compared with the noise, s, and the fewest rows of one.
pub(crate) const WINDOW_S: f64 = 0.5;
pub(crate) const FEWEST_ROWS: usize = 5;

/// Largest share of missing values in a window.
const MAX_MISSING: f64 = 0.2;

/// Variance of every sliding window of one axis, and the noise of the axis at its quietest.
pub(crate) struct Windows {
    /// By the row in the middle of the window; infinite near the ends of a segment and where values are missing.
    pub(crate) variance: Vec<f64>,
    /// Variance of the noise.
    pub(crate) noise: f64,
}

impl Windows {
    pub(crate) fn of(values: &[f64], segments: &[Range<usize>], window: usize) -> Self {
        let mut variance = vec![f64::INFINITY; values.len()];
        for segment in segments.iter().filter(|segment| segment.len() >= window) {
            slide(&values[segment.clone()], window, &mut variance[segment.clone()]);
        }
        let apart: Vec<f64> =
            variance.iter().copied().step_by((window / 2).max(1)).filter(|v| v.is_finite()).collect();
        let noise = quietest(apart).max(step(values).powi(2) / 12.0).max(f64::MIN_POSITIVE);
        Self { variance, noise }
    }
}

/// The variance of each window, about its own mean.
fn slide(values: &[f64], window: usize, variance: &mut [f64]) {
    let first = values.iter().copied().find(|value| value.is_finite()).unwrap_or(0.0);
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0_usize);
    // the origin follows the values, so that the difference of two large sums does not lose the variance
    let mut origin = first;
    for end in 0..values.len() {
        let mut take = |value: f64, sign: f64| {
            if value.is_finite() {
                let x = value - origin;
                sum += sign * x;
                squares += sign * x * x;
                count = if sign > 0.0 { count + 1 } else { count - 1 };
            }
        };
        take(values[end], 1.0);
        if end >= window {
            take(values[end - window], -1.0);
        }
        if end % 4096 == 4095 {
            origin = if values[end].is_finite() { values[end] } else { first };
            let begin = (end + 1).saturating_sub(window);
            let inside = || values[begin..=end].iter().filter(|value| value.is_finite()).map(|v| v - origin);
            (sum, squares, count) = (inside().sum(), inside().map(|x| x * x).sum(), inside().count());
        }
        if end + 1 >= window && (count as f64) >= (1.0 - MAX_MISSING) * window as f64 {
            let mean = sum / count as f64;
            variance[end + 1 - window.div_ceil(2)] = (squares / count as f64 - mean * mean).max(0.0);
        }
    }
}

/// The variance of the quiet windows: the median of those below four times the tenth percentile.
fn quietest(mut variances: Vec<f64>) -> f64 {
    if variances.is_empty() {
        return 0.0;
    }
    variances.sort_unstable_by(f64::total_cmp);
    // windows in which a coarse axis does not move at all say nothing about its noise
    let moving = variances.partition_point(|v| *v <= 0.0);
    let some = &variances[moving..];
    let Some(low) = some.get(some.len() / 10) else { return 0.0 };
    let mut quiet: Vec<f64> = some.iter().copied().take_while(|v| *v <= 4.0 * low).collect();
    median(&mut quiet)
}

/// The step of a digital axis: its smallest change. Close to 0 where the values are not on a grid.
pub(crate) fn step(values: &[f64]) -> f64 {
    let changes = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|change| *change > 0.0);
    let smallest = changes.fold(f64::INFINITY, f64::min);
    if smallest.is_finite() { smallest } else { 0.0 }
}

/// Rows in which every axis of every sensor varies by less than `ratio` times its noise variance: contiguous, in order.
pub(crate) fn quiet(imu: &Imu, windows: &[Windows], ratio: f64) -> Vec<Range<usize>> {
    let is_quiet = |row: usize| windows.iter().all(|axis| axis.variance[row] <= ratio * axis.noise);
    imu.segments.iter().flat_map(|segment| fos_data::recording::runs(segment.clone(), is_quiet)).collect()
}

/// The windows of all axes that a log has.
pub(crate) fn windows(imu: &Imu) -> Vec<Windows> {
    let length = imu.rows_in(WINDOW_S, FEWEST_ROWS);
    let axes = |axes: &Option<Axes>| -> Vec<Windows> {
        let values = axes.iter().flat_map(|axes| axes.values.iter());
        values.map(|values| Windows::of(values, &imu.segments, length)).collect()
    };
    let mut all = axes(&imu.accelerometer);
    all.extend(axes(&imu.gyro));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The brute-force twin: the variance of each window by its definition.
    #[test]
    fn sliding_variances_are_those_of_the_windows() {
        let values: Vec<f64> =
            (0..9000).map(|n| 33_000.0 + (n as f64 * 0.37).sin() * 3.0 + (n / 700) as f64 * 40.0).collect();
        let mut variance = vec![f64::INFINITY; values.len()];
        slide(&values, 50, &mut variance);
        for start in (0..values.len() - 50).step_by(97) {
            let window = &values[start..start + 50];
            let mean = window.iter().sum::<f64>() / 50.0;
            let direct = window.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 50.0;
            assert!((variance[start + 25] - direct).abs() < 1e-5 * direct.max(1.0), "{start}");
        }
        assert!(variance[..25].iter().all(|v| v.is_infinite()));
    }
}

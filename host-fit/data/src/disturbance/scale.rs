//! Energy of one axis on one time scale: second differences of block means, which are invariant to level and steady
//! drift.
//!
//! Blocks begin at every row and windows overlap by 15 sixteenths, so that a detection does not depend on the first row
//! of a log.

use std::cell::Cell;
use std::ops::Range;

use crate::recording::{Segment, runs};
use crate::statistics::{MAD_TO_SD, finite_median};

/// Blocks of a window: enough to determine its energy to a third.
const WINDOW_BLOCKS: usize = 8;

/// Minimum length of a window, s: about the ringing of a knock.
const SHORTEST_WINDOW_S: f64 = 0.25;

/// Limit of the sum of the squared excess of all axes but the largest: chance reaches 30 less often than once in a
/// million windows. With this overlap some four times as many windows are independent: 2 ln 4 more.
pub(super) const FAR: f64 = 33.0;

/// Score from which the windows before and after one above [`FAR`] belong to it.
pub(super) const NEAR: f64 = 7.0;

/// Number of windows whose energies are computed at a time.
const WINDOWS_AT_ONCE: usize = 512;

/// Number of window starts in the length of one window.
const OVERLAP: usize = 16;

/// The windows of one time scale.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    /// Length of a block, rows.
    pub(super) block: usize,
    /// Length of a window, rows.
    pub(super) window: usize,
    /// Distance of consecutive windows, rows.
    pub(super) stride: usize,
    /// Margin of a barely detected event on either side, rows.
    pub(super) margin: usize,
}

impl Scale {
    /// Scale with blocks of 2^`level` rows.
    pub(super) fn new(level: u32, period_s: f64) -> Self {
        let block = 1 << level;
        let rows = (SHORTEST_WINDOW_S / period_s).ceil() as usize;
        let window = block * WINDOW_BLOCKS.max(rows.div_ceil(block));
        let stride = (window / OVERLAP).max(1);
        Self { block, window: window / stride * stride, stride, margin: (2 * block).max(rows / 2) }
    }

    /// Number of windows in `n` rows.
    pub(super) fn windows(&self, n: usize) -> usize {
        n.checked_sub(self.window).map_or(0, |room| room / self.stride + 1)
    }

    /// Rows of the window with this index.
    pub(super) fn rows(&self, window: usize) -> Range<usize> {
        window * self.stride..window * self.stride + self.window
    }

    /// Second difference of block means about the block that begins at `row`; NaN where a value is missing.
    /// `means[row]` is the mean of the block that begins there.
    pub(super) fn second_difference(&self, means: &[f64], row: usize) -> f64 {
        second_difference(means[row - self.block], means[row], means[row + self.block])
    }

    /// Rows of a segment at which all three blocks of a second difference are within it.
    pub(super) fn inner(&self, segment: &Segment) -> Range<usize> {
        let first = segment.rows.start + self.block;
        first..(segment.rows.end + 1).saturating_sub(2 * self.block).max(first)
    }

    /// ln of the mean square of the second differences in each window; NaN where fewer than half are known.
    pub(super) fn log_energy(&self, means: &[f64], segments: &[Segment]) -> Vec<f64> {
        let (n, width) = (self.windows(means.len()), self.window / self.stride);
        let mut energies = Vec::with_capacity(n);
        // some at a time: all axes are here at once, and a log is long
        for first in (0..n).step_by(WINDOWS_AT_ONCE) {
            let end = (first + WINDOWS_AT_ONCE).min(n);
            let sums = sliding_sums(self.pieces(means, segments, first..end + width - 1), width);
            energies.extend(sums.iter().map(|[sum, count]| log_mean(*sum, *count as usize, self.window)));
        }
        energies
    }

    /// Sum of squares and number of second differences in each of these strides. The numbers are exact in f64.
    fn pieces(&self, means: &[f64], segments: &[Segment], strides: Range<usize>) -> Vec<[f64; 2]> {
        let mut pieces = vec![[0.0_f64; 2]; strides.len()];
        let rows = strides.start * self.stride..strides.end * self.stride;
        let first = segments.partition_point(|segment| segment.rows.end <= rows.start);
        for segment in segments[first..].iter().take_while(|segment| segment.rows.start < rows.end) {
            let inner = self.inner(segment);
            let (mut start, inner_end) = (inner.start.max(rows.start), inner.end.min(rows.end));
            while start < inner_end {
                let stride = start / self.stride;
                let end = ((stride + 1) * self.stride).min(inner_end);
                let before = &means[start - self.block..end - self.block];
                let after = &means[start + self.block..end + self.block];
                let [sum, count] = &mut pieces[stride - strides.start];
                for ((at, before), after) in means[start..end].iter().zip(before).zip(after) {
                    let second = second_difference(*before, *at, *after);
                    let is_known = second.is_finite();
                    *sum += if is_known { second * second } else { 0.0 };
                    *count += f64::from(u8::from(is_known));
                }
                start = end;
            }
        }
        pieces
    }

    /// Means of blocks twice as long; NaN where a value is missing.
    pub(super) fn doubled(&self, mut means: Vec<f64>) -> Vec<f64> {
        let rows = Cell::from_mut(&mut means[..]).as_slice_of_cells();
        for (mean, after) in rows.iter().zip(rows.iter().skip(self.block)) {
            mean.set(0.5 * (mean.get() + after.get()));
        }
        let known = means.len().saturating_sub(self.block);
        means[known..].fill(f64::NAN);
        means
    }

    /// Sets the means of all blocks that contain one of these rows to NaN.
    pub(super) fn forget(&self, means: &mut [f64], rows: &Range<usize>) {
        means[(rows.start + 1).saturating_sub(self.block)..rows.end].fill(f64::NAN);
    }
}

fn second_difference(before: f64, at: f64, after: f64) -> f64 {
    before - 2.0 * at + after
}

/// Sums of `width` consecutive elements, from every element on. Sums of 1, 2, 4, … elements make up any width, so each
/// costs a few additions however wide it is.
fn sliding_sums(mut powers: Vec<[f64; 2]>, width: usize) -> Vec<[f64; 2]> {
    let mut sums = vec![[0.0; 2]; (powers.len() + 1).saturating_sub(width)];
    // in place, for every sum takes elements from its own on: a log is long
    let powers = Cell::from_mut(&mut powers[..]).as_slice_of_cells();
    let (mut taken, mut power) = (0, 1);
    while taken < width {
        if width & power != 0 {
            let rest = powers.iter().skip(taken);
            sums.iter_mut().zip(rest).for_each(|(sum, more)| *sum = plus(*sum, more.get()));
            taken += power;
        }
        let next = powers.iter().skip(power);
        powers.iter().zip(next).for_each(|(one, next)| one.set(plus(one.get(), next.get())));
        power *= 2;
    }
    sums
}

fn plus(one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    [one[0] + other[0], one[1] + other[1]]
}

/// ln of the mean of `count` squares; NaN if fewer than half of `of` are known.
pub(super) fn log_mean(sum: f64, count: usize, of: usize) -> f64 {
    if 2 * count >= of && sum > 0.0 { (sum / count as f64).ln() } else { f64::NAN }
}

/// Usual level around each window: medians of pieces of `piece` windows, and the running median of five of them. An
/// event shorter than two and a half pieces does not change it; a longer one is followed to its edge.
pub(super) fn local_level(log_energy: &[f64], piece: usize) -> Vec<f64> {
    let medians: Vec<f64> = log_energy.chunks(piece.max(1)).map(median_of_known).collect();
    let around = |at: usize| median_of_known(&medians[at.saturating_sub(2)..(at + 3).min(medians.len())]);
    let smooth: Vec<f64> = (0..medians.len()).map(around).collect();
    (0..log_energy.len()).map(|window| smooth[window / piece.max(1)]).collect()
}

/// Median of the finite values; NaN if there are none.
pub(super) fn median_of_known(values: &[f64]) -> f64 {
    finite_median(values).unwrap_or(f64::NAN)
}

/// Lower limit of the scatter, below which an estimate comes from too few values.
const MIN_SCATTER: f64 = 0.1;

/// Usual energy of one axis on one time scale, window by window.
#[derive(Debug)]
pub(super) struct Usual {
    /// Level, window by window.
    pub(super) level: Vec<f64>,
    /// Windows without and with vibration scatter differently.
    is_shaken: Vec<bool>,
    scatter: [f64; 2],
}

impl Usual {
    /// Scatter of the energy about `level`.
    pub(super) fn about(level: Vec<f64>, is_shaken: Vec<bool>, log_energy: &[f64]) -> Self {
        let scatter = [false, true].map(|shaken| {
            let windows = log_energy.iter().zip(&level).zip(&is_shaken);
            let off: Vec<f64> = windows
                .filter(|(_, is_shaken)| **is_shaken == shaken)
                .map(|((energy, level), _)| (energy - level).abs())
                .collect();
            // the maximum with NaN is the other value
            (MAD_TO_SD * median_of_known(&off)).max(MIN_SCATTER)
        });
        Self { level, is_shaken, scatter }
    }

    /// Excess of the energy of a window above its level, in standard deviations; 0 if below or unknown.
    pub(super) fn excess(&self, window: usize, log_energy: f64) -> f64 {
        let scatter = self.scatter[usize::from(self.is_shaken[window])];
        let above = (log_energy - self.level[window]) / scatter;
        if above.is_finite() { above.max(0.0) } else { 0.0 }
    }
}

/// Sum of the squared excess of all axes but the largest.
pub(super) fn sum_but_most(excess: impl Iterator<Item = f64>) -> f64 {
    let squares = excess.map(|excess| excess.powi(2));
    let (sum, most) = squares.fold((0.0, 0.0_f64), |(sum, most), square| (sum + square, most.max(square)));
    sum - most
}

/// Merges stretches of flagged rows less than `within` rows apart.
pub(super) fn stretches(flags: &[bool], within: usize) -> Vec<Range<usize>> {
    let mut all: Vec<Range<usize>> = Vec::new();
    for rows in runs(0..flags.len(), |row| flags[row]) {
        match all.last_mut() {
            Some(last) if rows.start - last.end < within => last.end = rows.end,
            _ => all.push(rows),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Boundary;
    use fos_testkit::noise::Noise;

    /// Against the sum over the rows of each window, for widths with and without binary digits, gaps and short segments.
    #[test]
    fn energy_is_the_mean_square_of_each_window() {
        let mut noise = Noise::new(5);
        for (level, period_s) in [(0, 0.005), (0, 0.01), (2, 0.02), (4, 0.005)] {
            let scale = Scale::new(level, period_s);
            let mut means: Vec<f64> = (0..3000).map(|_| noise.normal()).collect();
            means[700..900].fill(f64::NAN);
            let segment = |rows: Range<usize>, tick| Segment {
                rows,
                tick,
                missing_before: 0,
                boundary: Boundary::Start,
            };
            let segments = [segment(0..1201, 0), segment(1201..1203, 1300), segment(1203..3000, 1400)];
            let found = scale.log_energy(&means, &segments);
            assert_eq!(found.len(), scale.windows(means.len()));
            for (window, found) in found.into_iter().enumerate() {
                let of_segment = |segment: &Segment| {
                    let rows = scale.rows(window);
                    let inner = scale.inner(segment);
                    (inner.start.max(rows.start)..inner.end.min(rows.end))
                        .map(|row| scale.second_difference(&means, row).powi(2))
                        .filter(|square| square.is_finite())
                        .collect::<Vec<f64>>()
                };
                let squares: Vec<f64> = segments.iter().flat_map(of_segment).collect();
                let direct = log_mean(squares.iter().sum(), squares.len(), scale.window);
                // as many roundings as additions
                let agrees = (found - direct).abs() < 1e-12 || found.is_nan() && direct.is_nan();
                assert!(agrees, "{level} {window}: {found} {direct}");
            }
        }
    }
}

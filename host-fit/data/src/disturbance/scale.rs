//! The energy of one axis on one time scale: second differences of block means, which no level and no steady drift
//! moves.

use crate::statistics::{MAD_TO_SD, finite_median};

/// Blocks of a window: enough for its energy to be known to a third.
const WINDOW_BLOCKS: usize = 8;

/// And so long at least, s: a knock rings for about that.
const SHORTEST_WINDOW_S: f64 = 0.25;

/// The windows of one time scale.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    /// Rows of a block.
    pub(super) block: usize,
    /// Rows of a window.
    pub(super) window: usize,
    /// Rows on either side of what only just stands out that belong to it.
    pub(super) margin: usize,
}

impl Scale {
    /// Of blocks of 2^`level` rows.
    pub(super) fn new(level: u32, period_s: f64) -> Self {
        let block = 1 << level;
        let rows = (SHORTEST_WINDOW_S / period_s).ceil() as usize;
        let window = block * WINDOW_BLOCKS.max(rows.div_ceil(block));
        Self { block, window, margin: (2 * block).max(rows / 2) }
    }

    /// ln of the mean square of the second differences in each window; NaN where fewer than half are known. `joins`
    /// says whether block k goes with the two before it.
    pub(super) fn log_energy(&self, means: &[f64], joins: &[bool]) -> Vec<f64> {
        let per_window = self.window / self.block;
        let of = |window: usize| {
            let (mut sum, mut count) = (0.0, 0_usize);
            for k in (window * per_window).max(2)..((window + 1) * per_window).min(means.len()) {
                let second = means[k] - 2.0 * means[k - 1] + means[k - 2];
                if joins[k] && second.is_finite() {
                    sum += second * second;
                    count += 1;
                }
            }
            match 2 * count >= per_window && sum > 0.0 {
                true => (sum / count as f64).ln(),
                false => f64::NAN,
            }
        };
        (0..means.len().div_ceil(per_window)).map(of).collect()
    }
}

/// Means of pairs; NaN where one is not known.
pub(super) fn halved(means: &[f64]) -> Vec<f64> {
    means.chunks_exact(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
}

/// The usual level around each window: medians of pieces of `piece` windows, and the median of five of them. What lasts
/// for less than two and a half pieces does not move it, what lasts longer is followed to the edge.
pub(super) fn local_level(log_energy: &[f64], piece: usize) -> Vec<f64> {
    let medians: Vec<f64> = log_energy.chunks(piece.max(1)).map(median_of_known).collect();
    let around = |at: usize| median_of_known(&medians[at.saturating_sub(2)..(at + 3).min(medians.len())]);
    let smooth: Vec<f64> = (0..medians.len()).map(around).collect();
    (0..log_energy.len()).map(|window| smooth[window / piece.max(1)]).collect()
}

/// Median of what is known; NaN of nothing.
pub(super) fn median_of_known(values: &[f64]) -> f64 {
    finite_median(values).unwrap_or(f64::NAN)
}

/// Scatter below this is that of too few values.
const LEAST_SCATTER: f64 = 0.1;

/// By how many of its standard deviations the energy is above its level; what is not known is not.
pub(super) fn excess(log_energy: &[f64], level: &[f64]) -> Vec<f64> {
    let above: Vec<f64> = log_energy.iter().zip(level).map(|(energy, level)| energy - level).collect();
    let off: Vec<f64> = above.iter().map(|above| above.abs()).collect();
    let scatter = (MAD_TO_SD * median_of_known(&off)).max(LEAST_SCATTER);
    above.into_iter().map(|above| if above.is_finite() { above / scatter } else { 0.0 }).collect()
}

//! Outliers: single samples, or a few in a row, far from their neighbours.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use crate::statistics::{MAD_TO_SD, median};

/// Number of values on either side that a value is compared with, and maximum number of consecutive outliers.
const REACH: usize = 5;

/// Minimum distance of an outlier in standard deviations, and as a multiple of that of all but a thousandth of the
/// values: normal noise never reaches it, and noise with tails as wide as Laplace's in one sample in 10⁷.
const MIN_SIGMAS: f64 = 8.0;
const MIN_TAIL_RATIO: f64 = 2.5;

/// Minimum distance near the ends of a stretch, in standard deviations: the device may have begun to move there.
const MIN_SIGMAS_AT_END: f64 = 30.0;

/// Minimum ratio to the distances of all but [`REACH`] of the values in `ISOLATION_ROWS` rows before and after, which
/// the onset of shaking does not reach.
const MIN_ISOLATION: f64 = 5.0;
const ISOLATION_ROWS: usize = 25;

/// Largest share of outliers among the rows; with more the noise is intermittent.
const MAX_SHARE: f64 = 1e-3;

#[derive(Debug, Clone, PartialEq)]
pub struct Spikes {
    /// Rows of the outliers, in order.
    pub rows: Vec<usize>,
    /// The largest one: row, value, and distance in standard deviations of the values about their neighbours.
    pub worst: (usize, f64, f64),
}

/// Finds the outliers in gap-free `stretches` of rows: values further than 8 standard deviations from the median of
/// their neighbourhood, far beyond the tail of all, and five times as far as their neighbours. `None` if they exceed a
/// thousandth of the rows, or for too few values.
pub fn spikes(values: &[f64], stretches: &[Range<usize>]) -> Option<Spikes> {
    // row by row, NaN where unknown: all axes may be searched at the same time, and a log is long
    let mut off = vec![f64::NAN; values.len()];
    for stretch in stretches {
        write_distances(&values[stretch.clone()], &mut off[stretch.clone()]);
    }
    let known = || off.iter().copied().filter(|off| !off.is_nan());
    let n_known = known().count();
    let mut sizes = Vec::with_capacity(n_known);
    sizes.extend(known());
    let mut deviation = MAD_TO_SD * median(&mut sizes);
    if deviation <= 0.0 {
        // coarse steps: most values equal their neighbours, and noise that reaches the next code is no outlier
        let step = known().filter(|off| *off > 0.0).fold(f64::INFINITY, f64::min);
        let mean = known().sum::<f64>() / n_known.max(1) as f64;
        deviation = if step.is_finite() { mean.max(step / MIN_SIGMAS) } else { 0.0 };
    }
    if deviation <= 0.0 {
        return None;
    }
    let stands_alone = |row: usize| {
        let near = &off[row.saturating_sub(ISOLATION_ROWS)..(row + ISOLATION_ROWS + 1).min(off.len())];
        let mut others: Vec<f64> = near.iter().copied().filter(|off| !off.is_nan()).collect();
        let place = others.len().saturating_sub(REACH + 1);
        off[row] > MIN_ISOLATION * *others.select_nth_unstable_by(place, f64::total_cmp).1
    };
    let tail = sizes.len() - 1 - sizes.len() / 1000;
    let tail = *sizes.select_nth_unstable_by(tail, f64::total_cmp).1;
    // a thousandth may be outliers themselves, which then are the tail
    let far = (MIN_SIGMAS * deviation).max((MIN_TAIL_RATIO * tail).min(MIN_SIGMAS_AT_END * deviation));
    let rows_far = |stretch: &Range<usize>| {
        let measured = || stretch.clone().filter(|row| values[*row].is_finite());
        let n = measured().count();
        let is_far = |(at, row): (usize, usize)| {
            let is_inside = (REACH..n - REACH.min(n)).contains(&at);
            let limit = if is_inside { far } else { MIN_SIGMAS_AT_END * deviation };
            (off[row] > limit && stands_alone(row)).then_some(row)
        };
        measured().enumerate().filter_map(is_far).collect::<Vec<usize>>()
    };
    let rows: Vec<usize> = stretches.iter().flat_map(rows_far).collect();
    let worst = rows.iter().copied().max_by(|a, b| off[*a].total_cmp(&off[*b]))?;
    let few = rows.len() <= ((MAX_SHARE * n_known as f64) as usize).max(1);
    few.then(|| Spikes { rows, worst: (worst, values[worst], off[worst] / deviation) })
}

/// Writes the distance of each value from the median of its neighbourhood; NaN for a missing value and among too few.
fn write_distances(values: &[f64], off: &mut [f64]) {
    if values.iter().all(|value| value.is_finite()) {
        write_medians(values, off);
    } else {
        let known: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
        let mut medians = vec![f64::NAN; known.len()];
        write_medians(&known, &mut medians);
        let places = values.iter().zip(&mut *off).filter(|(value, _)| value.is_finite());
        places.zip(medians).for_each(|((_, place), median)| *place = median);
    }
    off.iter_mut().zip(values).for_each(|(off, value)| *off = (value - *off).abs());
}

/// Writes the median of each value and of up to [`REACH`] values on either side; nothing among too few.
fn write_medians(values: &[f64], medians: &mut [f64]) {
    let n = values.len();
    let inside = (n + 1).saturating_sub(LANES + WINDOW - 1).div_ceil(LANES) * LANES;
    for at in (0..REACH.min(n)).chain(REACH + inside..n) {
        let mut around = values[at.saturating_sub(REACH)..(at + REACH + 1).min(n)].to_vec();
        if around.len() > REACH {
            medians[at] = median(&mut around);
        }
    }
    if inside > 0 {
        Arch::new().dispatch(Inside { values, medians: &mut medians[REACH..REACH + inside] });
    }
}

/// Medians of complete windows, several at once in vector registers, each a value further on.
struct Inside<'a> {
    values: &'a [f64],
    medians: &'a mut [f64],
}

impl WithSimd for Inside<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { values, medians } = self;
        let around = values.windows(LANES + WINDOW - 1).step_by(LANES);
        let around = around.filter_map(<[f64]>::first_chunk);
        for (medians, around) in medians.chunks_exact_mut(LANES).zip(around) {
            medians.copy_from_slice(&medians_of(around));
        }
    }
}

/// Number of windows processed at once.
const LANES: usize = 8;

const WINDOW: usize = 2 * REACH + 1;

/// Medians of the windows that begin at each of the first [`LANES`] values. Of seven values out of eleven neither the
/// smallest nor the largest is the median: both are dropped, the next value is added, and so on until one remains
/// (Paeth, Median finding on a 3 × 3 grid, Graphics Gems, 1990).
#[inline(always)]
fn medians_of(values: &[f64; LANES + WINDOW - 1]) -> [f64; LANES] {
    let mut window: [[f64; LANES]; WINDOW] =
        std::array::from_fn(|at| std::array::from_fn(|lane| values[lane + at]));
    let end = REACH + 2;
    let mut first = 0;
    for next in end..=WINDOW {
        for at in first + 1..end {
            exchange(&mut window, first, at);
        }
        for at in first + 1..end - 1 {
            exchange(&mut window, at, end - 1);
        }
        first += 1;
        if next < WINDOW {
            window[end - 1] = window[next];
        }
    }
    window[first]
}

/// Moves the smaller of two to the first place, lane by lane.
#[inline(always)]
fn exchange(window: &mut [[f64; LANES]; WINDOW], first: usize, second: usize) {
    let (one, other) = (window[first], window[second]);
    for lane in 0..LANES {
        let is_less = one[lane] < other[lane];
        window[first][lane] = if is_less { one[lane] } else { other[lane] };
        window[second][lane] = if is_less { other[lane] } else { one[lane] };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::{random_walk, white_noise};

    fn found(values: &[f64]) -> Vec<usize> {
        spikes(values, std::slice::from_ref(&(0..values.len()))).map_or_else(Vec::new, |spikes| spikes.rows)
    }

    #[test]
    fn finds_an_outlier_at_any_position() {
        for row in [0, 1, 500, 998, 999] {
            let mut values = white_noise(3, 1000);
            values[row] = -32_768.0;
            assert_eq!(found(&values), [row]);
        }
    }

    #[test]
    fn the_moving_median_is_that_of_each_window() {
        for length in (0..40).chain([200, 3000]) {
            let values: Vec<f64> = white_noise(9, length).iter().map(|x| (4.0 * x).round()).collect();
            let expected = (0..length).map(|at| {
                let mut window = values[at.saturating_sub(REACH)..(at + REACH + 1).min(length)].to_vec();
                if window.len() > REACH { median(&mut window) } else { f64::INFINITY }
            });
            let mut medians = vec![f64::INFINITY; length];
            write_medians(&values, &mut medians);
            assert_eq!(medians, expected.collect::<Vec<_>>(), "{length}");
        }
    }

    #[test]
    fn noise_walks_steps_and_bursts_have_no_outliers() {
        // twelve of 4000 samples reach the next code
        let rare: Vec<f64> = white_noise(7, 4000).iter().map(|x| (x * 0.168).round()).collect();
        assert!((3..30).contains(&rare.iter().filter(|value| **value != 0.0).count()));
        let step: Vec<f64> = white_noise(1, 4000)
            .iter()
            .enumerate()
            .map(|(row, x)| x + if row > 1900 { 500.0 } else { 0.0 })
            .collect();
        let burst: Vec<f64> = white_noise(2, 4000)
            .iter()
            .enumerate()
            .map(|(row, x)| if (1000..1400).contains(&row) { 200.0 * x } else { *x })
            .collect();
        let coarse: Vec<f64> = white_noise(4, 4000).iter().map(|x| (x * 0.4).round()).collect();
        for values in
            [white_noise(5, 100_000), random_walk(6, 4000), step, burst, coarse, rare, vec![2.5; 1000]]
        {
            assert!(found(&values).is_empty());
        }
    }
}

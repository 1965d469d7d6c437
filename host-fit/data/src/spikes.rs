//! Samples that are no measurements: single values, or a few, far off those around them.

use std::ops::Range;

use crate::statistics::{MAD_TO_SD, median};

/// Values on either side that a value is held against: so many in a row, at most, can be a spike.
const REACH: usize = 5;

/// A spike is so many standard deviations off, and so many times as far as all but a thousandth of the values: normal
/// noise never is, and of noise with tails as wide as Laplace's one sample in 10⁷.
const FAR: f64 = 8.0;
const BEYOND_TAIL: f64 = 2.5;

/// At the end of a stretch it is so many: there the unit may have begun to move.
const FAR_AT_AN_END: f64 = 30.0;

/// And it stands alone: so many times as far off as all but [`REACH`] of the values as many rows before and after.
/// Shaking that begins does not.
const ALONE: f64 = 5.0;
const AROUND: usize = 25;

/// More than this share of the rows are no spikes: the noise comes and goes.
const MOST: f64 = 1e-3;

/// Spikes of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct Spikes {
    /// Their rows, in order.
    pub rows: Vec<usize>,
    /// The one furthest off: its row, its value, and by how many standard deviations of the values about their
    /// neighbours.
    pub worst: (usize, f64, f64),
}

/// The spikes among `stretches` of rows without gaps: values further than 8 standard deviations from the median of those
/// around them, far beyond the tail of all, and five times as far off as their neighbours. None where there are more of
/// them than a thousandth, or too few values to tell.
pub fn spikes(values: &[f64], stretches: &[Range<usize>]) -> Option<Spikes> {
    let mut off: Vec<(usize, f64)> = Vec::new();
    let mut is_inside: Vec<bool> = Vec::new();
    for stretch in stretches {
        let known: Vec<usize> = stretch.clone().filter(|row| values[*row].is_finite()).collect();
        let inside = REACH..known.len() - REACH.min(known.len());
        for (at, middle) in medians_around(&known, values).enumerate() {
            if let Some(middle) = middle {
                off.push((known[at], (values[known[at]] - middle).abs()));
                is_inside.push(inside.contains(&at));
            }
        }
    }
    let deviation = MAD_TO_SD * median(&mut off.iter().map(|(_, off)| *off).collect::<Vec<_>>());
    // coarse steps: most values are their neighbours'
    let mean = off.iter().map(|(_, off)| off).sum::<f64>() / off.len().max(1) as f64;
    let deviation = if deviation > 0.0 { deviation } else { mean };
    if deviation <= 0.0 {
        return None;
    }
    let stands_alone = |at: usize| {
        let (row, own) = off[at];
        let near = &off[at.saturating_sub(AROUND)..(at + AROUND + 1).min(off.len())];
        let mut others: Vec<f64> =
            near.iter().filter(|(other, _)| other.abs_diff(row) <= AROUND).map(|(_, off)| *off).collect();
        let place = others.len().saturating_sub(REACH + 1);
        own > ALONE * *others.select_nth_unstable_by(place, f64::total_cmp).1
    };
    let mut sizes: Vec<f64> = off.iter().map(|(_, off)| *off).collect();
    let tail = sizes.len() - 1 - sizes.len() / 1000;
    let tail = *sizes.select_nth_unstable_by(tail, f64::total_cmp).1;
    // a thousandth may be spikes themselves, which then are the tail
    let far = (FAR * deviation).max((BEYOND_TAIL * tail).min(FAR_AT_AN_END * deviation));
    let is_far = |at: &usize| {
        let (_, own) = off[*at];
        own > if is_inside[*at] { far } else { FAR_AT_AN_END * deviation } && stands_alone(*at)
    };
    let far: Vec<(usize, f64)> = (0..off.len()).filter(is_far).map(|at| off[at]).collect();
    let worst = far.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let few = far.len() <= ((MOST * off.len() as f64) as usize).max(1);
    few.then(|| Spikes {
        rows: far.iter().map(|(row, _)| *row).collect(),
        worst: (worst.0, values[worst.0], worst.1 / deviation),
    })
}

/// The median of the values of each row and of up to [`REACH`] on either side; none of too few. The window stays sorted
/// while it moves.
fn medians_around<'a>(known: &'a [usize], values: &'a [f64]) -> impl Iterator<Item = Option<f64>> + 'a {
    let mut window: Vec<f64> = Vec::with_capacity(2 * REACH + 2);
    let place = |window: &[f64], value: f64| window.partition_point(|other| other.total_cmp(&value).is_lt());
    let add = move |window: &mut Vec<f64>, row: usize| {
        let at = place(window, values[row]);
        window.insert(at, values[row]);
    };
    known.iter().take(REACH).for_each(|row| add(&mut window, *row));
    (0..known.len()).map(move |at| {
        if let Some(row) = known.get(at + REACH) {
            add(&mut window, *row);
        }
        if let Some(gone) = at.checked_sub(REACH + 1) {
            window.remove(place(&window, values[known[gone]]));
        }
        (window.len() > REACH).then(|| window[window.len() / 2])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::{random_walk, white_noise};

    fn found(values: &[f64]) -> Vec<usize> {
        spikes(values, std::slice::from_ref(&(0..values.len()))).map_or_else(Vec::new, |spikes| spikes.rows)
    }

    #[test]
    fn a_wild_sample_is_found_wherever_it_is() {
        for row in [0, 1, 500, 998, 999] {
            let mut values = white_noise(3, 1000);
            values[row] = -32_768.0;
            assert_eq!(found(&values), [row]);
        }
    }

    #[test]
    fn the_moving_median_is_that_of_each_window() {
        for length in [0, 1, 5, 6, 7, 11, 12, 200] {
            let values: Vec<f64> = white_noise(9, length).iter().map(|x| (4.0 * x).round()).collect();
            let known: Vec<usize> = (0..length).filter(|row| row % 7 != 3).collect();
            let found: Vec<Option<f64>> = medians_around(&known, &values).collect();
            let expected = (0..known.len()).map(|at| {
                let around = &known[at.saturating_sub(REACH)..(at + REACH + 1).min(known.len())];
                let mut window: Vec<f64> = around.iter().map(|row| values[*row]).collect();
                (window.len() > REACH).then(|| median(&mut window))
            });
            assert_eq!(found, expected.collect::<Vec<_>>(), "{length}");
        }
    }

    #[test]
    fn noise_walks_steps_and_bursts_have_none() {
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
        for values in [white_noise(5, 100_000), random_walk(6, 4000), step, burst, coarse, vec![2.5; 1000]] {
            assert!(found(&values).is_empty());
        }
    }
}

//! Stretches in which an axis holds its value although it measures noise: a register that was not renewed.

use std::ops::Range;

/// Shorter repeats are left to chance.
const FEWEST: usize = 10;

/// Chance makes one run of so many repeats in so many logs, by the share of neighbours that are equal.
const ODDS: f64 = 1e-4;

/// Repeats that are so many times as long as the longest of nearly all others are none of a converter with coarse steps.
const LONGER: usize = 3;

/// A converter with coarse steps makes so many runs of repeats at least.
const RUNS_OF_A_CONVERTER: usize = 100;

/// More than this share of the values: coarse steps, or a sensor that is read more often than it measures.
const MOST: f64 = 0.02;

/// The rows, within `stretches` without gaps, that repeat a value for longer than chance would have it; the first of
/// each run is a measurement and not among them.
pub fn stuck(values: &[f64], stretches: &[Range<usize>]) -> Vec<Range<usize>> {
    let runs: Vec<Range<usize>> = stretches.iter().flat_map(|rows| repeats(values, rows.clone())).collect();
    let known: usize = stretches.iter().map(Range::len).sum();
    let mut lengths: Vec<usize> = runs.iter().map(Range::len).collect();
    lengths.sort_unstable();
    // of a few repeats in a whole log none is usual
    let usual = match lengths.len() {
        0..RUNS_OF_A_CONVERTER => 0,
        count => lengths[count - 4 - count / 1000],
    };
    let is_equal = lengths.iter().filter(|length| **length <= usual).sum::<usize>().max(1);
    let share = (is_equal as f64 / known.max(1) as f64).clamp(1e-3, 0.999);
    let by_chance = ((ODDS / known.max(1) as f64).ln() / share.ln()).ceil() as usize;
    let least = by_chance.max(FEWEST).max(LONGER * usual);
    let stuck: Vec<Range<usize>> = runs.into_iter().filter(|run| run.len() >= least).collect();
    let is_few = (stuck.iter().map(Range::len).sum::<usize>() as f64) < MOST * known as f64;
    if is_few { stuck } else { Vec::new() }
}

/// Rows that have the value of the one before them, run by run.
fn repeats(values: &[f64], rows: Range<usize>) -> Vec<Range<usize>> {
    crate::recording::runs(rows.start + 1..rows.end.max(rows.start + 1), |row| values[row] == values[row - 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::white_noise;

    fn found(values: &[f64]) -> Vec<Range<usize>> {
        stuck(values, std::slice::from_ref(&(0..values.len())))
    }

    #[test]
    fn a_value_that_stays_is_found_and_the_sample_that_it_is_of_kept() {
        for step in [0.0, 0.2, 1.0] {
            let mut values = white_noise(1, 50_000);
            if step > 0.0 {
                values.iter_mut().for_each(|value| *value = (*value / step).round() * step);
            }
            let held = values[2000];
            values[2000..2160].fill(held);
            // the neighbours may happen to be equal
            let found = found(&values);
            assert_eq!(found.len(), 1, "{step}: {found:?}");
            assert!(
                found[0].start.abs_diff(2001) <= 3 && found[0].end.abs_diff(2160) <= 3,
                "{step}: {found:?}"
            );
        }
    }

    #[test]
    fn coarse_steps_and_doubled_samples_are_not_stuck() {
        let noise = white_noise(2, 50_000);
        let coarse: Vec<f64> = noise.iter().map(|value| (value / 3.0).round()).collect();
        let doubled: Vec<f64> = (0..noise.len()).map(|row| noise[row - row % 2]).collect();
        let held: Vec<f64> = (0..noise.len()).map(|row| noise[row - row % 20]).collect();
        for values in [noise, coarse, doubled, held, vec![1.0; 5000]] {
            assert!(found(&values).is_empty());
        }
    }
}

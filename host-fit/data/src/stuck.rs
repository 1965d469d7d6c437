//! Stretches in which an axis repeats one value although it measures noise: a register that was not updated. One rule
//! for any length; these rows are excluded from fits and diagnoses.

use std::ops::Range;

/// Shorter repeats are attributed to chance.
const MIN_RUN: usize = 10;

/// Probability per log that chance makes a run of repeats as long as the limit.
const CHANCE_PER_LOG: f64 = 1e-4;

/// A held value must last this many times as long as nearly all others: repeats of a sensor that is read more often than
/// it measures, or of a converter with coarse steps, do not.
const MIN_LENGTH_RATIO: usize = 3;

/// Minimum share of changes by two steps or more that determines the ratio of noise to step: that of steps of 4 standard
/// deviations. With coarser steps a value may repeat for any length.
const MIN_TWO_STEPS: f64 = 1e-3;

/// Share of stuck rows at rest from which an axis is rejected: most of it would be missing.
pub(crate) const REFUSED_SHARE: f64 = 0.5;

/// Minimum number of changes for an estimate of noise and step; with fewer the axis holds a single value.
pub(crate) const MIN_CHANGES: usize = 10;

/// Rows, within gap-free `stretches`, that repeat a value for longer than noise and step of the axis explain. The first
/// row of each run is a measurement and is not included.
///
/// Noise stays on a code most easily if the mean lies on it: with probability 1 − 2Q per row, Q the tail beyond half a
/// step, and 2Q² of the changes are then of two steps. So the changes alone, which a stuck stretch lacks, bound how
/// often chance repeats a value.
pub fn stuck(values: &[f64], stretches: &[Range<usize>]) -> Vec<Range<usize>> {
    let runs: Vec<Range<usize>> = stretches.iter().flat_map(|rows| repeats(values, rows.clone())).collect();
    if runs.iter().all(|run| run.len() < MIN_RUN) {
        return Vec::new();
    }
    let Some(equal) = chance_of_equal(values, stretches) else { return Vec::new() };
    let known: usize = stretches.iter().map(Range::len).sum();
    let by_chance = ((CHANCE_PER_LOG / known.max(1) as f64).ln() / equal.ln()).ceil() as usize;
    let least = by_chance.max(MIN_RUN).max(MIN_LENGTH_RATIO * usual(&runs, known));
    runs.into_iter().filter(|run| run.len() >= least).collect()
}

/// Upper bound of the probability that the next value is the same, from the changes of two steps or more; `None` if
/// there are too few of them.
fn chance_of_equal(values: &[f64], stretches: &[Range<usize>]) -> Option<f64> {
    let (two_steps, pairs) = two_step_changes(values, stretches)?;
    // minus three standard errors: fewer two-step changes mean a larger bound on repeats
    let share = (two_steps - 3.0 * two_steps.sqrt()) / pairs;
    if share < MIN_TWO_STEPS {
        return None;
    }
    let tail = (share / 2.0).sqrt().min(1.0 / 3.0);
    Some(1.0 - 2.0 * tail)
}

/// Number of changes of more than one step that the next change reverses, and number of pairs of neighbours.
///
/// Noise goes back and forth. A sensor with coarse steps that turns between rests also changes by many steps, but in one
/// direction; counted as noise, these changes would make each of its rests, a single code, a stuck value.
fn two_step_changes(values: &[f64], stretches: &[Range<usize>]) -> Option<(f64, f64)> {
    let changes = |rows: &Range<usize>| -> Vec<f64> {
        let changes = values[rows.clone()].windows(2).map(|pair| pair[1] - pair[0]);
        changes.filter(|change| change.abs() > 0.0).collect()
    };
    let changes: Vec<Vec<f64>> = stretches.iter().map(changes).collect();
    let mut sizes: Vec<f64> = changes.iter().flatten().map(|change| change.abs()).collect();
    if sizes.len() < MIN_CHANGES {
        return None;
    }
    let step = tenth(&mut sizes)?;
    let is_taken_back = |pair: &&[f64]| pair[0].abs() > 1.5 * step && pair[0] * pair[1] < 0.0;
    let two_steps = changes.iter().flat_map(|changes| changes.windows(2)).filter(is_taken_back).count();
    let pairs: usize = stretches.iter().map(|rows| rows.len().saturating_sub(1)).sum();
    Some((two_steps as f64, pairs as f64))
}

/// Step of an axis if it is coarser than about 2.5 standard deviations of its noise: values change, and nearly always by
/// one step.
pub(crate) fn coarse_step(values: &[f64], stretches: &[Range<usize>]) -> Option<f64> {
    /// Share of pairs of neighbours, with steps of 2.5 standard deviations and the mean on a code.
    const SHARE: f64 = 0.022;
    /// With such steps at least half of the neighbours are equal, wherever the mean lies between two codes.
    const EQUAL: f64 = 0.4;
    let neighbours = || stretches.iter().flat_map(|rows| values[rows.clone()].windows(2));
    let equal = neighbours().filter(|pair| pair[0] == pair[1]).count() as f64;
    if equal < EQUAL * neighbours().count() as f64 {
        return None;
    }
    let (two_steps, pairs) = two_step_changes(values, stretches)?;
    if two_steps > SHARE * pairs {
        return None;
    }
    let changes = neighbours().map(|pair| (pair[1] - pair[0]).abs()).filter(|change| *change > 0.0);
    crate::statistics::median_of(changes)
}

/// Tenth percentile of the changes from one value to the next: one step.
pub(crate) fn least_change(values: &[f64]) -> Option<f64> {
    let changes = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let mut changes: Vec<f64> = changes.filter(|change| *change > 0.0).collect();
    tenth(&mut changes)
}

/// Tenth percentile of `sizes`; `None` if there are none.
fn tenth(sizes: &mut [f64]) -> Option<f64> {
    let low = sizes.len() / 10;
    (!sizes.is_empty()).then(|| *sizes.select_nth_unstable_by(low, f64::total_cmp).1)
}

/// Number of repeats that nearly no value of a sample-and-hold sensor exceeds; 0 if most values occur once.
fn usual(runs: &[Range<usize>], known: usize) -> usize {
    let in_runs: usize = runs.iter().map(|run| run.len() + 1).sum();
    if runs.len() < known.saturating_sub(in_runs) {
        return 0;
    }
    let mut lengths: Vec<usize> = runs.iter().map(Range::len).collect();
    lengths.sort_unstable();
    let rare = 4 + lengths.len() / 1000;
    lengths
        .len()
        .checked_sub(rare)
        .and_then(|at| lengths.get(at))
        .copied()
        .unwrap_or(usize::MAX / MIN_LENGTH_RATIO)
}

/// Rows equal to the row before them, run by run.
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
    fn marks_repeats_but_keeps_the_first_sample() {
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
        let coarse = |step: f64| noise.iter().map(|value| (value / step).round()).collect();
        let held = |rows: usize, n: usize| (0..n).map(|row| noise[row - row % rows]).collect();
        let logs: [Vec<f64>; 10] = [
            noise.clone(),
            coarse(2.0),
            coarse(3.0),
            coarse(4.0),
            coarse(6.0),
            held(2, 50_000),
            held(20, 50_000),
            held(20, 1000),
            held(100, 5000),
            vec![1.0; 5000],
        ];
        for (at, values) in logs.into_iter().enumerate() {
            assert_eq!(found(&values), [], "log {at}");
        }
    }

    /// `rest` rows each at their own level and `turn` rows of rotation between them, in noise of unit variance hidden by
    /// steps of `step`.
    fn coarse_rests(rests: usize, (rest, turn): (usize, usize), step: f64, seed: u64) -> Vec<f64> {
        let levels: Vec<f64> = white_noise(seed, rests + 1).iter().map(|level| 40.0 * step * level).collect();
        let course = levels.windows(2).flat_map(|pair| {
            let [from, to] = [pair[0], pair[1]];
            let turned = move |row: usize| from + (to - from) * row as f64 / turn as f64;
            std::iter::repeat_n(from, rest).chain((0..turn).map(turned))
        });
        let course: Vec<f64> = course.collect();
        let noise = white_noise(seed + 1, course.len());
        course.iter().zip(&noise).map(|(level, noise)| ((level + noise) / step).round() * step).collect()
    }

    /// Three rests of one code each, with turns between them in which the code moves: each rest used to count as stuck.
    #[test]
    fn a_coarse_sensor_that_turns_between_rests_is_not_stuck() {
        let (mut logs, mut wrong) = (0, Vec::new());
        for seed in 0..20 {
            for rests in [2, 3, 4, 8] {
                for turn in [40, 200, 500] {
                    for step in [8.0, 20.0, 100.0] {
                        logs += 1;
                        let values = coarse_rests(rests, (4000, turn), step, seed);
                        if !found(&values).is_empty() {
                            wrong.push((seed, rests, turn, step));
                        }
                    }
                }
            }
        }
        assert!(wrong.is_empty(), "{} of {logs}: {:?}", wrong.len(), &wrong[..3.min(wrong.len())]);
    }

    /// Number of stuck rows found among 20,000, divided by the true number, for a value held for `share` of them by a
    /// sensor with steps of `step` standard deviations.
    fn share_found(rule: impl Fn(&[f64]) -> usize, share: f64, step: f64) -> f64 {
        let mut values: Vec<f64> = white_noise(7, 20_000).iter().map(|v| (v / step).round() * step).collect();
        let rows = (share * 20_000.0) as usize;
        let held = values[5000];
        values[5000..=5000 + rows].fill(held);
        rule(&values) as f64 / rows as f64
    }

    /// Shares of a log from 0.001 to 0.5, at steps of 0.01 to 2 standard deviations, for which `rule` misses the held
    /// value.
    fn misses(rule: impl Fn(&[f64]) -> usize) -> Vec<(f64, f64)> {
        let shares = [0.001, 0.005, 0.015, 0.025, 0.05, 0.09, 0.11, 0.2, 0.35, 0.5];
        let steps = [0.01, 0.3, 1.0, 2.0];
        let cases = shares.iter().flat_map(|share| steps.map(|step| (*share, step)));
        // 20 rows are too few to distinguish from the repeats of coarse steps
        let cases = cases.filter(|(share, step)| *share > 0.001 || *step < 0.5);
        cases.filter(|(share, step)| !(0.99..1.1).contains(&share_found(&rule, *share, *step))).collect()
    }

    #[test]
    fn finds_a_held_value_at_any_share_of_the_log() {
        let rows = |values: &[f64]| found(values).iter().map(Range::len).sum();
        assert_eq!(misses(rows), []);
        // negative control: a rule that gives up if more than a fiftieth is stuck
        let gives_up = |values: &[f64]| match rows(values) {
            rows if rows * 50 > values.len() => 0,
            rows => rows,
        };
        let missed = misses(gives_up);
        assert!(missed.len() > 20, "{missed:?}");
        println!(
            "attack: stuck at any length | one value repeated for 0.1 % to 50 % of a log whose resolution is 0.01 to 2 standard deviations: detected every time, with its length to 10 % | negative control: a rule limited to 2 % of the log misses {}",
            missed.len(),
        );
    }
}

//! A dead zone at zero rate: a gyro holds one value, its bias, while it turns more slowly than a limit, and jumps to the
//! true rate outside.
//!
//! In the histogram of a gyro that turns slowly to both sides it shows as one frequent value, an empty range on either
//! side up to the limit, and all values beyond. With coarse steps, values are equally spaced everywhere; with a stuck
//! register, the neighbours of the repeated value occur at other times.

/// Least number of samples at the repeated value.
const MIN_HELD: usize = 20;

/// Least number of samples on each side within one half width of the edge.
const MIN_OUTSIDE: usize = 12;

/// Least ratio of the empty range to the usual distance of neighbouring values outside.
const EMPTY_STEPS: f64 = 4.0;

/// Largest ratio of the two empty ranges.
const SIDES_DIFFER: f64 = 1.5;

/// Number of parts of the half width beyond the edge, and least number of them with values: a log of a few constant
/// rates leaves gaps.
const PARTS: usize = 6;
const PARTS_WITH_VALUES: usize = 4;

/// Least width of the empty range in steps of the sensor, from which on it shows in values on a regular lattice, and least
/// ratio of the repeated value to the mean count of a step: it has the samples of the steps that are empty, two or more.
const LATTICE_STEPS: f64 = 1.5;
const LATTICE_COUNT: f64 = 2.5;

/// Largest ratio of the steps of a regular lattice.
const REGULAR: f64 = 1.2;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DeadZone {
    /// Repeated value, unit of the axis.
    pub(crate) value: f64,
    /// Half of the width, unit of the axis.
    pub(crate) half_width: f64,
}

/// Result of a search for a dead zone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Searched {
    Found(DeadZone),
    None,
    /// The axis does not turn slowly to both sides, so the log would not show a dead zone.
    NotShown,
}

/// Searches for a dead zone in the values of a gyro.
pub(super) fn search(values: &[f64]) -> Searched {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let mut distinct: Vec<(f64, usize)> = Vec::new();
    for value in &sorted {
        match distinct.last_mut() {
            Some((last, count)) if last == value => *count += 1,
            _ => distinct.push((*value, 1)),
        }
    }
    let Some(held) = (0..distinct.len()).max_by_key(|at| distinct[*at].1) else { return Searched::NotShown };
    let (value, count) = distinct[held];
    let quantile = |share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
    // at rest, nearly all values lie near the middle half
    let middle = quantile(0.75) - quantile(0.25);
    let turns = [value - quantile(0.001), quantile(0.999) - value].iter().all(|side| *side > REST * middle);
    let nothing = if turns { Searched::None } else { Searched::NotShown };
    if held == 0 || held + 1 == distinct.len() || count < MIN_HELD {
        return nothing;
    }
    let sides = [value - distinct[held - 1].0, distinct[held + 1].0 - value];
    let half_width = 0.5 * (sides[0] + sides[1]);
    if sides[0] > SIDES_DIFFER * sides[1] || sides[1] > SIDES_DIFFER * sides[0] {
        return nothing;
    }
    let is_edged = [-1.0, 1.0].into_iter().all(|sign: f64| {
        let out = |at: f64| sign * (at - value);
        let beyond =
            distinct.iter().filter(|(at, _)| (half_width * 0.5..2.0 * half_width).contains(&out(*at)));
        let beyond: Vec<(f64, usize)> = beyond.copied().collect();
        let samples: usize = beyond.iter().map(|(_, count)| count).sum();
        let mut parts = [false; PARTS];
        for (at, _) in &beyond {
            let part = (out(*at) / half_width - 1.0) * PARTS as f64;
            parts[(part.max(0.0) as usize).min(PARTS - 1)] = true;
        }
        let mut gaps: Vec<f64> = beyond.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
        gaps.sort_unstable_by(f64::total_cmp);
        let (Some(least), Some(gap), Some(largest)) = (gaps.first(), gaps.get(gaps.len() / 2), gaps.last())
        else {
            return false;
        };
        let is_filled = || parts.iter().filter(|has| **has).count() >= PARTS_WITH_VALUES;
        let per_step = samples as f64 / beyond.len() as f64;
        let is_regular = || largest < &(REGULAR * least) && per_step >= MIN_OUTSIDE as f64;
        let on_lattice = || half_width > LATTICE_STEPS * gap && count as f64 > LATTICE_COUNT * per_step;
        samples >= MIN_OUTSIDE
            && (half_width > EMPTY_STEPS * gap && is_filled() || is_regular() && on_lattice())
            && beyond.iter().all(|(_, outside)| 2 * outside < count)
    });
    if is_edged { Searched::Found(DeadZone { value, half_width }) } else { nothing }
}

/// An axis turns if its outermost thousandths lie further out, on both sides, than this multiple of the interquartile
/// range. For normal noise the multiple is 2.3.
const REST: f64 = 5.0;

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::white_noise;

    /// A gyro at rest, then turning to and fro, with noise of unit variance quantised to `step`.
    fn turning(step: f64, dead: f64, seed: u64) -> Vec<f64> {
        let noise = white_noise(seed, 40_000);
        let rate = |row: usize| match row {
            0..20_000 => 0.0,
            _ => 200.0 * (row as f64 / 700.0).sin(),
        };
        let bias = 7.3;
        let seen = noise.iter().enumerate().map(|(row, noise)| rate(row) + noise);
        seen.map(|value| if value.abs() < dead { bias } else { value + bias })
            .map(|value| (value / step).round() * step)
            .collect()
    }

    #[test]
    fn finds_a_dead_zone_and_its_width() {
        for (seed, dead) in [2.0, 4.0, 10.0].into_iter().enumerate() {
            let Searched::Found(found) = search(&turning(0.1, dead, seed as u64)) else {
                panic!("{dead}: not found")
            };
            assert!((found.half_width / dead - 1.0).abs() < 0.15, "{dead}: {found:?}");
            assert!((found.value - 7.3).abs() < 0.06, "{found:?}");
        }
    }

    /// Two or three steps of the sensor wide: its edges were looked for between steps.
    #[test]
    fn finds_a_dead_zone_of_a_few_steps() {
        for seed in 0..5 {
            let Searched::Found(found) = search(&turning(0.5, 1.2, seed)) else {
                panic!("{seed}: not found")
            };
            assert!((found.half_width - 1.2).abs() < 0.5, "{found:?}");
        }
    }

    #[test]
    fn finds_no_dead_zone_in_coarse_steps_stuck_values_and_rests() {
        for seed in 0..20 {
            for step in [0.01, 0.3, 2.0, 8.0, 40.0] {
                assert!(!matches!(search(&turning(step, 0.0, seed)), Searched::Found(_)), "{seed}, {step}");
            }
            let mut stuck = turning(0.1, 0.0, seed);
            let value = stuck[5000];
            stuck[5000..15_000].fill(value);
            assert!(!matches!(search(&stuck), Searched::Found(_)), "{seed}");
            let rest = &turning(0.1, 0.0, seed)[..20_000];
            assert_eq!(search(rest), Searched::NotShown, "{seed}");
        }
    }

    #[test]
    fn finds_no_dead_zone_in_constant_rates() {
        let noise = white_noise(1, 9000);
        let rates = [0.0, 30.0, -30.0];
        let seen = noise.iter().enumerate().map(|(row, noise)| match rates[row / 3000] {
            0.0 => 0.0,
            rate => ((rate + noise) / 0.1).round() * 0.1,
        });
        assert!(!matches!(search(&seen.collect::<Vec<f64>>()), Searched::Found(_)));
    }
}

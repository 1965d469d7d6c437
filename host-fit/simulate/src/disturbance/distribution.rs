//! Noise that is not normal: heavy tails, occasional wide samples, a bounded range, coarse steps. Its slow part is
//! unchanged.

use crate::random::{Random, between, chance};

/// Distribution of the samples about their slow course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Distribution {
    /// A power of a normal number, with its sign: above 1 the tails are heavier, similar to Laplace's at about 1.5.
    Power(f64),
    /// Share of the samples with a wider scatter, and the factor by which it is wider.
    Mixture(f64, f64),
    /// Bound, in standard deviations, as of dithered or clipped noise.
    Bounded(f64),
    /// Quantisation step, in standard deviations.
    Coarse(f64),
}

/// Window that separates the scatter from the slow course, samples.
const FAST: usize = 101;

impl Distribution {
    pub(crate) fn draw(random: &mut Random) -> Self {
        match between(random, 0.0, 4.0) as usize {
            0 => Self::Power(between(random, 1.2, 1.9)),
            1 => Self::Mixture(between(random, 0.002, 0.05), between(random, 2.0, 6.0)),
            2 => Self::Bounded(between(random, 1.2, 2.5)),
            _ => Self::Coarse(between(random, 0.5, 2.5)),
        }
    }

    /// Applies the distribution to noise, preserving its variance.
    pub(crate) fn apply(self, values: &[f64], random: &mut Random) -> Vec<f64> {
        let course = moving_mean(values);
        let fast: Vec<f64> = values.iter().zip(&course).map(|(value, slow)| value - slow).collect();
        let deviation = root_mean_square(&fast);
        if deviation <= 0.0 {
            return values.to_vec();
        }
        if let Self::Coarse(step) = self {
            let step = step * deviation;
            return values.iter().map(|value| (value / step).round() * step).collect();
        }
        let shaped: Vec<f64> = fast.iter().map(|value| self.shaped(value / deviation, random)).collect();
        let to_deviation = deviation / root_mean_square(&shaped);
        course.iter().zip(shaped).map(|(slow, fast)| slow + to_deviation * fast).collect()
    }

    /// Applies the distribution to a number of unit variance.
    fn shaped(self, value: f64, random: &mut Random) -> f64 {
        match self {
            Self::Power(power) => value.signum() * value.abs().powf(power),
            Self::Mixture(share, times) => value * if chance(random, share) { times } else { 1.0 },
            Self::Bounded(bound) => bound * (value / bound).tanh(),
            Self::Coarse(_) => value,
        }
    }
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Mean of the [`FAST`] samples about each sample, of fewer at the ends.
fn moving_mean(values: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0];
    sums.extend(values.iter().scan(0.0, |sum, value| {
        *sum += value;
        Some(*sum)
    }));
    let around = |at: usize| at.saturating_sub(FAST / 2)..(at + FAST / 2 + 1).min(values.len());
    let means = (0..values.len()).map(|at| {
        let rows = around(at);
        (sums[rows.end] - sums[rows.start]) / rows.len() as f64
    });
    means.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Stream, normal, random};

    #[test]
    fn the_tails_change_and_neither_the_variance_nor_the_slow_course() {
        let random = &mut random(1, Stream::Unit);
        let noise: Vec<f64> = (0..40_000).map(|row| 1e-4 * f64::from(row) + 0.1 * normal(random)).collect();
        let kurtosis = |values: &[f64]| {
            let course = moving_mean(values);
            let fast: Vec<f64> = values.iter().zip(course).map(|(value, slow)| value - slow).collect();
            let fourth = fast.iter().map(|value| value.powi(4)).sum::<f64>() / fast.len() as f64;
            (fourth / root_mean_square(&fast).powi(4), root_mean_square(&fast))
        };
        for (distribution, expected) in [
            (Distribution::Power(1.5), 5.0..8.0),
            // 3·(1 + 0.02·624)/(1 + 0.02·24)²
            (Distribution::Mixture(0.02, 5.0), 16.0..21.0),
            (Distribution::Bounded(1.5), 1.2..2.3),
            (Distribution::Coarse(1.5), 2.6..3.4),
        ] {
            let made = distribution.apply(&noise, random);
            let (found, deviation) = kurtosis(&made);
            assert!(expected.contains(&found), "{distribution:?}: {found}");
            assert!((0.095..0.125).contains(&deviation), "{distribution:?}: {deviation}");
            let slow = |values: &[f64]| values[30_000..31_000].iter().sum::<f64>() / 1000.0;
            assert!((slow(&made) - slow(&noise)).abs() < 0.01, "{distribution:?}");
        }
    }
}

//! Noise behind the steps of a converter.
//!
//! Rounding to steps of size q adds q²/12 to the variance of noise that spans several steps. With coarser steps the
//! variance depends on the position of the mean: smallest on a code, where the noise rarely reaches the next, and at
//! least q²/4 between two, however small the noise. So a variance of the samples agrees with a range of noise, and from
//! about 2.5 standard deviations per step on with none at all.

use statrs::function::erf::erfc;

use super::estimate::{Level, NoiseEstimate};

/// Variance of the samples, in steps², from which on they show their noise: the step adds less than 0.2 % to it.
const FINE: f64 = 25.0;

/// Statistics of rounded samples of an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rounded {
    /// Step, the axis' unit.
    pub(super) step: f64,
    /// Half the mean square of the changes between adjacent samples, steps².
    pub(super) variance: f64,
    /// Number of changes.
    pub(super) pairs: f64,
    /// Sample period, s.
    pub(super) period_s: f64,
    /// Time from the first sample to the last, s.
    pub(super) span_s: f64,
}

impl Rounded {
    /// Computes the statistics from gap-free stretches of values with this step.
    pub(super) fn of(stretches: &[&[f64]], step: f64, period_s: f64, span_s: f64) -> Self {
        let pairs = || stretches.iter().flat_map(|stretch| stretch.windows(2));
        let squares: f64 = pairs().map(|pair| ((pair[1] - pair[0]) / step).powi(2)).sum();
        let pairs = pairs().count().max(1) as f64;
        Self { step, variance: squares / (2.0 * pairs), pairs, period_s, span_s }
    }

    /// Converts `found`, an estimate from rounded samples, to the noise before rounding, with intervals that include
    /// it. The second value is true if the step hides the white noise, so that all levels are limits.
    pub(super) fn before_rounding(&self, found: NoiseEstimate) -> (NoiseEstimate, bool) {
        let Some(value) = found.white.value.filter(|_| self.variance < FINE) else { return (found, false) };
        let low = found.white.low.unwrap_or(0.0);
        // white noise N makes samples of variance N²/period; filtered samples have less
        let of_samples = |sigma: f64| sigma * self.step * self.period_s.sqrt();
        let coloured = value / of_samples(self.variance.sqrt());
        let least = least_noise(self.variance * (low / value).powi(2));
        // a value near 0 bounds nothing: the upper end does
        let of_high = (found.white.high / of_samples(1.0) / coloured.max(1.0)).powi(2);
        let most = most_noise(self.most_variance().max(of_high));
        let high = found.white.high.max(coloured.max(1.0) * of_samples(most));
        let added = of_samples(1.0).powi(2) * (self.variance - least * least);
        let without = (low * low - added).max(0.0).sqrt().min(coloured * of_samples(least));
        if without > 0.0 {
            return (
                NoiseEstimate { white: Level { low: Some(without), high, ..found.white }, ..found },
                false,
            );
        }
        (self.limits(high, found.flicker.high, found.walk.high), true)
    }

    /// Largest variance that agrees with the observed excursions to the next code, 95 %: two changes are one excursion,
    /// and the mean of a Poisson variable observed as k is at most about k + 2·√k + 3.
    fn most_variance(&self) -> f64 {
        let seen = self.variance * self.pairs;
        (seen + 2.0 * seen.sqrt() + 3.0) / self.pairs
    }

    /// Returns the limits for an axis with one value in `samples` samples.
    pub(super) fn limits_of_constant(step: f64, samples: usize, period_s: f64, span_s: f64) -> NoiseEstimate {
        let rounded = Self { step, variance: 0.0, pairs: samples.max(1) as f64, period_s, span_s };
        rounded.limits(most_noise(rounded.most_variance()) * step * period_s.sqrt(), 0.0, 0.0)
    }

    /// Changes of the bias below a step are not visible either.
    fn limits(&self, white: f64, flicker: f64, walk: f64) -> NoiseEstimate {
        let limit = |high: f64| Level { value: None, low: None, high };
        NoiseEstimate {
            white: limit(white),
            flicker: limit(flicker + self.step),
            walk: limit(walk + self.step / self.span_s.sqrt()),
            gauss_markov: None,
            walk_within_20_percent_s: None,
        }
    }
}

/// Standard deviation, in steps, below which noise has a variance below `variance`, steps², for any position of the
/// mean.
fn least_noise(variance: f64) -> f64 {
    inverse(variance, 0.5)
}

/// Standard deviation, in steps, above which noise has a variance above `variance`, steps², for any position of the
/// mean.
fn most_noise(variance: f64) -> f64 {
    inverse(variance, 0.0)
}

/// Returns the standard deviation at which rounding gives `variance` with the mean at this offset from a code; 0 if the
/// variance is always larger.
fn inverse(variance: f64, offset: f64) -> f64 {
    let (mut below, mut above) = (0.0, variance.sqrt() + 1.0);
    // terminates: halved 50 times
    for _ in 0..50 {
        let middle = 0.5 * (below + above);
        match rounded_variance(middle, offset) < variance {
            true => below = middle,
            false => above = middle,
        }
    }
    if below < 1e-9 { 0.0 } else { above }
}

/// Standard deviation, in steps, from which on rounding adds 1/12 to the variance wherever the mean is: the
/// difference is of the order of e^(−2π²σ²) (Widrow and Kollár, Quantization Noise, 2008, section 5.4).
const SMOOTH: f64 = 1.5;

/// Variance of normal noise of `sigma` about `offset` after rounding to whole steps.
fn rounded_variance(sigma: f64, offset: f64) -> f64 {
    if sigma > SMOOTH {
        return sigma * sigma + 1.0 / 12.0;
    }
    let furthest = (8.0 * sigma).ceil() as i32 + 1;
    let above = |limit: f64| 0.5 * erfc((limit - offset) / (sigma * std::f64::consts::SQRT_2));
    let (mut mean, mut square) = (0.0, 0.0);
    for code in -furthest..=furthest {
        let code = f64::from(code);
        let chance = above(code - 0.5) - above(code + 0.5);
        mean += chance * code;
        square += chance * code * code;
    }
    square - mean * mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::white_noise;

    fn estimate_of([white, flicker, walk]: [Level; 3]) -> NoiseEstimate {
        NoiseEstimate { white, flicker, walk, gauss_markov: None, walk_within_20_percent_s: None }
    }

    /// Cases whose interval of N misses the truth, and the number of limits, for steps of a tenth to eight standard
    /// deviations and seven positions of the mean between two codes.
    fn misses(corrected: bool) -> (Vec<(f64, f64)>, usize) {
        let noise = white_noise(11, 40_000);
        let (mut missed, mut limits) = (Vec::new(), 0);
        for step in [0.1, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0] {
            for offset in [0.0, 0.1, 0.2, 0.25, 0.3, 0.4, 0.5] {
                let rounded: Vec<f64> = noise.iter().map(|v| (v / step + offset).round() * step).collect();
                let (level, is_limit) = match Rounded::of(&[&rounded], step, 0.01, 400.0) {
                    of if of.variance == 0.0 => {
                        (Rounded::limits_of_constant(step, 40_000, 0.01, 400.0).white, true)
                    }
                    of => {
                        // as blocks of white samples show it, known to 2 %
                        let n = of.variance.sqrt() * step * 0.1;
                        let white = Level { value: Some(n), low: Some(0.98 * n), high: 1.02 * n };
                        let none = Level { value: None, low: None, high: 0.0 };
                        let found = estimate_of([white, none, none]);
                        let (corrected_to, is_limit) = of.before_rounding(found);
                        if corrected { (corrected_to.white, is_limit) } else { (white, false) }
                    }
                };
                limits += usize::from(is_limit);
                if level.low.is_some_and(|low| low > 0.1) || level.high < 0.1 {
                    missed.push((step, offset));
                }
                // an uninformative limit would cover it too
                assert!(
                    !corrected || level.high < 0.1 * (2.0_f64).max(0.6 * step),
                    "{step} {offset} {level:?}"
                );
            }
        }
        (missed, limits)
    }

    #[test]
    fn intervals_cover_noise_before_rounding() {
        let (missed, limits) = misses(true);
        assert_eq!(missed, []);
        assert!((30..=42).contains(&limits), "{limits}");
        // negative control: the noise of the rounded samples
        let (missed, _) = misses(false);
        assert!(missed.len() > 35, "{missed:?}");
        println!(
            "attack: coarse steps | a resolution of 0.1 to 8 standard deviations, with the mean at 7 positions between two codes: all 70 intervals of N contain the true value, {limits} of them as upper limits | negative control: if N is estimated from the rounded samples, {} intervals do not",
            missed.len(),
        );
    }

    #[test]
    fn rounding_adds_a_twelfth_to_noise_of_several_steps() {
        for offset in [0.0, 0.2, 0.5] {
            // the accuracy of erfc, times the squares of the outer codes
            assert!((rounded_variance(SMOOTH, offset) - SMOOTH * SMOOTH - 1.0 / 12.0).abs() < 1e-8);
        }
    }

    /// With hardly any white noise found in coarse samples, the limit was millions of times the scatter, and took a minute.
    #[test]
    fn limit_stays_near_the_scatter_where_no_white_noise_was_found() {
        let level = |value: f64| Level { value: Some(value), low: None, high: 0.02 };
        let of = Rounded { step: 0.03, variance: 0.11, pairs: 299.0, period_s: 1.0, span_s: 299.0 };
        for value in [1e-3, 1e-6, 1e-12] {
            let found = estimate_of([level(value); 3]);
            let high = of.before_rounding(found).0.white.high;
            assert!((0.01..0.05).contains(&high), "{value}: {high}");
        }
    }

    #[test]
    fn fine_steps_do_not_change_the_estimate() {
        let level = Level { value: Some(1.0), low: Some(0.9), high: 1.1 };
        let found = estimate_of([level; 3]);
        let fine = Rounded { step: 0.1, variance: 100.0, pairs: 1e4, period_s: 1.0, span_s: 1e4 };
        assert_eq!(fine.before_rounding(found), (found, false));
    }
}

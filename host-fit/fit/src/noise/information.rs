//! Information that a recording at rest contains about N, B and K: how long to record for an accuracy.
//!
//! The expected information about the logarithms of the levels is F_ij = Σ_k ∂ln S/∂θ_i · ∂ln S/∂θ_j over the frequencies
//! k/T up to half the rate of the block means (Whittle 1953), with S = N² + B²/(2πf) + (K/(2πf))².

use nalgebra::{Matrix3, Vector3};

use super::least::least_where;
use super::level::RISE;
use super::model::NoiseLevels;

/// Times searched: up to so many doublings of a recording's length, 2¹⁶ of which are months.
const MOST_DOUBLINGS: i32 = 16;

/// Largest flicker noise of a search, as a multiple of √(N·K).
const MOST_FLICKER: f64 = 4.0;

/// Ends of an interval are searched from this distance in ln K on, over so many doublings: from 1 % to a factor of 13.
const FIRST_LOG: f64 = 0.01;
const MOST_LOG_DOUBLINGS: i32 = 9;

/// Share of a bracket that a step of the golden section keeps; ten steps leave 1 %, as the rise is flat at its minimum.
const GOLDEN: f64 = 0.618_034;
const GOLDEN_STEPS: usize = 10;

/// Two-sided spectral densities of white noise, flicker and random walk at a frequency in Hz, unit²/Hz (IEEE Std 952).
fn densities(levels: &NoiseLevels, frequency_hz: f64) -> [f64; 3] {
    let omega = std::f64::consts::TAU * frequency_hz;
    [levels.white.powi(2), levels.flicker.powi(2) / omega, (levels.walk / omega).powi(2)]
}

/// Derivatives of ln S by ln N, ln B and ln K at a frequency in Hz: 2·S_θ/S.
pub(super) fn density_slopes(levels: &NoiseLevels, frequency_hz: f64) -> [f64; 3] {
    let parts = densities(levels, frequency_hz);
    let total: f64 = parts.iter().sum();
    parts.map(|part| 2.0 * part / total)
}

/// Expected standard deviations of ln N, ln B and ln K after `seconds` at rest in block means of `block_s`, by the
/// Cramér-Rao bound. Infinite for a level of 0, which is treated as known to be absent.
pub fn log_deviations(levels: &NoiseLevels, seconds: f64, block_s: f64) -> [f64; 3] {
    let every = (1..=(0.5 * seconds / block_s) as usize).map(|k| (k as f64 / seconds, 1.0));
    let mut information = information(|frequency_hz| density_slopes(levels, frequency_hz), every);
    let is_absent = [levels.white, levels.flicker, levels.walk].map(|level| level <= 0.0);
    // an absent level has no information, and must not stand in the way of the inverse
    (0..3).filter(|level| is_absent[*level]).for_each(|level| information[(level, level)] = 1.0);
    let covariance = information.cholesky().map(|factor| factor.inverse());
    std::array::from_fn(|level| match &covariance {
        Some(covariance) if !is_absent[level] => covariance[(level, level)].sqrt(),
        _ => f64::INFINITY,
    })
}

/// Information about the logarithms of three parameters: Σ ∂ln S/∂θ_i · ∂ln S/∂θ_j over frequencies, Hz, and the number of
/// frequencies that each stands for.
pub(super) fn information(
    slopes: impl Fn(f64) -> [f64; 3],
    frequencies: impl IntoIterator<Item = (f64, f64)>,
) -> Matrix3<f64> {
    frequencies.into_iter().fold(Matrix3::zeros(), |sum, (frequency_hz, number)| {
        let slopes = Vector3::from(slopes(frequency_hz));
        sum + slopes * slopes.transpose() * number
    })
}

/// Frequencies k/T of block means of `block_s` over `seconds`, Hz, and the number of frequencies that each stands for: one
/// at first, later a tenth of k, as the densities change no faster.
pub(super) fn frequencies(seconds: f64, block_s: f64) -> Vec<(f64, f64)> {
    let last = (0.5 * seconds / block_s) as usize;
    let mut frequencies = Vec::new();
    let mut next = 1;
    while next <= last {
        let end = (next + (next / 10).max(1)).min(last + 1);
        frequencies.push((0.5 * (next + end - 1) as f64 / seconds, (end - next) as f64));
        next = end;
    }
    frequencies
}

/// Expected rise of −2 ln L of noise of levels `own` under levels `other`, after `seconds` at rest in block means of
/// `block_s`: 2 Σ (S₀/S − 1 − ln(S₀/S)) over the frequencies (Whittle 1953).
pub fn expected_rise(own: &NoiseLevels, other: &NoiseLevels, seconds: f64, block_s: f64) -> f64 {
    Expected::of(own, seconds, block_s).rise(other)
}

/// Spectrum of the noise of given levels.
struct Expected {
    /// Frequency, Hz, density there, and the number of frequencies that it stands for.
    spectrum: Vec<(f64, f64, f64)>,
}

impl Expected {
    fn of(levels: &NoiseLevels, seconds: f64, block_s: f64) -> Self {
        let density = |(frequency_hz, number)| (frequency_hz, density(levels, frequency_hz), number);
        Self { spectrum: frequencies(seconds, block_s).into_iter().map(density).collect() }
    }

    fn rise(&self, other: &NoiseLevels) -> f64 {
        let of_frequency = |(frequency_hz, own, number): &(f64, f64, f64)| {
            let ratio = own / density(other, *frequency_hz);
            number * (ratio - 1.0 - ratio.ln())
        };
        2.0 * self.spectrum.iter().map(of_frequency).sum::<f64>()
    }
}

fn density(levels: &NoiseLevels, frequency_hz: f64) -> f64 {
    densities(levels, frequency_hz).iter().sum()
}

/// Expected ratio of the ends of the 90 % interval of K: of the walks for which −2 ln L, minimised over the flicker noise,
/// is expected to rise by 2.71. Unlike the bound it heeds that flicker noise is not negative: where there is little, it may
/// hide a part of the walk but not add to it. White noise counts as known, which narrows the interval by up to a tenth.
/// Infinite if an end is beyond a factor of 13.
pub fn expected_walk_ratio(levels: &NoiseLevels, seconds: f64, block_s: f64) -> f64 {
    let expected = Expected::of(levels, seconds, block_s);
    // flicker noise of 1.4 times the root is as large as white noise and walk where these are equal
    let most_flicker = levels.flicker + MOST_FLICKER * (levels.white * levels.walk).sqrt();
    let rise = |factor: f64| {
        let walk = levels.walk * factor;
        let of_flicker = |flicker: f64| expected.rise(&NoiseLevels { walk, flicker, ..*levels });
        least_value(0.0, most_flicker, of_flicker)
    };
    let factor = |of: fn(f64) -> f64| least_where(FIRST_LOG, MOST_LOG_DOUBLINGS, |log| rise(of(log)) >= RISE);
    match factor(f64::exp).zip(factor(|log| (-log).exp())) {
        Some((above, below)) => (above + below).exp(),
        None => f64::INFINITY,
    }
}

/// Least value of a function with one minimum between two places (golden section).
fn least_value(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let inner = |low: f64, high: f64| high - GOLDEN * (high - low);
    let (mut left, mut right) = (inner(low, high), low + high - inner(low, high));
    let (mut at_left, mut at_right) = (f(left), f(right));
    for _ in 0..GOLDEN_STEPS {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = inner(low, high);
            at_left = f(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + high - inner(low, high);
            at_right = f(right);
        }
    }
    at_left.min(at_right).min(f(low)).min(f(high))
}

/// Time at rest, s, after which the 90 % interval of K is expected to be within a factor of the value to either side, on
/// average; searched from `first_s` on. None where years would not do.
pub fn seconds_for_walk_within(levels: &NoiseLevels, factor: f64, first_s: f64, block_s: f64) -> Option<f64> {
    let is_enough = |seconds: f64| expected_walk_ratio(levels, seconds, block_s) <= factor * factor;
    least_where(first_s, MOST_DOUBLINGS, is_enough)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVELS: NoiseLevels = NoiseLevels { white: 0.01, flicker: 0.0, walk: 3.16e-5, gauss_markov: None };

    #[test]
    fn white_noise_alone_is_known_by_the_number_of_means() {
        let white = NoiseLevels { walk: 0.0, ..LEVELS };
        let [deviation, flicker, walk] = log_deviations(&white, 1000.0, 1.0);
        // sd(ln N) = 1/√(2n)
        assert!((deviation * 2000.0_f64.sqrt() - 1.0).abs() < 0.01, "{deviation}");
        assert_eq!([flicker, walk], [f64::INFINITY; 2]);
    }

    #[test]
    fn the_bound_of_a_walk_is_the_published_one() {
        // 10⁵ samples a second apart: 8.0 % by the exact likelihood
        let deviation = log_deviations(&LEVELS, 1e5, 1.0)[2];
        assert!((0.076..0.084).contains(&deviation), "{deviation}");
    }

    #[test]
    fn the_time_stated_reaches_the_accuracy_asked_for() {
        let seconds = seconds_for_walk_within(&LEVELS, 1.2, 1000.0, 1.0).expect("a time");
        let [reached, before] = [1.0, 0.9].map(|share| expected_walk_ratio(&LEVELS, share * seconds, 1.0));
        assert!(reached <= 1.44 && before > 1.44, "{reached}, {before} in {seconds} s");
        let absent = NoiseLevels { walk: 0.0, ..LEVELS };
        assert_eq!(seconds_for_walk_within(&absent, 1.2, 1000.0, 1.0), None);
    }

    /// ±1.645 standard deviations of ln K.
    #[test]
    fn expected_interval_is_that_of_the_bound_where_flicker_noise_is_known() {
        let levels = NoiseLevels { white: 1.2e-4, flicker: 4e-5, walk: 1e-5, gauss_markov: None };
        let width = expected_walk_ratio(&levels, 1e5, 1.0).ln();
        let bound = 2.0 * 1.644_854 * log_deviations(&levels, 1e5, 1.0)[2];
        // white noise is unknown in the bound
        assert!((0.9..1.0).contains(&(width / bound)), "{width}, bound {bound}");
    }

    /// The bound lets unknown flicker noise widen both sides, and knows flicker noise of 0.
    #[test]
    fn flicker_noise_near_zero_may_hide_a_walk_but_adds_none() {
        let little = NoiseLevels { flicker: 0.1 * (LEVELS.white * LEVELS.walk).sqrt(), ..LEVELS };
        let width = |levels: &NoiseLevels| expected_walk_ratio(levels, 2e4, 1.0).ln();
        let bound = |levels: &NoiseLevels| 2.0 * 1.644_854 * log_deviations(levels, 2e4, 1.0)[2];
        assert!(1.05 * bound(&LEVELS) < width(&LEVELS) && width(&little) < 0.95 * bound(&little));
        assert!(
            (width(&little) / width(&LEVELS) - 1.0).abs() < 0.05,
            "{} {}",
            width(&little),
            width(&LEVELS)
        );
    }
}

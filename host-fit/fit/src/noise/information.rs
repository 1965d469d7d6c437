//! Information that a recording at rest contains about N, B and K: how long to record for an accuracy.
//!
//! The expected information about the logarithms of the levels is F_ij = Σ_k ∂ln S/∂θ_i · ∂ln S/∂θ_j over the frequencies
//! k/T up to half the rate of the block means (Whittle 1953), with S = N² + B²/(2πf) + (K/(2πf))².

use nalgebra::DMatrix;

use super::least::least_where;
use super::model::NoiseLevels;

/// Times searched: up to so many doublings of a recording's length, 2¹⁶ of which are months.
const MOST_DOUBLINGS: i32 = 16;

/// Two-sided spectral densities of white noise, flicker and random walk at a frequency in Hz, unit²/Hz (IEEE Std 952).
pub fn densities(levels: &NoiseLevels, frequency_hz: f64) -> [f64; 3] {
    let omega = std::f64::consts::TAU * frequency_hz;
    [levels.white.powi(2), levels.flicker.powi(2) / omega, (levels.walk / omega).powi(2)]
}

/// Expected standard deviations of ln N, ln B and ln K after `seconds` at rest in block means of `block_s`, by the
/// Cramér-Rao bound. Infinite for a level of 0, which is treated as known to be absent.
pub fn log_deviations(levels: &NoiseLevels, seconds: f64, block_s: f64) -> [f64; 3] {
    let present: Vec<usize> = [levels.white, levels.flicker, levels.walk]
        .iter()
        .enumerate()
        .filter(|(_, level)| **level > 0.0)
        .map(|(at, _)| at)
        .collect();
    let mut information = DMatrix::<f64>::zeros(present.len(), present.len());
    let mut deviations = [f64::INFINITY; 3];
    for k in 1..=(0.5 * seconds / block_s) as usize {
        let parts = densities(levels, k as f64 / seconds);
        let total: f64 = parts.iter().sum();
        // ∂ln S/∂ln θ = 2·S_θ/S
        let slopes: Vec<f64> = present.iter().map(|level| 2.0 * parts[*level] / total).collect();
        for i in 0..slopes.len() {
            for j in 0..slopes.len() {
                information[(i, j)] += slopes[i] * slopes[j];
            }
        }
    }
    if let Some(covariance) = information.cholesky().map(|factor| factor.inverse()) {
        present.iter().enumerate().for_each(|(at, level)| deviations[*level] = covariance[(at, at)].sqrt());
    }
    deviations
}

/// Time at rest, s, after which ln K is expected to have at most this standard deviation; none where years would not do.
pub fn seconds_for_walk_deviation(levels: &NoiseLevels, deviation: f64, block_s: f64) -> Option<f64> {
    let is_enough = |seconds: f64| log_deviations(levels, seconds, block_s)[2] <= deviation;
    least_where(40.0 * block_s, MOST_DOUBLINGS, is_enough)
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
        let seconds = seconds_for_walk_deviation(&LEVELS, 0.12, 1.0).expect("a time");
        let reached = log_deviations(&LEVELS, seconds, 1.0)[2];
        assert!((0.11..=0.12).contains(&reached), "{reached} after {seconds} s");
        let absent = NoiseLevels { walk: 0.0, ..LEVELS };
        assert_eq!(seconds_for_walk_deviation(&absent, 0.12, 1.0), None);
    }
}

//! White noise and a first-order Gauss-Markov process as the noise of an axis at rest, in place of flicker noise and a
//! random walk.
//!
//! The bias obeys ḃ = −b/τ + w with standard deviation σ, so its covariance is σ²·e^(−|t|/τ). Values and intervals are
//! those of the restricted profile likelihood, as for N, B and K.

use serde::Serialize;

use super::information::frequencies;
use super::level::{Level, restricted_deviance};
use super::levels::{LogLevels, Regression};
use super::model::{GaussMarkov, NoiseLevels};
use super::profile::{Interval, Profile};

/// Least decrease of −2 ln L, beyond the penalty for parameters, for which the process is preferred: odds of 33 to 1.
const PREFERRED: f64 = 7.0;

/// Number of correlation times that the search tries first, and the number of the best ones that it starts from.
const TRIED: u32 = 6;
const STARTS: usize = 2;

/// Largest Allan variance of a Gauss-Markov process of unit variance, at 1.89 correlation times: 0.437²·2 (IEEE Std 952).
const PEAK: f64 = 0.382;

/// White noise and a Gauss-Markov process, each with its 90 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GaussMarkovNoise {
    /// N beside the process, unit·√s.
    pub white: Level,
    /// Standard deviation σ of the bias, the axis' unit.
    pub deviation: Level,
    /// Correlation time τ, s.
    pub tau_s: Level,
    /// Decrease of −2 ln L against N, B and K, less ln n for each parameter more than those that were detected; n is the
    /// number of block means.
    pub gain: f64,
}

impl GaussMarkovNoise {
    /// Returns the Allan deviation at an averaging time, unit (IEEE Std 952, annex C):
    /// N²/t + 2σ²·(τ/t)·(1 − (τ/2t)·(3 − 4e^(−t/τ) + e^(−2t/τ))).
    pub fn allan_deviation(&self, averaging_s: f64) -> f64 {
        let [white, deviation, tau_s] = [self.white, self.deviation, self.tau_s].map(|level| level.at_most());
        let x = averaging_s / tau_s;
        let process = match x < 1e-2 {
            // the first terms of the series where the difference would cancel
            true => x / 3.0 - x * x / 4.0,
            false => (1.0 - (3.0 - 4.0 * (-x).exp() + (-2.0 * x).exp()) / (2.0 * x)) / x,
        };
        (white * white / averaging_s + 2.0 * deviation * deviation * process).sqrt()
    }
}

/// Fits white noise and a Gauss-Markov process to a regression whose levels N, B and K were estimated with `deviance`, and
/// have this Allan deviation; none if these describe it as well.
pub(super) fn gauss_markov(
    regression: &Regression<'_>,
    levels: [Level; 3],
    allan_deviation: impl Fn(f64) -> f64,
    deviance: f64,
) -> Option<GaussMarkovNoise> {
    let [white, flicker, walk] = levels;
    let detected = [flicker, walk].iter().filter(|level| level.value.is_some()).count();
    if detected == 0 {
        return None;
    }
    let blocks = regression.blocks;
    let profile = Profile {
        deviance: |logs: &LogLevels| {
            let [white, deviation, tau_s] = logs.map(f64::exp);
            let gauss_markov = Some(GaussMarkov { deviation, tau_s });
            restricted_deviance(regression, NoiseLevels { white, flicker: 0.0, walk: 0.0, gauss_markov })
        },
        slopes: density_slopes,
        frequencies: frequencies(blocks.samples() as f64 * blocks.period_s, blocks.length_s),
    };
    let best = profile.best(&starts(regression, white.at_most(), allan_deviation, profile.deviance));
    let more = (2 - detected) as f64;
    let gain = deviance - best.deviance - more * (blocks.len() as f64).ln();
    if gain < PREFERRED {
        return None;
    }
    let level = |parameter: usize| {
        let Interval { low, high, .. } = profile.interval(parameter, &best);
        Level { value: Some(best.logs[parameter].exp()), low, high }
    };
    Some(GaussMarkovNoise { white: level(0), deviation: level(1), tau_s: level(2), gain })
}

/// Derivatives of ln S by ln N, ln σ and ln τ at a frequency in Hz, of the two-sided density S = N² + 2σ²τ/(1 + (ωτ)²).
fn density_slopes(logs: &LogLevels, frequency_hz: f64) -> LogLevels {
    let [white, deviation, tau_s] = logs.map(f64::exp);
    let turned = (std::f64::consts::TAU * frequency_hz * tau_s).powi(2);
    let (white, process) = (white * white, 2.0 * deviation * deviation * tau_s / (1.0 + turned));
    let [white, process] = [white, process].map(|part| part / (white + process));
    [2.0 * white, 2.0 * process, process * (1.0 - turned) / (1.0 + turned)]
}

/// Returns the most likely of a few correlation times, with the standard deviation that has the Allan deviation of the
/// levels there.
fn starts(
    regression: &Regression<'_>,
    white: f64,
    allan_deviation: impl Fn(f64) -> f64,
    deviance: impl Fn(&LogLevels) -> f64,
) -> Vec<LogLevels> {
    let blocks = regression.blocks;
    let span_s = blocks.middle_s(blocks.len() - 1) - blocks.middle_s(0);
    let (shortest_s, longest_s) = (3.0 * blocks.length_s, span_s / 3.0);
    let mut starts: Vec<(LogLevels, f64)> = (0..TRIED)
        .map(|at| {
            let share = f64::from(at) / f64::from(TRIED - 1);
            let tau_s = shortest_s * (longest_s / shortest_s).powf(share);
            let slow = allan_deviation(tau_s).powi(2) - white * white / tau_s;
            let variance = (slow / PEAK).max(1e-2 * white * white / tau_s);
            let logs = [white.ln(), 0.5 * variance.ln(), tau_s.ln()];
            (logs, deviance(&logs))
        })
        .collect();
    starts.sort_by(|a, b| a.1.total_cmp(&b.1));
    starts.into_iter().take(STARTS).map(|(logs, _)| logs).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn allan_deviation_has_its_limits_and_its_peak() {
        let known = |value: f64| Level { value: Some(value), low: Some(value), high: value };
        let noise =
            GaussMarkovNoise { white: known(0.0), deviation: known(2.0), tau_s: known(100.0), gain: 9.0 };
        let square = |seconds: f64| noise.allan_deviation(seconds).powi(2);
        // far below τ a random walk of K² = 2σ²/τ, far above white noise of N² = 2σ²·τ
        let walk = 2.0 * 4.0 / 100.0;
        assert!((square(0.01) / (walk * 0.01 / 3.0) - 1.0).abs() < 1e-3);
        assert!((square(1e7) / (2.0 * 4.0 * 100.0 / 1e7) - 1.0).abs() < 1e-4);
        // both forms agree where one replaces the other
        assert!((square(0.999) / square(1.001) - 0.998).abs() < 1e-4);
        assert!((square(189.0) / 4.0 - PEAK).abs() < 1e-3, "{}", square(189.0) / 4.0);
    }
}

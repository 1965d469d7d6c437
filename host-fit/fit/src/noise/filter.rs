//! Discrete noise of a Kalman filter with one bias state per axis.
//!
//! The measurement at update k is the true rate or specific force plus b_k plus white noise of variance r, and
//! b_{k+1} = φ·b_k + w_k with w of variance q. Over an update interval Δt, with N, K as two-sided densities (van Loan 1978;
//! Brown and Hwang 2012, section 4.2):
//!
//! r = N²/Δt; for a Gauss-Markov process φ = e^(−Δt/τ), q = σ²·(1 − φ²); for a random walk φ = 1, q = K²·Δt.

use serde::Serialize;

use super::estimate::NoiseEstimate;

/// Reason why a value of [`FilterNoise`] is absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Absent {
    /// The step of the converter hides the white noise: N is a limit.
    HiddenByStep,
    /// The log does not show a random walk: K is a limit.
    WalkNotSeen,
}

/// Noise of one axis as a Kalman filter needs it. Values that the log does not identify are absent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FilterNoise {
    /// Update interval Δt, s.
    pub interval_s: f64,
    /// N, unit·√s: two-sided, the Allan deviation of the white noise at 1 s.
    pub white: Option<f64>,
    /// Variance r of the white noise of one update, unit².
    pub white_variance: Option<f64>,
    /// Standard deviation σ of the bias, unit; none for a random walk.
    pub deviation: Option<f64>,
    /// Correlation time τ, s; none for a random walk.
    pub tau_s: Option<f64>,
    /// K, unit/√s; none for a Gauss-Markov process.
    pub walk: Option<f64>,
    /// Factor φ of the bias from one update to the next; 1 for a random walk.
    pub transition: Option<f64>,
    /// Variance q that is added to the bias in each update, unit².
    pub bias_variance: Option<f64>,
    /// Reason why values are absent.
    pub absent: Option<Absent>,
}

impl FilterNoise {
    /// Converts levels for updates every `interval_s`: to a Gauss-Markov process if it describes the axis better than
    /// flicker noise and a random walk, else to the random walk.
    pub fn of(levels: &NoiseEstimate, interval_s: f64) -> Self {
        let process = levels.gauss_markov;
        let white = process.map_or(levels.white, |process| process.white).value;
        let none = Self {
            interval_s,
            white,
            white_variance: white.map(|white| white * white / interval_s),
            deviation: None,
            tau_s: None,
            walk: None,
            transition: None,
            bias_variance: None,
            absent: None,
        };
        if let Some((deviation, tau_s)) =
            process.and_then(|process| process.deviation.value.zip(process.tau_s.value))
        {
            let transition = Some((-interval_s / tau_s).exp());
            // 1 − φ² without cancellation
            let added = deviation * deviation * -(-2.0 * interval_s / tau_s).exp_m1();
            let (deviation, tau_s) = (Some(deviation), Some(tau_s));
            return Self { deviation, tau_s, transition, bias_variance: Some(added), ..none };
        }
        match (white, levels.walk.value) {
            (None, _) => Self { absent: Some(Absent::HiddenByStep), ..none },
            (_, None) => Self { absent: Some(Absent::WalkNotSeen), ..none },
            (_, Some(walk)) => Self {
                walk: Some(walk),
                transition: Some(1.0),
                bias_variance: Some(walk * walk * interval_s),
                ..none
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::estimate::Level;
    use super::super::gauss_markov::GaussMarkovNoise;
    use super::*;

    fn known(value: f64) -> Level {
        Level { value: Some(value), low: Some(0.9 * value), high: 1.1 * value }
    }

    const LIMIT: Level = Level { value: None, low: None, high: 1.0 };

    fn levels() -> NoiseEstimate {
        NoiseEstimate {
            white: known(0.01),
            flicker: LIMIT,
            walk: known(3e-5),
            gauss_markov: None,
            walk_within_20_percent_s: None,
        }
    }

    #[test]
    fn recursion_has_the_variance_of_the_process() {
        let process =
            GaussMarkovNoise { white: known(0.02), deviation: known(0.5), tau_s: known(530.0), gain: 20.0 };
        let noise = FilterNoise::of(&NoiseEstimate { gauss_markov: Some(process), ..levels() }, 0.0025);
        let (transition, added) = (noise.transition.unwrap(), noise.bias_variance.unwrap());
        // stationary variance q/(1 − φ²), and correlation 1/e after τ
        assert!((added / (1.0 - transition * transition) / 0.25 - 1.0).abs() < 1e-9);
        assert!((transition.powf(530.0 / 0.0025) * std::f64::consts::E - 1.0).abs() < 1e-9);
        assert_eq!(
            (noise.white, noise.white_variance, noise.walk),
            (Some(0.02), Some(0.02 * 0.02 / 0.0025), None)
        );
    }

    #[test]
    fn a_random_walk_adds_its_variance_over_the_interval() {
        let noise = FilterNoise::of(&levels(), 0.01);
        assert_eq!((noise.transition, noise.tau_s, noise.absent), (Some(1.0), None, None));
        // after 100 s K·√100
        let after = (noise.bias_variance.unwrap() * 1e4).sqrt();
        assert!((after / 3e-4 - 1.0).abs() < 1e-12, "{after}");
    }

    #[test]
    fn unknown_values_are_absent_with_the_reason() {
        let unseen = FilterNoise::of(&NoiseEstimate { walk: LIMIT, ..levels() }, 0.01);
        assert_eq!((unseen.bias_variance, unseen.absent), (None, Some(Absent::WalkNotSeen)));
        assert!(unseen.white_variance.is_some());
        let hidden = FilterNoise::of(&NoiseEstimate { white: LIMIT, walk: LIMIT, ..levels() }, 0.01);
        assert_eq!((hidden.white_variance, hidden.absent), (None, Some(Absent::HiddenByStep)));
    }
}

//! An hour of band-limited, nonlinear sensor error with a stated innovation, in place of the paper's recording.
//!
//! A delayed feedback through a square, behind a first-order low-pass (the discrete form of Mackey and Glass, Science
//! 197 (1977) 287, with a parabola):
//!
//! ```text
//!   x(n) = (1 − γ) x(n−1) + γ (1 − a x(n−10)²) + e(n),    γ = 0.4, a = 1.7
//! ```
//!
//! It neither decays nor diverges: without e(n) it is chaotic and stays within ±1. It is a quadratic autoregression
//! with a lag within the paper's ten, so that a linear predictor cannot model it and a quadratic one can. 99 % of its
//! power lies below 30 Hz at 200 Hz sampling. Real sensor noise is nothing like it: it demonstrates the methods on data
//! with a nonlinear part.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Sampling rate of the log, Hz.
pub const RATE_HZ: f64 = 200.0;
const GAMMA: f64 = 0.4;
const SQUARE: f64 = 1.7;
const LAG: usize = 10;

/// Standard deviation of e(n), x being of size 1.
const INNOVATION: f64 = 1e-4;

/// Samples discarded until the initial state has no influence.
const SETTLING: usize = 5000;

/// Column and size of x in its unit: 10 mm/s² and 1 mrad/s.
const AXES: [(&str, f64); 2] = [("ay_mps2", 0.01), ("gy_rads", 0.001)];

/// Innovation variance of a column, the square of its unit; `None` for one that is not simulated.
pub fn innovation_variance(column: &str) -> Option<f64> {
    AXES.iter().find(|(name, _)| *name == column).map(|(_, scale)| (scale * INNOVATION).powi(2))
}

/// Columns `t_s`, `ay_mps2`, `gy_rads`. The same arguments give the same numbers.
pub fn band_limited(duration_s: f64, seed: u64) -> Vec<(String, Vec<f64>)> {
    let samples = (duration_s * RATE_HZ).round() as usize;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut columns = vec![("t_s".to_owned(), (0..samples).map(|n| n as f64 / RATE_HZ).collect())];
    for (name, scale) in AXES {
        let mut x: Vec<f64> = (0..LAG).map(|_| 0.1 * normal(&mut random)).collect();
        for n in LAG..LAG + SETTLING + samples {
            let feedback = 1.0 - SQUARE * x[n - LAG] * x[n - LAG];
            x.push((1.0 - GAMMA) * x[n - 1] + GAMMA * feedback + INNOVATION * normal(&mut random));
        }
        columns.push((name.to_owned(), x[LAG + SETTLING..].iter().map(|x| scale * x).collect()));
    }
    columns
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

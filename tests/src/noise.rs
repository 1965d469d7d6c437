//! Seeded random series for tests.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Gaussian white noise of unit variance.
pub fn white_noise(seed: u64, length: usize) -> Vec<f64> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    (0..length).map(|_| StandardNormal.sample(&mut generator)).collect()
}

/// x(n) = Σ ar\[k−1\] x(n−k) + e(n) with e white of the given variance, after a run-in of 10,000 samples,
/// ten times the longest memory used in these tests.
pub fn autoregression(seed: u64, length: usize, ar: &[f64], innovation_variance: f64) -> Vec<f64> {
    let run_in = 10_000;
    let mut x = white_noise(seed, run_in + length);
    let scale = innovation_variance.sqrt();
    for n in 0..x.len() {
        let recalled: f64 = ar.iter().zip(x[..n].iter().rev()).map(|(a, past)| a * past).sum();
        x[n] = scale * x[n] + recalled;
    }
    x.split_off(run_in)
}

/// x(n) = x(n−1) + e(n), e white of unit variance.
pub fn random_walk(seed: u64, length: usize) -> Vec<f64> {
    let mut x = white_noise(seed, length);
    for n in 1..length {
        x[n] += x[n - 1];
    }
    x
}

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

/// Noise of any length, draw by draw: SplitMix64 (Steele, Lea, Flood 2014) and the polar method (Marsaglia, Bray 1964).
pub struct Noise {
    state: u64,
    spare: Option<f64>,
}

impl Noise {
    /// Generator with a seed.
    pub fn new(seed: u64) -> Self {
        Self { state: seed, spare: None }
    }

    /// Next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0 … 1.
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2.0_f64.powi(-53)
    }

    /// Normal, mean 0, variance 1.
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        loop {
            let (a, b) = (2.0 * self.uniform() - 1.0, 2.0 * self.uniform() - 1.0);
            let square = a * a + b * b;
            if square > 0.0 && square < 1.0 {
                let radius = (-2.0 * square.ln() / square).sqrt();
                self.spare = Some(b * radius);
                return a * radius;
            }
        }
    }
}

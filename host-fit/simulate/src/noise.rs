//! Stochastic error of one axis, typical of phone-class sensors at rest.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Time constants of the Gauss-Markov processes whose sum approximates flicker noise, s. At a factor of ten apart, the
/// spectrum of the sum follows 1/f within 1 dB between the first and the last.
const FLICKER_TAUS_S: [f64; 4] = [1.0, 10.0, 100.0, 1000.0];

/// Coefficients of the colour of the fast noise: the anti-alias filter leaves a resonance-free AR(2).
const COLOUR: [f64; 2] = [0.45, -0.15];

/// Coefficient of the quadratic term of the fast noise, per its standard deviation: v(n−1)·v(n−2).
const QUADRATIC: f64 = 0.04;

/// Noise levels of an axis, in its unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct NoiseSizes {
    /// White noise before colour, standard deviation per sample.
    pub(super) white: f64,
    /// Bias instability: flat of the Allan deviation over 0.664.
    pub(super) flicker: f64,
    /// Random walk of the bias, per square root of a second.
    pub(super) random_walk: f64,
}

/// Noise of one axis, sample by sample.
#[derive(Debug, Clone)]
pub(super) struct Noise {
    sizes: NoiseSizes,
    period_s: f64,
    fast: [f64; 2],
    flicker: [f64; 4],
    walk: f64,
}

impl Noise {
    pub(super) fn new(sizes: NoiseSizes, period_s: f64, random: &mut impl Rng) -> Self {
        // stationary from the first sample
        let flicker = FLICKER_TAUS_S.map(|_| sizes.flicker_deviation() * normal(random));
        Self { sizes, period_s, fast: [0.0; 2], flicker, walk: 0.0 }
    }

    /// Next value, in the axis' unit: fast noise plus wander.
    pub(super) fn next(&mut self, random: &mut impl Rng) -> f64 {
        let [first, second] = self.fast;
        let fast = COLOUR[0] * first + COLOUR[1] * second + QUADRATIC * first * second + normal(random);
        // a quadratic model may be unstable: its state is clamped
        self.fast = [fast.clamp(-8.0, 8.0), first];
        for (state, tau_s) in self.flicker.iter_mut().zip(FLICKER_TAUS_S) {
            let decay = (-self.period_s / tau_s).exp();
            let innovation = (1.0 - decay * decay).sqrt() * self.sizes.flicker_deviation();
            *state = decay * *state + innovation * normal(random);
        }
        self.walk += self.sizes.random_walk * self.period_s.sqrt() * normal(random);
        self.sizes.white * self.fast[0] + self.flicker.iter().sum::<f64>() + self.walk
    }
}

impl NoiseSizes {
    /// Standard deviation of each Gauss-Markov process. One process peaks at 0.437·σ·√2 = 0.617 σ in Allan deviation
    /// (IEEE Std 952); with neighbours a decade away the flat of the sum is 0.85 σ, and 0.664·B by definition.
    fn flicker_deviation(&self) -> f64 {
        self.flicker * 0.664 / 0.85
    }
}

fn normal(random: &mut impl Rng) -> f64 {
    StandardNormal.sample(random)
}

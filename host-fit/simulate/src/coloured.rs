//! Noise of one axis of a device: coloured fast noise, flicker, random walk; its spectrum, and simulated series.

use serde::Serialize;

use super::random::{Random, Stream, between, chance, normal, random};

/// Shortest and longest time constant of the Gauss-Markov processes that sum to flicker noise, s.
const FLICKER_TAUS_S: [f64; 2] = [0.05, 4000.0];
/// Number of processes: one every factor of 3.09.
const FLICKER_PROCESSES: usize = 11;

/// A Gauss-Markov process.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GaussMarkov {
    /// Standard deviation, unit of the axis.
    pub sigma: f64,
    /// Correlation time, s.
    pub tau_s: f64,
}

/// Spectral shape of the fast noise: v(n) = φ1 v(n−1) + φ2 v(n−2) + e(n) + θ e(n−1), of unit variance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Colour {
    /// φ1, φ2.
    pub ar: [f64; 2],
    pub ma: f64,
    /// Standard deviation of e, that of v being 1.
    pub innovation: f64,
}

impl Colour {
    pub const WHITE: Self = Self { ar: [0.0; 2], ma: 0.0, innovation: 1.0 };

    /// Normalises these coefficients to unit variance: the mean of the spectrum over the band is that of white noise.
    pub fn new(ar: [f64; 2], ma: f64) -> Self {
        // the variance is the energy of the impulse response; poles within 0.7 leave nothing after 200 samples
        let (mut past, mut energy) = ([0.0; 2], 0.0);
        for n in 0..200 {
            let drive = if n == 0 { 1.0 } else { f64::from(u8::from(n == 1)) * ma };
            let value = ar[0] * past[0] + ar[1] * past[1] + drive;
            energy += value * value;
            past = [value, past[0]];
        }
        Self { ar, ma, innovation: energy.sqrt().recip() }
    }

    /// Draws a colour whose level at zero frequency is 0.6 to 1.3 of that of the whole band.
    pub(super) fn draw(random: &mut Random) -> Self {
        // terminates: a good part of the draws is accepted
        loop {
            let ar = if chance(random, 0.5) {
                let (radius, angle) = (between(random, 0.1, 0.6), between(random, 0.0, std::f64::consts::PI));
                [2.0 * radius * angle.cos(), -radius * radius]
            } else {
                let (p, q) = (between(random, -0.4, 0.6), between(random, -0.4, 0.6));
                [p + q, -p * q]
            };
            let colour = Self::new(ar, between(random, -0.5, 0.5));
            if (0.6..1.3).contains(&colour.density(0.0).sqrt()) {
                return colour;
            }
        }
    }

    /// Two-sided spectral density at `cycles` per sample; 1 for white noise of unit variance.
    pub fn density(&self, cycles: f64) -> f64 {
        let w = std::f64::consts::TAU * cycles;
        let numerator = 1.0 + 2.0 * self.ma * w.cos() + self.ma * self.ma;
        let re = 1.0 - self.ar[0] * w.cos() - self.ar[1] * (2.0 * w).cos();
        let im = self.ar[0] * w.sin() + self.ar[1] * (2.0 * w).sin();
        self.innovation * self.innovation * numerator / (re * re + im * im)
    }
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxisNoise {
    /// Sampling period, s.
    pub period_s: f64,
    /// Standard deviation of the fast noise per sample, unit of the axis.
    pub white: f64,
    pub colour: Colour,
    /// Flicker noise, as a sum of processes.
    pub flicker: Vec<GaussMarkov>,
    /// Random walk, unit of the axis per √s.
    pub random_walk: f64,
}

impl AxisNoise {
    /// Noise of a density (unit/√Hz, one-sided, over the whole band), a bias instability and a random walk (unit/√s).
    ///
    /// A sum of Gauss-Markov processes of one σ, their time constants a factor ρ apart, has the one-sided spectrum
    /// σ²/(f ln ρ) between the first and the last; flicker is B²/(πf), two-sided B²/(2πf) (IEEE Std 952), so σ² = B² ln
    /// ρ / π.
    pub fn new(density: f64, flicker: f64, random_walk: f64, colour: Colour, rate_hz: f64) -> Self {
        let ratio = (FLICKER_TAUS_S[1] / FLICKER_TAUS_S[0]).powf(1.0 / (FLICKER_PROCESSES - 1) as f64);
        let sigma = flicker * (ratio.ln() / std::f64::consts::PI).sqrt();
        let processes = (0..FLICKER_PROCESSES)
            .map(|k| GaussMarkov { sigma, tau_s: FLICKER_TAUS_S[0] * ratio.powi(k as i32) });
        Self {
            period_s: 1.0 / rate_hz,
            white: density * (rate_hz / 2.0).sqrt(),
            colour,
            flicker: processes.collect(),
            random_walk,
        }
    }

    /// Two-sided spectral density per sample of fast noise, flicker and rounding to `lsb` at `freq_hz`, unit² of the
    /// axis: white noise of variance σ² has σ². The random walk is included if `freq_hz` is above zero.
    pub fn density(&self, freq_hz: f64, lsb: f64) -> f64 {
        let cycles = freq_hz * self.period_s;
        let w = std::f64::consts::TAU * cycles;
        let first_order = |decay: f64| 1.0 - 2.0 * decay * w.cos() + decay * decay;
        let mut density = self.fast_density(cycles, lsb);
        for process in &self.flicker {
            let decay = (-self.period_s / process.tau_s).exp();
            density += process.sigma * process.sigma * (1.0 - decay * decay) / first_order(decay);
        }
        if freq_hz > 0.0 {
            density += self.random_walk * self.random_walk * self.period_s / first_order(1.0);
        }
        density
    }

    /// The same of fast noise and rounding alone, at `cycles` per sample.
    pub fn fast_density(&self, cycles: f64, lsb: f64) -> f64 {
        self.white * self.white * self.colour.density(cycles) + lsb * lsb / 12.0
    }

    /// `n` samples from a seed.
    pub fn simulate(&self, n: usize, seed: u64) -> Vec<f64> {
        self.series(n, &mut random(seed, Stream::Noise(0, 0)))
    }

    /// `n` samples: the stationary parts are stationary from the first sample, the random walk starts at zero.
    pub(super) fn series(&self, n: usize, random: &mut Random) -> Vec<f64> {
        let mut out = Vec::with_capacity(n);
        let [phi1, phi2] = self.colour.ar;
        let (mut past, mut last) = ([0.0; 2], 0.0);
        let mut fast = |random: &mut Random| {
            let e = self.colour.innovation * normal(random);
            let value = phi1 * past[0] + phi2 * past[1] + e + self.colour.ma * last;
            (past, last) = ([value, past[0]], e);
            value
        };
        for _ in 0..200 {
            fast(random);
        }
        let steps: Vec<(f64, f64)> = self.flicker.iter().map(|p| p.step(self.period_s)).collect();
        let mut states: Vec<f64> = self.flicker.iter().map(|p| p.sigma * normal(random)).collect();
        let (mut walk, walk_step) = (0.0, self.random_walk * self.period_s.sqrt());
        for _ in 0..n {
            let mut value = self.white * fast(random) + walk;
            for (state, (decay, drive)) in states.iter_mut().zip(&steps) {
                value += *state;
                *state = decay * *state + drive * normal(random);
            }
            walk += walk_step * normal(random);
            out.push(value);
        }
        out
    }

    /// Cheaper approximation with the same levels: white, and slow parts that change every 40 samples. For axes that
    /// are not examined closely.
    pub(super) fn plain_series(&self, n: usize, random: &mut Random) -> Vec<f64> {
        const HOLD: usize = 40;
        let slow: Vec<&GaussMarkov> = self.flicker.iter().skip(3).collect();
        let steps: Vec<(f64, f64)> = slow.iter().map(|p| p.step(self.period_s * HOLD as f64)).collect();
        let mut states: Vec<f64> = slow.iter().map(|p| p.sigma * normal(random)).collect();
        let mut level = states.iter().sum::<f64>();
        (0..n)
            .map(|sample| {
                if sample % HOLD == 0 {
                    for (state, (decay, drive)) in states.iter_mut().zip(&steps) {
                        *state = decay * *state + drive * normal(random);
                    }
                    level = states.iter().sum();
                }
                level + self.white * normal(random)
            })
            .collect()
    }
}

impl GaussMarkov {
    /// Decay over a time, and the standard deviation of the innovation.
    pub(super) fn step(&self, period_s: f64) -> (f64, f64) {
        let decay = (-period_s / self.tau_s).exp();
        (decay, self.sigma * (1.0 - decay * decay).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::{Stream, random};
    use super::*;
    use fos_data::statistics::variance;

    /// Allan variance at averages of `length` samples, overlapping, from its definition (IEEE Std 952, annex C).
    fn allan_variance(series: &[f64], length: usize) -> f64 {
        let mut sums = vec![0.0];
        sums.extend(series.iter().scan(0.0, |sum, value| {
            *sum += value;
            Some(*sum)
        }));
        let mean = |start: usize| (sums[start + length] - sums[start]) / length as f64;
        let pairs = 0..=series.len() - 2 * length;
        let count = pairs.clone().count() as f64;
        pairs.map(|start| (mean(start + length) - mean(start)).powi(2)).sum::<f64>() / (2.0 * count)
    }

    #[test]
    fn flicker_is_flat_at_its_bias_instability() {
        // 0.664 B; eight records of 2000 s, taus well inside both ends. A σ of a record at 100 s has 10 % of scatter,
        // the ripple of processes a factor of three apart is below 1 %
        let noise = AxisNoise::new(0.0, 1.0, 0.0, Colour::WHITE, 20.0);
        let taus = [1.0, 3.0, 10.0, 30.0, 100.0];
        let mut sums = [0.0; 5];
        for seed in 0..8 {
            let series = noise.series(40_000, &mut random(seed, Stream::Unit));
            for (sum, tau) in sums.iter_mut().zip(taus) {
                *sum += allan_variance(&series, (tau / 0.05_f64).round() as usize) / 8.0;
            }
        }
        for (tau, square) in taus.iter().zip(sums) {
            assert!((square.sqrt() / 0.664 - 1.0).abs() < 0.1, "{tau} s: {}", square.sqrt());
        }
    }

    #[test]
    fn colour_preserves_the_level_of_the_whole_band() {
        for seed in 0..20 {
            let mut random = random(seed, Stream::Unit);
            let colour = Colour::draw(&mut random);
            let mean = (0..1000).map(|k| colour.density((k as f64 + 0.5) / 2000.0)).sum::<f64>() / 1000.0;
            assert!((mean - 1.0).abs() < 1e-6, "{colour:?}: {mean}");
            let noise = AxisNoise::new(0.1, 0.0, 0.0, colour, 200.0);
            let measured = variance(&[&noise.series(40_000, &mut random)]);
            // 4e4 samples, correlated over a few
            assert!((measured - 1.0).abs() < 0.06, "{colour:?}: {measured}");
        }
    }
}

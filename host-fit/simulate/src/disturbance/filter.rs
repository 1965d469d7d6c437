//! Digital filter of a part, which shapes its noise and is in no data sheet: the spectrum has slopes, notches and images
//! that are no interference.

use crate::random::{Random, between};

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Filter {
    /// Mean of the last n samples.
    MovingAverage(usize),
    /// First-order low-pass, applied n times; cut-off as a share of the sampling rate.
    LowPass(f64, usize),
    /// A windowed FIR with these taps, as in front of a decimator.
    Fir(Vec<f64>),
    /// A notch at this share of the sampling rate, of this width.
    Notch(f64, f64),
    /// Every sample twice: the output rate is twice that of the part.
    Doubled,
}

impl Filter {
    /// Draws one of the families of filters.
    pub(crate) fn draw(random: &mut Random) -> Self {
        match between(random, 0.0, 6.0) as usize {
            0 => Self::MovingAverage(2 + between(random, 0.0, 6.99) as usize),
            1 => Self::LowPass(between(random, 0.05, 0.45), 1),
            2 => Self::LowPass(between(random, 0.08, 0.45), 2),
            3 => Self::Fir(windowed_sinc(
                between(random, 0.1, 0.45),
                9 + 2 * between(random, 0.0, 12.0) as usize,
            )),
            4 => Self::Notch(between(random, 0.1, 0.45), between(random, 0.005, 0.05)),
            _ => Self::Doubled,
        }
    }

    pub(crate) fn apply(&self, values: &[f64]) -> Vec<f64> {
        match self {
            Self::MovingAverage(length) => convolved(values, &vec![1.0 / *length as f64; *length]),
            Self::LowPass(cutoff, order) => {
                let decay = (-std::f64::consts::TAU * cutoff).exp();
                (0..*order).fold(values.to_vec(), |values, _| {
                    let mut state = values.first().copied().unwrap_or(0.0);
                    let step = |value: &f64| {
                        state += (1.0 - decay) * (value - state);
                        state
                    };
                    values.iter().map(step).collect()
                })
            }
            Self::Fir(taps) => convolved(values, taps),
            Self::Notch(at, width) => notched(values, *at, *width),
            Self::Doubled => (0..values.len()).map(|row| values[row - row % 2]).collect(),
        }
    }
}

/// Taps of a low-pass: a sinc in a Hann window, of unit gain at zero frequency.
fn windowed_sinc(cutoff: f64, length: usize) -> Vec<f64> {
    let middle = (length - 1) as f64 / 2.0;
    let tap = |k: usize| {
        let x = k as f64 - middle;
        let angle = std::f64::consts::TAU * cutoff * x;
        let sinc = if x == 0.0 { 1.0 } else { angle.sin() / angle };
        let window = 0.5 - 0.5 * (std::f64::consts::TAU * (k + 1) as f64 / (length + 1) as f64).cos();
        sinc * window
    };
    let taps: Vec<f64> = (0..length).map(tap).collect();
    let sum: f64 = taps.iter().sum();
    taps.into_iter().map(|tap| tap / sum).collect()
}

fn convolved(values: &[f64], taps: &[f64]) -> Vec<f64> {
    let at = |row: usize| taps.iter().enumerate().map(|(k, tap)| tap * values[row.saturating_sub(k)]).sum();
    (0..values.len()).map(at).collect()
}

/// Notch with zeros on the unit circle and poles just inside: unit gain far from it.
fn notched(values: &[f64], at: f64, width: f64) -> Vec<f64> {
    let (cos, radius) = ((std::f64::consts::TAU * at).cos(), 1.0 - std::f64::consts::PI * width);
    // unit gain at zero frequency
    let gain = (1.0 - 2.0 * radius * cos + radius * radius) / (2.0 - 2.0 * cos);
    let first = values.first().copied().unwrap_or(0.0);
    let (mut x, mut y) = ([first; 2], [first; 2]);
    let step = |value: &f64| {
        let out =
            gain * (value - 2.0 * cos * x[0] + x[1]) + 2.0 * radius * cos * y[0] - radius * radius * y[1];
        (x, y) = ([*value, x[0]], [out, y[0]]);
        out
    };
    values.iter().map(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Stream, normal, random};

    #[test]
    fn filters_keep_the_level_and_never_amplify_noise() {
        let filters = [
            Filter::MovingAverage(4),
            Filter::LowPass(0.1, 1),
            Filter::LowPass(0.2, 2),
            Filter::Fir(windowed_sinc(0.2, 21)),
            Filter::Notch(0.2, 0.02),
            Filter::Doubled,
        ];
        let random = &mut random(1, Stream::Unit);
        let noise: Vec<f64> = (0..20_000).map(|_| normal(random)).collect();
        for filter in filters {
            let level = filter.apply(&[2.5; 2000]);
            assert!(level.iter().all(|value| (value - 2.5).abs() < 1e-9), "{filter:?}");
            let variance = filter.apply(&noise).iter().map(|x| x * x).sum::<f64>() / 20_000.0;
            assert!(variance > 0.05 && variance < 1.1, "{filter:?}: {variance}");
        }
    }
}

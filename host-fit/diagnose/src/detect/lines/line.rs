//! A detected line and its duty cycle.

use super::series::Series;

/// Duty cycle below which a line counts as intermittent.
pub(crate) const STEADY: f64 = 0.45;

/// Length of the stretches whose power is compared, s.
const DUTY_STRETCH_S: f64 = 5.0;

/// A detected line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    /// Frequency, Hz; the centre of the power of a wandering line.
    pub(crate) frequency_hz: f64,
    /// True if the phase is constant over the whole log.
    pub(crate) coherent: bool,
    /// Standard error of the frequency, Hz.
    pub(crate) frequency_error: f64,
    /// Amplitude, unit of the axis; √(2·power) for a wandering line.
    pub(crate) amplitude: f64,
    pub(crate) amplitude_error: f64,
    /// Phase of the sine at the first sample, rad.
    pub(crate) phase: f64,
    /// Band, Hz.
    pub(crate) band_hz: (f64, f64),
    /// 2·log-likelihood ratio minus 2·ln(number of bands tried).
    pub(crate) score: f64,
    /// Duty cycle: share of the log in which the line is present, from its power over time.
    pub(crate) duty: f64,
}

/// Duty cycle of a line: (Σ p)²/(m·Σ p²) of its power p over m stretches, above the noise; 1 for a constant amplitude.
pub(super) fn duty(series: &Series, line: &Line) -> f64 {
    let stretch = ((DUTY_STRETCH_S / series.period_s) as usize).max(1);
    let width_hz = (line.band_hz.1 - line.band_hz.0).max(1.0 / DUTY_STRETCH_S);
    let centre = 0.5 * (line.band_hz.0 + line.band_hz.1);
    // frequencies across the band at the resolution of a stretch
    let steps = (width_hz * DUTY_STRETCH_S).ceil().max(1.0) as i32;
    let frequencies: Vec<f64> =
        (-steps / 2..=steps / 2).map(|i| centre + f64::from(i) / DUTY_STRETCH_S).collect();
    let around: Vec<f64> =
        [-3.0, -2.0, 2.0, 3.0].into_iter().map(|i| centre + i * (width_hz + 2.0 / DUTY_STRETCH_S)).collect();
    let power = |values: &[f64], frequencies: &[f64]| {
        let part = Series { values: values.to_vec(), known: values.len(), period_s: series.period_s };
        frequencies.iter().map(|hz| part.transform(*hz).norm_sqr()).sum::<f64>() / frequencies.len() as f64
    };
    let powers: Vec<(f64, f64)> = series
        .values
        .chunks_exact(stretch)
        .map(|values| (power(values, &frequencies), power(values, &around)))
        .collect();
    let noise = powers.iter().map(|(_, noise)| noise).sum::<f64>() / powers.len().max(1) as f64;
    let n = frequencies.len() as f64;
    // E (s + e)² = s² + 2s·noise/n + noise²(1 + 1/n) with noise of n ordinates' mean
    let first: f64 = powers.iter().map(|(p, _)| p - noise).sum::<f64>() / powers.len().max(1) as f64;
    let second: f64 = powers
        .iter()
        .map(|(p, _)| (p - noise).powi(2) - noise * noise / n - 2.0 * noise * (p - noise) / n)
        .sum::<f64>()
        / powers.len().max(1) as f64;
    if second > 0.0 { (first * first / second).min(1.0) } else { 1.0 }
}

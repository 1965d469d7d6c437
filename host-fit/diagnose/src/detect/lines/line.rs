//! A line that was found, and how much of the time it is there.

use super::series::Series;

/// A line that is there for less than this share of the time comes and goes.
pub(crate) const STEADY: f64 = 0.45;

/// Length of the stretches whose power is compared, s.
const DUTY_STRETCH_S: f64 = 5.0;

/// A line that was found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    /// Frequency, Hz; of one that wanders the centre of its power.
    pub(crate) frequency_hz: f64,
    /// It keeps its phase over the whole log.
    pub(crate) coherent: bool,
    /// Standard error of the frequency, Hz.
    pub(crate) frequency_error: f64,
    /// Amplitude, unit of the axis; of one that wanders √(2·power).
    pub(crate) amplitude: f64,
    pub(crate) amplitude_error: f64,
    /// Phase of the sine at the first sample.
    pub(crate) phase: f64,
    /// Its band, Hz.
    pub(crate) band_hz: (f64, f64),
    /// 2·log-likelihood ratio minus 2·ln(bands looked at).
    pub(crate) score: f64,
    /// Share of the log's length in which it is there, from its power over time.
    pub(crate) duty: f64,
}

/// Share of the log in which a line is there: (Σ p)²/(m·Σ p²) of its power p over m stretches, above the noise; 1 for a
/// constant amplitude.
pub(super) fn duty(series: &Series, line: &Line) -> f64 {
    let stretch = ((DUTY_STRETCH_S / series.period_s) as usize).max(1);
    let width_hz = (line.band_hz.1 - line.band_hz.0).max(1.0 / DUTY_STRETCH_S);
    let centre = 0.5 * (line.band_hz.0 + line.band_hz.1);
    // a few frequencies across the band, each as wide as a stretch is long
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

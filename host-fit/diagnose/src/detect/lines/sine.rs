//! Sine of a coherent line.

use std::f64::consts::TAU;
use std::ops::Range;

use realfft::num_complex::Complex;

use super::periodogram::Periodogram;
use super::series::Series;
use fos_data::recording::Recording;
use fos_fit::noise::Blocks;

/// Accuracy of the frequency as a share of its standard error, and the largest number of iterations.
const WELL_WITHIN: f64 = 0.2;
const MAX_ITERATIONS: usize = 40;

/// Each pass reduces the part of a sine in the slow part to less than a tenth.
const SLOW_PASSES: usize = 2;

#[derive(Debug, Clone, Copy)]
pub(super) struct Sine {
    pub(super) frequency_hz: f64,
    pub(super) amplitude: f64,
    pub(super) phase: f64,
}

impl Series {
    /// Returns the best-fitting sine near the largest ordinate of a band, and `error` without it.
    ///
    /// The slow part absorbs a share of a slow sine. Therefore the sine that remains after both are subtracted is added
    /// to the estimate.
    pub(super) fn sine(
        &self,
        periodogram: &Periodogram,
        band: &Range<usize>,
        recording: &Recording,
        slow: &Blocks,
        error: &[f64],
    ) -> (Sine, Vec<f64>) {
        let peak = band.clone().max_by(|a, b| periodogram.power[*a].total_cmp(&periodogram.power[*b]));
        let peak = peak.unwrap_or(band.start);
        let relative_error =
            (periodogram.floor[peak] / periodogram.power[peak].max(periodogram.floor[peak])).sqrt();
        let within_hz = WELL_WITHIN * relative_error * self.frequency_bound_hz();
        let frequency_hz = self.peak_hz(peak as f64 * periodogram.resolution_hz, periodogram, within_hz);
        let mut phasor = self.phasor(frequency_hz);
        let mut without = subtracted(error, recording, frequency_hz, phasor);
        for _ in 0..SLOW_PASSES {
            let more = Self::new(recording, slow, &without).phasor(frequency_hz);
            without = subtracted(&without, recording, frequency_hz, more);
            phasor += more;
        }
        (Sine { frequency_hz, amplitude: phasor.norm(), phase: phasor.arg() }, without)
    }

    /// Returns the frequency of most power within an ordinate of `peak_hz`, by golden section: the main lobe has one
    /// maximum.
    pub(super) fn peak_hz(&self, peak_hz: f64, periodogram: &Periodogram, within_hz: f64) -> f64 {
        let (mut low, mut high) = (peak_hz - periodogram.resolution_hz, peak_hz + periodogram.resolution_hz);
        let golden = 0.381_966_011_250_105;
        let (mut a, mut b) = (low + golden * (high - low), high - golden * (high - low));
        let (mut at_a, mut at_b) = (self.transform(a).norm_sqr(), self.transform(b).norm_sqr());
        for _ in 0..MAX_ITERATIONS {
            if high - low < within_hz {
                break;
            }
            if at_a > at_b {
                (high, b, at_b) = (b, a, at_a);
                a = low + golden * (high - low);
                at_a = self.transform(a).norm_sqr();
            } else {
                (low, a, at_a) = (a, b, at_b);
                b = high - golden * (high - low);
                at_b = self.transform(b).norm_sqr();
            }
        }
        0.5 * (low + high)
    }
}

/// Subtracts a sine of this phasor from `error`, one value per row.
pub(super) fn subtracted(
    error: &[f64],
    recording: &Recording,
    frequency_hz: f64,
    phasor: Complex<f64>,
) -> Vec<f64> {
    let mut without = error.to_vec();
    for segment in &recording.segments {
        for row in segment.rows.clone() {
            let tick = segment.tick as f64 + (row - segment.rows.start) as f64;
            let angle = TAU * frequency_hz * tick * recording.rate.period_s + phasor.arg();
            without[row] -= phasor.norm() * angle.sin();
        }
    }
    without
}

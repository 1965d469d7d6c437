//! Power spectral density by Welch's method.

use std::f64::consts::PI;

use super::transforms;

/// One-sided power spectral density.
///
/// Normalised so that its integral over frequency, Σ density · resolution, is the variance of the series.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Spectrum {
    /// Frequencies, Hz, ascending. `welch` gives 0, resolution, 2 · resolution … half the rate.
    pub frequency_hz: Vec<f64>,
    /// Density at each frequency, unit²/Hz.
    pub density: Vec<f64>,
    /// Spacing of the transformed frequencies, Hz.
    pub resolution_hz: f64,
    /// Number of segments averaged. Hann windows that overlap by half are correlated by 1/6, so the relative
    /// standard error of one density is √((1 + 2/36) / segments) = 1.03/√segments for many (Welch 1967).
    pub segments: usize,
}

/// Welch's averaged periodogram (IEEE Trans. Audio Electroacoust. AU-15, 1967): segments of
/// `segment_length` samples, Hann window, 50 % overlap.
///
/// The mean of all samples is subtracted once, before windowing. (Subtracting it segment by segment, as some packages
/// do, would hide exactly the slow power that a bias model needs.) Stretches shorter than a segment are excluded, as
/// are the samples of a stretch after its last whole segment. `None` if no segment fits.
///
/// # Panics
/// If `segment_length` is less than 4.
pub fn welch(stretches: &[&[f64]], rate_hz: f64, segment_length: usize) -> Option<Spectrum> {
    assert!(segment_length >= 4, "a Hann window needs at least four samples");
    let window = hann(segment_length);
    let window_power: f64 = window.iter().map(|w| w * w).sum();
    let mean = super::mean(stretches);
    let transform = transforms::forward(segment_length);
    let mut windowed = transform.make_input_vec();
    let mut bins = transform.make_output_vec();

    let mut power = vec![0.0; bins.len()];
    let mut segments = 0;
    let starts_every = segment_length.div_ceil(2);
    for segment in stretches.iter().flat_map(|stretch| stretch.windows(segment_length).step_by(starts_every))
    {
        for ((target, x), w) in windowed.iter_mut().zip(segment).zip(&window) {
            *target = w * (x - mean);
        }
        transform.process(&mut windowed, &mut bins).expect("buffers made by this transform fit it");
        for (sum, bin) in power.iter_mut().zip(&bins) {
            *sum += bin.norm_sqr();
        }
        segments += 1;
    }
    if segments == 0 {
        return None;
    }

    // negative frequencies are folded onto positive ones; 0 and the Nyquist frequency have no partner
    let nyquist = segment_length.is_multiple_of(2).then_some(segment_length / 2);
    let sides = |bin: usize| if bin == 0 || Some(bin) == nyquist { 1.0 } else { 2.0 };
    let scale = 1.0 / (rate_hz * window_power * segments as f64);
    let resolution_hz = rate_hz / segment_length as f64;
    Some(Spectrum {
        frequency_hz: (0..power.len()).map(|bin| bin as f64 * resolution_hz).collect(),
        density: power.iter().enumerate().map(|(bin, p)| sides(bin) * scale * p).collect(),
        resolution_hz,
        segments,
    })
}

/// Segment length that shows slow effects and still averages: the largest power of two that fits at least four times
/// into the longest stretch (seven overlapping segments). At most 65,536 (330 s at 200 Hz), at least 4.
pub fn segment_length_for(stretches: &[&[f64]]) -> usize {
    let longest = stretches.iter().map(|stretch| stretch.len()).max().unwrap_or(0);
    let quarter = (longest / 4).clamp(4, 65_536);
    1 << quarter.ilog2()
}

impl Spectrum {
    /// The same spectrum averaged in bands of equal width on a logarithmic axis, for display.
    ///
    /// Power is averaged, not its logarithm, so that a line keeps its power. The first and the last bin are omitted: 0
    /// has no place on the axis, and the Nyquist frequency, folded onto itself, would show as a drop by half. Where the
    /// bands are narrower than the resolution (low frequencies) every bin is kept.
    pub fn smoothed(&self, bands_per_decade: usize) -> Spectrum {
        let band = |frequency: f64| (frequency.log10() * bands_per_decade as f64).floor();
        let bins = self.frequency_hz.iter().copied().zip(self.density.iter().copied());
        let mut bins: Vec<(f64, f64)> = bins.skip(1).collect();
        bins.pop();
        let (frequency_hz, density) = bins
            .chunk_by(|left, right| band(left.0) == band(right.0))
            .map(|bins| {
                let count = bins.len() as f64;
                let sum = bins.iter().fold((0.0, 0.0), |sum, bin| (sum.0 + bin.0, sum.1 + bin.1));
                (sum.0 / count, sum.1 / count)
            })
            .unzip();
        Spectrum { frequency_hz, density, ..*self }
    }
}

/// Periodic Hann window: shifted copies at half its length add up to one.
pub fn hann(length: usize) -> Vec<f64> {
    (0..length).map(|n| 0.5 - 0.5 * (2.0 * PI * n as f64 / length as f64).cos()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::{autoregression, white_noise};
    use fos_testkit::reference::{self, Reference, assert_all_close, number, numbers};

    fn integral(spectrum: &Spectrum) -> f64 {
        spectrum.density.iter().sum::<f64>() * spectrum.resolution_hz
    }

    #[test]
    fn agrees_with_scipy() {
        let reference = reference::own("spectrum");
        let Reference { answers, .. } = &reference;
        for case in answers["cases"].as_array().unwrap() {
            let length = case["segment_length"].as_u64().unwrap() as usize;
            let found = welch(&[reference.series()], number(&answers["rate_hz"]), length).unwrap();
            let tolerance = number(&answers["tolerance_relative"]);
            assert_all_close("frequency", &found.frequency_hz, &numbers(&case["frequency_hz"]), tolerance);
            assert_all_close("density", &found.density, &numbers(&case["density"]), tolerance);
        }
    }

    #[test]
    fn integral_of_one_segment_is_its_windowed_mean_square() {
        // Parseval's theorem, exact for every length, even and odd
        for length in [4, 5, 63, 64, 1000] {
            let series = white_noise(length as u64, length);
            let spectrum = welch(&[&series], 200.0, length).unwrap();
            let mean = super::super::mean(&[&series]);
            let window = hann(length);
            let power: f64 = series.iter().zip(&window).map(|(x, w)| ((x - mean) * w).powi(2)).sum();
            let expected = power / window.iter().map(|w| w * w).sum::<f64>();
            assert!((integral(&spectrum) / expected - 1.0).abs() < 1e-12, "rounding only, length {length}");
        }
    }

    #[test]
    fn integral_over_gaps_is_the_variance() {
        let series = autoregression(5, 200_000, &[0.9], 1.0);
        let stretches = [&series[..70_000], &series[70_010..70_100], &series[70_200..]];
        let spectrum = welch(&stretches, 100.0, 1024).unwrap();
        // the edges of each stretch weigh less than its middle: 2 of 390 half segments, three standard errors
        let ratio = integral(&spectrum) / super::super::variance(&stretches);
        assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    }

    #[test]
    fn smoothing_preserves_flatness_and_order() {
        let frequency_hz: Vec<f64> = (0..=5000).map(|bin| bin as f64 * 0.02).collect();
        let flat = Spectrum { density: vec![2.5; 5001], frequency_hz, resolution_hz: 0.02, segments: 1 };
        let smooth = flat.smoothed(20);
        assert!(smooth.density.iter().all(|density| *density == 2.5));
        assert!(smooth.frequency_hz.is_sorted_by(|a, b| a < b));
        assert_eq!(smooth.frequency_hz[0], 0.02);
        assert!(smooth.frequency_hz.len() < 80, "{} bands in 3.7 decades", smooth.frequency_hz.len());
    }

    #[test]
    fn stretches_shorter_than_a_segment_give_no_spectrum() {
        assert_eq!(welch(&[&[1.0; 15], &[2.0; 15]], 1.0, 16), None);
        assert_eq!(welch(&[], 1.0, 16), None);
    }

    #[test]
    fn suggested_segment_fits_the_longest_stretch_four_times() {
        let length = |samples: usize| segment_length_for(&[&vec![0.0; samples], &[0.0; 3]]);
        assert_eq!([length(0), length(100), length(4096), length(5000)], [4, 16, 1024, 1024]);
        assert_eq!(length(10_000_000), 65_536);
    }
}

//! Lowest mean square error of a causal linear predictor, from the data alone.

use super::quantisation::{Quantisation, quantisation};
use super::spectrum::hann;

/// −ψ(1): the mean distance of the logarithm of a periodogram ordinate below that of the density.
const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// Variance of the mean logarithm times the number of ordinates. One ordinate has π²/6; two whose complex
/// amplitudes are correlated by ρ have covariance Li₂(ρ²). A Hann window correlates neighbours by 2/3 and
/// next neighbours by 1/6: π²/6 + 2 Li₂(4/9) + 2 Li₂(1/36) = 1.644934 + 2 · 0.507035 + 2 · 0.027973.
const VARIANCE_PER_ORDINATE: f64 = 2.714_950;

/// Standard deviation of the change of ln σ² when the stretches are halved, in standard errors: 1.07 to 1.31 in
/// simulations of white, AR(1) and AR(4) noise in stretches of 128 to 8192 samples.
const SCATTER_OF_HALVING: f64 = 1.3;

/// Least length of a stretch: with random-walk noise the lowest bin of a shorter one, too coarse for it, would bias the
/// floor by more than 1 %.
const SHORTEST_STRETCH: usize = 128;

/// Number of samples below which the standard error exceeds 7 %.
const FEW_SAMPLES: usize = 1000;

/// Variance of the best one-step prediction error, with its uncertainty.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[must_use]
pub struct NoiseFloor {
    /// Innovation variance, unit² of the series.
    pub variance: f64,
    /// Standard error of the variance, unit².
    pub standard_error: f64,
    /// 95 % confidence interval of the variance, unit².
    pub interval: (f64, f64),
    pub samples: usize,
    /// Step of the converter, if the values show one.
    pub quantisation: Option<Quantisation>,
    /// Reasons to distrust the value; empty if there are none.
    pub cautions: Vec<Caution>,
}

/// A reason to distrust a noise floor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum Caution {
    /// Fewer than 1000 samples in stretches of at least 128.
    FewSamples,
    /// Stretches of half the length give a different result: they are too short for the sharp lines or the steep slow
    /// noise in them, and the interval is not valid.
    Unresolved,
    /// At least half of the value is the rounding of the converter. It is a valid floor, but it is the converter's, and
    /// noise that spans less than half a step is not white, so that a predictor can be better.
    Quantised,
}

impl std::fmt::Display for Caution {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Caution::FewSamples => "fewer than 1000 samples without gaps: record longer",
            Caution::Unresolved => {
                "the gap-free stretches are too short for the lines or drifts in them: record without gaps"
            }
            Caution::Quantised => {
                "at least half of it is the rounding of the converter: use a finer range or more bits"
            }
        })
    }
}

impl NoiseFloor {
    /// Returns true if a mean square error is below the confidence interval, and thus implausibly small.
    #[must_use]
    pub fn is_beaten_by(&self, mean_square_error: f64) -> bool {
        mean_square_error < self.interval.0
    }
}

/// Variance of the one-step prediction error of the best linear predictor that knows the whole past of the series
/// (Kolmogorov 1941, Szegő 1939; Brockwell & Davis 1991, theorem 5.8.1):
///
/// σ² = exp( (1/2π) ∫ ln(2π f(λ)) dλ )
///
/// The integral is taken as the mean of the logarithm of the periodogram, minus its bias ψ(1) = −0.577 (Davis & Jones,
/// J. Am. Stat. Assoc. 63, 1968; Hannan & Nicholls, J. Am. Stat. Assoc. 72, 1977). There are two differences: a Hann
/// window prevents the power of slow noise and drift, up to a hundred million times that of the floor, from leaking
/// into the frequencies that determine the floor; and ordinates are not averaged in groups before the logarithm, with
/// ψ(m) − ln m as the bias. With this window that would reduce the variance from 5.4/N to 3.9/N at best, at the price
/// of a bias where the spectrum is steep.
///
/// The interval is normal in ln σ². Logarithms of all stretches are pooled. A predictor that also uses other channels
/// may be below the floor; a nonlinear one only if the noise is not Gaussian.
///
/// `None` if no stretch has 128 samples or the series is constant.
pub fn noise_floor(stretches: &[&[f64]]) -> Option<NoiseFloor> {
    let used: Vec<&[f64]> = stretches
        .iter()
        .copied()
        .filter(|stretch| stretch.len() >= SHORTEST_STRETCH && !super::is_constant(&[stretch]))
        .collect();
    if used.is_empty() {
        return None;
    }
    let whole = log_spectrum(&used);
    let log_error = (VARIANCE_PER_ORDINATE / whole.ordinates).sqrt();
    let variance = (whole.mean + EULER_GAMMA).exp();
    let samples = super::sample_count(&used);
    let quantisation = quantisation(&used);

    let halves: Vec<&[f64]> = used.iter().flat_map(|s| <[_; 2]>::from(s.split_at(s.len() / 2))).collect();
    let change = (log_spectrum(&halves).mean - whole.mean).abs();
    let cautions = [
        (samples < FEW_SAMPLES, Caution::FewSamples),
        (change > 3.0 * SCATTER_OF_HALVING * log_error, Caution::Unresolved),
        (quantisation.is_some_and(|found| variance <= 2.0 * found.variance), Caution::Quantised),
    ];
    Some(NoiseFloor {
        variance,
        standard_error: variance * log_error,
        interval: (variance * (-1.96 * log_error).exp(), variance * (1.96 * log_error).exp()),
        samples,
        quantisation,
        cautions: cautions.into_iter().filter_map(|(speaks, caution)| speaks.then_some(caution)).collect(),
    })
}

/// Mean logarithm of the periodogram, and the number of ordinates it comes from.
struct LogSpectrum {
    mean: f64,
    ordinates: f64,
}

/// Ordinates at zero and at the Nyquist frequency are real, and the mean is subtracted, so they have another
/// distribution. Each covers half a bin; their neighbours replace them. Without this, the peak of slow noise at zero
/// would be missing: in stretches of 128 samples the floor would be 5 % too low at φ = 0.999.
fn log_spectrum(stretches: &[&[f64]]) -> LogSpectrum {
    let mut sum = 0.0;
    let mut ordinates = 0.0;
    for stretch in stretches {
        let window = hann(stretch.len());
        let window_power: f64 = window.iter().map(|w| w * w).sum();
        let mean = super::mean(&[stretch]);
        let transform = super::transforms::forward(stretch.len());
        let mut windowed = transform.make_input_vec();
        let mut bins = transform.make_output_vec();
        for ((target, x), w) in windowed.iter_mut().zip(*stretch).zip(&window) {
            *target = w * (x - mean);
        }
        transform.process(&mut windowed, &mut bins).expect("buffers made by this transform fit it");
        // periodic parts leave ordinates that are zero except for rounding; their logarithm must stay finite
        let rounding = f64::MIN_POSITIVE + f64::EPSILON.powi(2) * super::variance(&[stretch]);
        let log = |bin: usize| (bins[bin].norm_sqr() / window_power).max(rounding).ln();
        let last = (stretch.len() - 1) / 2;
        let at_nyquist = if stretch.len().is_multiple_of(2) { log(last) } else { 0.0 };
        sum += (1..=last).map(log).sum::<f64>() + 0.5 * (log(1) + at_nyquist);
        ordinates += 0.5 * stretch.len() as f64;
    }
    LogSpectrum { mean: sum / ordinates, ordinates }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use fos_testkit::noise::{autoregression, random_walk, white_noise};

    /// Number of 200 seeded records whose interval covers the truth.
    fn held(truth: f64, record: impl Fn(u64) -> Vec<f64>) -> usize {
        let floors = (0..200).map(|seed| noise_floor(&[&record(seed)]).unwrap());
        floors.filter(|floor| floor.interval.0 <= truth && truth <= floor.interval.1).count()
    }

    #[test]
    fn interval_has_its_stated_coverage() {
        // binomial 95 % of 200 is 190 ± 3.1; 180 to 198 are three standard deviations either way
        let counts = [
            ("white", held(1.0, |seed| white_noise(seed, 4000))),
            ("white, odd prime length", held(1.0, |seed| white_noise(seed, 1999))),
            ("AR(4)", held(0.04, |seed| autoregression(seed, 8000, &[1.6, -0.95, 0.42, -0.13], 0.04))),
            ("AR(1), φ = 0.999", held(1.0, |seed| autoregression(seed, 20_000, &[0.999], 1.0))),
            ("random walk", held(1.0, |seed| random_walk(seed, 20_000))),
        ];
        println!("interval holds in {counts:?} of 200");
        for (process, count) in counts {
            assert!((180..=198).contains(&count), "{process}: {count} of 200");
        }
    }

    #[test]
    fn interval_holds_over_gaps() {
        let count = (0..200)
            .filter(|seed| {
                let x = autoregression(*seed, 20_000, &[1.6, -0.95, 0.42, -0.13], 0.04);
                let floor = noise_floor(&[&x[..3000], &x[3100..9000], &x[9010..9100], &x[9200..]]).unwrap();
                floor.interval.0 <= 0.04 && 0.04 <= floor.interval.1
            })
            .count();
        assert!((180..=198).contains(&count), "{count} of 200");
    }

    #[test]
    fn standard_error_is_the_scatter_of_repeated_records() {
        let floors: Vec<NoiseFloor> =
            (0..200).map(|seed| noise_floor(&[&white_noise(seed, 4000)]).unwrap()).collect();
        let values: Vec<f64> = floors.iter().map(|floor| floor.variance).collect();
        let scatter = super::super::variance(&[&values]).sqrt();
        // a standard deviation of 200 values is known to 5 %; three of them
        assert!((scatter / floors[0].standard_error - 1.0).abs() < 0.15, "{scatter}");
    }

    #[test]
    fn strong_slow_power_does_not_leak_into_floor() {
        let n = 100_000;
        let series: Vec<f64> =
            white_noise(11, n).iter().enumerate().map(|(i, x)| x + 4e4 * (i as f64 / n as f64)).collect();
        let floor = noise_floor(&[&series]).unwrap();
        assert!(super::super::variance(&[&series]) > 1e8);
        assert!((floor.variance - 1.0).abs() < 3.0 * floor.standard_error, "{floor:?}");
        assert!(floor.cautions.is_empty(), "{floor:?}");
    }

    #[test]
    fn cautions_have_low_false_alarm_rate() {
        let cautioned = (0..200).filter(|seed| {
            !noise_floor(&[&autoregression(*seed, 8000, &[0.95], 1.0)]).unwrap().cautions.is_empty()
        });
        assert!(cautioned.count() <= 2, "one percent");
    }

    #[test]
    fn warns_of_short_record_and_rejects_shorter_ones() {
        assert_eq!(noise_floor(&[&white_noise(1, 999)]).unwrap().cautions, [Caution::FewSamples]);
        assert_eq!(noise_floor(&[&white_noise(1, 127)]), None);
        assert_eq!(noise_floor(&[&[9.81; 5000]]), None);
        assert_eq!(noise_floor(&[]), None);
    }

    #[test]
    fn warns_of_unresolved_resonance() {
        let series = autoregression(5, 20_000, &[1.9, -0.9999], 1.0);
        let short: Vec<&[f64]> = series.chunks_exact(200).collect();
        assert_eq!(noise_floor(&short).unwrap().cautions, [Caution::Unresolved]);
        let whole = noise_floor(&[&series]).unwrap();
        assert!(whole.cautions.is_empty() && (whole.variance - 1.0).abs() < 3.0 * whole.standard_error);
    }

    #[test]
    fn short_stretches_do_not_bias_floor_of_slow_noise() {
        let series = autoregression(5, 100_000, &[0.999], 1.0);
        let short: Vec<&[f64]> = series.chunks_exact(200).collect();
        let floor = noise_floor(&short).unwrap();
        // the resolution of the lowest bin leaves 1 % of bias; plus three standard errors
        assert!((floor.variance - 1.0).abs() < 0.01 + 3.0 * floor.standard_error, "{floor:?}");
    }

    #[test]
    fn warns_of_coarse_but_not_of_fine_converter() {
        let rounded = |step: f64| -> Vec<f64> {
            white_noise(6, 10_000).iter().map(|x| step * (x / step).round()).collect()
        };
        // rounding adds its LSB²/12; the floor of what was recorded is the sum
        let coarse = noise_floor(&[&rounded(4.0)]).unwrap();
        assert_eq!(coarse.cautions, [Caution::Quantised], "{coarse:?}");
        let fine = noise_floor(&[&rounded(0.1)]).unwrap();
        assert!(fine.cautions.is_empty() && fine.quantisation.is_some(), "{fine:?}");
        assert!((fine.variance - 1.0 - 0.01 / 12.0).abs() < 3.0 * fine.standard_error);
    }

    #[test]
    fn error_below_the_interval_beats_the_floor() {
        let floor = noise_floor(&[&white_noise(2, 10_000)]).unwrap();
        assert!(floor.is_beaten_by(0.8) && !floor.is_beaten_by(1.0));
    }

    #[test]
    fn error_constants_match_their_formulas() {
        let dilogarithm = |x: f64| (1..200).map(|k| x.powi(k) / f64::from(k * k)).sum::<f64>();
        let expected = PI * PI / 6.0 + 2.0 * dilogarithm(4.0 / 9.0) + 2.0 * dilogarithm(1.0 / 36.0);
        assert!((VARIANCE_PER_ORDINATE - expected).abs() < 1e-6, "{expected}");
        assert!((EULER_GAMMA + statrs::function::gamma::digamma(1.0)).abs() < 1e-12);
    }
}

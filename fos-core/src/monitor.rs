//! Monitor: compares the running statistics of the innovation with those of the fit, to detect a model that no longer fits.

use core::hint::cold_path;

use crate::axis::Correction;
use crate::exponential::exp_m1;
use crate::model::{AxisParameters, InnovationStatistics};
use crate::real::scalar;
use crate::{Range, Real, Scalar, Validity, root};

/// Shift of the mean of the innovation that the drift test tolerates, in standard deviations (Page 1954: k).
///
/// With threshold h = 40 the mean time between false alarms of white innovations is about
/// e^(2kh)/(4k²) = 2·10⁹ samples, 110 days at 200 Hz; a shift of 0.5 σ is found in h/(0.5 − k) = 160 samples.
const MEAN_SLACK: f64 = 0.25;
const MEAN_THRESHOLD: f64 = 40.0;

/// Excess of the squared innovation that the power test tolerates, in variances.
///
/// With threshold h = 60 a doubled variance is found in 60/(1 − 0.5) = 120 samples. White innovations exceed the threshold
/// once in about 10⁹ samples: e^(−0.29·h), where 0.29 is the root θ of E e^(θ(e² − 1.5)) = 1; simulation agrees.
/// Correlated innovations wander further, see [`power_inflation`].
const POWER_SLACK: f64 = 0.5;
const POWER_THRESHOLD: f64 = 60.0;

/// Limit on a single innovation in the tests, in standard deviations: an outlier is neither a shift of the mean nor a
/// change of the variance.
const OUTLIER: f64 = 4.0;

/// Time constant of the running statistics, s.
const TAU_S: f64 = 30.0;

/// Detected deviations of the innovation from the statistics of the fit. They stay set until [`Monitor::restart`].
#[must_use]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Drift {
    /// The mean has shifted.
    pub mean: bool,
    /// The variance has increased.
    pub variance: bool,
}

/// Running mean, variance and lag-1 correlation of an axis' innovation, and a two-sided cumulative-sum test
/// (CUSUM, Page 1954) of its mean and of its power against the values stored with the model. Constant memory.
#[derive(Debug, Clone)]
pub struct Monitor<R: Scalar> {
    fitted_mean: R,
    per_deviation: R::Gain,
    deviation: R::Stored,
    scale: R::Stored,
    mean_threshold: R::Sum,
    power_threshold: R::Sum,
    gain: R::Gain,

    samples: u32,
    mean: R::Mean,
    variance: R::Mean,
    lag_1: R::Mean,
    previous: R,
    above: R::Sum,
    below: R::Sum,
    power: R::Sum,
    drift: Drift,
}

impl<R: Scalar> Monitor<R> {
    /// A monitor for the axis of `parameters`, sampled every `period_s` seconds.
    pub fn new(parameters: &AxisParameters<R::Stored>, period_s: f64) -> Self {
        let fitted = parameters.innovation;
        let built = |value: R::Stored| -> R::Built { scalar(value) };
        let real = R::Built::from_f64;
        let deviation = built(fitted.variance).square_root();
        let scale = built(parameters.scale);
        // the sum of correlated innovations has (1 + ρ)/(1 − ρ) times the variance
        let correlation = built(fitted.lag_1_correlation).limit(real(-0.99), real(0.99));
        let positive = correlation.limit(R::Built::ZERO, R::Built::ONE);
        let inflation = (R::Built::ONE + positive) / (R::Built::ONE - positive);
        Self {
            fitted_mean: scalar(built(fitted.mean) / deviation),
            per_deviation: R::gain((R::Built::ONE / (scale * deviation)).to_f64()),
            deviation: scalar(deviation),
            scale: parameters.scale,
            mean_threshold: R::sum_of(scalar(real(MEAN_THRESHOLD) * inflation)),
            power_threshold: R::sum_of(scalar(real(POWER_THRESHOLD) * power_inflation(correlation))),
            gain: R::gain((-exp_m1(-scalar::<_, R::Built>(period_s) / real(TAU_S))).to_f64()),
            samples: 0,
            mean: R::ZERO.mean_at(),
            variance: R::ONE.mean_at(),
            lag_1: R::of(fitted.lag_1_correlation).mean_at(),
            previous: R::ZERO,
            above: R::NOTHING,
            below: R::NOTHING,
            power: R::NOTHING,
            drift: Drift::default(),
        }
    }

    /// Processes a correction; only a finite innovation from a measured history counts. Returns the drift detected so far.
    #[inline]
    pub fn update(&mut self, correction: &Correction<R>) -> Drift {
        let Some(innovation) = correction.innovation else { return self.drift };
        let reasons = Validity::OWN_HISTORY | Validity::INPUT_OUT_OF_RANGE | Validity::INPUT_NOT_FINITE;
        if correction.validity.intersects(reasons) || !innovation.is_finite() {
            return self.drift;
        }
        let normalised = innovation.times(self.per_deviation) - self.fitted_mean;
        let outlier = R::from_f64(OUTLIER);
        let (mut e, mut tested) = (normalised, normalised);
        if !Range::new(-outlier, outlier).contains(normalised) {
            cold_path();
            // the innovation is bounded, but its square must stay small
            let bound = R::LARGEST_SQUARED;
            (e, tested) = (normalised.limit(-bound, bound), normalised.limit(-outlier, outlier));
        }
        self.samples = self.samples.saturating_add(1);
        e.averaged_by(&mut self.mean, self.gain);
        let deviation = e - R::mean(self.mean);
        (deviation * deviation).averaged_by(&mut self.variance, self.gain);
        (deviation * self.previous).averaged_by(&mut self.lag_1, self.gain);
        self.previous = deviation;

        let (above, below, slack) = (tested.begin(), (-tested).begin(), sum::<R>(-MEAN_SLACK));
        self.drift.mean |=
            cusum_step::<R>(&mut self.above, self.mean_threshold, |sum| R::plus(R::plus(sum, above), slack));
        self.drift.mean |=
            cusum_step::<R>(&mut self.below, self.mean_threshold, |sum| R::plus(R::plus(sum, below), slack));
        let excess = R::plus(tested.square(), sum::<R>(-1.0 - POWER_SLACK));
        self.drift.variance |=
            cusum_step::<R>(&mut self.power, self.power_threshold, |sum| R::plus(sum, excess));
        self.drift
    }

    /// Number of innovations counted so far; the statistics are unreliable before a few thousand.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Running statistics in the scaled units of the model, comparable with those of the fit.
    pub fn statistics(&self) -> InnovationStatistics<R::Stored> {
        let (variance, deviation) = (R::mean(self.variance).to_f64(), self.deviation.to_f64());
        let mean = R::mean(self.mean).to_f64() + self.fitted_mean.to_f64();
        let correlation = if variance > 0.0 { R::mean(self.lag_1).to_f64() / variance } else { 0.0 };
        InnovationStatistics {
            mean: R::Stored::from_f64(mean * deviation),
            variance: R::Stored::from_f64(variance * deviation * deviation),
            lag_1_correlation: R::Stored::from_f64(correlation.clamp(-1.0, 1.0)),
        }
    }

    /// Running mean of the innovation in the axis' unit, saturated to the range of f64.
    pub fn mean_in_unit(&self) -> f64 {
        (self.statistics().mean.to_f64() * self.scale.to_f64()).limit(-f64::MAX, f64::MAX)
    }

    /// Ratio of the running standard deviation of the innovation to that of the fit: 2 means twice the noise.
    ///
    /// Computes a square root, so call it only occasionally. Relative error at most 6·10⁻⁸, with the feature `micromath`
    /// 6 %.
    pub fn deviation_ratio(&self) -> f32 {
        // the running variance is in variances of the fit
        root::sqrt(R::mean(self.variance).to_f64() as f32)
    }

    /// Running standard deviation of the innovation in the axis' unit, with the accuracy of the
    /// [ratio](Self::deviation_ratio); saturated to the range of f32.
    pub fn deviation_in_unit(&self) -> f32 {
        let unit = self.deviation.to_f64() * self.scale.to_f64();
        ((f64::from(self.deviation_ratio()) * unit) as f32).min(f32::MAX)
    }

    /// Drift detected since the last [`restart`](Self::restart).
    pub fn drift(&self) -> Drift {
        self.drift
    }

    /// Clears the alarm and restarts the tests; the running statistics stay.
    pub fn restart(&mut self) {
        (self.above, self.below, self.power) = (R::NOTHING, R::NOTHING, R::NOTHING);
        self.drift = Drift::default();
    }
}

/// Advances a one-sided cumulative sum, limited to 0 … threshold; returns true if it reaches the threshold.
#[inline(always)]
fn cusum_step<R: Scalar>(sum: &mut R::Sum, threshold: R::Sum, next: impl FnOnce(R::Sum) -> R::Sum) -> bool {
    let next = next(*sum);
    let reached = next >= threshold;
    *sum = if reached {
        threshold
    } else if next > R::NOTHING {
        next
    } else {
        R::NOTHING
    };
    reached
}

/// `value` as a sum.
#[inline(always)]
fn sum<R: Scalar>(value: f64) -> R::Sum {
    R::sum_of(R::Stored::from_f64(value))
}

/// Factor on the power threshold that keeps the false alarm rate of correlated innovations at that of white ones:
/// θ(0)/θ(ρ), where θ(ρ) is the root of 1 + ρ² − 2θ(1 − ρ²) = e^(−3θ) + ρ²e^(3θ), which is lim E e^(θΣ(e² − 1.5)) = 1
/// for a Gaussian recursion of order 1 (Szegő's theorem on its spectrum). This approximation is at most 4 % above it
/// and needs no root finding when a model is loaded.
fn power_inflation<R: Real>(correlation: R) -> R {
    let (real, square) = (R::from_f64, correlation * correlation);
    R::ONE + (real(3.8) - real(1.17) * correlation.abs()) * square / (R::ONE - square)
}

/// Formats the statistics and the drift, not the parameters.
#[cfg(feature = "defmt")]
impl<R: Scalar> defmt::Format for Monitor<R>
where
    R::Stored: defmt::Format,
{
    fn format(&self, f: defmt::Formatter<'_>) {
        let (samples, statistics) = (self.samples, self.statistics());
        defmt::write!(
            f,
            "Monitor {{ samples: {=u32}, statistics: {}, drift: {} }}",
            samples,
            statistics,
            self.drift
        );
    }
}

#[cfg(test)]
mod tests {
    use super::power_inflation;

    #[test]
    fn power_threshold_matches_correlated_innovations() {
        // from the left of the root, where the difference is positive
        let theta = |correlation: f64| {
            let square = correlation * correlation;
            let left = |theta: f64| {
                1.0 + square
                    - 2.0 * theta * (1.0 - square)
                    - (-3.0 * theta).exp()
                    - square * (3.0 * theta).exp()
            };
            (1..).map(|step| f64::from(step) * 1e-6).find(|&theta| left(theta) < 0.0).unwrap()
        };
        assert!((theta(0.0) - 0.2914).abs() < 1e-4);
        for correlation in [-0.9, -0.5, -0.1, 0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99] {
            let ratio = power_inflation(correlation) * theta(correlation) / theta(0.0);
            assert!((0.999..1.045).contains(&ratio), "{correlation}: {ratio}");
        }
    }
}

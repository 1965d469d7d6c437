//! Conversion of models to another scalar. On the way to the image, f64 is rounded to f32 here, once.

use crate::real::scalar;
use crate::{
    AxisParameters, InnovationStatistics, Input, Range, Real, Scalar, StillnessLimits, Term, Transform,
};

impl<S: Scalar> Range<S> {
    /// The same range in another scalar.
    pub fn convert<R: Scalar>(&self) -> Range<R> {
        Range { low: scalar(self.low), high: scalar(self.high) }
    }
}

impl<S: Real> Term<S> {
    /// The same term in another scalar.
    pub fn convert<R: Real>(&self) -> Term<R> {
        self.with_coefficient(scalar(self.coefficient))
    }
}

impl<S: Real> Transform<S> {
    /// The same transform in another scalar.
    pub fn convert<R: Real>(&self) -> Transform<R> {
        match *self {
            Self::Identity => Transform::Identity,
            Self::LowPass { tau_s } => Transform::LowPass { tau_s: scalar(tau_s) },
            Self::Rate { tau_s } => Transform::Rate { tau_s: scalar(tau_s) },
            Self::Variance { tau_s } => Transform::Variance { tau_s: scalar(tau_s) },
            Self::Backlash { half_width } => Transform::Backlash { half_width: scalar(half_width) },
            Self::Absolute => Transform::Absolute,
            Self::Decay { tau_s } => Transform::Decay { tau_s: scalar(tau_s) },
            Self::Time => Transform::Time,
            Self::Sine { frequency_hz } => Transform::Sine { frequency_hz: scalar(frequency_hz) },
            Self::Cosine { frequency_hz } => Transform::Cosine { frequency_hz: scalar(frequency_hz) },
        }
    }
}

impl<S: Real> Input<S> {
    /// The same input in another scalar.
    pub fn convert<R: Real>(&self) -> Input<R> {
        Input {
            source: self.source,
            transform: self.transform.convert(),
            centre: scalar(self.centre),
            scale: scalar(self.scale),
            source_range: self.source_range.convert(),
            range: self.range.convert(),
        }
    }
}

impl<S: Real> AxisParameters<S> {
    /// The same parameters in another scalar.
    pub fn convert<R: Real>(&self) -> AxisParameters<R> {
        AxisParameters {
            axis: self.axis,
            reference: scalar(self.reference),
            offset: scalar(self.offset),
            scale: scalar(self.scale),
            constant: scalar(self.constant),
            range: self.range.convert(),
            physical_range: self.physical_range.convert(),
            full_scale: scalar(self.full_scale),
            stuck_after_repeats: self.stuck_after_repeats,
            gap_limit_samples: self.gap_limit_samples,
            coast_limit_s: scalar(self.coast_limit_s),
            innovation: InnovationStatistics {
                mean: scalar(self.innovation.mean),
                variance: scalar(self.innovation.variance),
                lag_1_correlation: scalar(self.innovation.lag_1_correlation),
            },
        }
    }
}

impl<S: Real> StillnessLimits<S> {
    /// The same limits in another scalar.
    pub fn convert<R: Real>(&self) -> StillnessLimits<R> {
        StillnessLimits {
            window: self.window,
            accel_variance: scalar(self.accel_variance),
            gyro_variance: scalar(self.gyro_variance),
            gyro_at_rest: self.gyro_at_rest.map(scalar),
            gyro_deviation: scalar(self.gyro_deviation),
        }
    }
}

//! Orientation gate: an accelerometer at rest may be tracked only in the orientation of the fit, where the model has its
//! true value.

use crate::model::{Axis, AxisParameters};
use crate::{Real, Scalar};

/// Standard gravity, m/s²; gravity anywhere on the ground is within 0.3 % of it.
pub const GRAVITY_MPS2: f32 = 9.80665;

/// Distance of an accelerometer at rest from its reference above which its orientation differs from that of the fit, in
/// scaled units (standard deviations of the data of the fit). For a noise of 0.02 m/s², 20 of them are a tilt of 2°; a
/// bias drifts by less.
pub const OTHER_POSE: f64 = 20.0;

/// Decides from the previous sample whether an axis at rest is in the orientation of its fit.
///
/// At rest the true value of a gyro is 0 in every orientation. That of an accelerometer is the component of gravity,
/// which a model holds for one orientation only, as its reference. Tracking in another orientation would take the tilt
/// for an error. So an axis that is still in sample n is tracked if sample n − 1 was in that orientation:
///
/// ```text
/// |corrected(n − 1) − reference| ≤ 20 scale
/// ```
///
/// An accelerometer measures the same gravity after a rotation about its own axis. With several accelerometers, track
/// all of them or none: all gates must be open.
///
/// The test uses the corrected value of the latest sample alone, tracked or coasted, at rest or in motion, in the axis'
/// unit. There is no averaging and no look-ahead, so host and device decide alike, sample by sample. A sample without a
/// finite value leaves the decision unchanged. Before the first sample the orientation is unknown, so accelerometers are
/// not tracked.
///
/// The gate is needed only with the model's own reference: a measured true value holds in every orientation.
///
/// ```
/// use fos_core::{Axis, AxisParameters, GRAVITY_MPS2, InnovationStatistics, PoseGate, Range};
///
/// let upright = AxisParameters {
///     axis: Axis::Az,
///     reference: GRAVITY_MPS2,
///     offset: 0.0,
///     scale: 0.02,
///     constant: 0.0,
///     range: Range { low: -4.0, high: 4.0 },
///     physical_range: Range { low: 0.0, high: 0.0 },
///     full_scale: 39.2,
///     stuck_after_repeats: 0,
///     gap_limit_samples: 10,
///     coast_limit_s: 60.0,
///     innovation: InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 },
/// };
/// let gate = PoseGate::new(&upright);
/// assert!(!gate.is_open_at_first());
/// assert!(gate.is_open_after(9.9)); // sin 2° of gravity is 0.34 m/s², and 20 scales are 0.4 m/s²
/// assert!(!gate.is_open_after(-9.8)); // upside down
/// assert!(PoseGate::new(&AxisParameters { axis: Axis::Gz, reference: 0.0, ..upright }).is_open_after(30.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PoseGate<R> {
    reference: R,
    /// Limit in the axis' unit; infinite for axes whose reference holds in every orientation.
    limit: R,
}

impl<R: Real> PoseGate<R> {
    /// The gate of an axis; always open unless the axis is an accelerometer.
    pub fn new(parameters: &AxisParameters<R>) -> Self {
        let limit = match parameters.axis {
            Axis::Ax | Axis::Ay | Axis::Az => R::from_f64(OTHER_POSE) * parameters.scale,
            Axis::Gx | Axis::Gy | Axis::Gz | Axis::Other => R::from_f64(f64::INFINITY),
        };
        Self { reference: parameters.reference, limit }
    }

    /// The same gate in another scalar.
    pub fn convert<S: Scalar<Stored = R>>(&self) -> PoseGate<S> {
        PoseGate { reference: S::of(self.reference), limit: S::of(self.limit) }
    }
}

impl<R: Scalar> PoseGate<R> {
    /// True if the first sample may be tracked.
    pub fn is_open_at_first(&self) -> bool {
        self.limit >= R::MAX
    }

    /// True if the next sample may be tracked, given the [`Correction::corrected`](crate::Correction::corrected) of this
    /// one, in the axis' unit.
    #[inline(always)]
    pub fn is_open_after(&self, corrected: R) -> bool {
        (corrected - self.reference).abs() <= self.limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{InnovationStatistics, Range};

    fn parameters<R: Real>(axis: Axis, reference: f64, scale: f64) -> AxisParameters<R> {
        let real = R::from_f64;
        AxisParameters {
            axis,
            reference: real(reference),
            offset: R::ZERO,
            scale: real(scale),
            constant: R::ZERO,
            range: Range { low: real(-4.0), high: real(4.0) },
            physical_range: Range { low: R::ZERO, high: R::ZERO },
            full_scale: R::ZERO,
            stuck_after_repeats: 0,
            gap_limit_samples: 0,
            coast_limit_s: R::ZERO,
            innovation: InnovationStatistics { mean: R::ZERO, variance: R::ONE, lag_1_correlation: R::ZERO },
        }
    }

    // the scale is a power of two, so that the limit is exact in both scalars
    fn opens_up_to_the_limit<R: Real>() {
        for axis in [Axis::Ax, Axis::Ay, Axis::Az] {
            let gate = PoseGate::new(&parameters::<R>(axis, 4.0, 0.125));
            assert!(!gate.is_open_at_first());
            for (corrected, open) in [(4.0, true), (6.5, true), (1.5, true), (6.501, false), (1.499, false)] {
                assert_eq!(gate.is_open_after(R::from_f64(corrected)), open, "{axis:?} at {corrected}");
            }
            assert!(!gate.is_open_after(R::from_f64(f64::NAN)), "what is not known is no pose");
        }
        for axis in [Axis::Gx, Axis::Gy, Axis::Gz, Axis::Other] {
            let gate = PoseGate::new(&parameters::<R>(axis, -1.0, 0.125));
            assert!(gate.is_open_at_first());
            assert!(gate.is_open_after(R::MAX) && gate.is_open_after(-R::MAX), "no value shuts it");
        }
    }

    #[test]
    fn accelerometers_are_gated_at_twenty_scales_and_gyros_never() {
        opens_up_to_the_limit::<f32>();
        opens_up_to_the_limit::<f64>();
    }
}

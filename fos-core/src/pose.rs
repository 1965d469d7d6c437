//! Is the true value of an accelerometer at rest the one that the model knows? Decides whether a still axis may be
//! tracked.

use crate::model::{Axis, AxisParameters};
use crate::{Real, Scalar};

/// Standard gravity, m/s²; anywhere on the ground it is within 0.3 % of this.
pub const GRAVITY_MPS2: f32 = 9.80665;

/// A still accelerometer that is further than this from its reference, in scaled units (standard deviations of the
/// data that the model was fitted to), lies in another pose than that of the fit: 20 are a tilt of 2° for a noise of
/// 0.02 m/s², and a bias drifts by less.
pub const OTHER_POSE: f64 = 20.0;

/// Whether an axis at rest is in the pose of its fit, told by the sample before.
///
/// At rest the true value of a gyro is 0 in every pose; that of an accelerometer is what gravity gives in its pose,
/// and a model knows it for one pose only, its reference. Tracked in another one, the tilt would be taken for an
/// error. So an axis is tracked in sample n, should the unit be still then, if sample n − 1 was in the pose:
///
/// ```text
/// |corrected(n − 1) − reference| ≤ 20 scale
/// ```
///
/// An accelerometer whose axis the unit was turned about feels the same gravity as before, so that whoever tracks several
/// of them tracks either all or none: all gates must be open.
///
/// It is judged on the corrected value, with offset and all that the model predicts taken out, of the one latest
/// sample, tracked or coasted, at rest or not, in the axis' unit. Nothing is averaged and nothing looked ahead for,
/// so that host and device judge alike, and sample by sample. A sample without a finite value leaves its axis where
/// the last finite one was. Before the first sample the pose of an accelerometer is not known, and it is not tracked.
///
/// Only the model's own reference needs the gate: a true value that is measured is true in every pose.
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
    /// In the axis' unit; infinite where every pose is that of the fit.
    limit: R,
}

impl<R: Real> PoseGate<R> {
    /// The gate of an axis: always open unless it is an accelerometer.
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
    /// Whether the very first sample may be tracked.
    pub fn is_open_at_first(&self) -> bool {
        self.limit >= R::MAX
    }

    /// Whether the next sample may be tracked, after one that was `corrected` to this, in the axis' unit: a
    /// [`Correction::corrected`](crate::Correction::corrected).
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

    /// A power of two, so that the bound itself is exact in both scalars.
    fn judges_to_the_bound<R: Real>() {
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
    fn an_accelerometer_may_be_twenty_scales_from_its_reference_and_a_gyro_anywhere() {
        judges_to_the_bound::<f32>();
        judges_to_the_bound::<f64>();
    }
}

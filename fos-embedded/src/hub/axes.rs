//! The six axes of a sensor, and which of them a model has.

use fos_core::{Axis, Correction, PoseGate, Scalar};

/// Axes of a hub: accelerometer x, y, z, gyro x, y, z, in this order everywhere.
pub const AXES: usize = 6;

/// The axes of a hub, in their order everywhere.
pub const SIX: [Axis; AXES] = [Axis::Ax, Axis::Ay, Axis::Az, Axis::Gx, Axis::Gy, Axis::Gz];

/// The gate of an axis that is in the pose of its fit, or is not.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gate<R> {
    /// Which of the six it is.
    pub(super) channel: u8,
    pub(super) pose: PoseGate<R>,
}

impl<R: Scalar> Gate<R> {
    #[inline(always)]
    pub(super) fn is_open_after(&self, corrections: &[Correction<R>; AXES]) -> bool {
        corrections
            .get(usize::from(self.channel))
            .is_some_and(|correction| self.pose.is_open_after(correction.corrected))
    }
}

/// Which axis one of the six is.
pub(super) fn axis_of(channel: u8) -> Axis {
    SIX.get(usize::from(channel)).copied().unwrap_or(Axis::Other)
}

/// Which of the six an axis is.
pub(super) fn channel_of(axis: Axis) -> Option<u8> {
    (0..).zip(SIX).find(|(_, other)| *other == axis).map(|(channel, _)| channel)
}

/// The value of one of the six; there is always one.
#[inline(always)]
pub(super) fn at<R: Scalar>(values: &[R; AXES], channel: u8) -> R {
    values.get(usize::from(channel)).copied().unwrap_or(R::ZERO)
}

//! The six axes of a sensor and their order.

use fos_core::{Axis, Correction, PoseGate, Scalar};

/// Number of axes of a hub: accelerometer x, y, z, gyro x, y, z, in this order everywhere.
pub const AXES: usize = 6;

/// The axes of a hub, in the order used everywhere.
pub const SIX: [Axis; AXES] = [Axis::Ax, Axis::Ay, Axis::Az, Axis::Gx, Axis::Gy, Axis::Gz];

/// Orientation gate of an accelerometer of the model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gate<R> {
    /// Index of the axis among the six.
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

/// Axis with the index `channel` among the six.
pub(super) fn axis_of(channel: u8) -> Axis {
    SIX.get(usize::from(channel)).copied().unwrap_or(Axis::Other)
}

/// Index of an axis among the six; `None` for others.
pub(super) fn channel_of(axis: Axis) -> Option<u8> {
    match axis {
        Axis::Ax => Some(0),
        Axis::Ay => Some(1),
        Axis::Az => Some(2),
        Axis::Gx => Some(3),
        Axis::Gy => Some(4),
        Axis::Gz => Some(5),
        Axis::Other => None,
    }
}

/// True if `channel` is one of the axes of a model.
#[inline(always)]
pub(super) fn is_modelled(axes: &[u8], channel: u8) -> bool {
    #[expect(clippy::manual_contains, reason = "`contains` compares eight at a time with much code")]
    axes.iter().any(|modelled| *modelled == channel)
}

/// Value of one of the six axes. A wrong index, which cannot occur, gives 0.
#[inline(always)]
pub(super) fn at<R: Scalar>(values: &[R; AXES], channel: u8) -> R {
    values.get(usize::from(channel)).copied().unwrap_or(R::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_have_the_order_of_the_six_axes() {
        for (channel, axis) in (0..).zip(SIX) {
            assert_eq!((channel_of(axis), axis_of(channel)), (Some(channel), axis));
        }
        assert_eq!((channel_of(Axis::Other), axis_of(6)), (None, Axis::Other));
    }
}

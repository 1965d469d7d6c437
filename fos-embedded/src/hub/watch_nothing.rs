//! Replacement for `watch.rs` without the feature `monitor`: the fit of the model is not monitored.

use core::marker::PhantomData;

use fos_core::{AxisParameters, Correction, Drift, InnovationStatistics, Scalar};

use super::axes::AXES;

/// No monitors, hence no drift.
#[derive(Debug, Clone)]
pub(super) struct Watch<R>(PhantomData<R>);

impl<R: Scalar<Stored = f32>> Watch<R> {
    pub(super) const NOTHING: Self = Self(PhantomData);

    pub(super) fn clear(&mut self) {}

    pub(super) fn add(&mut self, _: &AxisParameters<f32>, _period_s: f64) {}

    #[inline]
    pub(super) fn update(&mut self, _axes: &[u8], _: &[Correction<R>; AXES]) -> Option<usize> {
        None
    }

    #[inline]
    pub(super) fn any(&self) -> bool {
        false
    }

    pub(super) fn drift(&self, _index: usize) -> Option<Drift> {
        None
    }

    pub(super) fn statistics(&self, _index: usize) -> Option<InnovationStatistics<f32>> {
        None
    }

    pub(super) fn deviation_ratio(&self, _index: usize) -> Option<f32> {
        None
    }

    pub(super) fn restart(&mut self) {}
}

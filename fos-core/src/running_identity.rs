//! Replacement for `running.rs` without the feature `transforms`: the identity is the only transform.

use core::marker::PhantomData;

use crate::{Scalar, Transform};

/// u = x, without coefficients or state: models with another transform were rejected.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Running<R: Scalar>(PhantomData<R>);

impl<R: Scalar> Running<R> {
    pub(crate) fn new(
        _: &Transform<R::Stored>,
        _period_s: f64,
        _centre: R::Stored,
        _scale: R::Stored,
    ) -> Self {
        Self(PhantomData)
    }

    pub(crate) fn start_at(&mut self, _: R) {}

    pub(crate) fn reset(&mut self) {}

    #[inline]
    pub(crate) fn update(&mut self, x: R) -> R {
        x
    }

    pub(crate) fn skip(&mut self, _: R, _ticks: u32) {}
}

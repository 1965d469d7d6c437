//! The scalar: f32 on the device, f32 and f64 on the host, one source for both.

use core::fmt::Debug;
use core::ops::{Add, Mul, Neg, Sub};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// The scalar in which a model is evaluated.
///
/// Per sample only `+`, `−`, `×` and comparisons are used, in a fixed order and never fused, so that every
/// machine with IEEE 754 arithmetic gives the same bits. There is no division on purpose: what divides is
/// inverted once, when a model is built, in f64.
pub trait Real:
    Copy
    + PartialOrd
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + sealed::Sealed
    + 'static
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// The largest finite value.
    const MAX: Self;

    /// The value nearest to `value`.
    fn from_f64(value: f64) -> Self;
    /// The value nearest to `value`; exact up to 2²⁴ in f32.
    fn from_u32(value: u32) -> Self;
    /// The same value, or nearest to it, as f64.
    fn to_f64(self) -> f64;
    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;

    /// The absolute value; NaN stays NaN.
    fn abs(self) -> Self;

    /// `self` if it lies in `low ..= high`, else the bound it is beyond; NaN gives `low`.
    #[inline]
    fn limit(self, low: Self, high: Self) -> Self {
        if self > high {
            high
        } else if self >= low {
            self
        } else {
            low
        }
    }
}

/// Finite and above 0.
pub(crate) fn is_positive<R: Real>(value: R) -> bool {
    value.is_finite() && value > R::ZERO
}

impl Real for f32 {
    const ZERO: f32 = 0.0;
    const ONE: f32 = 1.0;
    const MAX: f32 = f32::MAX;

    #[inline]
    fn from_f64(value: f64) -> f32 {
        value as f32
    }
    #[inline]
    fn from_u32(value: u32) -> f32 {
        value as f32
    }
    #[inline]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline]
    fn is_finite(self) -> bool {
        f32::is_finite(self)
    }
    #[inline]
    fn abs(self) -> f32 {
        f32::abs(self)
    }
}

impl Real for f64 {
    const ZERO: f64 = 0.0;
    const ONE: f64 = 1.0;
    const MAX: f64 = f64::MAX;

    #[inline]
    fn from_f64(value: f64) -> f64 {
        value
    }
    #[inline]
    fn from_u32(value: u32) -> f64 {
        f64::from(value)
    }
    #[inline]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
    #[inline]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
}

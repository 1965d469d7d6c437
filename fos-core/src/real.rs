//! The scalar: f32 on the device, f32 and f64 on the host, fixed point where there is no float; one source for all.

use core::fmt::Debug;
use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::arithmetic::Arithmetic;

/// What a model is evaluated in: a [`Real`], or [`Fixed`](crate::Fixed).
///
/// Per sample only `+`, `−`, `×` and comparisons are used, in a fixed order and never fused, so that every
/// machine gives the same bits. There is no division on purpose: what divides is inverted once, when a model is built,
/// in [`Built`](Self::Built).
pub trait Scalar:
    Arithmetic
    + PartialOrd
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// Of the models that it evaluates: itself, if that is a float.
    type Stored: Real;
    /// In which the constants of a model are computed, once, when it is built: as exact as they are kept. A device with
    /// floats of 32 bits links no arithmetic of 64.
    type Built: Real;

    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// The largest finite value.
    const MAX: Self;
    /// Not a number.
    const NAN: Self;

    /// The value nearest to `value`.
    fn from_f64(value: f64) -> Self;
    /// The value nearest to `value`; exact up to 2²⁴ in f32.
    fn from_u32(value: u32) -> Self;
    /// The same value, or nearest to it, as f64.
    fn to_f64(self) -> f64;
    /// The value nearest to that of a model or a log.
    fn of(stored: Self::Stored) -> Self;
    /// The same value, or nearest to it, as a model or a log has it.
    fn stored(self) -> Self::Stored;
    /// `code` × `unit`: what a sensor's code stands for.
    fn of_code(code: i16, unit: Self::Stored) -> Self;
    /// A sum of values, or of squares, as a model has it.
    fn sum_stored(sum: Self::Sum) -> Self::Stored;
    /// The sum nearest to that.
    fn sum_of(stored: Self::Stored) -> Self::Sum;
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

/// A float: the scalar of models.
pub trait Real: Scalar<Stored = Self, Built = Self> + Div<Output = Self> {
    /// The whole part; the nearest u32 to what is none, 0 of NaN.
    fn to_u32(self) -> u32;
    /// √x, correctly rounded: for constants, whatever the features.
    fn square_root(self) -> Self;
}

macro_rules! float {
    ($float:ty, $square_root:path) => {
        impl Scalar for $float {
            type Stored = $float;
            type Built = $float;

            const ZERO: $float = 0.0;
            const ONE: $float = 1.0;
            const MAX: $float = <$float>::MAX;
            const NAN: $float = <$float>::NAN;

            #[inline]
            fn from_f64(value: f64) -> $float {
                value as $float
            }
            #[inline]
            fn from_u32(value: u32) -> $float {
                value as $float
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn of(stored: $float) -> $float {
                stored
            }
            #[inline(always)]
            fn stored(self) -> $float {
                self
            }
            #[inline(always)]
            fn of_code(code: i16, unit: $float) -> $float {
                <$float>::from(code) * unit
            }
            #[inline(always)]
            fn sum_stored(sum: $float) -> $float {
                sum
            }
            #[inline(always)]
            fn sum_of(stored: $float) -> $float {
                stored
            }
            #[inline]
            fn is_finite(self) -> bool {
                <$float>::is_finite(self)
            }
            #[inline]
            fn abs(self) -> $float {
                <$float>::abs(self)
            }
        }

        impl Real for $float {
            #[inline]
            fn to_u32(self) -> u32 {
                self as u32
            }
            fn square_root(self) -> $float {
                $square_root(self)
            }
        }
    };
}

float!(f32, libm::sqrtf);
float!(f64, libm::sqrt);

/// Finite and above 0.
pub(crate) fn is_positive<R: Real>(value: R) -> bool {
    value.is_finite() && value > R::ZERO
}

/// The value nearest to it in another scalar; one of 32 bits stays what it is, without arithmetic of 64.
#[inline]
pub(crate) fn scalar<S: Scalar, R: Scalar>(value: S) -> R {
    R::from_f64(value.to_f64())
}

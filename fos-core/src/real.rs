//! The scalar: f32 on the device, f32 and f64 on the host, fixed point without an FPU; one source for all.

use core::fmt::Debug;
use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::arithmetic::Arithmetic;

/// Arithmetic in which a model is evaluated: a [`Real`], or [`Fixed`](crate::Fixed).
///
/// Per sample only `+`, `−`, `×` and comparisons are used, in a fixed order and never fused, so that every
/// machine gives the same bits. There is deliberately no division: divisors are inverted once, in
/// [`Built`](Self::Built), when a model is built.
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
    /// Float of the models that this scalar evaluates; a float evaluates models of that float.
    type Stored: Real;
    /// Float in which the constants of a model are computed when it is built; as precise as the constants are stored.
    /// With f32, a device links no 64-bit arithmetic.
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
    /// The f64 nearest to the value.
    fn to_f64(self) -> f64;
    /// The value nearest to a number of a model or log.
    fn of(stored: Self::Stored) -> Self;
    /// The number nearest to the value in the float of models and logs.
    fn stored(self) -> Self::Stored;
    /// `code` × `unit`, the physical value of a sensor's code.
    fn of_code(code: i16, unit: Self::Stored) -> Self;
    /// The sum nearest to a number of a model.
    fn sum_of(stored: Self::Stored) -> Self::Sum;
    /// True if the value is neither NaN nor infinite.
    fn is_finite(self) -> bool;

    /// The absolute value; NaN stays NaN.
    fn abs(self) -> Self;

    /// `self` limited to `low ..= high`; `low` for NaN.
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
    /// The integer part, saturated to the range of u32; 0 for NaN.
    fn to_u32(self) -> u32;
    /// √x, correctly rounded; for constants, independent of the features.
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

/// The nearest value in another scalar. An f32 stays unchanged, without 64-bit arithmetic.
#[inline]
pub(crate) fn scalar<S: Scalar, R: Scalar>(value: S) -> R {
    R::from_f64(value.to_f64())
}

//! Arithmetic of the step other than `+`, `−` and `×`: constant factors of any size, sums of products, slow low-passes.
//!
//! For floats it is plain arithmetic in a fixed order. In fixed point each of these types is wider than a value.

use core::fmt::Debug;
use core::ops::Neg;

/// Arithmetic of a scalar. Sealed: other crates cannot implement it.
pub trait Arithmetic: Copy + Send + Sync {
    /// A constant factor that may lie outside the range of values: 1/scale, or the gain of a slow low-pass.
    type Gain: Copy + Debug + Send + Sync;
    /// A sum of products.
    type Sum: Copy + PartialOrd + Neg<Output = Self::Sum> + Debug + Send + Sync;
    /// State of a low-pass, with more digits than a value: its steps may be smaller than the last place of the value.
    type Slow: Copy + Debug + Send + Sync;
    /// State of a running mean, which may lose steps smaller than the last place.
    type Mean: Copy + Debug + Send + Sync;

    /// The empty sum, 0.
    const NOTHING: Self::Sum;
    /// The largest sum, at which [`plus`](Self::plus) saturates in fixed point.
    const LARGEST_SUM: Self::Sum;
    /// Limit for values that are squared, so that the square is a value.
    const LARGEST_SQUARED: Self;

    /// Magnitude that no value reaches; a model that needs larger ones is rejected.
    const LIMIT: f32;
    /// True for a NaN that comparisons do not catch; always false for floats.
    fn is_absent(self) -> bool;

    /// The gain nearest to `value`.
    fn gain(value: f64) -> Self::Gain;
    /// The value of a gain.
    fn gain_to_f64(gain: Self::Gain) -> f64;
    /// `self` × `gain`.
    fn times(self, gain: Self::Gain) -> Self;
    /// `n` × `gain`.
    fn count(n: u32, gain: Self::Gain) -> Self;

    /// A sum that begins with `self`.
    fn begin(self) -> Self::Sum;
    /// `sum` + `value`.
    fn add_value(sum: Self::Sum, value: Self) -> Self::Sum;
    /// `sum` + `a` × `b`.
    fn add_product(sum: Self::Sum, a: Self, b: Self) -> Self::Sum;
    /// Value of a sum.
    fn end(sum: Self::Sum) -> Self;
    /// `self` × `self`.
    fn square(self) -> Self::Sum;
    /// `a` + `b`, saturating in fixed point, for sums without a bound from the model.
    fn plus(a: Self::Sum, b: Self::Sum) -> Self::Sum;
    /// `sum` × `gain`, for a gain of at most 1.
    fn share(sum: Self::Sum, gain: Self::Gain) -> Self::Sum;

    /// State of a low-pass with the value `self`.
    fn at_rest(self) -> Self::Slow;
    /// Value of a low-pass.
    fn now(slow: Self::Slow) -> Self;
    /// One step towards `self`: s ← s + gain·(self − s).
    fn approached_by(self, slow: &mut Self::Slow, gain: Self::Gain);

    /// State of a running mean with the value `self`.
    fn mean_at(self) -> Self::Mean;
    /// Value of a running mean.
    fn mean(mean: Self::Mean) -> Self;
    /// One step of the running mean towards `self`.
    fn averaged_by(self, mean: &mut Self::Mean, gain: Self::Gain);
}

/// A low-pass with compensated summation.
///
/// In f32 a plain s += g·(x − s) stops moving when g·(x − s) falls below half a unit in the last place of s: with
/// τ = 1000 s at 200 Hz that is 1 % of s. Carrying the part that did not fit (Kahan 1965) removes the dead band.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Compensated<R> {
    value: R,
    carried: R,
}

macro_rules! float {
    ($float:ty) => {
        impl Arithmetic for $float {
            type Gain = $float;
            type Sum = $float;
            type Slow = Compensated<$float>;
            type Mean = $float;

            const NOTHING: $float = 0.0;
            const LARGEST_SUM: $float = <$float>::MAX;
            const LARGEST_SQUARED: $float = 1e6;

            const LIMIT: f32 = f32::INFINITY;

            #[inline(always)]
            fn is_absent(self) -> bool {
                false
            }

            #[inline]
            fn gain(value: f64) -> $float {
                value as $float
            }
            #[inline]
            fn gain_to_f64(gain: $float) -> f64 {
                f64::from(gain)
            }
            #[inline(always)]
            fn times(self, gain: $float) -> $float {
                gain * self
            }
            #[inline]
            fn count(n: u32, gain: $float) -> $float {
                n as $float * gain
            }

            #[inline(always)]
            fn begin(self) -> $float {
                self
            }
            #[inline(always)]
            fn add_value(sum: $float, value: $float) -> $float {
                sum + value
            }
            #[inline(always)]
            fn add_product(sum: $float, a: $float, b: $float) -> $float {
                sum + a * b
            }
            #[inline(always)]
            fn end(sum: $float) -> $float {
                sum
            }
            #[inline(always)]
            fn square(self) -> $float {
                self * self
            }
            #[inline(always)]
            fn plus(a: $float, b: $float) -> $float {
                a + b
            }
            #[inline(always)]
            fn share(sum: $float, gain: $float) -> $float {
                sum * gain
            }

            fn at_rest(self) -> Compensated<$float> {
                Compensated { value: self, carried: 0.0 }
            }
            #[inline]
            fn now(slow: Compensated<$float>) -> $float {
                slow.value
            }
            #[inline]
            fn approached_by(self, slow: &mut Compensated<$float>, gain: $float) {
                let change = gain * (self - slow.value) + slow.carried;
                let value = slow.value + change;
                *slow = Compensated { value, carried: change - (value - slow.value) };
            }

            #[inline(always)]
            fn mean_at(self) -> $float {
                self
            }
            #[inline(always)]
            fn mean(mean: $float) -> $float {
                mean
            }
            #[inline(always)]
            fn averaged_by(self, mean: &mut $float, gain: $float) {
                *mean = *mean + gain * (self - *mean);
            }
        }
    };
}

float!(f32);
float!(f64);

//! What a step computes with beside `+`, `−` and `×`: constants of any size, sums of products, values that hardly move.
//!
//! For floats all of it is plain arithmetic, in a fixed order. In fixed point each is wider than a value.

use core::fmt::Debug;

/// The arithmetic of a scalar. Nobody else can implement it.
pub trait Arithmetic: Copy + Send + Sync {
    /// A constant factor that need not be a value: 1/scale, or the gain of a slow low-pass.
    type Gain: Copy + Debug + Send + Sync;
    /// A sum of products.
    type Sum: Copy + PartialOrd + Debug + Send + Sync;
    /// The value of a low-pass, which changes by less than its last place.
    type Slow: Copy + Debug + Send + Sync;
    /// The same of a running mean, which may miss changes in its last place.
    type Mean: Copy + Debug + Send + Sync;

    /// No sum yet.
    const NOTHING: Self::Sum;
    /// What is squared is kept within it, so that its square is a value.
    const LARGEST_SQUARED: Self;

    /// Whether a number of this size is a value: what a model has is refused otherwise.
    fn holds(value: f64) -> bool;
    /// Not a number, and not sorted out by comparisons either.
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
    /// `sum` + `a` × `b`.
    fn add_product(sum: Self::Sum, a: Self, b: Self) -> Self::Sum;
    /// What it has come to.
    fn end(sum: Self::Sum) -> Self;
    /// `self` × `self`.
    fn square(self) -> Self::Sum;
    /// `a` + `b`, of sums that no model bounds.
    fn plus(a: Self::Sum, b: Self::Sum) -> Self::Sum;

    /// A low-pass at `self`.
    fn at_rest(self) -> Self::Slow;
    /// Its value.
    fn now(slow: Self::Slow) -> Self;
    /// One step towards `self`: s ← s + gain·(self − s).
    fn approached_by(self, slow: &mut Self::Slow, gain: Self::Gain);

    /// A running mean at `self`.
    fn mean_at(self) -> Self::Mean;
    /// Its value.
    fn mean(mean: Self::Mean) -> Self;
    /// One step towards `self`.
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
            const LARGEST_SQUARED: $float = 1e6;

            fn holds(_: f64) -> bool {
                true
            }
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

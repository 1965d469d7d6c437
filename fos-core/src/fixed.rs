//! Fixed-point numbers, for cores without an FPU.

use core::fmt;
use core::ops::{Add, Mul, Neg, Sub};

use crate::arithmetic::Arithmetic;
use crate::check::FIXED_LIMIT;
use crate::real::Scalar;

/// Bits after the binary point of a value.
const FRACTION: u32 = 23;

/// IEEE 754 f32: bits of the fraction, and the biased exponent of 1.
const F32_FRACTION: u32 = 23;
const F32_BIAS: u32 = 127;
/// IEEE 754 f64: bits of the fraction, and the biased exponent of 1.
const F64_FRACTION: u32 = 52;
const F64_BIAS: i32 = 1023;

/// A 32-bit fixed-point number: −256 to 256 in steps of 2⁻²³, or NaN.
///
/// The range covers the values of a hub: m/s², rad/s, °C and scaled units. Arithmetic saturates and never wraps; a model
/// whose terms could saturate is rejected
/// ([`ModelError::AxisNotInFixedPoint`](crate::ModelError::AxisNotInFixedPoint)). Sums of products and low-passes have 64
/// bits. docs/MATHS.md bounds the difference from f64.
///
/// ```
/// use fos_core::{Fixed, Scalar};
///
/// let third = Fixed::of(1.0 / 3.0);
/// assert!((third.to_f64() - 1.0 / 3.0).abs() <= 0.5 * 2f64.powi(-23));
/// assert_eq!(Fixed::of(1000.0), Fixed::MAX);
/// assert!(!Fixed::of(f32::NAN).is_finite());
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fixed(i32);

/// A constant factor of any size: mantissa · 2^−shift, 1 ≤ shift ≤ 62.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Gain {
    mantissa: i32,
    shift: u8,
}

impl Fixed {
    const LARGEST: i32 = i32::MAX;

    /// The value nearest to `value`, saturated; NaN for NaN.
    // from the bits: a float multiplication would be a library call
    pub const fn from_f32(value: f32) -> Self {
        let bits = value.to_bits();
        let exponent = (bits >> F32_FRACTION) & 0xff;
        let significand = (bits & ((1 << F32_FRACTION) - 1)) | (1 << F32_FRACTION);
        if exponent == 0xff && significand != 1 << F32_FRACTION {
            return Self::NAN;
        }
        let magnitude = if exponent >= F32_BIAS + 8 {
            Self::LARGEST
        } else if exponent >= F32_BIAS {
            // at most 2³¹ − 2⁷
            (significand << (exponent - F32_BIAS)).cast_signed()
        } else if F32_BIAS - exponent > F32_FRACTION + 1 {
            0
        } else {
            let shift = F32_BIAS - exponent;
            ((significand + (1 << (shift - 1))) >> shift).cast_signed()
        };
        Self(if bits >> 31 == 1 { -magnitude } else { magnitude })
    }

    /// `n` × `gain`, |n| < 2³².
    #[inline]
    fn count_of(n: i64, gain: Gain) -> Self {
        // n · mantissa · 2^(23 − shift): the product fits 64 bits
        let product = n.wrapping_mul(i64::from(gain.mantissa));
        let shift = u32::from(gain.shift);
        match shift.checked_sub(FRACTION) {
            Some(0) => Self::limited(product),
            Some(shift) => Self::limited(product.wrapping_shr(shift - 1).wrapping_add(1) >> 1),
            None => Self::limited(product.saturating_mul(1_i64 << (FRACTION - shift))),
        }
    }

    /// A value from its steps of 2⁻²³, saturated.
    #[inline]
    const fn limited(steps: i64) -> Self {
        const LARGEST: i64 = Fixed::LARGEST as i64;
        Self(if steps > LARGEST {
            Self::LARGEST
        } else if steps < -LARGEST {
            -Self::LARGEST
        } else {
            steps as i32
        })
    }
}

/// The product with all 64 bits.
#[inline(always)]
fn product(a: i32, b: i32) -> i64 {
    // the M0+ multiplies 32 × 32 to 32 bits, and the compiler would call a 64 × 64 library routine; among Arm cores it is
    // recognised by its lack of atomics
    if cfg!(all(target_arch = "arm", not(target_has_atomic = "32"))) {
        product_of_halves(a, b)
    } else {
        i64::from(a).wrapping_mul(i64::from(b))
    }
}

/// The product from 16-bit halves, whose products fit 32 bits.
#[inline(always)]
fn product_of_halves(a: i32, b: i32) -> i64 {
    let (low_a, high_a) = (a & 0xffff, a >> 16);
    let (low_b, high_b) = (b & 0xffff, b >> 16);
    let low = i64::from(low_a.cast_unsigned().wrapping_mul(low_b.cast_unsigned()));
    let high = i64::from(high_a.wrapping_mul(high_b)) << 32;
    let one = i64::from(high_a.wrapping_mul(low_b)) << 16;
    let other = i64::from(low_a.wrapping_mul(high_b)) << 16;
    low.wrapping_add(high).wrapping_add(one).wrapping_add(other)
}

/// `product` · 2^−shift, rounded to nearest. 1 ≤ shift ≤ 62, |product| ≤ 2⁶².
#[inline(always)]
const fn rounded(product: i64, shift: u32) -> i64 {
    product.wrapping_add(1_i64.wrapping_shl(shift.wrapping_sub(1))).wrapping_shr(shift)
}

impl Gain {
    /// The gain of the same value; 0 below 2^−32, at most 2³⁰.
    // from the bits: this runs once per sample
    #[inline]
    const fn from_f32(value: f32) -> Self {
        let bits = value.to_bits();
        let exponent = (bits >> F32_FRACTION) & 0xff;
        let significand = ((bits & ((1 << F32_FRACTION) - 1)) | (1 << F32_FRACTION)) << (30 - F32_FRACTION);
        let shift = (F32_BIAS + 30).wrapping_sub(exponent);
        let (magnitude, shift) = match shift {
            1..=62 => (significand.cast_signed(), shift as u8),
            63..=256 => (0, 62),
            _ => (i32::MAX, 1),
        };
        Self { mantissa: if bits >> 31 == 1 { -magnitude } else { magnitude }, shift }
    }

    /// The gain nearest to `value`.
    const fn from_f64(value: f64) -> Self {
        let bits = value.to_bits();
        let exponent = ((bits >> F64_FRACTION) & 0x7ff) as i32 - F64_BIAS;
        // 31 bits, rounded
        let significand = (bits & ((1 << F64_FRACTION) - 1)) | (1 << F64_FRACTION);
        let mut mantissa = ((significand >> 21) + 1) >> 1;
        let mut shift = 30 - exponent;
        if mantissa >> 31 == 1 {
            (mantissa, shift) = (mantissa >> 1, shift - 1);
        }
        let (magnitude, shift) = match shift {
            ..1 => (i32::MAX, 1),
            1..=62 => (mantissa as i32, shift as u8),
            // fewer bits below 2^−32
            63..=92 => ((mantissa >> (shift - 62)) as i32, 62),
            _ => (0, 62),
        };
        Self { mantissa: if value < 0.0 { -magnitude } else { magnitude }, shift }
    }
}

/// Formatted as f64.
impl fmt::Debug for Fixed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.to_f64(), f)
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Fixed {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=f32}", self.stored());
    }
}

impl Add for Fixed {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0).max(-Self::LARGEST))
    }
}

impl Sub for Fixed {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0).max(-Self::LARGEST))
    }
}

impl Mul for Fixed {
    type Output = Self;

    // not inlined: the 64-bit product is long
    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        Self::end(Self::add_product(0, self, other))
    }
}

impl Neg for Fixed {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self(self.0.wrapping_neg())
    }
}

impl Scalar for Fixed {
    type Stored = f32;
    type Built = f64;

    const ZERO: Self = Self(0);
    const ONE: Self = Self(1 << FRACTION);
    const MAX: Self = Self(Self::LARGEST);
    /// Below all values, so that no range contains it.
    const NAN: Self = Self(i32::MIN);

    fn from_f64(value: f64) -> Self {
        if value.is_nan() {
            return Self::NAN;
        }
        // the conversion saturates
        Self::limited(libm::round(value * f64::from(1_u32 << FRACTION)) as i64)
    }
    fn from_u32(value: u32) -> Self {
        Self::limited(i64::from(value) << FRACTION)
    }
    fn to_f64(self) -> f64 {
        if self == Self::NAN { f64::NAN } else { f64::from(self.0) / f64::from(1_u32 << FRACTION) }
    }
    fn of(stored: f32) -> Self {
        Self::from_f32(stored)
    }
    fn stored(self) -> f32 {
        if self == Self::NAN {
            f32::NAN
        } else if self.0 == 0 {
            0.0
        } else {
            // times 2^−23, by the exponent
            f32::from_bits((self.0 as f32).to_bits().wrapping_sub(FRACTION << F32_FRACTION))
        }
    }
    #[inline]
    fn of_code(code: i16, unit: f32) -> Self {
        Self::count_of(i64::from(code), Gain::from_f32(unit))
    }
    #[inline]
    fn sum_of(stored: f32) -> i64 {
        const STEPS: f32 = (1_u64 << (2 * FRACTION)) as f32;
        // the conversion saturates
        (stored * STEPS) as i64
    }
    #[inline]
    fn is_finite(self) -> bool {
        self != Self::NAN
    }
    #[inline]
    fn abs(self) -> Self {
        if self == Self::NAN { self } else { Self(self.0.wrapping_abs()) }
    }
}

/// Additional fraction bits of a low-pass.
const SLOW: u32 = 30;

impl Arithmetic for Fixed {
    type Gain = Gain;
    type Sum = i64;
    type Slow = i64;
    type Mean = i64;

    const NOTHING: i64 = 0;
    const LARGEST_SUM: i64 = i64::MAX;
    // its square is the largest value
    const LARGEST_SQUARED: Self = Self(16 << FRACTION);

    const LIMIT: f32 = FIXED_LIMIT;

    #[inline(always)]
    fn is_absent(self) -> bool {
        self == Self::NAN
    }

    fn gain(value: f64) -> Gain {
        Gain::from_f64(value)
    }
    fn gain_to_f64(gain: Gain) -> f64 {
        libm::scalbn(f64::from(gain.mantissa), -i32::from(gain.shift))
    }
    // not inlined, like a product
    #[inline(never)]
    fn times(self, gain: Gain) -> Self {
        Self::limited(rounded(product(self.0, gain.mantissa), u32::from(gain.shift)))
    }
    fn count(n: u32, gain: Gain) -> Self {
        Self::count_of(i64::from(n), gain)
    }

    #[inline]
    fn begin(self) -> i64 {
        i64::from(self.0) << FRACTION
    }
    // neither overflows: a model whose sums could is rejected
    #[inline]
    fn add_value(sum: i64, value: Self) -> i64 {
        sum.wrapping_add(value.begin())
    }
    #[inline]
    fn add_product(sum: i64, a: Self, b: Self) -> i64 {
        sum.wrapping_add(product(a.0, b.0))
    }
    #[inline]
    fn end(sum: i64) -> Self {
        Self::limited(rounded(sum, FRACTION))
    }
    #[inline]
    fn square(self) -> i64 {
        product(self.0, self.0)
    }
    #[inline]
    fn plus(a: i64, b: i64) -> i64 {
        a.saturating_add(b)
    }
    #[inline(never)]
    fn share(sum: i64, gain: Gain) -> i64 {
        // two halves, for the product has 94 bits
        let mantissa = i64::from(gain.mantissa);
        let high = (sum >> 32).wrapping_mul(mantissa);
        let low = (sum & 0xffff_ffff).wrapping_mul(mantissa) >> 32;
        let product = high.wrapping_add(low);
        match u32::from(gain.shift).checked_sub(32) {
            Some(shift) => product >> shift,
            None => product << (32 - u32::from(gain.shift)),
        }
    }

    fn at_rest(self) -> i64 {
        i64::from(self.0) << SLOW
    }
    #[inline]
    fn now(slow: i64) -> Self {
        Self::limited(rounded(slow, SLOW))
    }
    #[inline(never)]
    fn approached_by(self, slow: &mut i64, gain: Gain) {
        let left = self.at_rest().wrapping_sub(*slow);
        *slow = slow.wrapping_add(Self::share(left, gain));
    }

    fn mean_at(self) -> i64 {
        self.at_rest()
    }
    fn mean(mean: i64) -> Self {
        Self::now(mean)
    }
    fn averaged_by(self, mean: &mut i64, gain: Gain) {
        self.approached_by(mean, gain);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of every magnitude and both signs, with the extremes.
    fn numbers() -> impl Iterator<Item = i32> + Clone {
        let mut state = 1_u32;
        let drawn = (0..600_u32).map(move |n| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state.cast_signed() >> (n % 31)
        });
        drawn.chain([i32::MIN, i32::MAX, -i32::MAX, 0, 1, -1, 0xffff, 0x1_0000, -0x1_0000, 0x7fff_0000])
    }

    #[test]
    fn product_of_halves_equals_the_product() {
        for a in numbers() {
            for b in numbers() {
                assert_eq!(product_of_halves(a, b), i64::from(a) * i64::from(b), "{a} {b}");
            }
        }
    }

    #[test]
    fn gain_has_31_bits_and_products_are_rounded_once() {
        for gain in [1.0, -1.0, 0.1, 5e-6, 1.0 / 0.002, 1e-9, -333.3, 1.0e6, 2f64.powi(-31), 3e-12, 0.0] {
            let held = Fixed::gain(gain);
            let value = Fixed::gain_to_f64(held);
            assert!(
                (value - gain).abs() <= (gain.abs() * 2f64.powi(-31)).max(2f64.powi(-62)),
                "{gain} {value}"
            );
            for number in numbers().filter(|&number| number != i32::MIN) {
                let found = f64::from(Fixed(number).times(held).0);
                let exact = (f64::from(number) * value).clamp(-f64::from(i32::MAX), f64::from(i32::MAX));
                assert!((found - exact).abs() <= 0.500_001, "{gain} {number}: {found} {exact}");
            }
        }
        // products saturate, and vanish below half a step
        assert_eq!(Fixed::ONE.times(Fixed::gain(1e12)), Fixed::MAX);
        assert_eq!(Fixed::ONE.times(Fixed::gain(-1e12)), -Fixed::MAX);
        assert_eq!(Fixed::MAX.times(Fixed::gain(1e-20)), Fixed::ZERO);
    }

    #[test]
    fn code_times_unit_is_exact() {
        for unit in
            [0.001_197_f32, 0.000_305, 1.0 / 256.0, 1.0, 1e-6, 0.0, -0.01, 1e-38, f32::MIN_POSITIVE / 4.0]
        {
            for code in [0, 1, -1, 77, 8192, i16::MAX, i16::MIN] {
                let exact = (f64::from(code) * f64::from(unit)).clamp(-256.0, 256.0);
                let found = Fixed::of_code(code, unit).to_f64();
                assert!((found - exact).abs() <= 2f64.powi(-23), "{unit} {code}: {found} {exact}");
            }
        }
        assert_eq!((Fixed::of_code(1, 1e30), Fixed::of_code(-1, f32::MAX)), (Fixed::MAX, -Fixed::MAX));
    }

    #[test]
    fn count_agrees_with_f64() {
        for gain in [5e-6, 0.005, 1.0, 2f64.powi(-23), 2f64.powi(-22), 2f64.powi(-24), 300.0] {
            let held = Fixed::gain(gain);
            for n in [0, 1, 2, 3, 1000, 720_000, u32::MAX] {
                let exact = (f64::from(n) * Fixed::gain_to_f64(held)).min(256.0);
                let found = Fixed::count(n, held).to_f64();
                assert!((found - exact).abs() <= 2f64.powi(-23), "{gain} {n}: {found} {exact}");
            }
        }
    }

    #[test]
    fn slow_low_pass_has_no_dead_band() {
        let gain = 5e-6;
        let (mut slow, mut exact) = (Fixed::ONE.at_rest(), 1.0_f64);
        let (target, held) = (Fixed::from_f64(1.004), Fixed::gain(gain));
        for _ in 0..2_000_000 {
            target.approached_by(&mut slow, held);
            exact += gain * (target.to_f64() - exact);
        }
        assert!(
            (Fixed::now(slow).to_f64() - exact).abs() <= 2f64.powi(-23),
            "{:?} {exact}",
            Fixed::now(slow)
        );
        // from one end of the range to the other, in one step and slowly
        for (from, to) in [(Fixed::MAX, -Fixed::MAX), (-Fixed::MAX, Fixed::MAX)] {
            let mut slow = from.at_rest();
            to.approached_by(&mut slow, Fixed::gain(1.0));
            assert_eq!(Fixed::now(slow), to);
            let mut slow = from.at_rest();
            to.approached_by(&mut slow, Fixed::gain(0.25));
            let quarter = from.to_f64() + 0.25 * (to.to_f64() - from.to_f64());
            assert!((Fixed::now(slow).to_f64() - quarter).abs() <= 2f64.powi(-23));
        }
    }

    #[test]
    fn unbounded_sums_saturate() {
        let square = Fixed::MAX.square();
        let many = (0..100).fold(Fixed::NOTHING, |sum, _| Fixed::plus(sum, square));
        assert_eq!(many, i64::MAX);
        assert_eq!(Fixed::sum_of(f32::MAX), i64::MAX);
        assert_eq!(Fixed::end(Fixed::sum_of(1.5)), Fixed::from_f64(1.5));
        assert_eq!(Fixed::MAX + Fixed::MAX, Fixed::MAX);
        assert_eq!(-Fixed::MAX - Fixed::MAX, -Fixed::MAX);
        assert_eq!(Fixed::MAX * Fixed::MAX, Fixed::MAX);
    }
}

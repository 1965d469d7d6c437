//! e^x − 1 with little flash.
//!
//! libm's expm1, exp and sincos take 8 KiB of a Cortex-M4F's flash, most of it for arguments that no model has.
//! This implementation halves the argument, sums a short series and doubles back. It agrees with libm to 10⁻¹⁴, in f32 to
//! 3·10⁻⁷.

use super::Real;

/// Largest argument of the series: the truncated terms have a relative size of 10⁻¹⁷.
const SMALL: f64 = 1.0 / 32.0;

/// Argument below which e^x is 0 in f64.
const NOTHING: f64 = -745.0;

/// e^x − 1 for x ≤ 0, without loss of digits near 0: e^2a − 1 = (e^a − 1)·(e^a + 1). −1 for a NaN.
pub(crate) fn exp_m1<R: Real>(x: R) -> R {
    let real = R::from_f64;
    // −∞ for all purposes, and NaN
    if x < real(NOTHING) || !x.is_finite() {
        return -R::ONE;
    }
    let (mut a, mut doublings) = (x, 0);
    while a < real(-SMALL) {
        a = a * real(0.5);
        doublings += 1;
    }
    let mut series = R::ONE;
    for divisor in (2..=8).rev() {
        series = R::ONE + a * (R::ONE / R::from_u32(divisor)) * series;
    }
    let mut result = a * series;
    for _ in 0..doublings {
        result = result * (result + real(2.0));
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_libm() {
        let mut worst: f64 = 0.0;
        for n in 0..200_000 {
            let x = -(10f64.powf(-12.0 + 15.0 * f64::from(n) / 200_000.0));
            let truth = libm::expm1(x);
            worst = worst.max((exp_m1(x) / truth - 1.0).abs());
        }
        assert!(worst < 1e-14, "{worst:e}");
        assert_eq!((exp_m1(0.0), exp_m1(f64::NEG_INFINITY), exp_m1(f64::NAN)), (0.0, -1.0, -1.0));
    }

    #[test]
    fn f32_agrees_with_libm() {
        let mut worst: f64 = 0.0;
        for n in 0..200_000 {
            let x = -(10f64.powf(-12.0 + 14.0 * f64::from(n) / 200_000.0)) as f32;
            worst = worst.max((f64::from(exp_m1(x)) / libm::expm1(f64::from(x)) - 1.0).abs());
        }
        assert!(worst < 3e-7, "{worst:e}");
        assert_eq!((exp_m1(0.0_f32), exp_m1(f32::NEG_INFINITY), exp_m1(f32::NAN)), (0.0, -1.0, -1.0));
    }
}

//! The functions that a model is built with, once: small where a device pays for every byte of flash.
//!
//! libm's expm1, exp and sincos take 8 KiB of a Cortex-M4F's flash, most of it for arguments that no model has. These
//! take their arguments apart by halving, sum a short series and double back; they agree with libm's to 10⁻¹⁴, in f32
//! to 3·10⁻⁷.

use crate::Real;

/// Below this the series below are cut off after terms of relative size 10⁻¹⁷.
const SMALL: f64 = 1.0 / 32.0;

/// From −745 on e^x is 0 in f64.
const NOTHING: f64 = -745.0;

/// e^x − 1 for x ≤ 0, without loss of digits near 0: e^2a − 1 = (e^a − 1)·(e^a + 1). −1 for a NaN.
pub(crate) fn exp_m1<R: Real>(x: R) -> R {
    let real = R::from_f64;
    // what is as good as −∞, and a NaN
    if x < real(NOTHING) || !x.is_finite() {
        return -R::ONE;
    }
    let (mut a, mut doublings) = (x, 0);
    while a < real(-SMALL) {
        a = a * real(0.5);
        doublings += 1;
    }
    let mut series = R::ONE;
    for inverse in [1.0 / 8.0, 1.0 / 7.0, 1.0 / 6.0, 1.0 / 5.0, 1.0 / 4.0, 1.0 / 3.0, 1.0 / 2.0] {
        series = R::ONE + a * real(inverse) * series;
    }
    let mut result = a * series;
    for _ in 0..doublings {
        result = result * (result + real(2.0));
    }
    result
}

/// Sine and cosine of a turn of so many cycles, 0 or more: sin 2a = 2·sin a·cos a, cos 2a − 1 = −2·sin² a.
#[cfg(feature = "transforms")]
pub(crate) fn sin_cos_of_cycles(cycles: f64) -> (f64, f64) {
    // whole turns do nothing
    let part = cycles - f64::from(cycles as u32);
    // beyond 2³² turns a tick there is nothing to tell; nor of a NaN
    let (mut a, mut doublings) = (if part < 1.0 { part * core::f64::consts::TAU } else { 0.0 }, 0);
    while a > SMALL {
        a *= 0.5;
        doublings += 1;
    }
    let (mut sin, half) = (sin_of_small(a), sin_of_small(0.5 * a));
    let mut cos_m1 = -2.0 * half * half;
    for _ in 0..doublings {
        (sin, cos_m1) = (2.0 * sin * (1.0 + cos_m1), -2.0 * sin * sin);
    }
    (sin, 1.0 + cos_m1)
}

/// Sine of an angle of at most [`SMALL`].
#[cfg(feature = "transforms")]
fn sin_of_small(angle: f64) -> f64 {
    let square = angle * angle;
    let mut series = 1.0;
    for inverse in [1.0 / 72.0, 1.0 / 42.0, 1.0 / 20.0, 1.0 / 6.0] {
        series = 1.0 - square * inverse * series;
    }
    angle * series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_agrees_with_libm() {
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
    fn the_exponential_of_32_bits_is_as_good_as_stated() {
        let mut worst: f64 = 0.0;
        for n in 0..200_000 {
            let x = -(10f64.powf(-12.0 + 14.0 * f64::from(n) / 200_000.0)) as f32;
            worst = worst.max((f64::from(exp_m1(x)) / libm::expm1(f64::from(x)) - 1.0).abs());
        }
        assert!(worst < 3e-7, "{worst:e}");
        assert_eq!((exp_m1(0.0_f32), exp_m1(f32::NEG_INFINITY), exp_m1(f32::NAN)), (0.0, -1.0, -1.0));
    }

    #[cfg(feature = "transforms")]
    #[test]
    fn sine_and_cosine_agree_with_libm() {
        let mut worst: f64 = 0.0;
        for n in 0..200_000 {
            let cycles = f64::from(n) * 7.7e-6;
            let (sin, cos) = sin_cos_of_cycles(cycles);
            let (true_sin, true_cos) = libm::sincos(core::f64::consts::TAU * cycles.fract());
            worst = worst.max((sin - true_sin).abs()).max((cos - true_cos).abs());
        }
        assert!(worst < 1e-14, "{worst:e}");
        let (sin, cos) = sin_cos_of_cycles(1e300);
        assert!(sin.abs() <= 1.0 && cos.abs() <= 1.0);
    }
}

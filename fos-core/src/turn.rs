//! Sine and cosine of a turn, small where a device pays for every byte of flash: by halving, a short series and doubling
//! back, as e^x − 1 is (exponential.rs); they agree with libm's to 10⁻¹⁴.

/// Below this the series is cut off after terms of relative size 10⁻¹⁷.
const SMALL: f64 = 1.0 / 32.0;

/// Sine and cosine of a turn of so many cycles, 0 or more: sin 2a = 2·sin a·cos a, cos 2a − 1 = −2·sin² a.
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

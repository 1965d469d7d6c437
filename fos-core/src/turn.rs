//! Sine and cosine with little flash. Method: halving, a short series and doubling back, as for e^x − 1
//! (exponential.rs). They agree with libm to 10⁻¹⁴.

/// Largest argument of the series, in radians: the truncated terms have a relative size of 10⁻¹⁷.
const SMALL: f64 = 1.0 / 32.0;

/// Sine and cosine of an angle in cycles, 0 or more, by doubling: sin 2a = 2·sin a·cos a, cos 2a − 1 = −2·sin² a.
pub(crate) fn sin_cos_of_cycles(cycles: f64) -> (f64, f64) {
    // whole cycles have no effect
    let part = cycles - f64::from(cycles as u32);
    // beyond 2³² cycles, and for NaN, the angle is set to 0
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
    fn agrees_with_libm() {
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

//! The square root, for occasional queries; no step needs one.
//!
//! Uses libm, or with the feature `micromath` the approximation of that crate, the same on host and device
//! (docs/decisions/micromath.md).

/// √x. NaN for negative numbers and NaN; 0 below the smallest normal number.
///
/// micromath computes with the bits of x as a positive normal number, so every other number is handled here.
pub(crate) fn sqrt(x: f32) -> f32 {
    if x.is_nan() || x < 0.0 {
        f32::NAN
    } else if x < f32::MIN_POSITIVE {
        0.0
    } else if x == f32::INFINITY {
        x
    } else {
        normal(x)
    }
}

#[cfg(not(feature = "micromath"))]
fn normal(x: f32) -> f32 {
    libm::sqrtf(x)
}

#[cfg(feature = "micromath")]
fn normal(x: f32) -> f32 {
    micromath::F32Ext::sqrt(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest relative error: half a unit in the last place for a correctly rounded square root; for micromath the result
    /// of the sweep, rounded up.
    const BOUND: f64 = if cfg!(feature = "micromath") { 0.0607 } else { 6.0e-8 };

    #[test]
    fn error_is_within_bound_over_twelve_decades() {
        const STEPS: u32 = 1_000_000;
        let (mut worst, mut at) = (0.0, 0.0);
        for step in 0..=STEPS {
            // 10⁻⁶ … 10⁶, evenly in the logarithm: 83,000 a decade
            let x = libm::pow(10.0, 12.0 * f64::from(step) / f64::from(STEPS) - 6.0) as f32;
            let exact = libm::sqrt(f64::from(x));
            let error = libm::fabs(f64::from(sqrt(x)) - exact) / exact;
            assert!(error <= BOUND, "√{x} is off by {error:e}");
            if error > worst {
                (worst, at) = (error, x);
            }
        }
        std::println!("largest relative error of the square root: {worst:.3e}, at {at:e}; stated {BOUND:e}");
    }

    #[test]
    fn handles_special_values() {
        for x in [-1.0, -f32::MIN_POSITIVE, f32::NEG_INFINITY, f32::NAN] {
            assert!(sqrt(x).is_nan(), "{x}");
        }
        for x in [0.0, -0.0, 1e-40] {
            assert_eq!(sqrt(x), 0.0, "{x}");
        }
        assert_eq!(sqrt(f32::INFINITY), f32::INFINITY);
        let smallest = f64::from(sqrt(f32::MIN_POSITIVE));
        assert!(
            libm::fabs(smallest / libm::sqrt(f64::from(f32::MIN_POSITIVE)) - 1.0) <= BOUND,
            "{smallest:e}"
        );
    }

    /// Shows why the constants of a model come from libm, independent of the features (docs/decisions/micromath.md).
    #[cfg(feature = "micromath")]
    #[test]
    fn micromath_is_too_coarse_for_model_constants() {
        use micromath::F32Ext;

        let mut worst = 0.0_f64;
        for step in 0..=5000 {
            let tau_s = libm::pow(10.0, f64::from(step) / 1000.0 - 2.0); // 0.01 … 1000 s
            let exact = -libm::expm1(-0.005 / tau_s);
            let gain = 1.0 - f64::from(F32Ext::exp((-0.005 / tau_s) as f32));
            worst = worst.max(libm::fabs(gain / exact - 1.0));
        }
        std::println!("1 − e^(−T/τ) at 200 Hz, τ to 1000 s: off by up to {:.3} %", 100.0 * worst);
        assert!(worst > 1e-4, "{worst:e}");

        // a spectral line is a phasor rotated every sample: if the rotation is not of length 1, it grows or decays
        let (mut low, mut high) = (1.0_f64, 1.0_f64);
        for step in 1..1000 {
            let angle = core::f32::consts::PI * step as f32 / 1000.0;
            let (sin, cos) = (f64::from(F32Ext::sin(angle)), f64::from(F32Ext::cos(angle)));
            let after_a_second = libm::pow(libm::sqrt(sin * sin + cos * cos), 200.0);
            (low, high) = (low.min(after_a_second), high.max(after_a_second));
        }
        std::println!("amplitude of a line after a second at 200 Hz: {low:.3} to {high:.3} of what it was");
        assert!(low < 0.9 || high > 1.1, "{low} {high}");
    }
}

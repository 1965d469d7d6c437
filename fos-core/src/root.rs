//! The square root, for what is asked now and then; no step needs one.
//!
//! libm's, or with the feature `micromath` that crate's: an approximation, and the same one on host and device
//! (docs/decisions/micromath.md).

/// √x. NaN for what has none; 0 below the smallest normal number.
///
/// micromath works on the bits of a positive normal number and takes anything else for one, so nothing else gets
/// there.
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

    /// Largest relative error: of a correctly rounded square root half a unit in the last place, of micromath's
    /// what the sweep finds, rounded up.
    const BOUND: f64 = if cfg!(feature = "micromath") { 0.0607 } else { 6.0e-8 };

    #[test]
    fn is_as_good_as_stated_over_twelve_decades() {
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
    fn what_has_no_root_has_none() {
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

    /// Why what a model is built from is libm's, whatever the features (docs/decisions/micromath.md).
    #[cfg(feature = "micromath")]
    #[test]
    fn micromath_would_spoil_a_line_and_dent_a_time_constant() {
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

        // a line is a phasor that is rotated every sample: one that is not of length 1 grows or dies
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

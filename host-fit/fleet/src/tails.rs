//! Tails and quantiles of the distributions of small samples: Student's t, χ², F.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, StudentsT};

/// Probability outside of an interval on each side: intervals are 90 %.
pub(crate) const OUTSIDE: f64 = 0.05;

/// Halvings of a bracket; more than the bits of a double.
const HALVINGS: usize = 60;

/// Maximum doublings of a bracket until it contains the root.
const DOUBLINGS: usize = 200;

/// Probability that |t| is larger than `value`, for any real number of degrees of freedom; 1 if there are none.
pub(crate) fn t_tail(freedom: f64, value: f64) -> f64 {
    if value.is_nan() {
        return 1.0;
    }
    let distribution = StudentsT::new(0.0, 1.0, freedom).ok();
    let tail =
        distribution.map_or(1.0, |distribution| 2.0 * distribution.sf(value.abs().min(f64::MAX.sqrt())));
    if tail.is_finite() { tail.clamp(0.0, 1.0) } else { 1.0 }
}

/// The value that |t| exceeds with probability `outside`.
pub(crate) fn t_quantile(freedom: f64, outside: f64) -> f64 {
    falls_to(outside, |value| t_tail(freedom, value))
}

/// Half width of a 90 % interval in standard errors. Uses at least one degree of freedom: with fewer the interval is uselessly wide.
pub(crate) fn half_interval(freedom: f64) -> f64 {
    t_quantile(freedom.max(1.0), 2.0 * OUTSIDE)
}

/// The value that χ² exceeds with probability `outside`.
pub(crate) fn chi_squared_quantile(freedom: f64, outside: f64) -> f64 {
    ChiSquared::new(freedom).map_or(0.0, |distribution| falls_to(outside, |value| distribution.sf(value)))
}

/// The value that F exceeds with probability `outside`.
pub(crate) fn f_quantile(freedoms: [f64; 2], outside: f64) -> f64 {
    falls_to(outside, |value| f_tail(freedoms, value))
}

/// Probability that F is larger than `value`.
pub(crate) fn f_tail([above, below]: [f64; 2], value: f64) -> f64 {
    if value.is_nan() {
        return 1.0;
    }
    // An infinite ratio, from a lot of equal devices, would give NaN.
    let value = value.min(f64::MAX.sqrt());
    FisherSnedecor::new(above, below).map_or(1.0, |distribution| distribution.sf(value))
}

/// Smallest x ≥ 0 at which a non-increasing function falls to `level`; 0 if it is not above it at 0.
pub(crate) fn falls_to(level: f64, of: impl Fn(f64) -> f64) -> f64 {
    if of(0.0) <= level {
        return 0.0;
    }
    let (mut above, mut below) = (0.0, 1.0);
    for _ in 0..DOUBLINGS {
        if of(below) <= level {
            break;
        }
        (above, below) = (below, 2.0 * below);
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (above + below);
        *(if of(middle) > level { &mut above } else { &mut below }) = middle;
        if below - above <= 1e-12 * below {
            break;
        }
    }
    above
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_match_printed_tables() {
        let near =
            |found: f64, printed: f64| assert!((found / printed - 1.0).abs() < 1e-4, "{found} {printed}");
        near(t_quantile(1.0, 0.1), 6.3138);
        near(t_quantile(3.0, 0.1), 2.3534);
        near(t_quantile(1e6, 0.1), 1.64485);
        near(chi_squared_quantile(2.0, 0.05), 5.9915);
        near(chi_squared_quantile(2.0, 0.95), 0.10259);
        near(f_quantile([2.0, 5.0], 0.05), 5.7861);
        near(t_tail(4.0, 2.7764), 0.05);
    }

    #[test]
    fn tail_is_one_without_degrees_of_freedom() {
        assert_eq!((t_tail(0.0, 1e9), t_tail(f64::NAN, 1e9), t_tail(3.0, f64::NAN)), (1.0, 1.0, 1.0));
        assert!(t_tail(0.01, 1e6) > 0.8);
        assert!(half_interval(0.0).is_finite());
    }
}

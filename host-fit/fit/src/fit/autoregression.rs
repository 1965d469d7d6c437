//! Linear autoregressions r(n) = Σ_k a_k r(n−k) + e(n) by the classical methods, all of the same shape.
//!
//! | method | minimises | file |
//! |---|---|---|
//! | Yule-Walker | the forward error, the series taken as zero beyond its ends (eq. 9) | `yule_walker` |
//! | covariance | the forward error, over rows whose lags were measured | `covariance` |
//! | modified covariance | forward and backward error together, over the same rows | `covariance` |
//! | Burg | forward and backward error, one reflection coefficient after the other (eq. 12, 13) | `burg` |
//!
//! Signs: `coefficients` are those of the prediction, as everywhere in this crate; `reflection` are the γ_k of the paper,
//! whose polynomial is 1 − Σ a_k z⁻ᵏ: γ_p = −a_p.
//!
//! Nothing is centred: the caller takes the mean off. No sum of products crosses the end of a stretch.

use std::fmt;

use nalgebra::ComplexField;
use thiserror::Error;

use super::{burg, covariance, yule_walker};
use crate::candidates::MAX_LAG;

/// How an autoregression is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// From the biased autocorrelation, by Levinson-Durbin.
    YuleWalker,
    /// Least squares, forward.
    Covariance,
    /// Least squares, forward and backward.
    ModifiedCovariance,
    /// Lattice.
    Burg,
}

impl fmt::Display for Method {
    /// As on the command line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::YuleWalker => "yule-walker",
            Self::Covariance => "covariance",
            Self::ModifiedCovariance => "modified-covariance",
            Self::Burg => "burg",
        })
    }
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::YuleWalker, Self::Covariance, Self::ModifiedCovariance, Self::Burg];
}

/// An estimated autoregression of order p.
#[derive(Debug, Clone, PartialEq)]
pub struct Autoregression<T = f64> {
    /// a_1 … a_p.
    pub coefficients: Vec<T>,
    /// γ_1 … γ_p; empty for the two least-squares methods, which have none.
    pub reflection: Vec<T>,
    /// Estimated variance of e: by (9e) for Yule-Walker and Burg, the mean squared residual for the others. Unit of r².
    pub innovation_variance: f64,
}

/// Why there is no estimate.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum AutoregressionError {
    /// An order of nothing, or further back than a model may reach.
    #[error("order {0} is outside 1 to {MAX_LAG}")]
    Order(usize),
    /// Too little to fit to.
    #[error(
        "{rows} rows have {order} samples before them; more than {order} are needed for an order of {order}"
    )]
    TooShort {
        /// Rows whose lags were all measured.
        rows: usize,
        /// The order.
        order: usize,
    },
    /// NaN or infinite samples.
    #[error("a sample is not finite: split the series there")]
    NotFinite,
    /// Coefficients would be rounding error.
    #[error(
        "{method} at order {order}: rounding alone would change the coefficients by more than {TRUSTED:e} of their size; take the mean off, lower the order, or use another method"
    )]
    IllConditioned {
        /// The method.
        method: Method,
        /// The order at which it shows.
        order: usize,
    },
}

/// The largest relative error of the coefficients by rounding that is not refused.
pub const TRUSTED: f64 = 1e-6;

/// Estimates an autoregression of the gap-free `stretches` of one series.
///
/// ```
/// use fos_fit::fit::autoregression::{Method, estimate};
///
/// let halving: Vec<f64> = (0..40).map(|n| 0.5_f64.powi(n)).collect();
/// let fit = estimate(Method::Covariance, &[&halving], 1)?;
/// assert!((fit.coefficients[0] - 0.5).abs() < 1e-12);
/// # Ok::<(), fos_fit::fit::autoregression::AutoregressionError>(())
/// ```
///
/// # Errors
/// An order of 0 or too large, too few samples, a sample that is not finite, or an ill-conditioned problem.
pub fn estimate(
    method: Method,
    stretches: &[&[f64]],
    order: usize,
) -> Result<Autoregression, AutoregressionError> {
    check(stretches, order)?;
    match method {
        Method::YuleWalker => yule_walker::estimate(stretches, order),
        Method::Covariance => covariance::estimate(stretches, order),
        Method::ModifiedCovariance => covariance::estimate_modified(stretches, order),
        Method::Burg => burg::estimate(stretches, order),
    }
}

fn check(stretches: &[&[f64]], order: usize) -> Result<(), AutoregressionError> {
    if !(1..=usize::from(MAX_LAG)).contains(&order) {
        return Err(AutoregressionError::Order(order));
    }
    let rows = stretches.iter().map(|stretch| stretch.len().saturating_sub(order)).sum();
    if rows <= order {
        return Err(AutoregressionError::TooShort { rows, order });
    }
    if !stretches.iter().copied().flatten().all(|value| value.is_finite()) {
        return Err(AutoregressionError::NotFinite);
    }
    Ok(())
}

/// One step up: the polynomial of order k from that of order k − 1 and γ_k (eq. 9c, 9d), in the signs of the prediction.
pub(super) fn step_up<T: ComplexField>(coefficients: &mut Vec<T>, reflection: T) {
    let lower = coefficients.clone();
    for (a, mirrored) in coefficients.iter_mut().zip(lower.into_iter().rev()) {
        *a += reflection.clone() * mirrored.conjugate();
    }
    coefficients.push(-reflection);
}

/// Σ a(n)·b(n)*, in partial sums of their own so that no addition waits for the one before.
pub(super) fn inner_product<T: ComplexField>(a: &[T], b: &[T]) -> T {
    const LANES: usize = 8;
    let mut sums: [T; LANES] = core::array::from_fn(|_| T::zero());
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a.remainder().iter().zip(b.remainder()).map(|(x, y)| x.clone() * y.clone().conjugate());
    let rest = rest.fold(T::zero(), |sum, product| sum + product);
    for (x, y) in a.zip(b) {
        for lane in 0..LANES {
            sums[lane] += x[lane].clone() * y[lane].clone().conjugate();
        }
    }
    sums.into_iter().fold(rest, |sum, lane| sum + lane)
}

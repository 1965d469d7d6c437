//! Linear autoregressions r(n) = Σ_k a_k r(n−k) + e(n) by the classical methods, with a common result type.
//!
//! | method | minimises | file |
//! |---|---|---|
//! | Yule-Walker | the forward error, the series taken as zero beyond its ends (eq. 9) | `yule_walker` |
//! | covariance | the forward error, over rows whose lags were measured | `covariance` |
//! | modified covariance | forward and backward error together, over the same rows | `covariance` |
//! | Burg | forward and backward error, one reflection coefficient after the other (eq. 12, 13) | `burg` |
//!
//! Signs: `coefficients` are those of the prediction, as everywhere in this crate; `reflection` are the γ_k of the
//! paper, whose polynomial is 1 − Σ a_k z⁻ᵏ: γ_p = −a_p.
//!
//! Nothing is centred: the caller subtracts the mean. No sum of products crosses the end of a stretch.

pub(super) mod burg;
mod covariance;
mod order;
pub(super) mod polynomial;
mod result;
pub(super) mod yule_walker;

pub use order::{Criterion, best_order};
pub use result::{Autoregression, AutoregressionError, Method, TRUSTED};

use crate::candidates::MAX_LAG;

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

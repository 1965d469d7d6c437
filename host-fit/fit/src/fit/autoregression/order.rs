//! Order of an autoregression by an information criterion.

use super::result::{AutoregressionError, Method};

/// Penalty of an order: n·ln σ̂² + penalty · p, with σ̂² the innovation variance of order p over n samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// 2 per coefficient (Akaike 1974): for prediction; the probability of too high an order does not decrease with n.
    Aic,
    /// ln n per coefficient (Schwarz 1978): consistent; finds the true order, if there is one, as n grows.
    Bic,
}

impl Criterion {
    fn of(self, innovation_variance: f64, order: usize, samples: usize) -> f64 {
        let n = samples as f64;
        let price = match self {
            Self::Aic => 2.0,
            Self::Bic => n.ln(),
        };
        n * innovation_variance.ln() + price * order as f64
    }
}

/// Returns the order from 1 to `max_order` that minimises `criterion`, and its value at every order from 1 on.
///
/// ```
/// use fos_fit::fit::autoregression::{Criterion, Method, best_order};
///
/// // r(n) = 1.5 r(n − 1) − 0.7 r(n − 2) + e(n), e uniform
/// let mut state = 1_u32;
/// let mut noise = || { state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223); f64::from(state >> 8) / 16_777_216.0 - 0.5 };
/// let mut r = vec![0.0; 4000];
/// for n in 2..r.len() {
///     r[n] = 1.5 * r[n - 1] - 0.7 * r[n - 2] + noise();
/// }
/// let (order, values) = best_order(Method::Burg, &[&r], 10, Criterion::Bic)?;
/// assert_eq!((order, values.len()), (2, 10));
/// # Ok::<(), fos_fit::fit::autoregression::AutoregressionError>(())
/// ```
///
/// # Errors
/// Errors of [`estimate`](super::estimate), for any of the orders.
pub fn best_order(
    method: Method,
    stretches: &[&[f64]],
    max_order: usize,
    criterion: Criterion,
) -> Result<(usize, Vec<f64>), AutoregressionError> {
    let samples = crate::signal::sample_count(stretches);
    // rejects an order of 0
    super::estimate(method, stretches, max_order)?;
    let criterion_at = |order| {
        let variance = super::estimate(method, stretches, order)?.innovation_variance;
        Ok(criterion.of(variance, order, samples))
    };
    let values = (1..=max_order).map(criterion_at).collect::<Result<Vec<f64>, AutoregressionError>>()?;
    let best = (0..values.len()).min_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0);
    Ok((best + 1, values))
}

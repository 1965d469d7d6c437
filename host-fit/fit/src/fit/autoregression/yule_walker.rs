//! The Yule-Walker equations by the Levinson-Durbin recursion.
//!
//! Paper eq. 9a–9f; Levinson, J. Math. Phys. 25 (1947) 261. With R(k) = Σ r(n) r(n−k) / N, biased so that the matrix is
//! positive definite,
//!
//! ```text
//!   E_0 = R(0)                                                (9a)
//!   γ_k = −(R(k) − Σ_{i<k} a_i R(k−i)) / E_{k−1}              (9b)
//!   a_k = −γ_k,    a_i ← a_i + γ_k a_{k−i}                    (9c, 9d)
//!   E_k = (1 − γ_k²) E_{k−1}                                  (9e)
//! ```

use nalgebra::DMatrix;

use super::polynomial::{inner_product, step_up};
use super::result::{Autoregression, AutoregressionError, Method, TRUSTED};

/// Rounding error of R(k) relative to R(0): sums in eight parts of some 10⁵ products each, and the error of the
/// recursion.
const ROUNDING: f64 = 1e-14;

pub(in crate::fit) fn estimate(
    stretches: &[&[f64]],
    order: usize,
) -> Result<Autoregression, AutoregressionError> {
    let samples: usize = stretches.iter().map(|stretch| stretch.len()).sum();
    let lagged = |lag: usize| {
        let stretch_sum = |stretch: &&[f64]| match stretch.get(lag..) {
            Some(late) => inner_product(late, &stretch[..late.len()]),
            None => 0.0,
        };
        stretches.iter().map(stretch_sum).sum::<f64>() / samples as f64
    };
    let autocorrelation: Vec<f64> = (0..=order).map(lagged).collect();
    levinson_durbin(&autocorrelation)
}

/// Returns the autoregression with autocorrelation R(0) … R(p).
pub(in crate::fit) fn levinson_durbin(
    autocorrelation: &[f64],
) -> Result<Autoregression, AutoregressionError> {
    let order = autocorrelation.len() - 1;
    let refused = |order| AutoregressionError::IllConditioned { method: Method::YuleWalker, order };
    let mut innovation_variance = autocorrelation[0];
    if innovation_variance <= 0.0 || !innovation_variance.is_finite() {
        return Err(refused(0));
    }
    // the error of the coefficients is the condition number times the error of R (Cybenko, SIAM J. Sci. Stat. Comput. 1
    // (1980) 303)
    let matrix = DMatrix::from_fn(order, order, |i, j| autocorrelation[i.abs_diff(j)]);
    let values = matrix.singular_values();
    if values.max() * ROUNDING > TRUSTED * values.min() {
        return Err(refused(order));
    }
    let mut coefficients: Vec<f64> = Vec::with_capacity(order);
    let mut reflection = Vec::with_capacity(order);
    for k in 1..=order {
        let predicted: f64 =
            coefficients.iter().zip(autocorrelation[1..k].iter().rev()).map(|(a, r)| a * r).sum();
        let gamma = -(autocorrelation[k] - predicted) / innovation_variance;
        step_up(&mut coefficients, gamma);
        reflection.push(gamma);
        innovation_variance *= 1.0 - gamma * gamma;
        if innovation_variance <= 0.0 {
            return Err(refused(k));
        }
    }
    Ok(Autoregression { coefficients, reflection, innovation_variance })
}

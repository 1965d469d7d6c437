//! Burg's method: a lattice of reflection coefficients, determined one after the other.
//!
//! Paper eq. 12, 13; Burg 1967. From f_0 = b_0 = r, over all n whose lags were measured,
//!
//! ```text
//!   γ_k = −2 Σ f_{k−1}(n) b_{k−1}(n−1) / Σ (f_{k−1}²(n) + b_{k−1}²(n−1))    (13)
//!   f_k(n) = f_{k−1}(n) + γ_k b_{k−1}(n−1)                                  (12a)
//!   b_k(n) = b_{k−1}(n−1) + γ_k f_{k−1}(n)                                  (12b)
//! ```
//!
//! and the coefficients by (9d).

use super::polynomial::{inner_product, step_up};
use super::result::{Autoregression, AutoregressionError, Method, TRUSTED};

pub(in crate::fit) fn estimate(
    stretches: &[&[f64]],
    order: usize,
) -> Result<Autoregression, AutoregressionError> {
    let refused = |order| AutoregressionError::IllConditioned { method: Method::Burg, order };
    let power = |series: &[f64]| inner_product(series, series);
    let samples: usize = stretches.iter().map(|stretch| stretch.len()).sum();
    let mut innovation_variance =
        stretches.iter().map(|stretch| power(stretch)).sum::<f64>() / samples as f64;
    let variance = innovation_variance;
    let mut lattices: Vec<Lattice> = stretches.iter().map(|stretch| Lattice::new(stretch)).collect();
    let (mut coefficients, mut reflection) = (Vec::with_capacity(order), Vec::with_capacity(order));
    for k in 1..=order {
        // f and b are differences of numbers of the size of r, so their relative rounding error grows as they shrink
        let rounding = f64::EPSILON * (variance / innovation_variance).sqrt();
        if rounding > TRUSTED || rounding.is_nan() {
            return Err(refused(k));
        }
        let (mut products, mut squares) = (0.0, 0.0);
        for lattice in &lattices {
            let (forward, backward) = lattice.errors(k);
            products += inner_product(forward, backward);
            squares += power(forward) + power(backward);
        }
        let gamma = products * (-2.0 / squares);
        lattices.iter_mut().for_each(|lattice| lattice.advance(k, gamma));
        step_up(&mut coefficients, gamma);
        innovation_variance *= 1.0 - gamma * gamma;
        reflection.push(gamma);
    }
    Ok(Autoregression { coefficients, reflection, innovation_variance })
}

/// Forward and backward prediction errors of one stretch.
struct Lattice {
    forward: Vec<f64>,
    /// b(n), stored at index n minus the number of stages, so that it aligns with f(n + 1).
    backward: Vec<f64>,
}

impl Lattice {
    fn new(stretch: &[f64]) -> Self {
        Self { forward: stretch.to_vec(), backward: stretch.to_vec() }
    }

    /// Returns f_{k−1}(n) and b_{k−1}(n−1), n from k on.
    fn errors(&self, k: usize) -> (&[f64], &[f64]) {
        let left = self.forward.len().saturating_sub(k);
        (&self.forward[self.forward.len() - left..], &self.backward[..left])
    }

    /// Advances by stage k, in place.
    fn advance(&mut self, k: usize, gamma: f64) {
        let left = self.forward.len().saturating_sub(k);
        let first = self.forward.len() - left;
        for (f, b) in self.forward[first..].iter_mut().zip(&mut self.backward[..left]) {
            let forward = *f;
            *f += gamma * *b;
            *b += gamma * forward;
        }
    }
}

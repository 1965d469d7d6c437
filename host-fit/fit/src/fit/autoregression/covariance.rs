//! The covariance method and the modified covariance method: least squares over the rows whose lags were measured.
//!
//! ```text
//!   covariance:            least Σ_n (r(n) − Σ a_k r(n−k))²
//!   modified covariance:   least Σ_n (r(n) − Σ a_k r(n−k))² + (r(n−p) − Σ a_k r(n−p+k))²
//! ```
//!
//! The normal equations are usually solved by Cholesky's factorisation (Marple, Digital Spectral Analysis, 1987, ch.
//! 8). Here its factor R is computed from the data by orthogonal reflections: XᵀX = RᵀR is never formed, which doubles
//! the number of accurate digits.

use std::ops::Range;

use fos_core::y;

use super::result::{Autoregression, AutoregressionError, Method, TRUSTED};
use crate::fit::least_squares::{self, System};
use crate::moments::Product;

pub(super) fn estimate(stretches: &[&[f64]], order: usize) -> Result<Autoregression, AutoregressionError> {
    solve(stretches, order, &[forward(order)], Method::Covariance)
}

pub(super) fn estimate_modified(
    stretches: &[&[f64]],
    order: usize,
) -> Result<Autoregression, AutoregressionError> {
    solve(stretches, order, &[forward(order), backward(order)], Method::ModifiedCovariance)
}

/// Lags of the regressors, then of the target.
fn forward(order: usize) -> Vec<usize> {
    (1..=order).chain([0]).collect()
}

fn backward(order: usize) -> Vec<usize> {
    (0..order).rev().chain([order]).collect()
}

fn solve(
    stretches: &[&[f64]],
    order: usize,
    equations: &[Vec<usize>],
    method: Method,
) -> Result<Autoregression, AutoregressionError> {
    let columns = |lags: &Vec<usize>| lags.iter().map(|lag| Product::of(&[y(*lag as u16)], &[])).collect();
    let ranges: Vec<Range<usize>> =
        stretches.iter().map(|stretch| order.min(stretch.len())..stretch.len()).collect();
    let system = |(signal, range), lags| System {
        signals: std::slice::from_ref(signal),
        ranges: std::slice::from_ref(range),
        columns: columns(lags),
    };
    let systems: Vec<System<'_>> = stretches
        .iter()
        .zip(&ranges)
        .flat_map(|stretch| equations.iter().map(move |lags| (stretch, lags)))
        .map(|(stretch, lags)| system(stretch, lags))
        .collect();
    let refused = |order| AutoregressionError::IllConditioned { method, order };
    let solution = least_squares::solve(&systems).map_err(|column| refused(column + 1))?;
    if solution.rounding > TRUSTED || solution.rounding.is_nan() {
        return Err(refused(order));
    }
    Ok(Autoregression {
        innovation_variance: solution.residual_sum_of_squares / solution.rows as f64,
        coefficients: solution.weights,
        reflection: Vec::new(),
    })
}

//! Coefficients of a chosen set of terms, from an orthogonal factorisation of the data.
//!
//! The search works on the Gram matrix, whose condition number is the square of the data's. Here the chosen columns
//! themselves, X = [1 p_1 … p_K] with the target y beside them, are solved for (`least_squares`).

use fos_core::{Factor, y};
use thiserror::Error;

use super::least_squares::{self, System};
use crate::candidates::{MAX_DEGREE, MAX_INPUT, MAX_LAG, Monomial, is_candidate, monomial_text};
use crate::model::FittedTerm;
use crate::moments::{Product, Rows};

/// A least-squares fit of given terms.
#[derive(Debug, Clone, PartialEq)]
pub struct Refit {
    /// a_0, unit of y.
    pub constant: f64,
    /// a_m of each term, unit of y over unit of the monomial.
    pub coefficients: Vec<f64>,
    /// Standard error of the constant, √(σ²(XᵀX)⁻¹) with σ² = RSS/(n − p), p parameters with the constant.
    /// Valid for white residuals.
    pub constant_error: f64,
    /// Standard error of each coefficient, likewise.
    pub coefficient_errors: Vec<f64>,
    /// Q of each term in the given order: the reduction of the mean square error when it was added.
    pub mse_reductions: Vec<f64>,
    /// Mean of e², summed over the actual residuals.
    pub mse: f64,
    /// Condition number of X with its columns scaled to unit norm.
    pub condition: f64,
    /// Number of rows used, n.
    pub rows: usize,
}

impl Refit {
    /// Returns the fitted terms `monomials` with their coefficients and standard errors.
    pub fn terms(&self, monomials: &[Monomial]) -> Vec<FittedTerm> {
        let solved = self.coefficients.iter().zip(&self.coefficient_errors);
        let term = |(factors, (coefficient, error)): (&Monomial, (&f64, &f64))| FittedTerm {
            coefficient: *coefficient,
            standard_error: Some(*error),
            factors: factors.clone(),
        };
        monomials.iter().zip(solved).map(term).collect()
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RefitError {
    /// A term that no pool can contain.
    #[error(
        "{text} cannot be a term: at most {MAX_DEGREE} factors, output lags from 1, lags to {MAX_LAG}, inputs to u{MAX_INPUT}"
    )]
    Term { term: usize, text: String },
    #[error("{parameters} parameters cannot be fitted to {rows} rows")]
    TooFewRows {
        rows: usize,
        /// Number of terms and the constant.
        parameters: usize,
    },
    #[error("term {term}, {text}, is a sum of the constant and the terms before it: leave it out")]
    Collinear { term: usize, text: String },
}

/// Fits the constant and `terms` to all `rows` of the signals by least squares.
///
/// # Panics
/// If the signals do not fit the terms.
pub fn refit(signals: &[&[f64]], rows: &Rows, terms: &[Monomial]) -> Result<Refit, RefitError> {
    rows.check(signals, terms.iter().flatten());
    if let Some(term) = terms.iter().position(|m| !is_candidate(m)) {
        return Err(RefitError::Term { term, text: monomial_text(&terms[term]) });
    }
    let parameters = terms.len() + 1;
    let count = rows.count();
    if count <= parameters {
        return Err(RefitError::TooFewRows { rows: count, parameters });
    }
    let system = System { signals, ranges: rows.ranges(), columns: columns(terms) };
    let solution = least_squares::solve(&[system]).map_err(|column| {
        // the constant's column cannot be dependent: it is first and not zero
        let term = column - 1;
        RefitError::Collinear { term, text: monomial_text(&terms[term]) }
    })?;
    let n = count as f64;
    let mse = solution.residual_sum_of_squares / n;
    let errors = solution.standard_errors();
    Ok(Refit {
        constant: solution.weights[0],
        coefficients: solution.weights[1..].to_vec(),
        constant_error: errors[0],
        coefficient_errors: errors[1..].to_vec(),
        mse_reductions: solution.reductions[1..].iter().map(|reduction| reduction / n).collect(),
        mse,
        condition: solution.condition,
        rows: count,
    })
}

/// Memory of a refit besides the data, bytes: one block of rows, and the factor.
pub fn working_bytes(terms: usize) -> usize {
    least_squares::working_bytes(terms + 2)
}

/// Returns the mean of e² for given weights, from the residuals; NaN without rows. Unit of y².
///
/// # Panics
/// If the signals do not fit the terms.
pub fn mean_square_error(
    signals: &[&[f64]],
    rows: &Rows,
    constant: f64,
    terms: &[Monomial],
    coefficients: &[f64],
) -> f64 {
    rows.check(signals, terms.iter().flatten());
    let weights: Vec<f64> = std::iter::once(constant).chain(coefficients.iter().copied()).collect();
    let system = System { signals, ranges: rows.ranges(), columns: columns(terms) };
    least_squares::residual_sum_of_squares(&[system], &weights) / rows.count() as f64
}

/// Returns the columns of [X y]: the constant, the terms, the target.
fn columns(terms: &[Monomial]) -> Vec<Product> {
    let target = [y(0)];
    let monomials =
        std::iter::once(&[] as &[Factor]).chain(terms.iter().map(Vec::as_slice)).chain([&target[..]]);
    monomials.map(|m| Product::of(m, &[])).collect()
}

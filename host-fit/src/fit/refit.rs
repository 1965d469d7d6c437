//! Coefficients of a chosen set of terms, from an orthogonal factorisation of the data.
//!
//! The search works on the Gram matrix, whose condition number is the square of the data's. Here the chosen
//! columns themselves, X = [1 p_1 … p_K] with the target y beside them, are reduced to triangular form by
//! Householder reflections, block of rows after block of rows (`householder`):
//!
//! ```text
//!           [ R  z ]
//!   [X y] = Q        ,      R a = z,    n·Q_m = z_m²,    n·MSE = ρ²
//!           [ 0  ρ ]
//! ```
//!
//! so memory is one block, and nothing squared is ever solved.

use std::ops::Range;

use fos_core::{Factor, y};
use nalgebra::{DMatrix, DVectorViewMut};
use thiserror::Error;

use super::householder::{Block, Triangle};
use crate::candidates::{MAX_DEGREE, MAX_INPUT, MAX_LAG, Monomial, is_candidate, monomial_text};
use crate::moments::{Product, Rows, SignalsError};

/// Rows taken in at a time: eight terms and the target of 512 rows are 40 kB and stay in the first-level cache.
const BLOCK_ROWS: usize = 512;

/// Smallest share of a column's norm that must be left when the columns before it are taken out. Householder
/// reflections leave some 10⁻¹⁵ of a column that is an exact sum of others, a little more after thousands of
/// blocks; a candidate the search may choose leaves 10⁻⁶ at least.
const RANK: f64 = 1e-12;

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
    /// Q of each term in the given order: how much it lowered the mean square error when it was added.
    pub mse_reductions: Vec<f64>,
    /// Mean of e², summed over the actual residuals.
    pub mse: f64,
    /// Condition number of X with its columns scaled to unit norm.
    pub condition: f64,
    /// Rows used, n.
    pub rows: usize,
}

/// Why terms could not be fitted.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RefitError {
    /// The signals do not fit the terms.
    #[error(transparent)]
    Signals(#[from] SignalsError),
    /// A term that no pool could offer.
    #[error(
        "{text} cannot be a term: at most {MAX_DEGREE} factors, output lags from 1, lags to {MAX_LAG}, inputs to u{MAX_INPUT}"
    )]
    Term {
        /// Index of the term.
        term: usize,
        /// The term as people write it.
        text: String,
    },
    /// As many parameters as rows, or more.
    #[error("{parameters} parameters cannot be fitted to {rows} rows")]
    TooFewRows {
        /// Rows with target and lagged values present.
        rows: usize,
        /// Terms and the constant.
        parameters: usize,
    },
    /// A term is a sum of the constant and the terms before it.
    #[error("term {term}, {text}, is a sum of the constant and the terms before it: leave it out")]
    Collinear {
        /// Index of the term.
        term: usize,
        /// The term as people write it.
        text: String,
    },
}

/// Fits the constant and `terms` to all `rows` of the signals by least squares.
///
/// # Errors
/// Signals that do not fit the terms, a monomial that cannot be a term, too few rows, or a term collinear with
/// those before it.
pub fn refit(signals: &[&[f64]], rows: &Rows, terms: &[Monomial]) -> Result<Refit, RefitError> {
    rows.check(signals, terms.iter().flatten())?;
    if let Some(term) = terms.iter().position(|m| !is_candidate(m)) {
        return Err(RefitError::Term { term, text: monomial_text(&terms[term]) });
    }
    let parameters = terms.len() + 1;
    let count = rows.count();
    if count <= parameters {
        return Err(RefitError::TooFewRows { rows: count, parameters });
    }
    // the columns of [X y]
    let target = [y(0)];
    let monomials =
        std::iter::once(&[] as &[Factor]).chain(terms.iter().map(Vec::as_slice)).chain([&target[..]]);
    let columns: Vec<Product> = monomials.map(|m| Product::of(m, &[])).collect();

    let factor = triangular_factor(signals, rows, &columns);
    let r = DMatrix::from_fn(parameters, parameters, |i, j| factor.at(i, j));
    let z = |m: usize| factor.at(m, parameters);
    for j in 0..parameters {
        if r[(j, j)].abs() <= RANK * r.column(j).norm() {
            // the constant's column cannot be dependent: it is first and not zero
            let term = j - 1;
            return Err(RefitError::Collinear { term, text: monomial_text(&terms[term]) });
        }
    }

    let mut weights: Vec<f64> = (0..parameters).map(z).collect();
    let solved = r.solve_upper_triangular_mut(&mut DVectorViewMut::from_slice(&mut weights, parameters));
    debug_assert!(solved, "the diagonal was checked");
    let n = count as f64;
    let mse = residual_sum_of_squares(signals, rows, &columns, &weights) / n;

    let mut inverse = DMatrix::<f64>::identity(parameters, parameters);
    r.solve_upper_triangular_mut(&mut inverse);
    let sigma = (mse * n / (n - parameters as f64)).sqrt();
    let error = |j: usize| sigma * inverse.row(j).norm();
    Ok(Refit {
        constant: weights[0],
        coefficients: weights[1..].to_vec(),
        constant_error: error(0),
        coefficient_errors: (1..parameters).map(error).collect(),
        mse_reductions: (1..parameters).map(|m| z(m) * z(m) / n).collect(),
        mse,
        condition: condition(&r),
        rows: count,
    })
}

/// The triangular factor of [X y] over all rows.
fn triangular_factor(signals: &[&[f64]], rows: &Rows, columns: &[Product]) -> Triangle {
    let mut triangle = Triangle::new(columns.len());
    let mut block = Block::new(BLOCK_ROWS, columns.len());
    for rows in blocks(rows, BLOCK_ROWS) {
        block.fill(rows.len(), |j, column| columns[j].fill(signals, rows.clone(), column));
        triangle.take_in(&mut block);
    }
    triangle
}

/// Σ (y − X a)² with every residual formed.
fn residual_sum_of_squares(signals: &[&[f64]], rows: &Rows, columns: &[Product], weights: &[f64]) -> f64 {
    let mut block = Block::new(BLOCK_ROWS, columns.len());
    let of_rows = |rows: Range<usize>| {
        block.fill(rows.len(), |j, column| columns[j].fill(signals, rows.clone(), column));
        block.residual_sum_of_squares(weights)
    };
    blocks(rows, BLOCK_ROWS).map(of_rows).sum()
}

/// The rows in pieces of at most `most`.
fn blocks(rows: &Rows, most: usize) -> impl Iterator<Item = Range<usize>> {
    let pieces = move |range: &Range<usize>| {
        let end = range.end;
        range.clone().step_by(most).map(move |start| start..end.min(start + most))
    };
    rows.ranges().iter().flat_map(pieces)
}

/// Largest over smallest singular value of R with unit columns.
fn condition(r: &DMatrix<f64>) -> f64 {
    let norms: Vec<f64> = r.column_iter().map(|column| column.norm()).collect();
    let scaled = DMatrix::from_fn(r.nrows(), r.ncols(), |i, j| r[(i, j)] / norms[j]);
    let values = scaled.singular_values();
    values.max() / values.min()
}

/// Bytes a refit of so many terms holds besides the data: one block of rows, and the factor.
pub(crate) fn working_bytes(terms: usize) -> usize {
    let width = terms + 2;
    (BLOCK_ROWS * (width + 2) + 4 * width * width) * size_of::<f64>()
}

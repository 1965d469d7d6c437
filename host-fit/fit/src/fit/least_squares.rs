//! Least squares on the data themselves, by Householder reflections, block of rows after block of rows.
//!
//! ```text
//!             [ R  z ]
//!   [X y] = Q [      ] ,      R a = z,    reduction of column m: z_m²,    residual sum of squares: ρ²
//!             [ 0  ρ ]
//! ```
//!
//! Memory is one block, and no squared matrix is ever solved.

use std::ops::Range;

use nalgebra::{DMatrix, DVectorViewMut};

use super::householder::{Block, Triangle};
use crate::moments::Product;

/// Rows per block: eight terms and the target of 512 rows are 40 kB and stay in the first-level cache.
const BLOCK_ROWS: usize = 512;

/// Smallest share of a column's norm that must remain after the columns before it are projected out. Householder
/// reflections leave some 10⁻¹⁵ of a column that is an exact sum of others, a little more after thousands of blocks; a
/// candidate of the search leaves at least 10⁻⁶.
const RANK: f64 = 1e-12;

/// Relative error of an entry of R.
const ROUNDING: f64 = 10.0 * f64::EPSILON;

/// Rows of [X y]: products of delayed samples at each of the rows, the target last.
pub(super) struct System<'a> {
    pub(super) signals: &'a [&'a [f64]],
    pub(super) ranges: &'a [Range<usize>],
    pub(super) columns: Vec<Product>,
}

/// Weights a that minimise Σ(y − X a)², with their accuracy.
pub(super) struct Solution {
    pub(super) weights: Vec<f64>,
    /// Reduction of the sum of squares by each column when it was added.
    pub(super) reductions: Vec<f64>,
    /// Σ(y − X a)², computed from the residuals.
    pub(super) residual_sum_of_squares: f64,
    /// Condition number of X with its columns scaled to unit norm.
    pub(super) condition: f64,
    /// Bound on the relative error of the weights by rounding, with columns scaled to unit norm:
    /// u·(κ + κ²·‖residual‖/(‖X‖·‖a‖)), the first-order bound of a backward stable method (Golub and Van Loan, Matrix
    /// Computations, 4th ed., eq. 5.3.8), with u ten units in the last place for the reflections of some twenty columns.
    pub(super) rounding: f64,
    pub(super) rows: usize,
    factor: DMatrix<f64>,
}

impl Solution {
    /// Standard error √(σ²(XᵀX)⁻¹) of each weight, with σ² the residual sum of squares over the degrees of freedom.
    /// Valid for white residuals.
    pub(super) fn standard_errors(&self) -> Vec<f64> {
        let parameters = self.weights.len();
        let mut inverse = DMatrix::<f64>::identity(parameters, parameters);
        self.factor.solve_upper_triangular_mut(&mut inverse);
        let sigma = (self.residual_sum_of_squares / (self.rows - parameters) as f64).sqrt();
        inverse.row_iter().map(|row| sigma * row.norm()).collect()
    }
}

/// Solves all `systems`, which have the same number of columns and together more rows than that, as one.
///
/// # Errors
/// Index of a column that is a sum of those before it.
pub(super) fn solve(systems: &[System<'_>]) -> Result<Solution, usize> {
    let parameters = systems[0].columns.len() - 1;
    let factor = triangular_factor(systems);
    let r = DMatrix::from_fn(parameters, parameters, |i, j| factor.at(i, j));
    let z = |m: usize| factor.at(m, parameters);
    let is_dependent = |j: &usize| r[(*j, *j)].abs() <= RANK * r.column(*j).norm();
    if let Some(column) = (0..parameters).find(is_dependent) {
        return Err(column);
    }
    let mut weights: Vec<f64> = (0..parameters).map(z).collect();
    let solved = r.solve_upper_triangular_mut(&mut DVectorViewMut::from_slice(&mut weights, parameters));
    debug_assert!(solved, "the diagonal was checked");
    let residual_sum_of_squares = residual_sum_of_squares(systems, &weights);
    let norms: Vec<f64> = r.column_iter().map(|column| column.norm()).collect();
    let values = DMatrix::from_fn(parameters, parameters, |i, j| r[(i, j)] / norms[j]).singular_values();
    let condition = values.max() / values.min();
    let size = weights.iter().zip(&norms).map(|(a, norm)| (a * norm).powi(2)).sum::<f64>().sqrt();
    let angle = residual_sum_of_squares.sqrt() / (values.max() * size).max(f64::MIN_POSITIVE);
    Ok(Solution {
        residual_sum_of_squares,
        reductions: (0..parameters).map(|m| z(m) * z(m)).collect(),
        rounding: ROUNDING * condition * (1.0 + condition * angle),
        condition,
        rows: systems.iter().flat_map(|system| system.ranges).map(ExactSizeIterator::len).sum(),
        weights,
        factor: r,
    })
}

/// Returns the triangular factor of [X y] over all rows.
fn triangular_factor(systems: &[System<'_>]) -> Triangle {
    let width = systems[0].columns.len();
    let mut triangle = Triangle::new(width);
    let mut block = Block::new(BLOCK_ROWS, width);
    for (system, rows) in blocks(systems, BLOCK_ROWS) {
        block.fill(rows.len(), |j, column| system.columns[j].fill(system.signals, rows.clone(), column));
        triangle.take_in(&mut block);
    }
    triangle
}

/// Returns Σ (y − X a)², computed from the residuals.
pub(super) fn residual_sum_of_squares(systems: &[System<'_>], weights: &[f64]) -> f64 {
    let mut block = Block::new(BLOCK_ROWS, weights.len() + 1);
    let block_sum = |(system, rows): (&System<'_>, Range<usize>)| {
        block.fill(rows.len(), |j, column| system.columns[j].fill(system.signals, rows.clone(), column));
        block.residual_sum_of_squares(weights)
    };
    blocks(systems, BLOCK_ROWS).map(block_sum).sum()
}

/// Splits the rows into pieces of at most `most`.
fn blocks<'a>(
    systems: &'a [System<'a>],
    most: usize,
) -> impl Iterator<Item = (&'a System<'a>, Range<usize>)> {
    let pieces = move |range: &'a Range<usize>| {
        range.clone().step_by(most).map(move |start| start..range.end.min(start + most))
    };
    systems
        .iter()
        .flat_map(move |system| system.ranges.iter().flat_map(pieces).map(move |rows| (system, rows)))
}

/// Memory besides the data for this number of columns, bytes: one block of rows, and the factor.
pub(super) fn working_bytes(width: usize) -> usize {
    (BLOCK_ROWS * width + 4 * width * width) * size_of::<f64>()
}

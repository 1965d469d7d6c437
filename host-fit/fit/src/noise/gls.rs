//! Generalised least squares: a regression with sensor noise as error, on whitened columns.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::blocks::Blocks;
use super::model::{NoiseLevels, Whitening};

/// Share of a column's squares that must remain after the columns before it are projected out; below it the column is a
/// combination of them.
const COLLINEAR: f64 = 1e-7;

/// Whitened regressors orthonormalised by modified Gram-Schmidt (twice), and a whitened output. The unknown levels of
/// [`Blocks::restarts`] are eliminated during whitening, without a regressor each.
#[derive(Debug, Clone)]
pub struct Gls {
    basis: Vec<Vec<f64>>,
    /// Column j of the whitened regressors is Σ_i basis_i·triangle\[j\]\[i\].
    triangle: Vec<Vec<f64>>,
    /// Indices of the given regressors that are used; the others are combinations of those before them.
    pub kept: Vec<usize>,
    n_regressors: usize,
    /// Residual of the whitened output.
    pub residual: Vec<f64>,
    projections: Vec<f64>,
    /// ln det of the noise covariance.
    pub log_determinant: f64,
    whitening: Arc<Whitening>,
}

impl Gls {
    /// Regresses `y` on `regressors`, all in block means, under noise of `levels`.
    pub fn new(blocks: &Blocks, levels: &NoiseLevels, y: &[f64], regressors: &[&[f64]]) -> Self {
        let mut columns = vec![y];
        columns.extend(regressors);
        let whitening = levels.whitening(blocks);
        let mut whitened = whitening.whiten(&columns);
        let residual = whitened.columns.remove(0);
        whitened.taken.remove(0);
        let mut gls = Self {
            basis: Vec::new(),
            triangle: Vec::new(),
            kept: Vec::new(),
            n_regressors: regressors.len(),
            residual,
            projections: Vec::new(),
            log_determinant: whitened.log_determinant,
            whitening: Arc::new(whitening),
        };
        for (index, column) in whitened.columns.into_iter().zip(whitened.taken).enumerate() {
            if let Some((direction, coordinates)) = gls.orthonormal(column) {
                gls.kept.push(index);
                gls.triangle.push(coordinates);
                let projection = dot(&direction, &gls.residual);
                for (left, part) in gls.residual.iter_mut().zip(&direction) {
                    *left -= projection * part;
                }
                gls.projections.push(projection);
                gls.basis.push(direction);
            }
        }
        gls
    }

    /// Orthonormalises a whitened column against the basis and returns it with its coordinates; `None` if nothing
    /// remains beside the basis and the levels, which account for `taken` of its squares.
    fn orthonormal(&self, (mut column, taken): (Vec<f64>, f64)) -> Option<(Vec<f64>, Vec<f64>)> {
        let before = dot(&column, &column) + taken;
        let mut coordinates = vec![0.0; self.basis.len()];
        for _ in 0..2 {
            for (coordinate, direction) in coordinates.iter_mut().zip(&self.basis) {
                let along = dot(direction, &column);
                column.iter_mut().zip(direction).for_each(|(value, part)| *value -= along * part);
                *coordinate += along;
            }
        }
        let left = dot(&column, &column);
        if !(left > COLLINEAR * before && left.is_finite()) {
            return None;
        }
        let norm = left.sqrt();
        column.iter_mut().for_each(|value| *value /= norm);
        coordinates.push(norm);
        Some((column, coordinates))
    }

    /// Returns −2 ln L up to a constant: ln det C + χ². It is restricted to the part orthogonal to unknown levels,
    /// since with one level per rest the maximum likelihood would underestimate the noise (Neyman and Scott 1948).
    pub fn deviance(&self) -> f64 {
        self.log_determinant + dot(&self.residual, &self.residual)
    }

    /// Returns ln det of the inverse of [`Gls::covariance`], the term by which coefficients reduce the likelihood of
    /// the levels (restricted likelihood; Patterson and Thompson 1971).
    pub fn log_determinant_of_information(&self) -> f64 {
        self.triangle.iter().enumerate().map(|(j, column)| 2.0 * column[j].ln()).sum()
    }

    /// Returns the decrease of χ² by further regressors together, and the number of them that are linearly independent.
    pub fn gain(&self, regressors: &[&[f64]]) -> (f64, usize) {
        let whitened = self.whitening.whiten(regressors);
        let mut wider = Self { residual: self.residual.clone(), ..self.without_output() };
        let before = dot(&self.residual, &self.residual);
        let mut added = 0;
        for column in whitened.columns.into_iter().zip(whitened.taken) {
            if let Some((direction, coordinates)) = wider.orthonormal(column) {
                let projection = dot(&direction, &wider.residual);
                wider.residual.iter_mut().zip(&direction).for_each(|(left, part)| *left -= projection * part);
                wider.triangle.push(coordinates);
                wider.basis.push(direction);
                added += 1;
            }
        }
        (before - dot(&wider.residual, &wider.residual), added)
    }

    fn without_output(&self) -> Self {
        Self { residual: Vec::new(), ..self.clone() }
    }

    /// Returns the coefficients of all given regressors; 0 for those that are not used.
    pub fn coefficients(&self) -> Vec<f64> {
        let mut kept = vec![0.0; self.basis.len()];
        for i in (0..kept.len()).rev() {
            let later: f64 = (i + 1..kept.len()).map(|j| self.triangle[j][i] * kept[j]).sum();
            kept[i] = (self.projections[i] - later) / self.triangle[i][i];
        }
        let mut all = vec![0.0; self.n_regressors];
        self.kept.iter().zip(kept).for_each(|(index, value)| all[*index] = value);
        all
    }

    /// Returns `y` minus what the given regressors explain, without whitening.
    pub fn unexplained(&self, y: &[f64], regressors: &[&[f64]]) -> Vec<f64> {
        let explained = combination(regressors, &self.coefficients(), y.len());
        y.iter().zip(explained).map(|(value, explained)| value - explained).collect()
    }

    /// Returns the covariance of the coefficients of the used regressors, in order: (RᵀR)⁻¹.
    pub fn covariance(&self) -> DMatrix<f64> {
        let k = self.basis.len();
        let upper = DMatrix::from_fn(k, k, |i, j| if i <= j { self.triangle[j][i] } else { 0.0 });
        let columns: Vec<DVector<f64>> = (0..k)
            .map(|unit| {
                let mut column = DVector::zeros(k);
                column[unit] = 1.0;
                // the diagonal is positive by construction
                upper.solve_upper_triangular(&column).unwrap_or_else(|| DVector::zeros(k))
            })
            .collect();
        // `from_columns` panics without a regressor
        let inverse = DMatrix::from_fn(k, k, |i, j| columns[j][i]);
        &inverse * inverse.transpose()
    }
}

/// Returns Σ weight·column, of columns with this number of rows; a column with weight 0 may hold NaN.
pub fn combination(columns: &[impl AsRef<[f64]>], weights: &[f64], rows: usize) -> Vec<f64> {
    let mut sum = vec![0.0; rows];
    for (column, weight) in columns.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        sum.iter_mut().zip(column.as_ref()).for_each(|(sum, value)| *sum += weight * value);
    }
    sum
}

/// Σ a·b.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

//! Time averages of products of candidates and target.

use thiserror::Error;

use super::layout::{Average, Layout};

/// Averages over the rows, written ⟨·⟩: of products of candidates p_i, and of candidates and target y.
#[derive(Debug, Clone)]
pub struct Gram {
    rows: usize,
    means: Vec<f64>,
    /// Row-major, M × M, both triangles filled.
    products: Vec<f64>,
    target_products: Vec<f64>,
    target_mean: f64,
    target_mean_square: f64,
}

#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("no row has its target and every lagged value: the segments are too short or hold no data")]
pub struct NoRows;

impl Gram {
    /// Forms the averages from the sums over `rows` of the products in `layout`.
    pub(super) fn new(rows: usize, layout: &Layout, sums: &[f64]) -> Result<Self, NoRows> {
        if rows == 0 {
            return Err(NoRows);
        }
        let average = |average| sums[layout.product(average)] / rows as f64;
        let size = layout.size;
        let mut products = vec![0.0; size * size];
        for i in 0..size {
            for j in 0..=i {
                let product = average(Average::Pair(i, j));
                products[i * size + j] = product;
                products[j * size + i] = product;
            }
        }
        Ok(Self {
            rows,
            means: (0..size).map(|i| average(Average::Mean(i))).collect(),
            products,
            target_products: (0..size).map(|i| average(Average::WithTarget(i))).collect(),
            target_mean: average(Average::Target),
            target_mean_square: average(Average::TargetSquare),
        })
    }

    /// Number of rows averaged over, n.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of candidates, M.
    pub fn size(&self) -> usize {
        self.means.len()
    }

    /// ⟨p_i p_j⟩
    pub fn product(&self, i: usize, j: usize) -> f64 {
        self.products[i * self.size() + j]
    }

    /// ⟨p_i⟩
    pub fn mean(&self, i: usize) -> f64 {
        self.means[i]
    }

    /// ⟨y p_i⟩
    pub fn target_product(&self, i: usize) -> f64 {
        self.target_products[i]
    }

    /// ⟨y⟩
    pub fn target_mean(&self) -> f64 {
        self.target_mean
    }

    /// ⟨y²⟩
    pub fn target_mean_square(&self) -> f64 {
        self.target_mean_square
    }

    /// ⟨y²⟩ − ⟨y⟩²: the mean square error of the constant alone.
    pub fn target_variance(&self) -> f64 {
        self.target_mean_square - self.target_mean * self.target_mean
    }
}

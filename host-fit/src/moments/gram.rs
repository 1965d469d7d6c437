//! Time averages of products of candidates and target.

use fos_core::{Factor, y};
use thiserror::Error;

use super::{Moments, Product};
use crate::candidates::{Candidates, monomial_text};

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

/// Why there is no Gram matrix.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum GramError {
    /// Nothing to average over.
    #[error("no row has its target and every lagged value: the segments are too short or hold no data")]
    NoRows,
    /// The pool asks for a product the moments were not made for.
    #[error("the moments do not cover {0}: accumulate them for a pool that holds it")]
    NotCovered(String),
}

impl Gram {
    pub(super) fn new(moments: &Moments, pool: &Candidates) -> Result<Self, GramError> {
        if moments.rows == 0 {
            return Err(GramError::NoRows);
        }
        let scale = moments.rows as f64;
        let average = |a: &[Factor], b: &[Factor]| match moments.sum(&Product::of(a, b)) {
            Some(sum) => Ok(sum / scale),
            None => Err(GramError::NotCovered(format!("{}·{}", monomial_text(a), monomial_text(b)))),
        };
        let target = [y(0)];
        let monomials = pool.monomials();
        let size = monomials.len();
        let mut products = vec![0.0; size * size];
        for (i, p) in monomials.iter().enumerate() {
            for (j, q) in monomials[..=i].iter().enumerate() {
                let product = average(p, q)?;
                products[i * size + j] = product;
                products[j * size + i] = product;
            }
        }
        Ok(Self {
            rows: moments.rows,
            means: monomials.iter().map(|p| average(p, &[])).collect::<Result<_, _>>()?,
            products,
            target_products: monomials.iter().map(|p| average(p, &target)).collect::<Result<_, _>>()?,
            target_mean: average(&target, &[])?,
            target_mean_square: average(&target, &target)?,
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

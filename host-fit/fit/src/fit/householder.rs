//! Triangular factor of a tall matrix by Householder reflections, a block of rows at a time.
//!
//! Sequential TSQR (Demmel, Grigori, Hoemmen and Langou, SIAM J. Sci. Comput. 34 (2012) A206): the factor
//! R so far is stacked on the next block of rows and reduced to triangular form again. With
//! v = [α − β; b] for a column's diagonal α and block part b, β = −sign(α)·√(α² + bᵀb), the reflection is
//!
//! ```text
//!   H = I − τ v vᵀ,    τ = −1/(β·(α − β)),    H [α; b] = [β; 0]
//! ```
//!
//! Reflections are orthogonal to rounding for any condition of the columns, and each column is treated in its own
//! scale. Only R is stored; a reflection is applied and discarded.
//!
//! It is our own code because on blocks a dozen columns wide the QR of `faer`, the fastest library we know, took 7
//! (unblocked) to 15 times (as released) as long; the tests compare it with that of `nalgebra`.

use aligned_vec::{AVec, avec};
use pulp::{Arch, Simd, WithSimd};

/// Lanes of the widest vector; columns are padded with zeros to a multiple of it. Rows of zeros change nothing.
const LANES: usize = 8;

/// A block of rows of a tall matrix, column by column, each aligned to a cache line.
pub(super) struct Block {
    values: AVec<f64>,
    width: usize,
    stride: usize,
    rows: usize,
}

impl Block {
    /// Allocates `rows` rows of `width` columns.
    pub(super) fn new(rows: usize, width: usize) -> Self {
        // one cache line more, or columns a multiple of 4096 bytes apart would share cache sets
        let stride = rows.next_multiple_of(LANES) + LANES;
        Self { values: avec![0.0; stride * width], width, stride, rows: 0 }
    }

    /// Fills `rows` rows, each column by `fill(column index, its values)`.
    pub(super) fn fill(&mut self, rows: usize, mut fill: impl FnMut(usize, &mut [f64])) {
        self.rows = rows;
        for (j, column) in self.values.chunks_exact_mut(self.stride).enumerate() {
            fill(j, &mut column[..rows]);
            column[rows..rows.next_multiple_of(LANES)].fill(0.0);
        }
    }

    /// Σ (last column − Σ weights·other columns)² over the rows.
    pub(super) fn residual_sum_of_squares(&self, weights: &[f64]) -> f64 {
        Arch::new().dispatch(ResidualSumOfSquares { block: self, weights })
    }

    fn padded(&self) -> usize {
        self.rows.next_multiple_of(LANES)
    }
}

/// Triangular factor of all rows so far.
pub(super) struct Triangle {
    /// Row-major, `width` × `width`, nothing below the diagonal.
    values: Vec<f64>,
    width: usize,
}

impl Triangle {
    /// Returns the factor of no rows: zero.
    pub(super) fn new(width: usize) -> Self {
        Self { values: vec![0.0; width * width], width }
    }

    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i * self.width + j]
    }

    /// Includes a block of rows, whose contents are destroyed.
    pub(super) fn take_in(&mut self, block: &mut Block) {
        assert_eq!(block.width, self.width);
        Arch::new().dispatch(TakeIn { triangle: self, block });
    }
}

struct TakeIn<'a> {
    triangle: &'a mut Triangle,
    block: &'a mut Block,
}

impl WithSimd for TakeIn<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (width, stride, padded) = (self.triangle.width, self.block.stride, self.block.padded());
        for j in 0..width {
            let (done, rest) = self.block.values.split_at_mut((j + 1) * stride);
            let b = S::as_simd_f64s(&done[j * stride..][..padded]).0;
            let row = &mut self.triangle.values[j * width..][..width];
            let square = dot(simd, b, b);
            if square == 0.0 {
                continue; // nothing below the diagonal to reflect
            }
            let alpha = row[j];
            let beta = -(alpha * alpha + square).sqrt().copysign(alpha);
            let head = alpha - beta;
            let tau = -1.0 / (beta * head);
            row[j] = beta;
            for (r, column) in row[j + 1..].iter_mut().zip(rest.chunks_exact_mut(stride)) {
                let column = S::as_mut_simd_f64s(&mut column[..padded]).0;
                let weight = tau * (head * *r + dot(simd, b, column));
                *r -= weight * head;
                let weight = simd.splat_f64s(-weight);
                for (x, b) in column.iter_mut().zip(b) {
                    *x = simd.mul_add_e_f64s(weight, *b, *x);
                }
            }
        }
    }
}

/// aᵀb, in four partial sums so that no addition waits for the previous one.
#[inline(always)]
fn dot<S: Simd>(simd: S, a: &[S::f64s], b: &[S::f64s]) -> f64 {
    let mut sums = [simd.splat_f64s(0.0); 4];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    for (a, b) in a.iter().zip(b) {
        for i in 0..4 {
            sums[i] = simd.mul_add_e_f64s(a[i], b[i], sums[i]);
        }
    }
    for (a, b) in a_rest.iter().zip(b_rest) {
        sums[0] = simd.mul_add_e_f64s(*a, *b, sums[0]);
    }
    let [p, q, r, s] = sums;
    simd.reduce_sum_f64s(simd.add_f64s(simd.add_f64s(p, q), simd.add_f64s(r, s)))
}

struct ResidualSumOfSquares<'a> {
    block: &'a Block,
    weights: &'a [f64],
}

impl WithSimd for ResidualSumOfSquares<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { block, weights } = self;
        let column = |j: usize| S::as_simd_f64s(&block.values[j * block.stride..][..block.padded()]).0;
        let mut sum = simd.splat_f64s(0.0);
        for (k, target) in column(weights.len()).iter().enumerate() {
            let mut residual = *target;
            for (j, weight) in weights.iter().enumerate() {
                residual = simd.mul_add_e_f64s(simd.splat_f64s(-weight), column(j)[k], residual);
            }
            sum = simd.mul_add_e_f64s(residual, residual, sum);
        }
        simd.reduce_sum_f64s(sum)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Columns of very different size; the last is nearly the sum of two others.
    fn matrix(rows: usize, width: usize) -> nalgebra::DMatrix<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(rows as u64);
        let mut matrix = nalgebra::DMatrix::from_fn(rows, width, |_, j| {
            10f64.powi(3 * j as i32 - 6) * (random.random::<f64>() - 0.4)
        });
        for i in 0..rows {
            matrix[(i, width - 1)] = matrix[(i, 0)] + matrix[(i, 1)] + 1e-9 * matrix[(i, 2)];
        }
        matrix
    }

    fn factor(matrix: &nalgebra::DMatrix<f64>, block_rows: usize) -> Triangle {
        let width = matrix.ncols();
        let (mut triangle, mut block) = (Triangle::new(width), Block::new(block_rows, width));
        for start in (0..matrix.nrows()).step_by(block_rows) {
            let rows = block_rows.min(matrix.nrows() - start);
            block.fill(rows, |j, column| {
                column.iter_mut().enumerate().for_each(|(i, x)| *x = matrix[(start + i, j)]);
            });
            triangle.take_in(&mut block);
        }
        triangle
    }

    #[test]
    fn agrees_with_a_library_factorisation_of_the_whole() {
        for (rows, width, block_rows) in [(7, 5, 100), (100, 5, 9), (1000, 4, 64), (2003, 6, 512)] {
            let matrix = matrix(rows, width);
            let (ours, library) = (factor(&matrix, block_rows), matrix.clone().qr().r());
            for j in 0..width {
                let scale = matrix.column(j).norm();
                for i in 0..=j {
                    // rows of R are determined up to sign; entries to ε of their column's norm, times the
                    // ratio 1e6 by which the dependent column leaves its neighbours undetermined
                    let sign = (ours.at(i, i) * library[(i, i)]).signum();
                    let difference = (ours.at(i, j) - sign * library[(i, j)]).abs();
                    let bound = if j == width - 1 { 1e-9 } else { 1e-13 } * scale;
                    assert!(difference <= bound, "R({i}, {j}) of {rows} × {width}: {difference:e}");
                }
            }
        }
    }
}

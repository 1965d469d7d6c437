//! Time averages of products of candidates: the Gram matrix, from one pass over the data.
//!
//! The [`Gram`] matrix holds everything that a search needs; its size is that of the pool and not of the record.
//!
//! Two products of delayed samples that differ only by a common delay a, p(n) and p(n − a), have sums that
//! differ only in a few rows at either end (Korenberg, Annals of Biomedical Engineering 16 (1988) 123). For
//! target rows b..e and largest lag N₀,
//!
//! ```text
//!   Σ_{n=b}^{e-1} p(n−a)  =  Σ_{n=b−a}^{b-1} p(n)  +  Σ_{n=b}^{e−N₀−1} p(n)  +  Σ_{n=e−N₀}^{e−a−1} p(n)
//!                                 head                  the same for all a            tail
//! ```
//!
//! so that ten output lags to degree 2 take 297 long sums instead of 2,279. All parts are added and none is subtracted,
//! so a transient near an end cannot cancel digits.

mod gram;
mod kernel;
mod layout;
mod product;
mod rows;

use std::ops::Range;

pub use gram::{Gram, NoRows};
pub(crate) use product::Product;
pub use rows::Rows;
pub(crate) use rows::column;

use crate::candidates::Candidates;
use kernel::Workspace;
use layout::Layout;

/// Sums over rows of every product of two candidates, of candidates and the target, and of each alone.
///
/// They are summed in cache blocks, then over blocks: the rounding error is some 10⁻¹⁵ of the sum of magnitudes, for
/// any length and unit of the signals.
///
/// ```
/// use fos_fit::candidates::Candidates;
/// use fos_fit::moments::{Moments, Rows};
///
/// let y = [1.0, 2.0, 4.0, 8.0, 16.0];
/// let pool = Candidates::builder().output(1..=1, 1).build()?;
/// let rows = Rows::usable(&[&y], &[0..5], pool.factors());
/// let gram = Moments::accumulate(&[&y], &rows, &pool).gram()?;
/// assert_eq!(gram.rows(), 4);
/// assert_eq!(gram.target_product(0), 2.0 * gram.product(0, 0)); // ⟨y(n)·y(n-1)⟩ = 2⟨y(n-1)²⟩
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Moments {
    layout: Layout,
    rows: usize,
    /// Sums, one per product of the layout.
    sums: Vec<f64>,
}

impl Moments {
    /// Sums over all `rows` of the signals (column 0 the output, column i + 1 input i).
    ///
    /// # Panics
    /// If the signals have unequal lengths, inputs are missing, or `rows` were made for shorter lags than the pool has.
    pub fn accumulate(signals: &[&[f64]], rows: &Rows, pool: &Candidates) -> Self {
        rows.check(signals, pool.factors());
        let layout = Layout::new(pool, kernel::tile_shape());
        let mut sums = vec![0.0; layout.products.len()];
        let mut workspace = Workspace::new(&layout);
        for range in rows.ranges() {
            fos_data::interrupt::check();
            if range.len() < layout.max_lag {
                add_directly(&layout, signals, range, &mut sums);
            } else {
                workspace.add(&layout, signals, range.start..range.end - layout.max_lag);
                add_ends(&layout, signals, range, &mut sums);
            }
        }
        let shared = workspace.sums();
        for shape in &layout.shapes {
            for sum in &mut sums[shape.first..shape.end] {
                *sum += shared[shape.sum];
            }
        }
        Self { layout, rows: rows.count(), sums }
    }

    /// Number of sums that take a pass over the data; all others follow from these.
    pub fn distinct(&self) -> usize {
        self.layout.shapes.len()
    }

    /// Memory besides the data while the sums were formed, bytes: sums, buffers of the pass, and their layout.
    pub fn bytes(&self) -> usize {
        let layout = &self.layout;
        size_of_val(&*layout.products)
            + size_of_val(&*layout.shapes)
            + size_of_val(&*self.sums)
            + Workspace::new(layout).bytes()
    }

    /// Returns the Gram matrix.
    pub fn gram(&self) -> Result<Gram, NoRows> {
        Gram::new(self.rows, &self.layout, &self.sums)
    }
}

/// Sums a range shorter than N₀ product by product, since nothing can be shared.
fn add_directly(layout: &Layout, signals: &[&[f64]], range: &Range<usize>, sums: &mut [f64]) {
    for ((shape, shift), sum) in layout.products.iter().zip(sums) {
        *sum += range.clone().map(|n| shape.at(signals, n - shift)).sum::<f64>();
    }
}

/// Adds head and tail of every product over a range of at least N₀ rows.
fn add_ends(layout: &Layout, signals: &[&[f64]], range: &Range<usize>, sums: &mut [f64]) {
    let lag = layout.max_lag;
    let (mut head, mut tail) = (vec![0.0; lag], vec![0.0; lag]);
    // totals[a] = Σ over the a rows before the range and the last N₀ rows but the last a
    let mut totals = vec![0.0; lag + 1];
    for shape in &layout.shapes {
        let copies = shape.first..shape.end;
        let farthest = layout.products[shape.end - 1].1;
        shape.product.fill(signals, range.start - farthest..range.start, &mut head[lag - farthest..]);
        shape.product.fill(signals, range.end - lag..range.end, &mut tail);
        let mut sum = 0.0;
        for a in (0..lag).rev() {
            sum += tail[lag - 1 - a];
            totals[a] = sum;
        }
        totals[lag] = 0.0;
        let mut sum = 0.0;
        for a in 1..=farthest {
            sum += head[lag - a];
            totals[a] += sum;
        }
        for ((_, shift), sum) in layout.products[copies.clone()].iter().zip(&mut sums[copies]) {
            *sum += totals[*shift];
        }
    }
}

#[cfg(test)]
mod tests;

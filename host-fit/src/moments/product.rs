//! A product of two candidates as a key: its factors sorted by lag, and the split into shape and shift.

use std::ops::Range;

use fos_core::{Channel, Factor};

use crate::candidates::MAX_DEGREE;

/// The most factors a product of two candidates has.
pub(super) const MAX_FACTORS: usize = 2 * MAX_DEGREE;

/// Bits that hold the channel in a packed factor: 0 the output, i + 1 input i, so up to 256.
const CHANNEL_BITS: u32 = 9;

/// A product of delayed samples, factors packed as `lag << 9 | channel` and sorted: by lag, then channel.
///
/// A fixed-size key rather than a `Vec`: a pool of 65 candidates makes 2,279 of them, and building them is
/// part of every fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) struct Product {
    /// Unused places are 0 and come last; `len` tells them from the output at lag 0.
    factors: [u32; MAX_FACTORS],
    len: u8,
}

impl Product {
    /// The product of two monomials of at most [`MAX_DEGREE`] factors each.
    pub(crate) fn of(a: &[Factor], b: &[Factor]) -> Self {
        let mut product = Self { factors: [0; MAX_FACTORS], len: (a.len() + b.len()) as u8 };
        let packed = &mut product.factors[..a.len() + b.len()];
        for (place, factor) in packed.iter_mut().zip(a.iter().chain(b)) {
            let channel = match factor.channel {
                Channel::Output => 0,
                Channel::Input(i) => u32::from(i) + 1,
            };
            *place = u32::from(factor.lag) << CHANNEL_BITS | channel;
        }
        packed.sort_unstable();
        product
    }

    pub(super) fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// (column of the signals, lag) of each factor, lags ascending. Column 0 is the output.
    pub(super) fn factors(&self) -> impl Iterator<Item = (usize, usize)> {
        let unpack =
            |packed: &u32| ((packed & ((1 << CHANNEL_BITS) - 1)) as usize, (packed >> CHANNEL_BITS) as usize);
        self.factors[..usize::from(self.len)].iter().map(unpack)
    }

    /// Smallest lag, 0 for the empty product.
    fn min_lag(&self) -> usize {
        self.factors().next().map_or(0, |(_, lag)| lag)
    }

    /// Largest lag, 0 for the empty product.
    pub(super) fn max_lag(&self) -> usize {
        self.factors().last().map_or(0, |(_, lag)| lag)
    }

    /// The same product `shift` samples later: p(n) = shape(n − shift), the shape's smallest lag being 0.
    pub(super) fn normalised(&self) -> (Product, usize) {
        let shift = self.min_lag();
        let mut shape = *self;
        for packed in &mut shape.factors[..usize::from(self.len)] {
            *packed -= (shift as u32) << CHANNEL_BITS;
        }
        (shape, shift)
    }

    /// Splits a shape in the middle: shape(n) = left(n)·right(n − shift), both halves shapes themselves.
    ///
    /// A half has at most [`MAX_DEGREE`] factors, so few halves make many products.
    pub(super) fn halves(&self) -> (Product, Product, usize) {
        let middle = usize::from(self.len / 2);
        let half = |factors: &[u32]| {
            let mut half = Product { factors: [0; MAX_FACTORS], len: factors.len() as u8 };
            half.factors[..factors.len()].copy_from_slice(factors);
            half
        };
        let (left, right) = self.factors[..usize::from(self.len)].split_at(middle);
        let (right, shift) = half(right).normalised();
        (half(left), right, shift)
    }

    /// The product's value at row `n`: Π signals[c][n − lag].
    pub(super) fn at(&self, signals: &[&[f64]], n: usize) -> f64 {
        self.factors().map(|(column, lag)| signals[column][n - lag]).product()
    }

    /// The product's values at `rows`, one after the other, into `out` of the same length.
    ///
    /// Inlined, so that inside the moment kernel it is compiled for the instruction set chosen there.
    #[inline(always)]
    pub(crate) fn fill(&self, signals: &[&[f64]], rows: Range<usize>, out: &mut [f64]) {
        let mut delayed =
            self.factors().map(|(column, lag)| &signals[column][rows.start - lag..rows.end - lag]);
        match (delayed.next(), delayed.next()) {
            (None, _) => out.fill(1.0),
            (Some(a), None) => out.copy_from_slice(a),
            (Some(a), Some(b)) => {
                for (z, (a, b)) in out.iter_mut().zip(a.iter().zip(b)) {
                    *z = a * b;
                }
            }
        }
        for factor in delayed {
            for (z, x) in out.iter_mut().zip(factor) {
                *z *= x;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use fos_core::{u, y};

    use super::*;

    #[test]
    fn splits_into_shape_and_shift() {
        let product = Product::of(&[y(2), u(0, 5)], &[y(4)]);
        let (shape, shift) = product.normalised();
        assert_eq!(shift, 2);
        assert_eq!(shape, Product::of(&[y(0), y(2), u(0, 3)], &[]));
        assert_eq!(shape.max_lag(), 3);

        let (left, right, apart) = shape.halves();
        assert_eq!(left, Product::of(&[y(0)], &[]));
        assert_eq!(right, Product::of(&[y(0), u(0, 1)], &[]));
        assert_eq!(apart, 2);
    }

    #[test]
    fn tells_short_products_from_long_ones() {
        assert_ne!(Product::of(&[y(0)], &[]), Product::of(&[y(0)], &[y(0)]));
        assert!(Product::of(&[], &[]).is_empty());
    }
}

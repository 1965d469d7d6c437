//! A product of two candidates as a key: its factors sorted by lag, and the split into shape and shift.

use std::ops::Range;

use fos_core::{Channel, Factor};

use crate::candidates::{MAX_DEGREE, MAX_INPUT, MAX_LAG};

/// Largest number of factors of a product of two candidates.
const MAX_FACTORS: usize = 2 * MAX_DEGREE;

/// Bits of a factor's channel: 1 is the output, i + 2 input i; 0 marks an unused place.
const CHANNEL_BITS: u32 = 7;
/// Bits of a factor: its lag, then its channel.
const FACTOR_BITS: u32 = 21;
const FACTOR_MASK: u128 = (1 << FACTOR_BITS) - 1;
/// A lag of one sample in each of the places.
const ONE_LAG_EACH: u128 = {
    let (mut ones, mut place) = (0, 0);
    while place < MAX_FACTORS as u32 {
        ones |= 1 << (place * FACTOR_BITS + CHANNEL_BITS);
        place += 1;
    }
    ones
};

const _: () = assert!(FACTOR_BITS as usize * MAX_FACTORS <= 128);
const _: () = assert!((MAX_LAG as u32) < 1 << (FACTOR_BITS - CHANNEL_BITS));
const _: () = assert!((MAX_INPUT as u32) + 2 < 1 << CHANNEL_BITS);

/// A product of delayed samples, sorted by lag, then channel, packed from the lowest bits up.
///
/// One number rather than a list: ten lags to degree 2 make 2,279 products, and every fit must find the equal ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Product(u128);

impl Product {
    /// The product of two monomials of at most [`MAX_DEGREE`] factors each.
    pub(crate) fn of(a: &[Factor], b: &[Factor]) -> Self {
        let mut packed = [0; MAX_FACTORS];
        let packed = &mut packed[..a.len() + b.len()];
        for (place, factor) in packed.iter_mut().zip(a.iter().chain(b)) {
            let channel = match factor.channel {
                Channel::Output => 1,
                Channel::Input(i) => u32::from(i) + 2,
            };
            *place = u32::from(factor.lag) << CHANNEL_BITS | channel;
        }
        packed.sort_unstable();
        Self(packed.iter().rev().fold(0, |product, factor| product << FACTOR_BITS | u128::from(*factor)))
    }

    pub(super) fn degree(self) -> u32 {
        (u128::BITS - self.0.leading_zeros()).div_ceil(FACTOR_BITS)
    }

    /// Returns (column of the signals, lag) of each factor, lags ascending. Column 0 is the output.
    pub(super) fn factors(self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.degree()).map(move |i| {
            let factor = (self.0 >> (i * FACTOR_BITS) & FACTOR_MASK) as usize;
            ((factor & ((1 << CHANNEL_BITS) - 1)) - 1, factor >> CHANNEL_BITS)
        })
    }

    /// Largest lag, 0 for the empty product.
    pub(super) fn max_lag(self) -> usize {
        self.factors().last().map_or(0, |(_, lag)| lag)
    }

    /// Returns the shape whose smallest lag is 0, and the shift a with p(n) = shape(n − a).
    pub(super) fn normalised(self) -> (Self, usize) {
        let shift = (self.0 & FACTOR_MASK) >> CHANNEL_BITS;
        let one_per_factor = ONE_LAG_EACH & ((1 << (self.degree() * FACTOR_BITS)) - 1);
        (Self(self.0 - shift * one_per_factor), shift as usize)
    }

    /// Splits a shape in the middle: shape(n) = left(n)·right(n − shift), both halves shapes themselves.
    ///
    /// A half has at most [`MAX_DEGREE`] factors, so few halves make many products.
    pub(super) fn halves(self) -> (Self, Self, usize) {
        let middle = self.degree() / 2 * FACTOR_BITS;
        let (right, shift) = Self(self.0 >> middle).normalised();
        (Self(self.0 & ((1 << middle) - 1)), right, shift)
    }

    /// Returns the product's value at row `n`: Π signals[c][n − lag].
    pub(super) fn at(self, signals: &[&[f64]], n: usize) -> f64 {
        self.factors().map(|(column, lag)| signals[column][n - lag]).product()
    }

    /// Writes the product's values at `rows` into `out` of the same length.
    ///
    /// Inlined, so that inside the moment kernel it is compiled for the instruction set chosen there.
    #[inline(always)]
    pub(crate) fn fill(self, signals: &[&[f64]], rows: Range<usize>, out: &mut [f64]) {
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
        assert_eq!((shape.max_lag(), shape.degree()), (3, 3));

        let (left, right, apart) = shape.halves();
        assert_eq!(left, Product::of(&[y(0)], &[]));
        assert_eq!(right, Product::of(&[y(0), u(0, 1)], &[]));
        assert_eq!(apart, 2);
    }

    #[test]
    fn distinguishes_products_by_length() {
        assert_ne!(Product::of(&[y(0)], &[]), Product::of(&[y(0)], &[y(0)]));
        assert_eq!(Product::of(&[], &[]).degree(), 0);
        assert_eq!(Product::of(&[], &[]).normalised(), (Product::of(&[], &[]), 0));
    }

    #[test]
    fn holds_six_factors_of_the_largest_lag_and_input() {
        let largest = u(MAX_INPUT, MAX_LAG);
        let product = Product::of(&[largest; 3], &[y(0), largest, largest]);
        let factors: Vec<_> = product.factors().collect();
        assert_eq!(factors[0], (0, 0));
        assert_eq!(factors[1..], [(usize::from(MAX_INPUT) + 1, usize::from(MAX_LAG)); 5]);
        let (left, right, shift) = product.halves();
        assert_eq!((left.degree(), right), (3, Product::of(&[u(MAX_INPUT, 0); 3], &[])));
        assert_eq!(shift, usize::from(MAX_LAG));
    }
}

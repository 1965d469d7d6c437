//! The terms of a model, compiled for the hot path.
//!
//! Order of evaluation, the same everywhere: p = 0 + t₁ + t₂ + …, r̂ = a0 + t₁ + t₂ + …, each term
//! ((c·f₁)·f₂)·f₃; within a part first all terms of degree 1, then 2, then 3, each in the order of the model.

use core::hint::cold_path;

use heapless::Vec;

use crate::history::Window;
use crate::{Channel, Factor, MAX_DEGREE, ModelError, Scalar, Term};

/// Largest degree of a term in this build.
pub(crate) const DEGREES: usize = if cfg!(feature = "products") { MAX_DEGREE } else { 1 };

/// Third factors of the cubic terms; empty without the feature `products`.
#[cfg(feature = "products")]
type Thirds<const TERMS: usize> = Vec<u16, TERMS>;
#[cfg(not(feature = "products"))]
type Thirds<const TERMS: usize> = Vec<u16, 0>;

/// A part of an axis' model, p or r̂: its constant and the number of its terms by degree.
#[derive(Debug, Clone)]
pub(crate) struct Part<R> {
    /// Initial value of the sum: 0 or a0.
    start: R,
    /// Terms of degree 1, 2 and 3.
    counts: [u16; MAX_DEGREE],
    /// Index of the first third factor of its cubic terms.
    first_third: u16,
    pub(crate) is_empty: bool,
    has_products: bool,
}

/// A term with its factors as places in the history. Third factors, which are rare, are stored in
/// [`Program::thirds`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Record<R> {
    coefficient: R,
    places: [u16; 2],
}

impl<R: Scalar> Record<R> {
    #[inline(always)]
    fn linear<const N: usize>(&self, sum: R::Sum, window: Window<'_, R, N>) -> R::Sum {
        let [a, _] = self.places;
        R::add_product(sum, self.coefficient, window.at(a))
    }

    #[inline(always)]
    fn quadratic<const N: usize>(&self, sum: R::Sum, window: Window<'_, R, N>) -> R::Sum {
        let [a, b] = self.places;
        R::add_product(sum, self.coefficient * window.at(a), window.at(b))
    }

    #[inline(always)]
    fn cubic<const N: usize>(&self, sum: R::Sum, third: u16, window: Window<'_, R, N>) -> R::Sum {
        let [a, b] = self.places;
        R::add_product(sum, self.coefficient * window.at(a) * window.at(b), window.at(third))
    }
}

/// The terms of all axes: for each axis the physical part, then the stochastic part.
#[derive(Debug, Clone)]
pub(crate) struct Program<R, const TERMS: usize> {
    records: Vec<Record<R>, TERMS>,
    /// Third factors of the cubic terms, in their order.
    thirds: Thirds<TERMS>,
}

/// Inputs and lags that the terms of an axis use.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Uses {
    /// Bit i is set if a term uses input i.
    pub(crate) inputs: u32,
    /// Longest lag, samples.
    pub(crate) depth: u16,
}

impl Uses {
    pub(crate) const NOTHING: Self = Self { inputs: 0, depth: 0 };

    fn add(&mut self, factor: Factor) {
        self.depth = self.depth.max(factor.lag);
        if let Channel::Input(input) = factor.channel {
            self.inputs |= 1_u32.checked_shl(u32::from(input)).unwrap_or(0);
        }
    }
}

/// Layout of a sample in the history: inputs first, then the remainders of the axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout {
    pub(crate) n_inputs: usize,
    pub(crate) n_axes: usize,
}

impl Layout {
    /// Number of places from the next write, the remainder of the first axis, back to `factor` of `axis`.
    fn back(&self, axis: usize, factor: Factor) -> usize {
        let lag = usize::from(factor.lag) * (self.n_inputs + self.n_axes);
        match factor.channel {
            Channel::Output => lag.saturating_sub(axis),
            Channel::Input(input) => lag + self.n_inputs.saturating_sub(usize::from(input)),
        }
    }
}

impl<R: Scalar, const TERMS: usize> Program<R, TERMS> {
    pub(crate) const fn new() -> Self {
        Self { records: Vec::new(), thirds: Vec::new() }
    }

    pub(crate) fn clear(&mut self) {
        self.records.clear();
        self.thirds.clear();
    }

    /// A part without terms, whose terms are [pushed](Self::push) next.
    pub(crate) fn part(&self, start: R) -> Part<R> {
        const { assert!(TERMS <= u16::MAX as usize, "at most 65535 terms") };
        let first_third = self.thirds.len() as u16;
        Part { start, counts: [0; MAX_DEGREE], first_third, is_empty: true, has_products: false }
    }

    /// Appends a term to the last part, for a history of `N` values. The terms of a part have ascending degrees.
    pub(crate) fn push<const N: usize>(
        &mut self,
        part: &mut Part<R>,
        term: &Term<R::Stored>,
        axis: usize,
        layout: Layout,
        uses: &mut Uses,
    ) -> Result<(), ModelError> {
        let mut places = [0; MAX_DEGREE];
        for (place, factor) in places.iter_mut().zip(term.factors()) {
            uses.add(*factor);
            let needed = layout.back(axis, *factor);
            let found = Window::<R, N>::place(needed);
            *place = found.ok_or(ModelError::LagTooDeep { axis, needed, capacity: N })?;
        }
        let [a, b, c] = places;
        let record = Record { coefficient: R::of(term.coefficient), places: [a, b] };
        let too_many = ModelError::TooManyTerms { capacity: TERMS };
        self.records.push(record).map_err(|_| too_many)?;
        let degree = term.factors().len();
        if DEGREES > 2 && degree > 2 {
            self.thirds.push(c).map_err(|_| too_many)?;
        }
        if let Some(count) = part.counts.get_mut(degree.wrapping_sub(1)) {
            *count += 1;
        }
        (part.is_empty, part.has_products) = (false, degree > 1);
        Ok(())
    }

    /// The records of all parts, in the order in which the parts were appended.
    #[inline(always)]
    pub(crate) fn records(&self) -> &[Record<R>] {
        &self.records
    }

    /// The third factors of all parts.
    #[inline(always)]
    pub(crate) fn thirds(&self) -> &[u16] {
        &self.thirds
    }
}

impl<R: Scalar> Part<R> {
    /// Returns the value of the part, whose records come first in `records`, and the records after it. With too few
    /// records, which cannot happen, it returns the constant.
    #[inline(always)]
    pub(crate) fn evaluate<'r, const N: usize>(
        &self,
        records: &'r [Record<R>],
        thirds: &[u16],
        window: Window<'_, R, N>,
    ) -> (R, &'r [Record<R>]) {
        let mut sum = self.start.begin();
        let [n_linear, ..] = self.counts;
        let Some((linear, rest)) = records.split_at_checked(usize::from(n_linear)) else {
            cold_path();
            return (R::end(sum), records);
        };
        // two at a time: most terms are linear, and the loop itself would be a quarter of their cost
        let (pairs, last) = linear.as_chunks::<2>();
        for [first, second] in pairs {
            sum = first.linear(sum, window);
            sum = second.linear(sum, window);
        }
        if let [last] = last {
            sum = last.linear(sum, window);
        }
        if DEGREES > 1 && self.has_products {
            self.products(sum, rest, thirds, window)
        } else {
            (R::end(sum), rest)
        }
    }

    /// Evaluates several histories, one per lane, each with the operations and order of [`evaluate`](Self::evaluate).
    #[cfg(feature = "coasts")]
    #[inline(always)]
    pub(crate) fn evaluate_lanes<'r, const LANES: usize, const N: usize>(
        &self,
        records: &'r [Record<R>],
        thirds: &[u16],
        window: Window<'_, [R; LANES], N>,
    ) -> ([R; LANES], &'r [Record<R>]) {
        let counts = self.counts.map(usize::from);
        let mut sum = [self.start.begin(); LANES];
        let mut left = records;
        let mut parts: [&[Record<R>]; MAX_DEGREE] = [&[]; MAX_DEGREE];
        for (part, count) in parts.iter_mut().zip(counts) {
            let Some((these, rest)) = left.split_at_checked(count) else { break };
            (*part, left) = (these, rest);
        }
        let [linear, quadratic, cubic] = parts;
        for Record { coefficient, places: [a, _] } in linear {
            let a = window.lanes(*a);
            for lane in 0..LANES {
                sum[lane] = R::add_product(sum[lane], *coefficient, a[lane]);
            }
        }
        for Record { coefficient, places: [a, b] } in quadratic {
            let (a, b) = (window.lanes(*a), window.lanes(*b));
            for lane in 0..LANES {
                sum[lane] = R::add_product(sum[lane], *coefficient * a[lane], b[lane]);
            }
        }
        let thirds = thirds.get(usize::from(self.first_third)..).unwrap_or(&[]);
        for (Record { coefficient, places: [a, b] }, third) in cubic.iter().zip(thirds) {
            let (a, b, c) = (window.lanes(*a), window.lanes(*b), window.lanes(*third));
            for lane in 0..LANES {
                sum[lane] = R::add_product(sum[lane], *coefficient * a[lane] * b[lane], c[lane]);
            }
        }
        (sum.map(R::end), left)
    }

    /// Adds the terms with more than one factor to `sum`; returns it with the records after them. Not inlined, so that its
    /// loops have all registers.
    #[inline(never)]
    fn products<'r, const N: usize>(
        &self,
        mut sum: R::Sum,
        records: &'r [Record<R>],
        thirds: &[u16],
        window: Window<'_, R, N>,
    ) -> (R, &'r [Record<R>]) {
        let [_, n_quadratic, n_cubic] = self.counts;
        let Some((quadratic, rest)) = records.split_at_checked(usize::from(n_quadratic)) else {
            return (R::end(sum), records);
        };
        for term in quadratic {
            sum = term.quadratic(sum, window);
        }
        let Some((cubic, rest)) = rest.split_at_checked(usize::from(n_cubic)) else {
            return (R::end(sum), rest);
        };
        let thirds = thirds.get(usize::from(self.first_third)..).unwrap_or(&[]);
        for (term, third) in cubic.iter().zip(thirds) {
            sum = term.cubic(sum, *third, window);
        }
        (R::end(sum), rest)
    }
}

//! The terms of a model, compiled to what the hot path needs and nothing else.
//!
//! Order of evaluation, the same everywhere: p = 0 + t₁ + t₂ + …, r̂ = a0 + t₁ + t₂ + …, each term
//! ((c·f₁)·f₂)·f₃; within a part first all terms of degree 1, then 2, then 3, each in the order of the model.

use heapless::Vec;

use crate::history::Window;
use crate::{Channel, Factor, MAX_DEGREE, ModelError, Real, Term};

/// A part of an axis' model, p or r̂: which of the terms it has, and its value at this tick.
#[derive(Debug, Clone)]
pub(crate) struct Part<R> {
    /// The sum begins with it: 0 or a0.
    start: R,
    // first those of degree 1, then 2, then 3
    n_linear: u16,
    n_quadratic: u16,
    n_cubic: u16,
    pub(crate) is_empty: bool,
    has_products: bool,
    pub(crate) value: R,
}

/// A term whose factors are places in the history.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CompiledTerm<R> {
    coefficient: R,
    places: [u16; MAX_DEGREE],
}

impl<R: Real> CompiledTerm<R> {
    #[inline(always)]
    fn linear<const N: usize>(&self, window: Window<'_, R, N>) -> R {
        let [a, _, _] = self.places;
        self.coefficient * window.at(a)
    }
}

/// The terms of all axes: of each axis the physical part, then the stochastic part.
#[derive(Debug, Clone)]
pub(crate) struct Program<R, const TERMS: usize> {
    terms: Vec<CompiledTerm<R>, TERMS>,
}

/// Where a sample's values lie in the history: inputs first, then the remainders of the axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout {
    pub(crate) n_inputs: usize,
    pub(crate) n_axes: usize,
}

impl Layout {
    /// Places from the remainder of the first axis, about to be written, back to `factor` of `axis`.
    fn back(&self, axis: usize, factor: Factor) -> usize {
        let lag = usize::from(factor.lag) * (self.n_inputs + self.n_axes);
        match factor.channel {
            Channel::Output => lag.saturating_sub(axis),
            Channel::Input(input) => lag + self.n_inputs.saturating_sub(usize::from(input)),
        }
    }
}

impl<R: Real, const TERMS: usize> Program<R, TERMS> {
    pub(crate) const fn new() -> Self {
        Self { terms: Vec::new() }
    }

    pub(crate) fn clear(&mut self) {
        self.terms.clear();
    }

    /// Appends the terms of a part, for a history of `N` values.
    pub(crate) fn append<const N: usize>(
        &mut self,
        start: R,
        terms: impl Iterator<Item = Term<R>> + Clone,
        axis: usize,
        layout: Layout,
    ) -> Result<Part<R>, ModelError> {
        let too_many = ModelError::TooManyTerms { capacity: TERMS };
        let mut counts = [0_u16; MAX_DEGREE];
        for (count, degree) in counts.iter_mut().zip(1..) {
            for term in terms.clone().filter(|term| term.factors().len() == degree) {
                let mut places = [0; MAX_DEGREE];
                for (place, factor) in places.iter_mut().zip(term.factors()) {
                    let needed = layout.back(axis, *factor);
                    let found = Window::<R, N>::place(needed);
                    *place = found.ok_or(ModelError::LagTooDeep { axis, needed, capacity: N })?;
                }
                let compiled = CompiledTerm { coefficient: term.coefficient, places };
                self.terms.push(compiled).map_err(|_| too_many)?;
                *count = count.checked_add(1).ok_or(too_many)?;
            }
        }
        let [n_linear, n_quadratic, n_cubic] = counts;
        let has_products = n_quadratic > 0 || n_cubic > 0;
        let is_empty = n_linear == 0 && !has_products;
        Ok(Part { start, n_linear, n_quadratic, n_cubic, is_empty, has_products, value: start })
    }

    /// The terms of all parts, in the order in which the parts were appended.
    #[inline(always)]
    pub(crate) fn terms(&self) -> &[CompiledTerm<R>] {
        &self.terms
    }
}

impl<R: Real> Part<R> {
    /// Evaluates the part, whose terms are the first of `terms`, and returns those after it; were they too few, it
    /// would keep its value.
    #[inline(always)]
    pub(crate) fn evaluate<'t, const N: usize>(
        &mut self,
        terms: &'t [CompiledTerm<R>],
        window: Window<'_, R, N>,
    ) -> &'t [CompiledTerm<R>] {
        if self.is_empty {
            return terms;
        }
        let mut sum = self.start;
        let Some((linear, mut rest)) = terms.split_at_checked(usize::from(self.n_linear)) else {
            return terms;
        };
        // four at a time: most terms are linear, and the loop itself would be a quarter of their cost
        let (fours, left) = linear.as_chunks::<4>();
        for [first, second, third, fourth] in fours {
            sum = sum + first.linear(window);
            sum = sum + second.linear(window);
            sum = sum + third.linear(window);
            sum = sum + fourth.linear(window);
        }
        for term in left {
            sum = sum + term.linear(window);
        }
        if self.has_products {
            (sum, rest) = self.products(sum, rest, window);
        }
        self.value = sum;
        rest
    }

    /// `sum` and the terms with more than one factor, and the terms after them. A function of its own, so that its
    /// loops have the registers to themselves.
    #[inline(never)]
    fn products<'t, const N: usize>(
        &self,
        mut sum: R,
        terms: &'t [CompiledTerm<R>],
        window: Window<'_, R, N>,
    ) -> (R, &'t [CompiledTerm<R>]) {
        let Some((quadratic, rest)) = terms.split_at_checked(usize::from(self.n_quadratic)) else {
            return (sum, terms);
        };
        for term in quadratic {
            let [a, b, _] = term.places;
            sum = sum + term.coefficient * window.at(a) * window.at(b);
        }
        let Some((cubic, rest)) = rest.split_at_checked(usize::from(self.n_cubic)) else {
            return (sum, rest);
        };
        for term in cubic {
            let [a, b, c] = term.places;
            sum = sum + term.coefficient * window.at(a) * window.at(b) * window.at(c);
        }
        (sum, rest)
    }
}

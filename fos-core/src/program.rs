//! The terms of a model, compiled to what the hot path needs and nothing else.
//!
//! Order of evaluation, the same everywhere: p = 0 + t₁ + t₂ + …, r̂ = a0 + t₁ + t₂ + …, each term
//! ((c·f₁)·f₂)·f₃; within a part first all terms of degree 1, then 2, then 3, each in the order of the model.

use heapless::Vec;

use crate::history::History;
use crate::{Channel, Factor, ModelError, Real, Term};

/// A term whose factors are how far to reach back in the history.
#[derive(Debug, Clone, Copy)]
struct CompiledTerm<R> {
    coefficient: R,
    back: [u16; 3],
}

/// How many terms of degree 1, 2 and 3 a part has.
pub(crate) type Degrees = [u16; 3];

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
    /// Places from the remainder of `axis`, about to be written, back to `factor`.
    fn back(&self, axis: usize, factor: Factor) -> usize {
        let to_channel = match factor.channel {
            Channel::Output => 0,
            Channel::Input(input) => (self.n_inputs + axis).saturating_sub(usize::from(input)),
        };
        to_channel + usize::from(factor.lag) * (self.n_inputs + self.n_axes)
    }
}

impl<R: Real, const TERMS: usize> Program<R, TERMS> {
    pub(crate) const fn new() -> Self {
        Self { terms: Vec::new() }
    }

    /// Appends those of `terms` that have `degree`; returns how many.
    pub(crate) fn append(
        &mut self,
        terms: impl Iterator<Item = Term<R>>,
        degree: usize,
        axis: usize,
        layout: Layout,
        capacity: usize,
    ) -> Result<u16, ModelError> {
        let mut appended = 0;
        for term in terms.filter(|term| term.factors().len() == degree) {
            let mut back = [0; 3];
            for (back, factor) in back.iter_mut().zip(term.factors()) {
                let needed = layout.back(axis, *factor);
                *back = match u16::try_from(needed) {
                    Ok(back) if needed <= capacity => back,
                    _ => return Err(ModelError::LagTooDeep { axis, needed, capacity }),
                };
            }
            let compiled = CompiledTerm { coefficient: term.coefficient, back };
            self.terms.push(compiled).map_err(|_| ModelError::TooManyTerms { capacity: TERMS })?;
            appended += 1;
        }
        Ok(appended)
    }

    /// All terms, to be taken part by part in their order.
    #[inline]
    pub(crate) fn terms(&self) -> Remaining<'_, R> {
        Remaining(&self.terms)
    }
}

/// The terms that have not been evaluated in this tick.
pub(crate) struct Remaining<'a, R>(&'a [CompiledTerm<R>]);

impl<'a, R: Real> Remaining<'a, R> {
    #[inline]
    fn take(&mut self, count: u16) -> &'a [CompiledTerm<R>] {
        // the counts add up to the length; were they wrong, nothing would be evaluated rather than a panic
        let (taken, rest) = self.0.split_at_checked(usize::from(count)).unwrap_or((&[], &[]));
        self.0 = rest;
        taken
    }

    /// `start` plus the next part's terms.
    #[inline]
    pub(crate) fn sum<const N: usize>(&mut self, start: R, degrees: Degrees, history: &History<R, N>) -> R {
        let [linear, quadratic, cubic] = degrees;
        let mut sum = start;
        for term in self.take(linear) {
            sum = sum + term.coefficient * history.back(term.back[0]);
        }
        if quadratic != 0 {
            for term in self.take(quadratic) {
                sum = sum + term.coefficient * history.back(term.back[0]) * history.back(term.back[1]);
            }
        }
        if cubic != 0 {
            for term in self.take(cubic) {
                let [a, b, c] = term.back;
                sum = sum + term.coefficient * history.back(a) * history.back(b) * history.back(c);
            }
        }
        sum
    }
}

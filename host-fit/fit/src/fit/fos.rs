//! Fast orthogonal search on the Gram matrix.
//!
//! Korenberg, "A robust orthogonal algorithm for system identification and time-series analysis", Biological
//! Cybernetics 60 (1989) 267. The model is y(n) = Σ a_m p_m(n) + e(n) (paper eq. 13), p_0 = 1. The orthogonal
//! functions w_m are never formed; with averages ⟨·⟩ over the rows, only
//!
//! ```text
//!   D(0,0) = 1         D(m,0) = ⟨p_m⟩         C(0) = ⟨y⟩                      (1)
//!   α(m,r) = D(m,r) / D(r,r)                                                  (2)
//!   D(m,r) = ⟨p_m p_r⟩ − Σ_{i<r} α(r,i) D(m,i)                                (3)   = ⟨p_m w_r⟩
//!   D(m,m) = ⟨p_m²⟩ − Σ_{i<m} α(m,i) D(m,i)                                   (4)   = ⟨w_m²⟩
//!   C(m)   = ⟨y p_m⟩ − Σ_{r<m} α(m,r) C(r)                                    (5)   = ⟨y w_m⟩
//!   g_m = C(m)/D(m,m)        Q_m = g_m² D(m,m)                                (6)
//!   MSE = ⟨y²⟩ − Σ Q_m                                                        (7)
//!   a_m = Σ_{i≥m} g_i v_i,   v_m = 1,   v_i = −Σ_{m≤r<i} α(i,r) v_r           (8)
//! ```
//!
//! Differences from the textbook: averages come from the Gram matrix, and every candidate keeps its D(m,·), so a step
//! costs M·K multiply-adds for M candidates and K terms, independent of the length of the record. D(m,r)/√D(r,r) is a
//! row of the Cholesky factor of the Gram matrix of the terms.

use super::stop::{StopRule, Stopped};
use crate::moments::Gram;

/// Smallest D(m,m)/⟨p_m²⟩ of a candidate that may be chosen; below it the candidate is collinear with the
/// terms.
///
/// (4) and its sums have a rounding error of some 10⁻¹⁵ of ⟨p_m²⟩, which 10⁻¹² keeps below 0.1 % of D(m,m). It is
/// relative to ⟨p_m²⟩ before the mean is subtracted, because the rounding is; and to each candidate's own, because a
/// square in small units is a small number but a valid candidate.
pub const COLLINEAR: f64 = 1e-12;

/// Rounding error of an entry of the Gram matrix and of the sums of the recursion, relative to the root mean squares of
/// the two factors of a product.
const ROUNDING: f64 = 1e-15;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    pub candidate: usize,
    /// Q: reduction of the mean square error, unit of y².
    pub mse_reduction: f64,
    /// Mean square error with this term, by (7). The refit computes it from residuals.
    pub mse: f64,
}

/// Result of a search: the chosen terms in order, and the reason why it stopped.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection {
    /// Terms in the order chosen.
    pub steps: Vec<Step>,
    /// Reason why the search stopped.
    pub stopped: Stopped,
    /// Mean square error of the constant alone, which is the variance of y.
    pub initial_mse: f64,
}

impl Selection {
    /// Indices of the chosen candidates, in order.
    pub fn candidates(&self) -> impl Iterator<Item = usize> {
        self.steps.iter().map(|step| step.candidate)
    }
}

/// A candidate not yet chosen, with its part of the recursion.
pub(super) struct Open {
    pub(super) candidate: usize,
    /// D(m,0), D(m,1), … for the terms so far.
    d: Vec<f64>,
    /// D(m,m) if it were chosen next.
    pub(super) dmm: f64,
    /// C(m).
    pub(super) c: f64,
}

impl Open {
    /// Equations (2) to (5) for term r, whose own D(r,·) is `d_r`.
    fn orthogonalise(&mut self, product: f64, d_r: &[f64], d_rr: &[f64], c_r: f64) {
        let r = d_r.len();
        let d = product - (0..r).map(|i| d_r[i] / d_rr[i] * self.d[i]).sum::<f64>();
        let alpha = d / d_rr[r];
        self.dmm -= alpha * d;
        self.c -= alpha * c_r;
        self.d.push(d);
    }

    /// Q of (6).
    pub(super) fn mse_reduction(&self) -> f64 {
        self.c * self.c / self.dmm
    }
}

/// Chooses terms from the pool of a Gram matrix, each time the one with the largest Q, until `rule` stops.
///
/// Equal Q go to the candidate that comes first in the pool.
pub fn search(gram: &Gram, rule: &StopRule) -> Selection {
    Expansion::from_constant(gram).run(rule)
}

/// Terms chosen so far, with the state for choosing the next.
pub(super) struct Expansion<'g> {
    gram: &'g Gram,
    factor: Factorisation,
    steps: Vec<Step>,
    open: Vec<Open>,
}

impl<'g> Expansion<'g> {
    pub(super) fn from_constant(gram: &'g Gram) -> Self {
        let factor = Factorisation::from_constant(gram);
        let open = (0..gram.size()).map(|candidate| {
            let mut open = Open {
                candidate,
                d: vec![],
                dmm: gram.product(candidate, candidate),
                c: gram.target_product(candidate),
            };
            factor.orthogonalise(&mut open, gram.mean(candidate));
            open
        });
        let mut expansion = Self { gram, open: open.collect(), factor, steps: Vec::new() };
        expansion.exclude_collinear();
        expansion
    }

    /// Returns the constant and `terms`, added in the order of their Q; those collinear with others are excluded.
    pub(super) fn from_terms(gram: &'g Gram, terms: &[usize]) -> Self {
        let mut expansion = Self::from_constant(gram);
        // terminates: each iteration adds one of `terms`, which is then no longer open
        while let Some(best) = expansion.best(|candidate| terms.contains(&candidate)) {
            expansion.take(best);
        }
        expansion
    }

    /// Mean square error by (7).
    pub(super) fn mse(&self) -> f64 {
        self.steps.last().map_or(self.gram.target_variance(), |step| step.mse)
    }

    /// The candidates chosen, in order.
    pub(super) fn candidates(&self) -> impl Iterator<Item = usize> {
        self.steps.iter().map(|step| step.candidate)
    }

    /// Rounding error of (7). The MSE is a quadratic form in the Gram matrix, vᵀGv with v = (1, −a_0, …, −a_K) for y
    /// and the terms. The factorisation is exact for a matrix whose entries differ by [`ROUNDING`] (backward stability;
    /// Higham 2002, theorem 10.3). Near-collinear terms have large weights of opposite sign: the error can then be many
    /// times the MSE.
    pub(super) fn rounding(&self) -> f64 {
        let weights = self.factor.weights();
        let constant = weights[0].abs();
        let sizes =
            self.candidates().zip(&weights[1..]).map(|(i, a)| a.abs() * self.gram.product(i, i).sqrt());
        let sum = self.gram.target_mean_square().sqrt() + constant + sizes.sum::<f64>();
        ROUNDING * sum * sum
    }

    /// Returns the candidates that are neither chosen nor collinear with the chosen ones.
    pub(super) fn open(&self) -> &[Open] {
        &self.open
    }

    /// Returns ⟨p_a p_b⟩ after all chosen terms are projected out of both.
    pub(super) fn residual_product(&self, a: &Open, b: &Open) -> f64 {
        let taken = a.d.iter().zip(&b.d).zip(&self.factor.diagonal).map(|((a, b), d_rr)| a * b / d_rr);
        self.gram.product(a.candidate, b.candidate) - taken.sum::<f64>()
    }

    /// Chooses further terms until `rule` stops.
    pub(super) fn run(mut self, rule: &StopRule) -> Selection {
        let worth = rule.worth(self.gram);
        // terminates: each iteration adds a term, up to `max_terms`
        let stopped = loop {
            fos_data::interrupt::check();
            let mse = self.mse();
            if worth.is_exact(mse) {
                break Stopped::Exact;
            }
            if self.steps.len() >= rule.max_terms {
                break Stopped::MaxTerms;
            }
            let Some(best) = self.best(|_| true) else {
                break Stopped::NothingLeft;
            };
            let (candidate, mse_reduction) = (self.open[best].candidate, self.open[best].mse_reduction());
            if !worth.takes(mse_reduction, mse) {
                break Stopped::Noise { candidate, mse_reduction, needed: worth.needed(mse) };
            }
            self.take(best);
        };
        self.stopped(stopped)
    }

    /// Finishes the search and returns the selection.
    pub(super) fn stopped(self, stopped: Stopped) -> Selection {
        Selection { steps: self.steps, stopped, initial_mse: self.gram.target_variance() }
    }

    /// Returns the index of the open candidate with the largest Q among the `offered` ones, the first of equals.
    fn best(&self, offered: impl Fn(usize) -> bool) -> Option<usize> {
        let larger = |best: usize, i: usize| {
            if self.open[i].mse_reduction() > self.open[best].mse_reduction() { i } else { best }
        };
        (0..self.open.len()).filter(|i| offered(self.open[*i].candidate)).reduce(larger)
    }

    /// Makes an open candidate the next term.
    fn take(&mut self, index: usize) {
        let mse = self.mse();
        let chosen = self.open.remove(index);
        let (candidate, mse_reduction) = (chosen.candidate, chosen.mse_reduction());
        self.factor.push(chosen);
        for m in &mut self.open {
            self.factor.orthogonalise(m, self.gram.product(m.candidate, candidate));
        }
        self.steps.push(Step { candidate, mse_reduction, mse: mse - mse_reduction });
        self.exclude_collinear();
    }

    fn exclude_collinear(&mut self) {
        let gram = self.gram;
        self.open.retain(|m| m.dmm > COLLINEAR * gram.product(m.candidate, m.candidate));
    }
}

/// State of the recursion for the terms chosen so far, the constant first.
struct Factorisation {
    /// D(m,0), …, D(m,m−1) of each term.
    d: Vec<Vec<f64>>,
    /// D(m,m) of each term.
    diagonal: Vec<f64>,
    /// C(m) of each term.
    c: Vec<f64>,
}

impl Factorisation {
    /// Equation (1).
    fn from_constant(gram: &Gram) -> Self {
        Self { d: vec![vec![]], diagonal: vec![1.0], c: vec![gram.target_mean()] }
    }

    fn push(&mut self, chosen: Open) {
        self.d.push(chosen.d);
        self.diagonal.push(chosen.dmm);
        self.c.push(chosen.c);
    }

    /// Projects the newest term out of a candidate; `product` is their ⟨p_m p_r⟩.
    fn orthogonalise(&self, open: &mut Open, product: f64) {
        let newest = self.c.len() - 1;
        open.orthogonalise(product, &self.d[newest], &self.diagonal, self.c[newest]);
    }

    /// Equation (8).
    fn weights(&self) -> Vec<f64> {
        let terms = self.c.len();
        let weight = |m: usize| {
            let mut v = vec![0.0; terms];
            v[m] = 1.0;
            for i in m + 1..terms {
                v[i] = -(m..i).map(|r| self.d[i][r] / self.diagonal[r] * v[r]).sum::<f64>();
            }
            (m..terms).map(|i| self.c[i] / self.diagonal[i] * v[i]).sum()
        };
        (0..terms).map(weight).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::single_range_in_vec_init, reason = "a list of one segment")]

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::candidates::Candidates;
    use crate::fit::Stop;
    use crate::moments::{Moments, Rows};

    #[test]
    fn the_recursion_is_the_cholesky_factor_of_the_chosen_terms() {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let output: Vec<f64> = (0..900).map(|_| random.random::<f64>() - 0.4).collect();
        let pool = Candidates::builder().output(1..=5, 2).build().unwrap();
        let rows = Rows::usable(&[&output], &[0..900], pool.factors());
        let gram = Moments::accumulate(&[&output], &rows, &pool).gram().unwrap();
        let rule = StopRule { max_terms: 12, stop: Stop::Never };
        let chosen: Vec<usize> = search(&gram, &rule).candidates().collect();
        let recursion = Expansion::from_terms(&gram, &chosen).factor;

        let entry = |i: usize, j: usize| match (i.checked_sub(1), j.checked_sub(1)) {
            (None, None) => 1.0,
            (Some(m), None) | (None, Some(m)) => gram.mean(chosen[m]),
            (Some(m), Some(r)) => gram.product(chosen[m], chosen[r]),
        };
        let cholesky = nalgebra::DMatrix::from_fn(13, 13, entry).cholesky().unwrap();
        let target =
            |m: usize| m.checked_sub(1).map_or(gram.target_mean(), |m| gram.target_product(chosen[m]));
        let solved = cholesky.solve(&nalgebra::DVector::from_fn(13, |m, _| target(m)));
        for (ours, weight) in recursion.weights().iter().zip(&solved) {
            assert!((ours - weight).abs() < 1e-12, "(8): {ours} for {weight}");
        }
        let cholesky = cholesky.l();
        for m in 0..13 {
            assert!((cholesky[(m, m)] - recursion.diagonal[m].sqrt()).abs() < 1e-14);
            for r in 0..m {
                let ours = recursion.d[m][r] / recursion.diagonal[r].sqrt();
                // averages of magnitude below 1, condition below 100
                assert!((cholesky[(m, r)] - ours).abs() < 1e-14, "{m} {r}");
            }
        }
    }
}

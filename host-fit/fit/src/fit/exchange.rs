//! Exchange refinement: terms of a greedy search are swapped, one or two at a time, until no swap helps.
//!
//! The greedy search never removes a term, though two later ones may make it worthless: on a known system with the
//! products r(n−1)·r(n−2) and r(n−3)² it chooses r(n−4)·r(n−10) and r(n−1)², each the best when it was chosen. A pair
//! is found only by trying pairs. All is computed from the Gram matrix, so that a swap costs M·K multiply-adds and no
//! pass over the data.
//!
//! [`refine`] alternates three moves until none changes anything:
//!
//! 1. *exchange*: one term for one, then two for two, while the MSE decreases;
//! 2. *prune*: a term that the stop rule would not have accepted is removed;
//! 3. *extend*: the greedy search continues from there.
//!
//! It terminates because every move lowers the cost of the set of terms (`Worth::cost`: ln MSE plus a penalty per
//! term). The cost depends on the set alone, so no set occurs twice, and there are finitely many. The decrease must be
//! checked, since it does not follow from the rules of the moves: they use Q of (6), and for nearly collinear terms,
//! such as the lags of a smooth signal, the Q of one term differs from the difference of two MSE of (7) by more than
//! the threshold of the stop rule. For the same reason the gain of a move must exceed the rounding error of the MSE:
//! smaller gains are not significant and would lead through equivalent sets.

use super::fos::{COLLINEAR, Expansion, Open, Selection};
use super::stop::{EXACT, StopRule, Stopped, Worth};
use crate::moments::Gram;

/// Smallest relative decrease of the MSE that justifies a swap: above rounding, below any significant change.
const WORTH: f64 = 1e-9;

/// Largest number of moves. The argument above bounds them only by the number of sets; on data of every kind there are
/// ten or fewer, and a thousand would take hours.
const MAX_MOVES: usize = 1000;

/// Largest number of indistinguishable models that are listed.
const MAX_TIES: usize = 10;

/// Threshold of n·ln(MSE ratio) below which two models of the same size count as tied: the 95 % point of a chi-square
/// variable with one degree of freedom, the chance gain of one more parameter.
pub const TIED: f64 = 3.841;

/// A model of the same size that is indistinguishable from the chosen one.
#[derive(Debug, Clone, PartialEq)]
pub struct Tie {
    /// Candidates of the chosen model that it lacks, in order of the pool.
    pub leaves: Vec<usize>,
    /// Candidates that it has instead.
    pub enters: Vec<usize>,
    /// n·ln(its MSE / MSE of the chosen model).
    pub deviance: f64,
}

/// Refines the selection of a greedy search under `rule`.
pub fn refine(gram: &Gram, rule: &StopRule, greedy: Selection) -> Selection {
    refine_within(MAX_MOVES, gram, rule, greedy).0
}

/// Refines with at most this many moves; also returns their number.
pub(super) fn refine_within(
    most: usize,
    gram: &Gram,
    rule: &StopRule,
    greedy: Selection,
) -> (Selection, usize) {
    let mut model = Model::of(gram, rule.worth(gram), greedy.candidates().collect());
    let mut selection = greedy;
    let mut moves = 0;
    loop {
        let before = moves;
        while let Some(better) = model.improved() {
            if moves == most {
                return (model.expansion().stopped(Stopped::MostMoves), moves);
            }
            model = better;
            moves += 1;
        }
        if moves == before {
            return (selection, moves);
        }
        let extended = model.expansion().run(rule);
        if extended.steps.len() == model.terms.len() {
            return (extended, moves);
        }
        let wider = Model::of(gram, model.worth, extended.candidates().collect());
        if !model.is_beaten_by(&wider) {
            return (model.expansion().stopped(Stopped::Rounding), moves);
        }
        (model, selection) = (wider, extended);
        moves += 1;
    }
}

/// Returns the models of the same size, one or two swaps away, that are indistinguishable from `terms`, best first.
pub fn ties(gram: &Gram, terms: &[usize]) -> Vec<Tie> {
    let expansion = Expansion::from_terms(gram, terms);
    let (mse, rounding) = (expansion.mse(), expansion.rounding());
    let rows = gram.rows() as f64;
    if mse <= EXACT * gram.target_mean_square() || rows * (rounding / mse).ln_1p() > TIED {
        return Vec::new(); // rounding error is no evidence either way
    }
    let mut found: Vec<Tie> = Vec::new();
    let mut list = |leaves: &[usize], enters: &[usize], swapped_mse: f64| {
        let deviance = rows * (swapped_mse / mse).ln();
        if deviance < TIED {
            let (mut leaves, mut enters) = (leaves.to_vec(), enters.to_vec());
            leaves.sort_unstable();
            enters.sort_unstable();
            found.push(Tie { leaves, enters, deviance });
        }
    };
    for_each_single(gram, terms, &mut list);
    for_each_pair(gram, terms, &mut list);
    found.sort_by(|a, b| a.deviance.total_cmp(&b.deviance));
    found.truncate(MAX_TIES);
    found
}

/// Receives a swap: the terms that leave, those that enter, and the resulting MSE.
type Visit<'v> = &'v mut dyn FnMut(&[usize], &[usize], f64);

/// Visits every swap of a kind.
type ForEachSwap = fn(&Gram, &[usize], Visit<'_>);

/// A set of terms and its cost.
struct Model<'g> {
    gram: &'g Gram,
    worth: Worth,
    /// Terms, without those collinear with others of the set.
    terms: Vec<usize>,
    mse: f64,
    /// Rounding error of the MSE.
    rounding: f64,
}

impl<'g> Model<'g> {
    fn of(gram: &'g Gram, worth: Worth, terms: Vec<usize>) -> Self {
        let expansion = Expansion::from_terms(gram, &terms);
        let (mse, rounding) = (expansion.mse(), expansion.rounding());
        Self { gram, worth, terms: expansion.candidates().collect(), mse, rounding }
    }

    fn with_terms(&self, terms: Vec<usize>) -> Self {
        Self::of(self.gram, self.worth, terms)
    }

    fn expansion(&self) -> Expansion<'g> {
        Expansion::from_terms(self.gram, &self.terms)
    }

    fn cost(&self) -> f64 {
        self.worth.cost(self.mse, self.terms.len())
    }

    /// Returns true if `other` costs less, for any rounding of both MSE.
    fn is_beaten_by(&self, other: &Self) -> bool {
        let at_most = other.worth.cost(other.mse + other.rounding, other.terms.len());
        at_most < self.worth.cost(self.mse - self.rounding, self.terms.len())
    }

    /// Returns the model after the first kind of move that lowers the cost.
    fn improved(&self) -> Option<Self> {
        fos_data::interrupt::check();
        // pairs last: they take the longest, and fewer terms make fewer pairs
        self.exchanged(for_each_single).or_else(|| self.pruned()).or_else(|| self.exchanged(for_each_pair))
    }

    /// Returns the model after the best swap of a kind, if one is worth it.
    fn exchanged(&self, for_each_swap: ForEachSwap) -> Option<Self> {
        if self.worth.is_exact(self.mse) {
            return None;
        }
        let mut best = self.mse * (1.0 - WORTH);
        let mut swap = None;
        for_each_swap(self.gram, &self.terms, &mut |leaves, enters, swapped_mse| {
            if swapped_mse < best {
                best = swapped_mse;
                swap = Some((leaves.to_vec(), enters.to_vec()));
            }
        });
        let (leaves, enters) = swap?;
        let mut terms = without(&self.terms, &leaves);
        terms.extend(enters);
        Some(self.with_terms(terms)).filter(|swapped| self.is_beaten_by(swapped))
    }

    /// Returns the model without the least significant term, if the rule would not have accepted it. Of two sets within
    /// rounding of each other this is the smaller, so that a lower cost suffices.
    fn pruned(&self) -> Option<Self> {
        let without_each = self.terms.iter().map(|&term| without(&self.terms, &[term]));
        let least = without_each
            .map(|terms| (Expansion::from_terms(self.gram, &terms).mse(), terms))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let (mse, terms) = least?;
        let is_taken = self.worth.takes(mse - self.mse, mse);
        Some(self.with_terms(terms)).filter(|pruned| !is_taken && pruned.cost() < self.cost())
    }
}

/// Visits every swap of one term for one candidate.
fn for_each_single(gram: &Gram, terms: &[usize], visit: Visit<'_>) {
    for &leaves in terms {
        fos_data::interrupt::check();
        let base = Expansion::from_terms(gram, &without(terms, &[leaves]));
        for open in base.open().iter().filter(|open| open.candidate != leaves) {
            visit(&[leaves], &[open.candidate], base.mse() - open.mse_reduction());
        }
    }
}

/// Visits every swap of two terms for two candidates.
fn for_each_pair(gram: &Gram, terms: &[usize], visit: Visit<'_>) {
    for (i, &first) in terms.iter().enumerate() {
        for &second in &terms[i + 1..] {
            fos_data::interrupt::check();
            let leaves = [first, second];
            let base = Expansion::from_terms(gram, &without(terms, &leaves));
            let open: Vec<&Open> =
                base.open().iter().filter(|open| !leaves.contains(&open.candidate)).collect();
            for (place, a) in open.iter().enumerate() {
                for b in &open[..place] {
                    if let Some(reduction) = joint_reduction(gram, &base, a, b) {
                        visit(&leaves, &[b.candidate, a.candidate], base.mse() - reduction);
                    }
                }
            }
        }
    }
}

fn without(terms: &[usize], leaves: &[usize]) -> Vec<usize> {
    terms.iter().copied().filter(|term| !leaves.contains(term)).collect()
}

/// Reduction of the MSE by two candidates together; `None` if they are collinear.
fn joint_reduction(gram: &Gram, base: &Expansion<'_>, a: &Open, b: &Open) -> Option<f64> {
    let d_ab = base.residual_product(a, b);
    let dmm = b.dmm - d_ab * d_ab / a.dmm;
    if dmm <= COLLINEAR * gram.product(b.candidate, b.candidate) {
        return None;
    }
    let c = b.c - d_ab / a.dmm * a.c;
    Some(a.mse_reduction() + c * c / dmm)
}

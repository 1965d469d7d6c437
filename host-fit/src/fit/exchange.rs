//! Exchange refinement: terms of a greedy search are swapped, one at a time and two at a time, until no swap helps.
//!
//! The greedy search keeps what it took first, though two later terms may make it worthless: on a known system with
//! the products r(n−1)·r(n−2) and r(n−3)² it takes r(n−4)·r(n−10) and r(n−1)², each the best when it was chosen. A
//! pair is found only by trying pairs. All is done on the Gram matrix, so that a swap costs M·K multiply-adds and no
//! pass over the data.
//!
//! [`refine`] alternates three moves until none changes anything, each of which lowers MSE/(1 − t)^K, where t is the
//! threshold of the stop rule and K the number of terms: it therefore ends.
//!
//! 1. *exchange*: one term for one, then two for two, while the MSE falls;
//! 2. *prune*: a term that the stop rule would not have taken is taken out;
//! 3. *extend*: the greedy search goes on from there.

use super::fos::{COLLINEAR, EXACT, Expansion, Open, Selection};
use super::stop::StopRule;
use crate::moments::Gram;

/// Smallest relative fall of the MSE that is worth a swap: above rounding, below anything that matters.
const WORTH: f64 = 1e-9;

/// How many models that the data cannot tell apart are listed at most.
const MOST_TIES: usize = 10;

/// n·ln(MSE ratio) below which two models of the same size are called tied: the 95 % point of a chi-square variable with
/// one degree of freedom, which is what one more parameter would be allowed by chance.
pub const TIED: f64 = 3.841;

/// A model of the same size that the data cannot tell from the chosen one.
#[derive(Debug, Clone, PartialEq)]
pub struct Tie {
    /// Candidates of the chosen model that it does not have, in order of the pool.
    pub leaves: Vec<usize>,
    /// Candidates that it has in their place.
    pub enters: Vec<usize>,
    /// n·ln(MSE of it / MSE of the chosen model).
    pub deviance: f64,
}

/// Refines what `rule` lets a greedy search choose.
pub fn refine(gram: &Gram, rule: &StopRule, greedy: Selection) -> Selection {
    let threshold = rule.noise.threshold(gram.rows(), gram.size());
    let exact = EXACT * gram.target_mean_square();
    let mut selection = greedy;
    loop {
        let mut terms: Vec<usize> = selection.candidates().collect();
        let mut changed = false;
        // pairs last: they take the longest, and the fewer terms are left the fewer pairs there are
        while exchange(gram, &mut terms, exact, for_each_single)
            || prune(gram, &mut terms, threshold, exact)
            || exchange(gram, &mut terms, exact, for_each_pair)
        {
            crate::interrupt::check();
            changed = true;
        }
        if !changed {
            return selection;
        }
        selection = Expansion::of_terms(gram, &terms).run(rule);
    }
}

/// The models of the same size, one or two swaps away, that the data cannot tell from `terms`; best first.
pub fn ties(gram: &Gram, terms: &[usize]) -> Vec<Tie> {
    let mse = Expansion::of_terms(gram, terms).mse();
    if mse <= EXACT * gram.target_mean_square() {
        return Vec::new(); // rounding error is no evidence either way
    }
    let rows = gram.rows() as f64;
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
    found.truncate(MOST_TIES);
    found
}

/// Takes a swap: what leaves, what enters, the MSE then.
type Visit<'v> = &'v mut dyn FnMut(&[usize], &[usize], f64);

/// Visits every swap of a kind.
type ForEachSwap = fn(&Gram, &[usize], Visit<'_>);

/// Makes the best swap of a kind, if one is worth it.
fn exchange(gram: &Gram, terms: &mut Vec<usize>, exact: f64, for_each_swap: ForEachSwap) -> bool {
    let mse = Expansion::of_terms(gram, terms).mse();
    if mse <= exact {
        return false;
    }
    let mut best = mse * (1.0 - WORTH);
    let mut swap = None;
    for_each_swap(gram, terms, &mut |leaves, enters, swapped_mse| {
        if swapped_mse < best {
            best = swapped_mse;
            swap = Some((leaves.to_vec(), enters.to_vec()));
        }
    });
    let Some((leaves, enters)) = swap else { return false };
    terms.retain(|term| !leaves.contains(term));
    terms.extend(enters);
    true
}

/// Takes out the least term, if the rule would not have taken it.
fn prune(gram: &Gram, terms: &mut Vec<usize>, threshold: f64, exact: f64) -> bool {
    let mse = Expansion::of_terms(gram, terms).mse();
    let mse_without = |i: usize| Expansion::of_terms(gram, &without(terms, &[terms[i]])).mse();
    let least = (0..terms.len()).map(|i| (i, mse_without(i))).min_by(|a, b| a.1.total_cmp(&b.1));
    match least {
        Some((i, mse_without))
            if mse_without - mse < (threshold * mse_without).max(exact) && threshold > 0.0 =>
        {
            terms.remove(i);
            true
        }
        _ => false,
    }
}

/// Every swap of one term for one candidate.
fn for_each_single(gram: &Gram, terms: &[usize], visit: Visit<'_>) {
    for &leaves in terms {
        let base = Expansion::of_terms(gram, &without(terms, &[leaves]));
        for open in base.open().iter().filter(|open| open.candidate != leaves) {
            visit(&[leaves], &[open.candidate], base.mse() - open.mse_reduction());
        }
    }
}

/// Every swap of two terms for two candidates.
fn for_each_pair(gram: &Gram, terms: &[usize], visit: Visit<'_>) {
    for (i, &first) in terms.iter().enumerate() {
        for &second in &terms[i + 1..] {
            let leaves = [first, second];
            let base = Expansion::of_terms(gram, &without(terms, &leaves));
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

/// What two candidates take off the MSE together; `None` if they are collinear.
fn joint_reduction(gram: &Gram, base: &Expansion<'_>, a: &Open, b: &Open) -> Option<f64> {
    let d_ab = base.residual_product(a, b);
    let dmm = b.dmm - d_ab * d_ab / a.dmm;
    if dmm <= COLLINEAR * gram.product(b.candidate, b.candidate) {
        return None;
    }
    let c = b.c - d_ab / a.dmm * a.c;
    Some(a.mse_reduction() + c * c / dmm)
}

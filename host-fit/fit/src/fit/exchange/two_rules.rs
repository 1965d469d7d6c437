//! The earlier refinement with two contradictory rules, as a negative control only.
//!
//! It removes a term whose Q is below the rounding error of an MSE of ⟨y²⟩, and adds one whose Q is above that of
//! noise: if the residual is smaller than both, both rules apply to the same term forever.

use super::{ForEachSwap, WORTH, for_each_pair, for_each_single, without};
use crate::fit::fos::{Expansion, Selection};
use crate::fit::stop::{EXACT, StopRule};
use crate::moments::Gram;

/// Returns the number of moves, at most `most`.
pub(super) fn moves(most: usize, gram: &Gram, rule: &StopRule, greedy: &Selection) -> usize {
    let threshold = rule.stop.threshold(gram.rows(), gram.size());
    let exact = EXACT * gram.target_mean_square();
    let mut terms: Vec<usize> = greedy.candidates().collect();
    let mut moves = 0;
    loop {
        let before = moves;
        while moves < most
            && (exchange(gram, &mut terms, exact, for_each_single)
                || prune(gram, &mut terms, threshold, exact)
                || exchange(gram, &mut terms, exact, for_each_pair))
        {
            moves += 1;
        }
        if moves == before || moves == most {
            return moves;
        }
        terms = Expansion::from_terms(gram, &terms).run(rule).candidates().collect();
    }
}

fn exchange(gram: &Gram, terms: &mut Vec<usize>, exact: f64, for_each_swap: ForEachSwap) -> bool {
    let mse = Expansion::from_terms(gram, terms).mse();
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

fn prune(gram: &Gram, terms: &mut Vec<usize>, threshold: f64, exact: f64) -> bool {
    let mse = Expansion::from_terms(gram, terms).mse();
    let mse_without = |i: usize| Expansion::from_terms(gram, &without(terms, &[terms[i]])).mse();
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

//! The refinement of a greedy search terminates on any data.
#![allow(clippy::single_range_in_vec_init, reason = "a list of one segment")]

use fos_testkit::series::every_kind;

use super::refine_within;
use super::two_rules;
use crate::candidates::Candidates;
use crate::fit::{Stop, StopRule, fos};
use crate::moments::{Gram, Moments, Rows};
use crate::signal;

/// Far more moves than a refinement needs.
const MAX_MOVES: usize = 100;

fn gram(series: &[f64], lags: u16, degree: usize) -> Gram {
    let pool = Candidates::builder().output(1..=lags, degree).build().unwrap();
    let rows = Rows::usable(&[series], &[0..series.len()], pool.factors()).unwrap();
    Moments::accumulate(&[series], &rows, &pool).unwrap().gram().unwrap()
}

/// Centred and scaled as for a fit; unchanged if that is impossible.
fn scaled(series: &[f64]) -> Vec<f64> {
    let (mean, deviation) = (signal::mean(&[series]), signal::variance(&[series]).sqrt());
    match deviation.is_normal() {
        true => series.iter().map(|x| (x - mean) / deviation).collect(),
        false => series.to_vec(),
    }
}

fn rules() -> Vec<StopRule> {
    let rules = [(Stop::Never, 12), (Stop::Korenberg, 12), (Stop::Multiplicity, 12), (Stop::Never, 4)];
    rules.into_iter().map(|(stop, max_terms)| StopRule { max_terms, stop }).collect()
}

/// A fit of the lags of a spline of noise did not terminate: `prune` removed the term that `extend` had added,
/// thousands of times.
#[test]
fn refinement_terminates_on_all_data() {
    let kinds = every_kind(1000);
    let refinements: Vec<Refinement> = kinds.iter().flat_map(refinements).collect();
    for Refinement { what, moves, .. } in &refinements {
        assert!(*moves < MAX_MOVES, "{what}: no end after {moves} moves");
    }
    let two_rules = |name: &str| {
        let without_end = refinements.iter().filter(|r| r.two_rules == MAX_MOVES && r.what.contains(name));
        without_end.count()
    };
    println!(
        "attack: refinements end | {} kinds of data (smooth, flat, coarse, periodic, exact, chaotic, wandering, over 300 decades of scale): {} refinements of FOS, from 3 candidate pools with 4 stopping rules, take at most {} moves | negative control: with different rules for removing and adding terms, {} refinements have not ended after {MAX_MOVES} moves",
        kinds.len(),
        refinements.len(),
        refinements.iter().map(|refinement| refinement.moves).max().unwrap(),
        two_rules(""),
    );
    // the data on which the problem was found
    assert!(two_rules("spline") > 0 && two_rules("Butterworth") > 0, "the negative control was not noticed");
}

struct Refinement {
    what: String,
    moves: usize,
    /// Number of moves with two contradictory rules.
    two_rules: usize,
}

fn refinements((name, values): &(String, Vec<f64>)) -> Vec<Refinement> {
    let mut found = Vec::new();
    let scaled = scaled(values);
    for (series, (lags, degree)) in
        [(&scaled, (10, 1)), (&scaled, (6, 2)), (&scaled, (3, 3)), (values, (4, 2))]
    {
        let gram = gram(series, lags, degree);
        for rule in rules() {
            let greedy = fos::search(&gram, &rule);
            let two_rules = two_rules::moves(MAX_MOVES, &gram, &rule, &greedy);
            let (_, moves) = refine_within(MAX_MOVES, &gram, &rule, greedy);
            let what = format!("{name}, L = {lags}, CP {degree}, {rule:?}");
            found.push(Refinement { what, moves, two_rules });
        }
    }
    found
}

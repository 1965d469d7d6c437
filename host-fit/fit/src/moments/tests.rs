//! Moments compared with sums computed row by row.
#![allow(clippy::single_range_in_vec_init, reason = "a list of one segment")]

use fos_core::{u, y};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::candidates::Monomial;

fn noise(samples: usize, seed: u64, scale: f64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..samples).map(|_| scale * (random.random::<f64>() - 0.3)).collect()
}

/// Compares every Gram entry with its definition. The bound is relative to the average magnitude of the summands, to
/// which rounding is proportional.
fn assert_matches_definition(signals: &[&[f64]], rows: &Rows, pool: &Candidates) {
    let gram = Moments::accumulate(signals, rows, pool).gram().unwrap();
    assert_eq!(gram.rows(), rows.count());
    let check = |value: f64, a: &Monomial, b: &Monomial| {
        let value_at = |m: &Monomial, n: usize| -> f64 {
            m.iter().map(|f| signals[column(f)][n - usize::from(f.lag)]).product()
        };
        let terms = rows.ranges().iter().cloned().flatten().map(|n| value_at(a, n) * value_at(b, n));
        let (sum, magnitude) = terms.fold((0.0, 0.0), |(s, m), t| (s + t, m + t.abs()));
        let (expected, scale) = (sum / rows.count() as f64, magnitude / rows.count() as f64);
        // n additions of the plain sum dominate: n·ε/2 at worst, and far less in practice
        let bound = 1e-13 * scale;
        assert!((value - expected).abs() <= bound, "{a:?}·{b:?}: {value} for {expected}");
    };
    let (one, target) = (vec![], vec![y(0)]);
    check(gram.target_mean(), &target, &one);
    check(gram.target_mean_square(), &target, &target);
    for (i, p) in pool.monomials().iter().enumerate() {
        check(gram.mean(i), p, &one);
        check(gram.target_product(i), p, &target);
        for (j, q) in pool.monomials().iter().enumerate() {
            check(gram.product(i, j), p, q);
        }
    }
}

fn pools() -> Vec<Candidates> {
    let builders = [
        Candidates::builder().output(1..=1, 1),
        Candidates::builder().output(1..=10, 2),
        Candidates::builder().output(1..=4, 3),
        Candidates::builder().output(1..=3, 2).input(0, 0..=5, 1).input(1, 2..=3, 2).cross_products(3),
        Candidates::builder().monomial(&[y(1), y(23)]).monomial(&[u(1, 0)]).monomial(&[u(0, 40), y(2), y(2)]),
    ];
    builders.into_iter().map(|builder| builder.build().unwrap()).collect()
}

#[test]
fn match_their_definition_over_uneven_sizes() {
    let lengths = [45, 50, 63, 90, 391, 392, 393, 400, 801, 1500];
    for (seed, samples) in lengths.into_iter().enumerate() {
        let columns: Vec<_> = (0..3).map(|c| noise(samples, 10 * seed as u64 + c, 3.0)).collect();
        let signals: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        for pool in pools() {
            let rows = Rows::usable(&signals, &[0..samples], pool.factors());
            assert_matches_definition(&signals, &rows, &pool);
        }
    }
}

#[test]
fn stop_at_gaps_missing_values_and_short_segments() {
    let mut columns: Vec<_> = (0..3).map(|c| noise(1200, 77 + c, 1.0)).collect();
    columns[0][300] = f64::NAN;
    columns[1][310] = f64::NAN;
    columns[2][700] = f64::INFINITY;
    let signals: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let segments = [0..3, 3..8, 8..8, 8..290, 295..420, 430..477, 480..1200];
    for pool in pools() {
        let rows = Rows::usable(&signals, &segments, pool.factors());
        assert_matches_definition(&signals, &rows, &pool);
    }
}

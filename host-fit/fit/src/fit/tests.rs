//! Defining properties, the textbook twin, units, stop rules and their calibration.
#![allow(clippy::single_range_in_vec_init, reason = "a list of one segment")]

use fos_core::{u, y};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;
use crate::moments::{Gram, column};

fn gaussian(samples: usize, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..samples).map(|_| StandardNormal.sample(&mut random)).collect()
}

/// y(n) = Σ ar[k]·y(n−k−1) + `quadratic`·(y(n−1)·y(n−2) − y(n−3)²) + 0.2·e(n): the difference of two squares has zero
/// mean, so the record does not diverge.
fn autoregressive(samples: usize, seed: u64, ar: &[f64], quadratic: f64) -> Vec<f64> {
    let mut series: Vec<f64> = gaussian(samples, seed).iter().map(|e| 0.2 * e).collect();
    for n in ar.len().max(3)..samples {
        let linear: f64 = ar.iter().enumerate().map(|(k, a)| a * series[n - k - 1]).sum();
        series[n] += linear + quadratic * (series[n - 1] * series[n - 2] - series[n - 3] * series[n - 3]);
    }
    series
}

const AR4: [f64; 4] = [1.6, -0.95, 0.42, -0.13];

fn whole(signals: &[&[f64]], pool: &Candidates) -> Rows {
    Rows::usable(signals, &[0..signals[0].len()], pool.factors())
}

fn gram(signals: &[&[f64]], pool: &Candidates) -> Gram {
    Moments::accumulate(signals, &whole(signals, pool), pool).gram().unwrap()
}

fn pool_65() -> Candidates {
    Candidates::builder().output(1..=10, 2).build().unwrap()
}

fn at_most(max_terms: usize) -> StopRule {
    StopRule { max_terms, stop: Stop::Never }
}

/// Residuals of a refit at its rows.
fn residuals(signals: &[&[f64]], rows: &Rows, terms: &[Monomial], fit: &Refit) -> Vec<f64> {
    let predicted = |n: usize| {
        let weighted = terms.iter().zip(&fit.coefficients).map(|(term, a)| a * value(signals, term, n));
        fit.constant + weighted.sum::<f64>()
    };
    rows.ranges().iter().cloned().flatten().map(|n| signals[0][n] - predicted(n)).collect()
}

fn value(signals: &[&[f64]], term: &Monomial, n: usize) -> f64 {
    term.iter().map(|f| signals[column(f)][n - usize::from(f.lag)]).product()
}

#[test]
fn residuals_are_orthogonal_and_minimal() {
    let output = autoregressive(3000, 1, &AR4, 0.02);
    let input = gaussian(3000, 2);
    let signals = [&output[..], &input];
    let pool = Candidates::builder().output(1..=5, 2).input(0, 0..=2, 1).cross_products(2).build().unwrap();
    let fit = fit(&signals, &[0..1000, 1003..3000], &pool, &at_most(8), Search::Greedy).unwrap();
    let rows = Rows::usable(&signals, &[0..1000, 1003..3000], pool.factors());
    let e = residuals(&signals, &rows, &fit.terms, &fit.refit);
    let n = e.len() as f64;
    let norm = e.iter().map(|e| e * e).sum::<f64>().sqrt();
    assert!((norm * norm / n / fit.refit.mse - 1.0).abs() < 1e-12, "{} {}", norm * norm / n, fit.refit.mse);
    let mse = fit.selection.steps.last().unwrap().mse;
    assert!((mse / fit.refit.mse - 1.0).abs() < 1e-10, "(7) agrees with the residuals");

    let all_rows: Vec<usize> = rows.ranges().iter().cloned().flatten().collect();
    for term in fit.terms.iter().chain([&vec![]]) {
        let column: Vec<f64> = all_rows.iter().map(|&n| value(&signals, term, n)).collect();
        let product: f64 = column.iter().zip(&e).map(|(p, e)| p * e).sum();
        let scale = column.iter().map(|p| p * p).sum::<f64>().sqrt() * norm;
        // cosine between residual and column: rounding of n products, √n·ε with a margin for the condition number
        assert!(product.abs() < 1e-12 * scale, "{term:?}: {}", product / scale);
    }
    for m in 0..fit.terms.len() {
        for step in [-1.0, 1.0] {
            let mut worse = fit.refit.clone();
            worse.coefficients[m] += step * fit.refit.coefficient_errors[m];
            let mse = residuals(&signals, &rows, &fit.terms, &worse).iter().map(|e| e * e).sum::<f64>() / n;
            assert!(mse > fit.refit.mse);
        }
    }
}

#[test]
fn agrees_with_the_textbook_recursion() {
    for seed in 0..4 {
        let output = autoregressive(1500, 40 + seed, &AR4, 0.02);
        let input = gaussian(1500, 50 + seed);
        let signals = [&output[..], &input];
        let pools = [
            Candidates::builder().output(1..=5, 2).build().unwrap(),
            Candidates::builder().output(1..=3, 3).input(0, 0..=3, 2).cross_products(2).build().unwrap(),
        ];
        for pool in pools {
            let rows = Rows::usable(&signals, &[0..1400], pool.factors());
            for rule in [at_most(7), StopRule::default()] {
                let twin = textbook::search(&signals, &rows, &pool, &rule);
                let gram = Moments::accumulate(&signals, &rows, &pool).gram().unwrap();
                let selection = fos::search(&gram, &rule);
                assert_eq!(
                    twin.iter().map(|t| t.0).collect::<Vec<_>>(),
                    selection.candidates().collect::<Vec<_>>(),
                    "{twin:?} {:?}",
                    selection.steps
                );
                for ((_, q), step) in twin.iter().zip(&selection.steps) {
                    assert!((q - step.mse_reduction).abs() < 1e-12 * selection.initial_mse);
                }
            }
        }
    }
}

#[test]
fn result_is_independent_of_unit() {
    let output = autoregressive(20_000, 9, &AR4, 0.02);
    let segments = &[0..20_000];
    let pool = pool_65();
    let unit = fit(&[&output], segments, &pool, &at_most(8), Search::Greedy).unwrap();
    for scale in [1e-6, 1e6] {
        let scaled: Vec<f64> = output.iter().map(|x| scale * x).collect();
        let fit = fit(&[&scaled], segments, &pool, &at_most(8), Search::Greedy).unwrap();
        assert_eq!(fit.terms, unit.terms);
        for (m, term) in fit.terms.iter().enumerate() {
            let expected = unit.refit.coefficients[m] * scale.powi(1 - term.len() as i32);
            // inputs are rounded again by the scaling: ε times the condition number
            let error = fit.refit.coefficients[m] / expected - 1.0;
            assert!(error.abs() < 1e-9, "{term:?}: {error:e}");
        }
        assert!((fit.refit.mse / (scale * scale) / unit.refit.mse - 1.0).abs() < 1e-12);
    }
}

#[test]
fn excludes_collinear_candidates_and_continues() {
    let output = autoregressive(2000, 3, &AR4, 0.0);
    let input = gaussian(2000, 4);
    let copy: Vec<f64> = input.iter().map(|x| 1e-6 * x).collect();
    let flat = vec![2.0; 2000];
    let driven: Vec<f64> = output.iter().zip(&input).map(|(y, x)| y + x).collect();
    let signals = [&driven[..], &input, &copy, &flat];
    let builder = Candidates::builder().output(1..=4, 1);
    let pool = builder.input(0, 0..=0, 1).input(1, 0..=0, 1).input(2, 0..=0, 1).build().unwrap();
    let fit = fit(&signals, &[0..2000], &pool, &at_most(20), Search::Greedy).unwrap();
    assert_eq!(fit.selection.stopped, Stopped::NothingLeft);
    assert_eq!(fit.terms.len(), 5, "without the constant input and one of the two copies");
    assert!(!fit.terms.contains(&vec![u(2, 0)]));
    assert!(fit.terms.contains(&vec![u(0, 0)]) != fit.terms.contains(&vec![u(1, 0)]));

    let rows = whole(&signals, &pool);
    let refused = refit::refit(&signals, &rows, &[vec![u(0, 0)], vec![y(1)], vec![u(1, 0)]]).unwrap_err();
    assert_eq!(refused, RefitError::Collinear { term: 2, text: "u1(n)".into() });
    let refused = refit::refit(&signals, &rows, &[vec![u(2, 0)]]).unwrap_err();
    assert_eq!(refused, RefitError::Collinear { term: 0, text: "u2(n)".into() });
}

/// A slow input is constant within the first thousands of rows: there it is collinear with the constant, over the whole
/// record it is not.
#[test]
fn refits_an_input_that_is_constant_for_the_first_blocks() {
    let output = gaussian(4000, 6);
    let step: Vec<f64> = (0..4000).map(|n| if n < 2100 { 0.0 } else { 1.0 + (n / 1500) as f64 }).collect();
    let shifted: Vec<f64> = output.iter().zip(&step).map(|(y, s)| y + 3.0 * s).collect();
    let signals = [&shifted[..], &step];
    let terms = [vec![u(0, 0)], vec![u(0, 0), u(0, 0)], vec![y(1)]];
    let rows = Rows::usable(&signals, &[0..4000], terms.iter().flatten());
    let fit = refit::refit(&signals, &rows, &terms).unwrap();
    let e = residuals(&signals, &rows, &terms, &fit);
    for term in terms.iter().chain([&vec![]]) {
        let product: f64 = rows.ranges()[0].clone().zip(&e).map(|(n, e)| value(&signals, term, n) * e).sum();
        assert!(product.abs() < 1e-8, "{term:?} {product}");
    }
}

#[test]
fn standard_errors_are_those_of_the_normal_equations() {
    // orthogonal regressor of known size: y = 1 + 2u + e, u = ±1 in turn, so (XᵀX)⁻¹ = I/n
    let n = 1000;
    let input: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
    let output: Vec<f64> = gaussian(n, 8).iter().zip(&input).map(|(e, u)| 1.0 + 2.0 * u + e).collect();
    let rows = Rows::usable(&[&output, &input], &[0..n], &[u(0, 0)]);
    let fit = refit::refit(&[&output, &input], &rows, &[vec![u(0, 0)]]).unwrap();
    let expected = (fit.mse * n as f64 / (n as f64 - 2.0) / n as f64).sqrt();
    assert!((fit.coefficient_errors[0] / expected - 1.0).abs() < 1e-12);
    assert!((fit.constant_error / expected - 1.0).abs() < 1e-12);
    assert!((fit.condition - 1.0).abs() < 1e-12);
    assert!((fit.coefficients[0] - 2.0).abs() < 5.0 * expected);
}

#[test]
fn stops_at_each_rule() {
    let output = autoregressive(5000, 12, &AR4, 0.0);
    let gram = gram(&[&output], &pool_65());
    let searched = |rule: StopRule| fos::search(&gram, &rule);
    assert_eq!(searched(at_most(3)).stopped, Stopped::MaxTerms);
    let default = searched(StopRule::default());
    let Stopped::Noise { mse_reduction, needed, .. } = default.stopped else {
        panic!("{:?}", default.stopped)
    };
    assert!(mse_reduction < needed);
    assert_eq!(default.steps.len(), 4);

    let flat = vec![3.0; 100];
    let pool = Candidates::builder().output(1..=2, 1).build().unwrap();
    let fit = fit(&[&flat], &[0..100], &pool, &StopRule::default(), Search::Greedy).unwrap();
    assert_eq!((fit.selection.stopped, fit.terms.len()), (Stopped::Exact, 0));
    assert!((fit.refit.constant - 3.0).abs() < 1e-14);
}

#[test]
fn reports_unfittable_data() {
    let short = vec![1.0; 8];
    let none = fit(&[&short], &[0..8], &pool_65(), &StopRule::default(), Search::Greedy);
    assert_eq!(none.unwrap_err(), FitError::NoRows(NoRows));
    let rows = Rows::usable(&[&short], &[0..8], &[y(6)]);
    let refused = refit::refit(&[&short], &rows, &[vec![y(1)]]).unwrap_err();
    assert_eq!(refused, RefitError::TooFewRows { rows: 2, parameters: 2 });
    for (monomial, text) in [(vec![y(0)], "y(n)"), (vec![], "1"), (vec![y(1); 4], "y(n-1)^4")] {
        let refused = refit::refit(&[&short], &rows, &[vec![y(1)], monomial]).unwrap_err();
        assert_eq!(refused, RefitError::Term { term: 1, text: text.into() });
    }
}

/// Share of white-noise records in which a rule chooses a term.
fn false_alarms(stop: Stop, records: u64) -> f64 {
    let pool = pool_65();
    let rule = StopRule { max_terms: 1, stop };
    let alarm =
        |seed: &u64| !fos::search(&gram(&[&gaussian(3600, 1000 + seed)], &pool), &rule).steps.is_empty();
    (0..records).filter(alarm).count() as f64 / records as f64
}

#[test]
fn white_noise_passes_the_published_rule_and_not_the_default() {
    let published = false_alarms(Stop::Korenberg, 300);
    assert!(published > 0.9, "the published rule allows for one candidate only: {published}");
    let default = false_alarms(Stop::Multiplicity, 300);
    assert!(default < 0.02, "{default}");
}

#[test]
fn the_default_rule_never_misses_a_true_ar4() {
    let pool = pool_65();
    for seed in 0..20 {
        let output = autoregressive(36_000, 2000 + seed, &AR4, 0.0);
        let selection = fos::search(&gram(&[&output], &pool), &StopRule::default());
        let chosen: Vec<usize> = selection.candidates().collect();
        for lag in 1..=4 {
            assert!(
                chosen.contains(&pool.position(&[y(lag)]).unwrap()),
                "seed {seed}: lag {lag} in {chosen:?}"
            );
        }
    }
}

#[test]
fn refinement_reports_its_move_limit() {
    let output = autoregressive(5000, 12, &AR4, 0.05);
    let gram = gram(&[&output], &pool_65());
    let rule = StopRule { stop: Stop::Korenberg, ..StopRule::default() };
    let greedy = fos::search(&gram, &rule);
    let (_, moves) = exchange::refine_within(1000, &gram, &rule, greedy.clone());
    assert!(moves > 0, "{moves}");
    let (cut_short, made) = exchange::refine_within(0, &gram, &rule, greedy);
    assert_eq!((cut_short.stopped, made), (Stopped::MostMoves, 0));
}

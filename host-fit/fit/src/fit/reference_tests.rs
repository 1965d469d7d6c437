//! The search, the refit and the autoregressions compared with independently computed answers: our own fixtures, and
//! published or external ones if they are installed.
#![allow(clippy::single_range_in_vec_init, reason = "a list of one segment")]

use fos_core::{Channel, Factor, u, y};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

use super::autoregression::{burg, yule_walker};
use super::*;
use fos_testkit::reference::{self, Reference, assert_all_close, number, numbers};

fn monomial(lags: &Value) -> Monomial {
    lags.as_array().unwrap().iter().map(|lag| y(lag.as_u64().unwrap() as u16)).collect()
}

fn assert_close(what: &str, value: f64, expected: f64, relative: f64) {
    let error = (value - expected).abs() / expected.abs();
    assert!(error <= relative, "{what}: {value} for {expected}, relative error {error:e}");
}

/// 1e-9: agreement of three independent formulations of the reference on terms that reduce the error by 10⁻⁸ of the
/// variance.
const FOS_TOLERANCE: f64 = 1e-9;

#[test]
fn reproduces_the_reference_selection() {
    for reference in reference::each("selection", "fos_S1_train36000") {
        assert_selection(&reference);
    }
}

fn assert_selection(reference: &Reference) {
    let signal = reference.series();
    for case in reference.answers["cases"].as_array().unwrap() {
        let integer = |key: &str| case[key].as_u64().unwrap();
        let degree = integer("degree") as usize;
        let pool = Candidates::builder().output(1..=integer("max_lag") as u16, degree).build().unwrap();
        let korenberg = case["korenberg_stop"].as_bool().unwrap();
        let rule = StopRule {
            max_terms: integer("max_terms") as usize,
            stop: if korenberg { Stop::Korenberg } else { Stop::Never },
        };
        let fit = fit(&[signal], &[0..signal.len()], &pool, &rule, Search::Greedy).unwrap();

        let terms = case["terms"].as_array().unwrap();
        let expected: Vec<Monomial> = terms.iter().map(|term| monomial(&term["lags"])).collect();
        assert_eq!(fit.terms, expected, "{case}");
        assert_eq!(fit.refit.rows as u64, integer("samples_used"));
        for (i, term) in terms.iter().enumerate() {
            let close = |what, value, expected| assert_close(what, value, expected, FOS_TOLERANCE);
            close("coefficient", fit.refit.coefficients[i], number(&term["coef"]));
            close("q", fit.refit.mse_reductions[i], number(&term["q_mse_reduction"]));
        }
        assert_close("constant", fit.refit.constant, number(&case["constant"]), FOS_TOLERANCE);
        assert_close("mse", fit.refit.mse, number(&case["mse"]), FOS_TOLERANCE);
        assert_close("variance", fit.selection.initial_mse, number(&case["variance_of_y"]), FOS_TOLERANCE);
    }
}

#[test]
fn reproduces_the_reference_fit_across_gaps() {
    for reference in reference::each("gaps", "gaps_S1_shared") {
        assert_fit_across_gaps(&reference);
    }
}

fn assert_fit_across_gaps(reference: &Reference) {
    let signal = reference.series();
    let tolerance = number(&reference.answers["tolerance_relative"]);
    for case in reference.answers["cases"].as_array().unwrap() {
        let terms: Vec<Monomial> = case["terms"].as_array().unwrap().iter().map(monomial).collect();
        let max_lag = y(case["max_lag"].as_u64().unwrap() as u16);
        let rows = Rows::usable(&[signal], &[0..signal.len()], &[max_lag]);
        assert_eq!(rows.count() as u64, case["rows_used"].as_u64().unwrap());
        assert!(terms[0].is_empty(), "the constant comes first");
        let fit = refit::refit(&[signal], &rows, &terms[1..]).unwrap();
        let fitted = std::iter::once(fit.constant).chain(fit.coefficients);
        for (value, expected) in fitted.zip(case["coef"].as_array().unwrap()) {
            assert_close("coefficient", value, number(expected), tolerance);
        }
        assert_close("mse", fit.mse, number(&case["mse"]), tolerance);
    }
}

/// Monomials of a `narx_*` or `bench_*` system: output lags and input lags of each term.
fn narx_monomial(term: &Value) -> Monomial {
    let lags =
        |key: &str| term[key].as_array().unwrap().iter().map(|lag| lag.as_u64().unwrap() as u16).collect();
    let (outputs, inputs): (Vec<u16>, Vec<u16>) = (lags("y"), lags("x"));
    let mut factors: Monomial = outputs.into_iter().map(y).collect();
    factors.extend(inputs.into_iter().map(|lag| u(0, lag)));
    factors.sort_unstable();
    factors
}

/// Output of a `narx_*` or `bench_*` system for a given input, simulated from its true terms.
fn simulate_narx(answers: &Value, input: &[f64], noise: &[f64]) -> Vec<f64> {
    let terms: Vec<(Monomial, f64)> = answers["true_terms"]
        .as_array()
        .unwrap()
        .iter()
        .map(|term| (narx_monomial(term), number(&term["coef"])))
        .collect();
    let mut output = vec![0.0; input.len()];
    for n in 4..input.len() {
        let value = |factor: &Factor| match factor.channel {
            Channel::Output => output[n - usize::from(factor.lag)],
            Channel::Input(_) => input[n - usize::from(factor.lag)],
        };
        let sum: f64 = terms.iter().map(|(p, a)| a * p.iter().map(value).product::<f64>()).sum();
        output[n] = number(&answers["constant"]) + sum + number(&answers["noise_sd"]) * noise[n];
    }
    output
}

/// Pool that the file describes in words.
fn narx_pool(answers: &Value) -> Candidates {
    let text = answers["candidates"].as_str().unwrap();
    let degree = if text.contains("degree 3") { 3 } else { 2 };
    let first = u16::from(!text.contains("x(n-0"));
    assert!(text.contains("y(n-1..n-4)") && text.contains("..n-4)"), "{text}");
    let pool = Candidates::builder().output(1..=4, degree).input(0, first..=4, degree);
    pool.cross_products(degree).build().unwrap()
}

#[test]
fn recovers_systems_exactly_for_any_seed() {
    for name in ["narx_cubic", "narx_products", "narx_bilinear", "narx_exact"] {
        assert_recovered(&reference::own(name));
    }
}

#[test]
fn recovers_published_systems_exactly_for_any_seed() {
    for name in ["bench_S2_book", "bench_S3_book", "bench_elec841_1", "bench_siso_doc"] {
        let Some(reference) = reference::outside(name) else { continue };
        assert_recovered(&reference);
    }
}

fn assert_recovered(reference: &Reference) {
    let Reference { name, answers, channels } = reference;
    let mut truth: Vec<Monomial> =
        answers["true_terms"].as_array().unwrap().iter().map(narx_monomial).collect();
    truth.sort();
    let pool = narx_pool(answers);
    let recover = |input: &[f64], output: &[f64], what: &str| {
        // the same rows as the reference
        let rows = 6..input.len();
        let fit = fit(&[output, input], &[rows], &pool, &StopRule::default(), Search::Exchange).unwrap();
        let mut found = fit.terms.clone();
        found.sort();
        assert_eq!(found, truth, "{name}, {what}: {:?}", fit.selection.stopped);
        fit
    };
    let fit = recover(&channels[0], &channels[1], "the reference's own samples");
    let expected = numbers(&answers["least_squares_on_true_terms"]["constant_then_terms"]);
    let errors = numbers(&answers["least_squares_on_true_terms"]["standard_errors"]);
    for (i, term) in answers["true_terms"].as_array().unwrap().iter().enumerate() {
        let place = fit.terms.iter().position(|found| *found == narx_monomial(term)).unwrap();
        let size = expected[i + 1].abs();
        // computed by another factorisation
        assert!((fit.refit.coefficients[place] - expected[i + 1]).abs() < 1e-10 * size, "{name}");
        let error = fit.refit.coefficient_errors[place];
        assert!(
            (error - errors[i + 1]).abs() < 1e-6 * errors[i + 1] + 1e-14,
            "{name}: {error} for {}",
            errors[i + 1]
        );
    }
    let unsigned = number(&answers["constant"]) != 0.0;
    let mut bounded = 0;
    for seed in 0..100 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let noise: Vec<f64> = (0..3000).map(|_| StandardNormal.sample(&mut random)).collect();
        let input: Vec<f64> = match unsigned {
            true => (0..3000).map(|_| random.random::<f64>()).collect(),
            false => (0..3000).map(|_| random.random_range(-1.0..1.0)).collect(),
        };
        let output = simulate_narx(answers, &input, &noise);
        // systems with products of the output diverge for some inputs
        if bounded < 20 && output.iter().all(|y| y.abs() < 10.0) {
            bounded += 1;
            recover(&input, &output, &format!("seed {seed}"));
        }
    }
    assert_eq!(bounded, 20, "{name}");
}

/// Every subset of 14 products was tried: exchanges end at the best of each size, which the greedy search misses.
#[test]
fn exchanges_find_the_best_of_all_subsets() {
    let Reference { answers, channels, .. } = reference::own("selection");
    let signals = [&channels[0][..]];
    let all = &answers["exhaustive"];
    let [max_lag, degree] = ["max_lag", "degree"].map(|key| all[key].as_u64().unwrap());
    let pool = Candidates::builder().output(1..=max_lag as u16, degree as usize).build().unwrap();
    let mut missed = 0;
    for best in all["best"].as_array().unwrap() {
        let max_terms = best["size"].as_u64().unwrap() as usize;
        let rule = StopRule { max_terms, stop: Stop::Never };
        let search = |search| fit(&signals, &[0..signals[0].len()], &pool, &rule, search).unwrap();
        let exchanged = search(Search::Exchange);
        let mut found = exchanged.terms.clone();
        found.sort();
        let mut expected: Vec<Monomial> = best["terms"].as_array().unwrap().iter().map(monomial).collect();
        expected.sort();
        assert_eq!(found, expected, "of {max_terms}");
        assert_close("mse", exchanged.refit.mse, number(&best["mse"]), FOS_TOLERANCE);
        missed += usize::from(search(Search::Greedy).refit.mse > exchanged.refit.mse * (1.0 + FOS_TOLERANCE));
    }
    assert!(missed > 0, "or this shows nothing of exchanges");
}

#[test]
fn exchanges_find_products_that_greedy_search_misses() {
    let Some(Reference { answers, channels, .. }) = reference::outside("fos_S1_train36000") else { return };
    let signal = &channels[0][..];
    let pool = Candidates::builder().output(1..=10, 2).build().unwrap();
    let fit = fit(&[signal], &[0..signal.len()], &pool, &StopRule::default(), Search::Exchange).unwrap();
    let quadratic = answers["truth"]["quadratic"].as_array().unwrap();
    let mut truth: Vec<Monomial> = (1..=4).map(|lag| vec![y(lag)]).collect();
    truth.extend(quadratic.iter().map(|term| monomial(&term["lags"])));
    let mut found = fit.terms.clone();
    found.sort();
    truth.sort();
    assert_eq!(found, truth);
    // statistically tied: the pair (1,1), (3,4)
    let index = |m: &Monomial| pool.position(m).unwrap();
    let mut runner_up = vec![index(&vec![y(1), y(1)]), index(&vec![y(3), y(4)])];
    runner_up.sort_unstable();
    let tie = fit.ties.iter().find(|tie| tie.enters == runner_up).expect("the tie is listed");
    assert!(tie.deviance > 0.0 && tie.deviance < 1.0, "{tie:?}");
}

/// Compares with the entry of one method in a file's `full_precision` or `real_part`.
fn assert_autoregression(
    what: &str,
    series: &[f64],
    order: usize,
    key: &str,
    expected: &Value,
    tolerance: f64,
) {
    let method = match key {
        "yule_walker" => autoregression::Method::YuleWalker,
        "covariance" => autoregression::Method::Covariance,
        "modified_covariance" => autoregression::Method::ModifiedCovariance,
        "burg" => autoregression::Method::Burg,
        other => panic!("{other}"),
    };
    let fit = autoregression::estimate(method, &[series], order).unwrap();
    let what = format!("{what} {key} {order}");
    assert_all_close(&what, &fit.coefficients, &numbers(&expected["ar"]), tolerance);
    if !expected["reflection"].is_null() {
        assert_all_close(&what, &fit.reflection, &numbers(&expected["reflection"]), tolerance);
    }
    for key in ["noise_variance", "forward_mse"] {
        if !expected[key].is_null() {
            assert_close(&what, fit.innovation_variance, number(&expected[key]), tolerance);
        }
    }
}

const METHODS: [&str; 4] = ["yule_walker", "covariance", "modified_covariance", "burg"];

#[test]
fn autoregressions_agree_with_matlabs_documentation() {
    let Some(reference) = reference::outside("ar_matlab_doc_ar4") else { return };
    let (answers, series) = (&reference.answers, reference.series());
    let full = &answers["full_precision"];
    for key in METHODS {
        assert_autoregression("matlab", series, 4, key, &full[key], number(&full["tolerance_relative"]));
    }
    let published = &answers["published"];
    let pages = ["aryule", "arcov", "armcov", "arburg"];
    for (method, page) in METHODS.into_iter().zip(pages) {
        let ar: Vec<f64> = numbers(&published["polynomial"][page])[1..].iter().map(|a| -a).collect();
        for (printed, computed) in ar.iter().zip(numbers(&full[method]["ar"])) {
            assert!((printed - computed).abs() < number(&published["tolerance"]));
        }
    }
}

#[test]
fn autoregressions_agree_with_independent_computation() {
    let reference = reference::own("autoregression");
    assert_every_order(reference.series(), &reference.answers);
}

#[test]
fn autoregressions_agree_with_marples_64_samples() {
    let Some(Reference { answers, .. }) = reference::outside("ar_marple64") else { return };
    assert_every_order(&numbers(&answers["complex_re"]), &answers);
}

fn assert_every_order(series: &[f64], answers: &Value) {
    for (order, cases) in answers["real_part"].as_object().unwrap() {
        for key in METHODS {
            // as computed by other factorisations, condition below 10³
            assert_autoregression("real", series, order.parse().unwrap(), key, &cases[key], 1e-10);
        }
    }
}

#[test]
fn autoregressions_of_series_with_a_mean_agree_with_statsmodels() {
    for reference in reference::each("autoregression_with_mean", "ar_sunspots_statsmodels") {
        assert_series_with_mean(&reference);
    }
}

fn assert_series_with_mean(reference: &Reference) {
    let (what, answers, series) = (&reference.name, &reference.answers, reference.series());
    let mean = series.iter().sum::<f64>() / series.len() as f64;
    let centred: Vec<f64> = series.iter().map(|x| x - mean).collect();
    for case in answers["published"].as_array().unwrap() {
        let tolerance = number(&case["tolerance"]);
        let order = case["order"].as_u64().unwrap() as usize;
        // absolute tolerance of printed digits; coefficients are of size 1
        assert_autoregression(what, &centred, order, case["method"].as_str().unwrap(), case, tolerance);
        let fit = |method| autoregression::estimate(method, &[&centred], order).unwrap();
        if let Some(sigma) = case.get("sigma") {
            let variance = fit(autoregression::Method::YuleWalker).innovation_variance;
            assert_close("sigma", variance.sqrt(), number(sigma), tolerance);
        }
        if let Some(variance) = case.get("sigma2") {
            // the reference has the mean square of the last stage's errors, we that of (9e)
            let a = fit(autoregression::Method::Burg).coefficients;
            let predicted = |past: Vec<f64>| past.iter().zip(&a).map(|(y, a)| y * a).sum::<f64>();
            let errors = (order..centred.len()).flat_map(|n| {
                let forward = centred[n] - predicted((1..=order).map(|k| centred[n - k]).collect());
                let first = n - order;
                let backward = centred[first] - predicted((1..=order).map(|k| centred[first + k]).collect());
                [forward, backward]
            });
            let mean_square = errors.map(|e| e * e).sum::<f64>() / (2 * (centred.len() - order)) as f64;
            // tolerance of the coefficients, which enter squared
            assert_close("sigma2", mean_square, number(variance), tolerance);
        }
    }
    let expected = &answers["computed"];
    let lags: Vec<Monomial> = (1..=9).map(|lag| vec![y(lag)]).collect();
    let rows = Rows::usable(&[series], &[0..series.len()], lags.iter().flatten());
    let fit = refit::refit(&[series], &rows, &lags).unwrap();
    let found: Vec<f64> = std::iter::once(fit.constant).chain(fit.coefficients).collect();
    assert_all_close(what, &found, &numbers(&expected["const_then_ar"]), 1e-10);
    assert_close(what, fit.mse, number(&expected["sigma2_mle"]), 1e-10);
    let errors: Vec<f64> = std::iter::once(fit.constant_error).chain(fit.coefficient_errors).collect();
    // the reference divides by n, we by the degrees of freedom
    let equations = rows.count() as f64;
    let theirs = ((equations - 10.0) / equations).sqrt();
    let errors: Vec<f64> = errors.iter().map(|error| error * theirs).collect();
    assert_all_close(what, &errors, &numbers(&expected["standard_errors"]), 1e-8);
}

#[test]
fn autoregressions_agree_with_hand_sized_cases() {
    for reference in reference::each("autoregression_by_hand", "ar_small") {
        assert_hand_sized_cases(&reference.answers);
    }
}

fn assert_hand_sized_cases(answers: &Value) {
    for case in answers["cases"].as_array().unwrap() {
        let tolerance = number(&case["tolerance"]);
        let check = |fit: &Autoregression| {
            // absolute: digits as printed
            let close = |values: &[f64], key: &str| {
                if !case[key].is_null() {
                    for (value, expected) in values.iter().zip(numbers(&case[key])) {
                        assert!((value - expected).abs() <= tolerance, "{case}: {value} for {expected}");
                    }
                }
            };
            close(&fit.coefficients, "ar");
            close(&fit.reflection, "reflection");
            assert_close("variance", fit.innovation_variance, number(&case["noise_variance"]), tolerance);
        };
        let order = case["order"].as_u64().map(|order| order as usize);
        match case["method"].as_str().unwrap() {
            "levinson" => check(&yule_walker::levinson_durbin(&numbers(&case["autocorrelation"])).unwrap()),
            "reflection_to_polynomial" => {
                let mut coefficients = Vec::new();
                for gamma in numbers(&case["reflection"]) {
                    autoregression::polynomial::step_up(&mut coefficients, gamma);
                }
                for (a, printed) in coefficients.iter().zip(&numbers(&case["polynomial"])[1..]) {
                    assert!((-a - printed).abs() <= tolerance, "{a} for {printed}");
                }
            }
            "yule_walker" => {
                let series = numbers(&case["series"]);
                check(&yule_walker::estimate(&[&series], order.unwrap()).unwrap());
            }
            "burg" => check(&burg::estimate(&[&numbers(&case["series"])[..]], order.unwrap()).unwrap()),
            other => panic!("{other}"),
        }
    }
}

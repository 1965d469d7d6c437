//! The search and refit against independently computed answers, where the reference files are at hand.
#![allow(clippy::single_range_in_vec_init, reason = "a list of one segment")]

use std::path::Path;

use fos_core::y;
use serde_json::Value;

use super::*;

/// A reference file and its first channel; `None`, saying so, if it is not there.
fn reference(name: &str) -> Option<(Value, Vec<f64>)> {
    // beside the repository, however deep the working tree is
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = here.ancestors().map(|folder| folder.join("shared/reference"));
    let folder = folders.find(|folder| folder.join(name).with_extension("json").exists());
    let Some(folder) = folder else {
        println!("skipped: no reference file {name}.json");
        return None;
    };
    let json = std::fs::read_to_string(folder.join(name).with_extension("json")).unwrap();
    let bytes = std::fs::read(folder.join(name).with_extension("f64")).unwrap();
    let samples = bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
    Some((serde_json::from_str(&json).unwrap(), samples))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn monomial(lags: &Value) -> Monomial {
    lags.as_array().unwrap().iter().map(|lag| y(lag.as_u64().unwrap() as u16)).collect()
}

fn assert_close(what: &str, value: f64, expected: f64, relative: f64) {
    let error = (value - expected).abs() / expected.abs();
    assert!(error <= relative, "{what}: {value} for {expected}, relative error {error:e}");
}

/// 1e-9: what three independent formulations of the reference agree to on terms that lower the error by 10⁻⁸
/// of the variance.
const FOS_TOLERANCE: f64 = 1e-9;

#[test]
fn reproduces_the_reference_selection() {
    let Some((reference, signal)) = reference("fos_S1_train36000") else { return };
    for case in reference["cases"].as_array().unwrap() {
        let integer = |key: &str| case[key].as_u64().unwrap();
        let degree = integer("degree") as usize;
        let pool = Candidates::builder().output(1..=integer("max_lag") as u16, degree).build().unwrap();
        let korenberg = case["korenberg_stop"].as_bool().unwrap();
        let rule = StopRule {
            max_terms: integer("max_terms") as usize,
            mse_ratio: None,
            noise: if korenberg { NoiseRule::Korenberg } else { NoiseRule::Off },
        };
        let fit = fit(&[&signal], &[0..signal.len()], &pool, &rule).unwrap();

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
    let Some((reference, signal)) = reference("gaps_S1_shared") else { return };
    let tolerance = number(&reference["tolerance_relative"]);
    for case in reference["cases"].as_array().unwrap() {
        let terms: Vec<Monomial> = case["terms"].as_array().unwrap().iter().map(monomial).collect();
        let max_lag = y(case["max_lag"].as_u64().unwrap() as u16);
        let rows = Rows::usable(&[&signal], &[0..signal.len()], &[max_lag]).unwrap();
        assert_eq!(rows.count() as u64, case["rows_used"].as_u64().unwrap());
        assert!(terms[0].is_empty(), "the constant comes first");
        let fit = refit::refit(&[&signal], &rows, &terms[1..]).unwrap();
        let fitted = std::iter::once(fit.constant).chain(fit.coefficients);
        for (value, expected) in fitted.zip(case["coef"].as_array().unwrap()) {
            assert_close("coefficient", value, number(expected), tolerance);
        }
        assert_close("mse", fit.mse, number(&case["mse"]), tolerance);
    }
}

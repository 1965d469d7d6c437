//! The diagnosis against series with one planted effect whose answer was computed independently, where the reference files
//! are at hand.
#![allow(clippy::single_range_in_vec_init, reason = "a list of one segment")]

use fos_core::{u, y};
use serde_json::Value;

use fos_fit::candidates::Candidates;
use fos_fit::fit::{Search, StopRule, fit, refit};
use fos_fit::moments::Rows;

use crate::detect::{Diagnosis, Question, Verdict, diagnose};
use crate::effects::{Inputs, Library, Regressor};
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_testkit::reference::{self, number};

/// Channels of the files, as the library knows them: the effects do not care that the unit of y is anybody's guess.
const COLUMNS: [(&str, &str); 5] = [
    ("y", "gx_rads"),
    ("temp_degC", "temp_c"),
    ("ax_m_s2", "ax_mps2"),
    ("volt_V", "supply_v"),
    ("mag_uT", "mag_x_ut"),
];

fn recording(answers: &Value, name: &str) -> Recording {
    let samples = reference::samples(name);
    let series = &answers["series"];
    let length = series["samples"].as_u64().unwrap() as usize;
    let rate = number(&answers["sample_rate_hz"]);
    let time = (0..length).map(|n| n as f64 / rate).collect();
    let mut columns = vec![("t_s".to_owned(), time)];
    for ((theirs, ours), channel) in COLUMNS.into_iter().zip(samples.chunks_exact(length)) {
        let at = columns.len() - 1;
        assert_eq!(series["channels"][at], theirs);
        columns.push((ours.to_owned(), channel.to_vec()));
    }
    Recording::from_columns(Source::made_by(name), columns, &LoadOptions::default()).unwrap()
}

fn diagnosed(recording: &Recording, library: &Library) -> Diagnosis {
    let question = Question {
        field: recording,
        quiet: None,
        judged: None,
        target: "gx_rads",
        sheet: None,
        full_scale: None,
        lsb: None,
        library,
        given: &[],
    };
    diagnose(&question).unwrap()
}

/// One-step mean square error on the rows of the reference, in the unit of the file: AR(2) and what the search keeps of the
/// powers and delays of `columns`.
fn searched_mse(recording: &Recording, columns: &[&str]) -> f64 {
    /// Delays that are tried, samples.
    const DELAYS: u16 = 10;
    let values = |column: &str| &recording.channel(column).unwrap().values;
    let scaled = |values: &[f64]| -> Vec<f64> {
        let (mean, deviation) =
            (fos_fit::signal::mean(&[values]), fos_fit::signal::variance(&[values]).sqrt());
        values.iter().map(|value| (value - mean) / deviation).collect()
    };
    let output = values("gx_rads");
    let mut signals = vec![scaled(output)];
    signals.extend(columns.iter().map(|column| scaled(values(column))));
    let signals: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
    let mut pool = Candidates::builder().output(1..=2, 1);
    for input in 0..columns.len() as u8 {
        pool = pool.input(input, 0..=DELAYS, 2);
    }
    let reach = if columns.is_empty() { 2 } else { usize::from(DELAYS) };
    let segments = [20 - reach..output.len()];
    let fit =
        fit(&signals, &segments, &pool.build().unwrap(), &StopRule::default(), Search::Exchange).unwrap();
    assert_eq!(fit.refit.rows, output.len() - 20, "the rows of the reference");
    println!("  {columns:?}: {:?}", fit.terms);
    fit.refit.mse * fos_fit::signal::variance(&[output])
}

/// The same with the regressors of the diagnosis as they stand, without delay.
fn prompt_mse(recording: &Recording, diagnosis: &Diagnosis) -> f64 {
    let inputs = Inputs::new(recording);
    let terms = diagnosis.findings.iter().flat_map(|finding| &finding.correction);
    let parsed = terms.filter_map(|term| Regressor::parse(&term.regressor).ok());
    let regressors: Vec<_> = parsed.map(|regressor| inputs.regressor(&regressor).unwrap()).collect();
    let mut signals: Vec<&[f64]> = vec![&recording.channel("gx_rads").unwrap().values];
    signals.extend(regressors.iter().map(|regressor| &regressor[..]));
    let mut terms = vec![vec![y(1)], vec![y(2)]];
    terms.extend((0..regressors.len() as u8).map(|input| vec![u(input, 0)]));
    let rows = Rows::usable(&signals, &[18..recording.n_rows()], terms.iter().flatten()).unwrap();
    refit::refit(&signals, &rows, &terms).unwrap().mse
}

/// Diagnoses the series; the only finding must be `effect` on `column`, and a search over that channel must come within half
/// a percent of the error that the true effect leaves. The diagnosis, where the files are.
fn assert_found(name: &str, library: &Library, effect: &str, column: &str) -> Option<Diagnosis> {
    let answers = reference::json(name)?;
    let recording = recording(&answers, name);
    let expected = &answers["expected"];
    // rounding of another factorisation
    assert!((searched_mse(&recording, &[]) / number(&expected["mse_ar2_only"]) - 1.0).abs() < 1e-9);

    let diagnosis = diagnosed(&recording, library);
    println!("{name}: {:?}, {}", diagnosis.verdict, diagnosis.sentence);
    println!("  without delay: {:e}", prompt_mse(&recording, &diagnosis));
    assert_eq!(diagnosis.findings.len(), 1, "and no other");
    let finding = &diagnosis.findings[0];
    assert_eq!(finding.effect, effect);
    let regressors = finding.correction.iter().map(|term| Regressor::parse(&term.regressor).unwrap());
    let mut columns: Vec<String> =
        regressors.flat_map(|regressor| regressor.columns().map(str::to_owned).collect::<Vec<_>>()).collect();
    columns.dedup();
    assert_eq!(columns, [column]);
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let found = searched_mse(&recording, &columns);
    let truth = number(&expected["mse_with_true_effect"]);
    println!("  refitted: {found:e}, with the true effect {truth:e}");
    // less than that would be noise that was fitted
    assert!((found / truth - 1.0).abs() < 0.005, "{found:e} for {truth:e}");
    Some(diagnosis)
}

#[test]
fn names_a_bias_that_is_linear_in_temperature() {
    let found = assert_found("effect_temp_linear", &Library::built_in(), "temp_linear", "temp_c");
    assert!(found.is_none_or(|found| found.verdict == Verdict::Missing));
}

#[test]
fn names_a_bias_that_follows_the_supply() {
    let found = assert_found("effect_supply_ratio", &Library::built_in(), "supply_sensitivity", "supply_v");
    assert!(found.is_none_or(|found| found.verdict == Verdict::Missing));
}

#[test]
fn names_a_bias_that_follows_vibration() {
    let name = "effect_vibration_rectification";
    let Some(found) = assert_found(name, &Library::built_in(), "vibration_rectification", "ax_mps2") else {
        return;
    };
    assert_eq!(found.verdict, Verdict::Missing);
    // of the three axes one is logged: that is enough for what vibration does, and too little for what tilt does
    assert!(found.untested.iter().any(|untested| untested.effect == "cross_axis"));
    assert!(found.untested.iter().all(|untested| untested.effect != "vibration_rectification"));
}

//! Tests the diagnosis on series with one planted effect and an independently computed answer: our own fixtures, and
//! external ones if they are installed.
#![allow(clippy::single_range_in_vec_init, reason = "a list of one segment")]

use fos_core::{u, y};
use fos_fit::candidates::Candidates;
use fos_fit::fit::{Search, StopRule, fit, refit};
use fos_fit::moments::Rows;

use crate::detect::{Diagnosis, Question, Verdict, diagnose};
use crate::effects::{Inputs, Library, Regressor};
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_testkit::reference::{self, Reference, number};

/// Column names in the files and in the library. The unit of y is unknown, which does not matter to the effects.
const COLUMNS: [(&str, &str); 5] = [
    ("y", "gx_rads"),
    ("temp_degC", "temp_c"),
    ("ax_m_s2", "ax_mps2"),
    ("volt_V", "supply_v"),
    ("mag_uT", "mag_x_ut"),
];

fn recording(Reference { name, answers, channels }: &Reference) -> Recording {
    let rate = number(&answers["sample_rate_hz"]);
    let time = (0..channels[0].len()).map(|n| n as f64 / rate).collect();
    let mut columns = vec![("t_s".to_owned(), time)];
    for (at, ((theirs, ours), channel)) in COLUMNS.into_iter().zip(channels).enumerate() {
        assert_eq!(answers["series"]["channels"][at], theirs);
        columns.push((ours.to_owned(), channel.clone()));
    }
    // thresholds of motion are absolute and mean nothing in the unit of y
    let options = LoadOptions { keep_moved: true, ..LoadOptions::default() };
    Recording::from_columns(Source::made_by(name), columns, &options).unwrap()
}

fn diagnosed(recording: &Recording, library: &Library) -> Diagnosis {
    let question = Question::new(recording, "gx_rads", library);
    diagnose(&question).unwrap()
}

/// One-step mean square error on the rows of the reference, in the unit of the file, of AR(2) and the terms that the
/// search selects from powers and delays of `columns`.
fn searched_mse(recording: &Recording, columns: &[&str]) -> f64 {
    /// Largest delay tried, samples.
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

/// The same for the regressors of the diagnosis without delay.
fn prompt_mse(recording: &Recording, diagnosis: &Diagnosis) -> f64 {
    let inputs = Inputs::new(recording);
    let terms = diagnosis.findings.iter().flat_map(|finding| &finding.correction);
    let parsed = terms.filter_map(|term| Regressor::parse(&term.regressor).ok());
    let regressors: Vec<_> = parsed.map(|regressor| inputs.regressor(&regressor).unwrap()).collect();
    let mut signals: Vec<&[f64]> = vec![&recording.channel("gx_rads").unwrap().values];
    signals.extend(regressors.iter().map(|regressor| &regressor[..]));
    let mut terms = vec![vec![y(1)], vec![y(2)]];
    terms.extend((0..regressors.len() as u8).map(|input| vec![u(input, 0)]));
    let rows = Rows::usable(&signals, &[18..recording.n_rows()], terms.iter().flatten());
    refit::refit(&signals, &rows, &terms).unwrap().mse
}

/// Diagnoses the series. The only finding must be `effect` on `column`, and a search over that channel must come within
/// 0.5 % of the error with the true effect.
fn assert_found(reference: &Reference, effect: &str, column: &str) -> Diagnosis {
    let name = &reference.name;
    let recording = recording(reference);
    let expected = &reference.answers["expected"];
    // tolerance for the rounding of another factorisation
    assert!((searched_mse(&recording, &[]) / number(&expected["mse_ar2_only"]) - 1.0).abs() < 1e-9);

    let diagnosis = diagnosed(&recording, &Library::built_in());
    println!("{name}: {:?}, {}", diagnosis.verdict, diagnosis.sentence);
    println!("  without delay: {:e}", prompt_mse(&recording, &diagnosis));
    assert_eq!(diagnosis.verdict, Verdict::Missing, "{name}: {}", diagnosis.sentence);
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
    // a smaller error would mean that noise was fitted
    assert!((found / truth - 1.0).abs() < 0.005, "{name}: {found:e} for {truth:e}");
    diagnosis
}

#[test]
fn identifies_linear_temperature_drift() {
    for reference in reference::each("effect_temp_linear", "effect_temp_linear") {
        assert_found(&reference, "temp_linear", "temp_c");
    }
}

#[test]
fn identifies_supply_sensitivity() {
    for reference in reference::each("effect_supply_sensitivity", "effect_supply_ratio") {
        assert_found(&reference, "supply_sensitivity", "supply_v");
    }
}

#[test]
fn identifies_vibration_rectification() {
    for reference in reference::each("effect_vibration_rectification", "effect_vibration_rectification") {
        let found = assert_found(&reference, "vibration_rectification", "ax_mps2");
        // one of three axes is logged: enough for vibration, too little for tilt
        assert!(found.untested.iter().any(|untested| untested.effect == "cross_axis"));
        assert!(found.untested.iter().all(|untested| untested.effect != "vibration_rectification"));
    }
}

//! A fit uses only the rows that it is fitted to; and a rival uses those rows, and no part of the model.

use fos_core::{Range, Validity};
use fos_data::column::AXES;
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::stillness;
use fos_diagnose::compare::study_of;
use fos_diagnose::study::Study;
use fos_fit::evaluate::{MODEL, Rival};
use fos_fit::fit::{AxisFit, FitOptions, Train, fit_axis, rest};
use fos_fit::model::UnitModel;
use fos_fit::playback::Playback;
use fos_testkit::is_thorough;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const RATE_HZ: f64 = 100.0;

type Columns = Vec<(String, Vec<f64>)>;

/// Six axes and a temperature, marked as at rest throughout; the temperature is steady until `warm_from`, then rises by
/// 4 K in 3 minutes.
fn log(rows: usize, warm_from: usize, seed: u64) -> Columns {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let mut columns: Columns =
        AXES.iter().map(|axis| ((*axis).to_owned(), (0..rows).map(|_| normal()).collect())).collect();
    let warm = |row: usize| 4.0 * (row.saturating_sub(warm_from) as f64 / (180.0 * RATE_HZ)).min(1.0);
    columns.push(("temp_c".to_owned(), (0..rows).map(|row| 30.0 + warm(row) + 0.02 * normal()).collect()));
    columns.push(("still".to_owned(), vec![1.0; rows]));
    columns
}

fn recording(columns: Columns) -> Recording {
    let options = LoadOptions { rate_hz: Some(RATE_HZ), ..LoadOptions::default() };
    Recording::from_columns(Source::made_by("test"), columns, &options).expect("a recording")
}

fn options(physical: &[&str], inputs: &[&str]) -> FitOptions {
    let specs = |texts: &[&str]| texts.iter().map(|text| text.parse().expect("an input")).collect();
    FitOptions {
        physical: specs(physical),
        inputs: specs(inputs),
        train: Train::Share(0.5),
        ..FitOptions::default()
    }
}

fn fitted(columns: Columns, options: &FitOptions) -> AxisFit {
    let recording = recording(columns);
    fit_axis(&recording, &rest(&recording, options.train), "gx", options).expect("a fit")
}

/// Model and report, as stored in a study.
fn text(fit: &AxisFit) -> String {
    serde_json::to_string(&(&fit.model, &fit.report)).expect("JSON")
}

/// Inputs used to be centred and scaled over the whole log: a warm-up outside of the fit shifted the centre, and an
/// insignificant coefficient times that distance entered the constant of the stochastic part, which fades after a minute
/// of motion.
#[test]
fn unfitted_rows_have_no_influence() {
    const ROWS: usize = 12_000;
    let mut columns = log(ROWS, 0, 3);
    // a signal to fit: an autoregression and a temperature coefficient
    let temp_c = columns[6].1.clone();
    let gyro = &mut columns[3].1;
    for row in 1..ROWS {
        gyro[row] += 0.6 * gyro[row - 1];
    }
    gyro.iter_mut().zip(&temp_c).for_each(|(rate, temp)| *rate += 0.8 * (temp - 30.0));
    // arbitrary values after the fitted rows
    let mut other = columns.clone();
    for (index, (name, values)) in other.iter_mut().enumerate().filter(|(_, (name, _))| *name != "still") {
        let (gain, shift) = if name == "temp_c" { (-9.0, 40.0) } else { (57.0, 3.0 + index as f64) };
        values[ROWS / 2..].iter_mut().for_each(|value| *value = gain * *value + shift);
        values[ROWS / 2 + 100..ROWS / 2 + 400].fill(1.0);
        values[ROWS - 1] = -32_768.0;
    }
    let mut inside = columns.clone();
    inside[6].1[ROWS / 2 - 1] += 0.5;
    let ways = [
        options(&[], &[]),
        options(&["temp_c"], &[]),
        options(&["temp_c:lowpass(20)", "clock:decay(60)"], &[]),
        options(&[], &["temp_c", "ax_mps2:variance(1)"]),
    ];
    let mut noticed = 0;
    for way in &ways {
        let fit = text(&fitted(columns.clone(), way));
        assert_eq!(fit, text(&fitted(other.clone(), way)), "{way:?}");
        noticed += usize::from(fit != text(&fitted(inside.clone(), way)));
    }
    assert_eq!(noticed, 3, "the ways that follow the temperature");
    println!(
        "attack: fitted rows | {} ways to fit, on a log whose other half is scaled, shifted, stuck and spiked in every column: model and report are identical byte for byte | negative control: a change of 0.5 K in one of {} fitted rows is detected in all {noticed} that depend on temperature",
        ways.len(),
        ROWS / 2
    );
}

/// Two thermometers that differ only in their noise: each has a coefficient, and their sum is that of a single one. p is
/// stored as on the fitted rows, whatever follows.
#[test]
fn range_of_p_covers_the_fitted_rows() {
    const ROWS: usize = 12_000;
    let mut columns = log(ROWS, 0, 5);
    let temp_c = columns[6].1.clone();
    let case_c: Vec<f64> = columns[0].1.iter().zip(&temp_c).map(|(noise, t)| t + 0.02 * noise).collect();
    let apart = temp_c.iter().zip(&case_c).map(|(temp, case)| 40.0 * (temp - case));
    columns[3].1.iter_mut().zip(apart).for_each(|(rate, apart)| *rate += apart);
    columns.push(("case_temp_c".to_owned(), case_c));
    columns[6].1[ROWS / 2..].fill(40.0);
    columns[8].1[ROWS / 2..].fill(20.0);
    let recording = recording(columns);
    let options = options(&["temp_c", "case_temp_c"], &[]);
    let stillness = rest(&recording, options.train);
    let fit = fit_axis(&recording, &stillness, "gx", &options).expect("a fit");
    assert_eq!(fit.model.axes[0].physical.len(), 2, "{:?}", fit.report.left_out);
    let parameters = fit.model.axes[0].parameters;
    let mut physical = fit.model.clone();
    physical.axis_mut().stochastic.clear();
    physical.axis_mut().parameters.constant = 0.0;
    let p = |model: &UnitModel| -> Vec<(f64, Validity)> {
        let playback = Playback::new(&recording, model, &stillness.still).expect("a playback");
        let mut predictor = model.predictor::<f64>().expect("a model");
        let mut feed = playback.feed();
        let outputs = (0..ROWS).map(|row| {
            let output = feed.coast(&mut predictor, row)[0];
            ((output.predicted - parameters.offset) / parameters.scale, output.validity)
        });
        outputs.collect()
    };
    let limited = p(&physical);
    let fitted = &limited[..ROWS / 2];
    let Range { low, high } = parameters.physical_range;
    let least = fitted.iter().map(|(p, _)| *p).fold(f64::INFINITY, f64::min);
    let most = fitted.iter().map(|(p, _)| *p).fold(f64::NEG_INFINITY, f64::max);
    let width = most - least;
    assert!(
        (least - low).abs() < 1e-3 * width && (most - high).abs() < 1e-3 * width,
        "{low} … {high}, {least} … {most}"
    );
    assert!(fitted.iter().all(|(_, validity)| !validity.contains(Validity::INPUT_OUT_OF_RANGE)));
    // warm and cold: neither input beyond its own range by more than a twentieth, and limited together
    physical.axis_mut().parameters.physical_range = Range::unlimited();
    let after = ROWS / 2 + 10..ROWS;
    let without = p(&physical)[after.clone()].iter().map(|(p, _)| p.abs()).fold(0.0, f64::max);
    let with = limited[after.clone()].iter().map(|(p, _)| p.abs()).fold(0.0, f64::max);
    assert!(without > 5.0 * width && with < 2.1 * width, "{without}, {with} of {width}");
    assert!(limited[after].iter().all(|(_, validity)| validity.contains(Validity::INPUT_OUT_OF_RANGE)));
}

/// Study of a fit, evaluated on the rows after it.
fn evaluation(columns: Columns, options: &FitOptions) -> (Study, AxisFit) {
    let recording = recording(columns);
    let stillness = rest(&recording, options.train);
    let fit = fit_axis(&recording, &stillness, "gx", options).expect("a fit");
    let read = LoadOptions::default();
    let study = study_of(&recording, &stillness, vec![fit.clone()], options.clone(), read, &mut |_| {});
    (study.expect("a study"), fit)
}

/// White noise, a steady temperature in the fitted half and 4 K of warm-up in the other: 8 of 24 such models used to
/// coast worse than the mean, "valid 100.0 %".
#[test]
fn insignificant_coefficient_is_excluded_and_no_coast_is_worse_than_the_mean() {
    const ROWS: usize = 60_000;
    let (mut left_out, mut worst) = (0, 0.0_f64);
    let logs = if is_thorough() { 24 } else { 6 };
    for seed in 0..logs {
        let way = options(&["temp_c"], &[]);
        let (study, fit) = evaluation(log(ROWS, ROWS / 2, 100 + seed), &way);
        let coast = |name: &str| {
            let errors = study.steps.iter().find(|step| step.name == name);
            errors.expect("errors").errors[0].coast_whole_mse
        };
        left_out += fit.report.left_out.len();
        worst = worst.max(coast(MODEL) / coast(Rival::Mean.name()));
    }
    // a term passes the threshold, 3.2 standard errors, once in 700 logs
    assert!(left_out + 1 >= logs as usize, "{left_out}");
    // and adds the square of its error, some 10 of 30,000, times that of the edge of its range
    assert!(worst < 1.01, "{worst}");
}

/// The rival's constant used to be the residual of the physical part, its range that of the stochastic part: the model
/// seemed better.
#[test]
fn rival_depends_on_the_fitted_rows_only() {
    const ROWS: usize = 12_000;
    let mut columns = log(ROWS, 0, 9);
    let clock: Vec<f64> = (0..ROWS).map(|row| 30.0 * (-(row as f64) / 3000.0).exp()).collect();
    columns[3].1.iter_mut().zip(&clock).for_each(|(rate, warm)| *rate += warm);
    let rate = columns[3].1.clone();
    let (study, fit) = evaluation(columns, &options(&["clock:decay(30)"], &[]));
    assert_eq!(fit.model.axes[0].physical.len(), 1);
    let (fitted, evaluation) = rate.split_at(ROWS / 2);
    let mean = fitted.iter().sum::<f64>() / fitted.len() as f64;
    let of = |name: &str| {
        study.steps.iter().find(|step| step.name == name).expect("errors").errors[0].one_step_mse
    };
    let by_hand =
        evaluation.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / evaluation.len() as f64;
    assert!((of(Rival::Mean.name()) / by_hand - 1.0).abs() < 1e-9, "{} {by_hand}", of(Rival::Mean.name()));
    // the first evaluated row has no row before it in the trace
    let steps = evaluation.windows(2).map(|pair| (pair[1] - pair[0]).powi(2));
    let held = steps.sum::<f64>() / (evaluation.len() - 1) as f64;
    assert!(
        (of(Rival::LastValue.name()) / held - 1.0).abs() < 1e-2,
        "{} {held}",
        of(Rival::LastValue.name())
    );
}

#[test]
fn rejects_a_constant_or_missing_input_by_name() {
    const ROWS: usize = 4000;
    let mut columns = log(ROWS, ROWS / 2, 1);
    let refused = |columns: &Columns| {
        let recording = recording(columns.clone());
        let error = fit_axis(&recording, &stillness::find(&recording), "gx", &options(&["temp_c"], &[]));
        error.expect_err("refused").to_string()
    };
    columns[6].1[..ROWS / 2].fill(25.0);
    assert!(
        refused(&columns).contains("temp_c is 25.0 in every row that is fitted"),
        "{}",
        refused(&columns)
    );
    columns[6].1[..ROWS / 2].fill(f64::NAN);
    assert!(
        refused(&columns).contains("temp_c has no value in the rows that are fitted"),
        "{}",
        refused(&columns)
    );
}

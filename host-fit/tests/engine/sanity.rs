//! Implausible logs cause a warning or are rejected; plausible ones cause no warning.

use fos_data::column::AXES;
use fos_data::recording::{LoadOptions, LogWarning, Recording, Source, load};
use fos_data::stillness;
use fos_diagnose::detect::{Question, diagnose};
use fos_diagnose::effects::Library;
use fos_fit::fit::{FitOptions, fit_axis};
use fos_simulate::{self, CasePlan, Durations, Kind, simulate_case, suite};
use fos_testkit::is_thorough;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

type Columns = Vec<(String, Vec<f64>)>;

const ROWS: usize = 20_000;

/// Six axes at rest, z up.
fn log(gain: f64, seed: u64) -> Columns {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let level = |axis: &str| if axis == "az_mps2" { 9.8 } else { 0.0 };
    let noise = |axis: &str| gain * if axis.starts_with('a') { 0.02 } else { 0.001 };
    let of_axis =
        |axis: &str| (axis.to_owned(), (0..ROWS).map(|_| level(axis) + noise(axis) * normal()).collect());
    AXES.map(of_axis).into()
}

fn recording(rate_hz: f64, columns: Columns) -> Recording {
    let options = LoadOptions { rate_hz: Some(rate_hz), ..LoadOptions::default() };
    Recording::from_columns(Source::made_by("test"), columns, &options).expect("a recording")
}

fn warnings_of(recording: &Recording) -> Vec<LogWarning> {
    recording.warnings(&stillness::find(recording).still)
}

fn refused(text: &str, rate_hz: Option<f64>) -> String {
    let file = tempfile::Builder::new().suffix(".csv").tempfile().expect("a file");
    std::fs::write(file.path(), text).expect("written");
    load(file.path(), &LoadOptions { rate_hz, ..LoadOptions::default() }).expect_err("refused").to_string()
}

/// A stuck axis used to be diagnosed as "Nothing is missing".
#[test]
fn rejects_a_stuck_axis_by_name() {
    let mut columns = log(1.0, 1);
    columns[3].1.fill(0.5);
    let field = recording(100.0, columns);
    let library = Library::built_in();
    let question = Question::new(&field, "gx", &library);
    let error = diagnose(&question).expect_err("refused").to_string();
    assert!(error.contains("gx_rads") && error.contains("0.5") && error.contains("stuck"), "{error}");
    assert!(warnings_of(&field).iter().any(|warning| matches!(warning, LogWarning::Stuck { .. })));
}

/// One sample of −32768 in 10,000 used to shift the offset by 3.3 standard deviations and the scale 328-fold, silently.
#[test]
fn excludes_and_reports_an_outlier() {
    // a single axis: no other one shows that the device was at rest
    let columns: Columns = log(1.0, 2).drain(3..4).collect();
    let mut wild = columns.clone();
    wild[0].1[4321] = -32.768;
    let fitted = |columns: &Columns| {
        let recording = recording(100.0, columns.clone());
        let fit =
            fit_axis(&recording, &stillness::find(&recording), "gx", &FitOptions::default()).expect("a fit");
        (fit.model.axes[0].parameters, fit.report.spikes, warnings_of(&recording))
    };
    let ((whole, none, nothing), (without, one, warnings)) = (fitted(&columns), fitted(&wild));
    assert_eq!((none, one), (0, 1));
    assert!(nothing.is_empty(), "{nothing:?}");
    assert!(
        warnings.iter().any(|warning| warning.to_string().contains("excluded 1 outlier (")),
        "{warnings:?}"
    );
    assert!((without.offset - whole.offset).abs() < 0.01 * whole.scale);
    assert!((without.scale / whole.scale - 1.0).abs() < 0.01);
    // negative control: the mean of all ten thousand fitted rows
    let fitted_rows = &wild[0].1[..ROWS / 2];
    let naive = fitted_rows.iter().sum::<f64>() / fitted_rows.len() as f64;
    assert!((naive - whole.offset).abs() > 3.0 * whole.scale);
}

/// Used to print "2736.8 Hz, 41 times the stamps go back" with exit code 0, and to ignore `--rate 50` for 0.8533 Hz.
#[test]
fn rejects_unordered_timestamps_and_prefers_a_stated_rate() {
    let mut rows: Vec<usize> = (0..1000).collect();
    rows.shuffle(&mut ChaCha8Rng::seed_from_u64(3));
    let csv = |rows: &[usize], period_s: f64| {
        let line = |row: &usize| format!("{},{}\n", *row as f64 * period_s, (row * 7919 % 101) as f64);
        rows.iter().map(line).fold("t_s,gx_rads\n".to_owned(), |text, line| text + &line)
    };
    let error = refused(&csv(&rows, 0.01), None);
    assert!(error.contains("goes back") && error.contains("sort the rows by t_s"), "{error}");
    rows.truncate(100);
    let error = refused(&csv(&rows, 0.01), None);
    assert!(error.contains("in 100 rows"), "{error}");
    rows.sort_unstable();
    let in_order: Vec<usize> = (0..1000).collect();
    let folder = tempfile::TempDir::new().expect("a folder");
    let path = folder.path().join("log.csv");
    std::fs::write(&path, csv(&in_order, 1.0 / 0.8533)).expect("written");
    let options = LoadOptions { rate_hz: Some(50.0), ..LoadOptions::default() };
    let log = load(&path, &options).expect("a log");
    let warnings = warnings_of(&log).iter().map(ToString::to_string).collect::<String>();
    assert!(
        log.rate.true_hz == 50.0 && warnings.contains("50 Hz replaces") && warnings.contains("0.8533"),
        "{warnings}"
    );
}

#[test]
fn warns_when_pooling_logs_that_differ() {
    let stamped = |rate_hz: f64, gain: f64, seed| {
        let mut columns = log(gain, seed);
        columns.push(("t_s".to_owned(), (0..ROWS).map(|row| row as f64 / rate_hz).collect()));
        Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default())
            .expect("a recording")
    };
    let warnings_of_joined = |logs: Vec<Recording>| warnings_of(&Recording::join(logs).expect("joined"));
    assert!(warnings_of_joined(vec![stamped(100.0, 1.0, 1), stamped(100.0, 1.0, 2)]).is_empty());
    let rates = warnings_of_joined(vec![stamped(100.0, 1.0, 1), stamped(101.0, 1.0, 2)]);
    assert!(matches!(rates[..], [LogWarning::RatesDiffer { .. }]), "{rates:?}");
    let noise = warnings_of_joined(vec![stamped(100.0, 1.0, 1), stamped(100.0, 57.0, 2)]);
    let ratios: Vec<f64> = noise
        .iter()
        .filter_map(|warning| match warning {
            LogWarning::NoiseDiffers { ratio, .. } => Some(*ratio),
            _ => None,
        })
        .collect();
    assert!(ratios.len() == 6 && ratios.iter().all(|ratio| (ratio / 57.0 - 1.0).abs() < 0.1), "{noise:?}");
}

#[test]
fn warns_of_wrong_units_and_duplicated_columns() {
    let mut columns = log(1.0, 5);
    for axis in &mut columns[..3] {
        axis.1.iter_mut().for_each(|value| *value /= 9.806_65);
    }
    columns[4].1.iter_mut().for_each(|rate| *rate = 57.3 * (*rate + 0.05));
    columns[5].1 = columns[3].1.clone();
    let warnings: Vec<String> =
        warnings_of(&recording(100.0, columns)).iter().map(ToString::to_string).collect();
    for word in ["gravity is 9.81", "gy_rads shows 2.8", "gx_rads and gz_rads hold the same values"] {
        assert!(warnings.iter().any(|line| line.contains(word)), "{word}: {warnings:?}");
    }
}

/// Simulated devices, with effects and without, cause no warning.
#[test]
fn plausible_logs_cause_no_warning() {
    let is_sound = |plan: &CasePlan| {
        let faults = ["saturation", "dropped_samples", "quantisation"];
        plan.kind != Kind::Outside
            && plan.planted.iter().all(|plant| !faults.contains(&plant.effect.description().name))
    };
    let plans: Vec<CasePlan> =
        suite(20_261_122, if is_thorough() { 60 } else { 20 }).into_iter().filter(is_sound).collect();
    let warnings: Vec<String> = plans
        .par_iter()
        .flat_map(|plan| {
            let durations = Durations { reference_s: 120.0, log_s: 400.0, evaluation_s: 120.0 };
            let case = simulate_case(&CasePlan { durations, ..plan.clone() });
            let case: fos_simulate::SimulatedCase = case.expect("a case");
            let options = LoadOptions { rate_hz: Some(case.meta.nominal_rate_hz), ..LoadOptions::default() };
            [case.reference, case.log, case.evaluation]
                .into_iter()
                .flat_map(|columns| {
                    let log = Recording::from_columns(Source::made_by("test"), columns, &options);
                    let setup = plan.setup;
                    let warnings = warnings_of(&log.expect("a recording"));
                    warnings
                        .into_iter()
                        .map(move |warning| format!("{setup:?}: {warning}"))
                        .collect::<Vec<_>>()
                })
                .collect::<Vec<_>>()
        })
        .collect();
    assert!(warnings.is_empty(), "{warnings:#?}");
    println!(
        "attack: sound logs | {} valid logs of {} simulated devices give no warning; a stuck axis, reversed timestamps and a wrong stated rate are refused; an outlier is excluded; outliers, wrong units, copied axes, resampling and unusual noise are reported | negative control: a single sample of −32768 moves the mean of a fit that includes it by 3 standard deviations",
        3 * plans.len(),
        plans.len()
    );
}

//! The user's path from a failing model to a corrected one, on the command line, on data with a hidden effect.

use std::path::{Path, PathBuf};

use crate::session::{done, fails};
use fos_diagnose::batch::Answers;
use fos_diagnose::detect::{Diagnosis, Verdict};
use fos_diagnose::study::Refinement;
use fos_diagnose::study::Study;
use fos_simulate::{Axis, CasePlan, Durations, Effect, Plant, Setup, simulate_case};

/// Writes a case with this effect hidden in gyro x. Its logs are shorter than those of `fos simulate --case`, which the
/// tutorials run.
fn write_case(folder: &Path, effect: &str, parameter: Option<f64>, size: f64, setup: Setup, seed: u64) {
    let effect = Effect::named(effect).expect("an effect");
    let mut plan = CasePlan::new(seed, "bmi270", setup, Axis::Gx);
    plan.planted = vec![Plant { effect, parameter, size }];
    plan.durations = Durations { reference_s: 300.0, log_s: LOG_S, evaluation_s: 400.0 };
    simulate_case(&plan).expect("a case").write(folder).expect("written");
}

const LOG_S: f64 = 900.0;

/// A folder with a case `unit` with this effect hidden in gyro x, and the study `unit.json` of its reference log.
fn with_hidden(effect: &str, parameter: Option<f64>, setup: Setup, seed: u64) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write_case(&folder.path().join("unit"), effect, parameter, 100.0, setup, seed);
    done(folder.path(), &["fit", "unit/reference.parquet", "--axis", "gx", "-o", "unit.json"]);
    folder
}

const FIELD: [&str; 2] = ["--from", "unit/log.parquet"];
const LATER: [&str; 2] = ["--evaluate-on", "unit/evaluation.parquet"];

fn refinement(folder: &Path) -> Refinement {
    Study::read(&folder.join("unit.json"))
        .expect("a study")
        .refinement_of("gx_rads")
        .expect("a refinement")
        .clone()
}

#[test]
fn identifies_adds_and_removes_a_hidden_effect() {
    let folder = with_hidden("thermal_lag", Some(60.0), Setup::Bench, 3);
    let folder = folder.path();

    let diagnose = [&["diagnose", "unit.json", "--json"][..], &FIELD, &LATER].concat();
    let text = done(folder, &diagnose);
    let answers: Vec<Diagnosis> = serde_json::from_str(&text).expect("answers");
    let json: serde_json::Value = serde_json::from_str(&text).expect("answers");
    let finding = |key: &str| json[0]["findings"][0][key].as_f64().expect("a number");
    let (of_variance, of_rms) = (finding("expected_drop"), finding("rms_reduction"));
    assert!((of_rms - (1.0 - (1.0 - of_variance).sqrt())).abs() < 1e-12, "{of_rms} for {of_variance}");
    assert_eq!(answers[0].verdict, Verdict::Missing);
    assert_eq!(answers[0].findings[0].effect, "thermal_lag");

    // an effect of little benefit can be added, and removed again
    let add = [&["add", "unit.json", "temp_linear"][..], &FIELD, &LATER].concat();
    let printed = done(folder, &add);
    assert!(printed.contains("+ temp_linear") && printed.contains("slow error, °/"), "{printed}");
    let message = fails(folder, 1, &["add", "unit.json", "temp_linear"]);
    assert!(message.contains("in the model already") && message.contains("undo"), "{message}");
    let before = refinement(folder).steps[0].clone();
    assert!(done(folder, &["undo", "unit.json"]).contains("removed: temp_linear"));
    assert_eq!(refinement(folder).steps, std::slice::from_ref(&before));
    let study = Study::read(&folder.join("unit.json")).expect("a study");
    assert_eq!(study.model, *before.model, "the model is what it was");
    assert!(fails(folder, 1, &["undo", "unit.json"]).contains("nothing was added"));

    let best = done(folder, &["add", "unit.json", "--best", "--figures", "figures"]);
    assert!(best.contains("Nothing is missing"), "{best}");
    let refined = refinement(folder);
    let [added] = refined.added().collect::<Vec<_>>()[..] else { panic!("one effect: {best}") };
    assert_eq!(added.effect.id, "thermal_lag");
    let tau_s = added.finding.params["tau_s"];
    assert!((tau_s / 60.0 - 1.0).abs() < 0.1, "{tau_s}");
    let [low, high] = added.finding.predicted_reduction_interval;
    assert!(added.measured_reduction > 0.9 && low > 0.9 && high <= 1.0, "{}", added.measured_reduction);
    let [before, after] = &refined.steps[..] else { panic!("two steps") };
    assert!(after.errors.slow_error_coast < before.errors.slow_error_coast.map(|error| 0.2 * error));
    assert!(
        after.cost.instructions > before.cost.instructions && after.cost.ram_bytes > before.cost.ram_bytes
    );
    for format in ["svg", "png"] {
        let figure = folder.join(format!("figures/gx_rads_staircase.{format}"));
        assert!(figure.metadata().is_ok_and(|file| file.len() > 1000), "{}", figure.display());
    }
    assert!(done(folder, &["history", "unit.json"]).contains("+ thermal_lag"));

    // the refined model runs on fos-core with the same reduction as here
    done(folder, &["export", "unit.json", "--image", "unit.fosm"]);
    assert!(done(folder, &["inspect", "unit.fosm"]).contains("temp_c"));
    let replay = ["replay", "unit.fosm", "unit/evaluation.parquet", "--json"];
    let summary: serde_json::Value = serde_json::from_str(&done(folder, &replay)).expect("a summary");
    let axis = &summary["axes"][0];
    let (single, own) = (axis["innovation_rms_f32"].as_f64(), after.errors.one_step_mse.sqrt());
    // the rows of warming up count here and not there
    assert!((single.expect("a number") / own - 1.0).abs() < 1e-3, "{single:?} for {own}");
    assert!(axis["largest_difference"].as_f64().expect("a number") < 1e-3 * own);
}

#[test]
fn holds_out_the_last_part_without_an_evaluation_log() {
    let folder = with_hidden("temp_linear", None, Setup::Bench, 4);
    let folder = folder.path();
    done(folder, &[&["add", "unit.json", "--best"][..], &FIELD].concat());
    let refined = refinement(folder);
    assert!(refined.logs.evaluation.is_none());
    let share = refined.logs.fitted_rows as f64 / (200.0 * LOG_S);
    assert!((share / 0.6 - 1.0).abs() < 0.04, "{share}");
    assert!(refined.added().next().is_some_and(|added| added.effect.id.starts_with("temp")));
    // another log is another staircase
    let other = [&["add", "unit.json", "bias_ramp"][..], &["--from", "unit/evaluation.parquet"]].concat();
    assert!(fails(folder, 1, &other).contains("cannot be compared"));
}

#[test]
fn accepts_a_user_defined_effect() {
    let folder = with_hidden("outside:temp_times_supply", None, Setup::Desk, 5);
    let folder = folder.path();
    let diagnose = [&["diagnose", "unit.json", "--json"][..], &FIELD].concat();
    let answers: Vec<Diagnosis> = serde_json::from_str(&done(folder, &diagnose)).expect("answers");
    assert_eq!(answers[0].verdict, Verdict::Unexplained, "{}", answers[0].sentence);
    assert!(answers[0].leads[0].follows.contains("product of"), "{:?}", answers[0].leads);

    let text = r#"
        id = "temp_times_supply"
        name = "supply sensitivity that warms up"
        band = "slow"
        any_terms = true
        mechanism = "the regulator's reference moves with temperature"
        equation = "p(n) = c · T(n) · V(n) + …"
        experiment = "two supplies at two temperatures"
        [[terms]]
        regressor = "temp_c * supply_v"
        [[terms]]
        regressor = "temp_c"
        [[terms]]
        regressor = "supply_v"
    "#;
    std::fs::write(folder.join("own.toml"), text).expect("written");
    let own = ["add", "unit.json", "temp_times_supply", "--effect", "own.toml"];
    done(folder, &[&own[..], &FIELD, &LATER].concat());
    let refined = refinement(folder);
    let added = refined.added().next().expect("added");
    assert!(added.measured_reduction > 0.5, "{}", added.measured_reduction);
    // the study contains the effect, so the file is no longer needed
    std::fs::remove_file(folder.join("own.toml")).expect("removed");
    done(folder, &["export", "unit.json", "--image", "unit.fosm"]);
    assert!(done(folder, &["history", "unit.json"]).contains("temp_times_supply"));
}

#[test]
fn rejected_additions_state_the_reason() {
    let folder = with_hidden("temp_linear", None, Setup::Bench, 6);
    let folder = folder.path();
    for (effect, reason) in [
        ("gauss_markov", "fit the stochastic part again"),
        ("saturation", "full scale"),
        ("sf_error", "ref_gx_rads"),
        ("lever_arm", "does not strike"),
        ("temp_lineer", "did you mean \"temp_linear\""),
    ] {
        let message = fails(folder, 1, &[&["add", "unit.json", effect][..], &FIELD].concat());
        assert!(message.contains(reason), "{effect}: {message}");
    }
    assert!(fails(folder, 1, &["add", "unit.json", "temp_linear"]).contains("--from"));
    let study = Study::read(&folder.join("unit.json")).expect("a study");
    assert!(study.refinements.is_empty(), "nothing is half-added");
}

#[test]
fn interrupted_batch_resumes_and_answers_every_case() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for (name, effect) in [("one", "mag_sensitivity"), ("two", "bias_ramp")] {
        write_case(&folder.join("cases").join(name), effect, None, 60.0, Setup::PoseRig, 1);
    }
    std::fs::create_dir(folder.join("cases/three")).expect("made");
    std::fs::write(folder.join("cases/three/meta.json"), "{}").expect("written");
    let batch = ["batch", "cases", "-o", "answers"];
    assert!(fails(folder, 1, &batch).contains("could not be diagnosed"));
    let read = || -> Answers {
        let text = std::fs::read(folder.join("answers/answers.json")).expect("answers");
        serde_json::from_slice(&text).expect("answers")
    };
    let answers = read();
    assert_eq!(answers.schema, "fos-answers/1");
    let first = |case: &str| -> (Option<String>, Option<String>) {
        let answer = answers.cases.iter().find(|answer| answer.case == case).expect("an answer");
        let named = answer.diagnosis.as_ref().and_then(|diagnosis| diagnosis.findings.first());
        (named.map(|finding| finding.effect.clone()), answer.error.clone())
    };
    assert_eq!(first("one").0.as_deref(), Some("mag_sensitivity"));
    assert_eq!(first("two").0.as_deref(), Some("bias_ramp"));
    assert!(
        first("three").1.is_some_and(|error| error.contains("meta.json")),
        "one broken case stops no other"
    );
    let corrections: Vec<PathBuf> = ["one_eval", "one_field", "two_eval", "two_field"]
        .map(|name| folder.join(format!("answers/corr/{name}.csv")))
        .to_vec();
    for path in &corrections {
        let text = std::fs::read_to_string(path).expect("a correction");
        assert!(text.starts_with("t_s,corr\n"), "{}", path.display());
    }
    // nothing has changed: the same answers, seconds included
    fails(folder, 1, &batch);
    assert_eq!(read(), answers);
    // a missing correction is computed again
    std::fs::remove_file(&corrections[0]).expect("removed");
    fails(folder, 1, &batch);
    assert!(corrections[0].exists());
}

/// Replaces line breaks by spaces.
fn words(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn every_effect_explains_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let listed = done(folder, &["effects"]);
    for effect in fos_diagnose::effects::Library::built_in().effects() {
        assert!(listed.contains(&effect.id), "{}", effect.id);
        let explained = words(&done(folder, &["effects", &effect.id]));
        for part in [&effect.equation, &effect.mechanism, &effect.experiment, &effect.source] {
            assert!(explained.contains(&words(part)), "{}: {explained}", effect.id);
        }
    }
    assert!(done(folder, &["effects", "--example"]).contains("[[terms]]"));
    assert!(fails(folder, 1, &["effects", "thermal_lagg"]).contains("thermal_lag"));
}

#[test]
fn counts_calibration_outcomes() {
    let folder = tempfile::tempdir().expect("a folder");
    let printed =
        done(folder.path(), &["calibrate", "--cases", "1", "--seed", "77", "--outcomes", "out.json"]);
    assert!(printed.contains("false alarm with nothing missing"), "{printed}");
    let text = std::fs::read(folder.path().join("out.json")).expect("outcomes");
    let outcomes: Vec<serde_json::Value> = serde_json::from_slice(&text).expect("outcomes");
    assert_eq!(outcomes.len(), 1);
}

//! Complete cases, read from their folders and diagnosed: three of our own simulator, and three of another one if
//! available.

use fos_data::case::Case;
use fos_diagnose::case::question;
use fos_diagnose::detect::{Diagnosis, Finding, Verdict, diagnose};
use fos_diagnose::effects::Library;
use fos_simulate::{Axis, CasePlan, Effect, Plant, Planted, Setup, simulate_case};
use fos_testkit::outside;

/// Diagnosis of a case of another simulator.
fn answer(name: &str) -> Option<Diagnosis> {
    let case = Case::read(&outside::path(&format!("cases/{name}"))?).expect("a case");
    Some(diagnose(&question(&case, &Library::built_in())).expect("an answer"))
}

/// Diagnosis of a simulated case with these effects planted, and the planted effects with their resulting values.
fn simulated(seed: u64, setup: Setup, target: Axis, planted: &[Plant]) -> (Diagnosis, Vec<Planted>) {
    let mut plan = CasePlan::new(seed, "bmi160", setup, target);
    plan.planted = planted.to_vec();
    let simulated = simulate_case(&plan).expect("a case");
    let folder = tempfile::tempdir().expect("a folder");
    simulated.write(folder.path()).expect("written");
    let case = Case::read(folder.path()).expect("a case");
    (diagnose(&question(&case, &Library::built_in())).expect("an answer"), simulated.truth.planted)
}

fn assert_missing(diagnosis: &Diagnosis, effect: &str) {
    assert_eq!(diagnosis.verdict, Verdict::Missing, "{}", diagnosis.sentence);
    assert_eq!(diagnosis.findings.len(), 1, "{:?}", diagnosis.findings);
    assert_eq!(diagnosis.findings[0].effect, effect);
}

fn assert_nothing_missing(diagnosis: &Diagnosis) {
    assert_eq!(diagnosis.verdict, Verdict::NothingMissing, "{}", diagnosis.sentence);
    assert!(diagnosis.findings.is_empty() && diagnosis.leads.is_empty());
}

/// Checks that the planted time constant, s, and sensitivity, mg/K, lie in the intervals of the finding.
fn assert_thermal_lag(finding: &Finding, tau_s: f64, mg_per_k: f64) {
    let [low, high] = finding.params_interval["tau_s"];
    assert!((low..=high).contains(&tau_s), "{tau_s}: {low} … {high}");
    let [low, high] = finding.sizes[0].interval;
    assert!(
        (low..=high).contains(&mg_per_k) && finding.sizes[0].unit == "mg/K",
        "{mg_per_k}: {low} … {high}"
    );
}

#[test]
fn identifies_a_planted_strong_g_sensitivity() {
    let strong = Plant { effect: Effect::GSensitivity, parameter: None, size: 150.0 };
    let (diagnosis, _) = simulated(1, Setup::PoseRig, Axis::Gx, &[strong]);
    assert_missing(&diagnosis, "g_sensitivity");
}

#[test]
fn reports_no_effect_without_a_planted_one() {
    assert_nothing_missing(&simulated(2, Setup::Bench, Axis::Gz, &[]).0);
}

#[test]
fn identifies_a_planted_thermal_lag_with_its_time_constant_and_size() {
    let medium = Plant { effect: Effect::ThermalLag, parameter: Some(75.0), size: 30.0 };
    let (diagnosis, planted) = simulated(3, Setup::Bench, Axis::Ay, &[medium]);
    assert_missing(&diagnosis, "thermal_lag");
    let mg_per_k = planted[0].coefficients[0] / 9.80665e-3;
    assert_thermal_lag(&diagnosis.findings[0], planted[0].params["tau_s"], mg_per_k);
}

#[test]
fn identifies_a_strong_g_sensitivity_of_another_simulator() {
    let Some(diagnosis) = answer("case_001") else { return };
    assert_missing(&diagnosis, "g_sensitivity");
}

#[test]
fn reports_no_effect_in_a_clean_log_of_another_simulator() {
    let Some(diagnosis) = answer("case_002") else { return };
    assert_nothing_missing(&diagnosis);
}

#[test]
fn identifies_a_thermal_lag_of_another_simulator() {
    let Some(diagnosis) = answer("case_006") else { return };
    assert_missing(&diagnosis, "thermal_lag");
    // planted: 73.9 s and 0.108 mg/K, 23 standard errors
    assert_thermal_lag(&diagnosis.findings[0], 73.9, 0.108);
}

//! Complete cases of another simulator, read from their folders and diagnosed, if they are available.

use fos_data::case::Case;
use fos_diagnose::case::question;
use fos_diagnose::detect::{Diagnosis, Finding, Verdict, diagnose};
use fos_diagnose::effects::Library;
use fos_testkit::outside;

/// Diagnosis of a case.
fn answer(name: &str) -> Option<Diagnosis> {
    let case = Case::read(&outside::path(&format!("cases/{name}"))?).expect("a case");
    Some(diagnose(&question(&case, &Library::built_in())).expect("an answer"))
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
fn identifies_a_strong_g_sensitivity() {
    let Some(diagnosis) = answer("case_001") else { return };
    assert_missing(&diagnosis, "g_sensitivity");
}

#[test]
fn reports_no_effect_in_a_clean_log() {
    let Some(diagnosis) = answer("case_002") else { return };
    assert_nothing_missing(&diagnosis);
}

#[test]
fn identifies_a_thermal_lag() {
    let Some(diagnosis) = answer("case_006") else { return };
    assert_missing(&diagnosis, "thermal_lag");
    // planted: 73.9 s and 0.108 mg/K, 23 standard errors
    assert_thermal_lag(&diagnosis.findings[0], 73.9, 0.108);
}

//! Cases by another simulator, which lie in `../shared/cases` or where FOS_CASES says; without them these tests say so and
//! pass.

use std::path::{Path, PathBuf};

use fos_data::case::Case;
use fos_diagnose::case::question;
use fos_diagnose::detect::{Diagnosis, Verdict, diagnose};
use fos_diagnose::effects::Library;

fn answer(name: &str) -> Option<Diagnosis> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let beside = here.ancestors().map(|folder| folder.join("shared/cases"));
    let named = std::env::var_os("FOS_CASES").map(PathBuf::from);
    let found = named.into_iter().chain(beside).map(|folder| folder.join(name)).find(|path| path.is_dir());
    let Some(found) = found else {
        println!("skipped: no {name} in ../shared/cases nor in FOS_CASES");
        return None;
    };
    let case = Case::read(&found).expect("a case");
    Some(diagnose(&question(&case, &Library::built_in())).expect("an answer"))
}

fn assert_missing(diagnosis: &Diagnosis, effect: &str) {
    assert_eq!(diagnosis.verdict, Verdict::Missing, "{}", diagnosis.sentence);
    assert_eq!(diagnosis.findings.len(), 1, "{:?}", diagnosis.findings);
    assert_eq!(diagnosis.findings[0].effect, effect);
}

#[test]
fn a_strong_g_sensitivity_is_named() {
    let Some(diagnosis) = answer("case_001") else { return };
    assert_missing(&diagnosis, "g_sensitivity");
}

#[test]
fn where_nothing_is_missing_nothing_is_named() {
    let Some(diagnosis) = answer("case_002") else { return };
    assert_eq!(diagnosis.verdict, Verdict::NothingMissing, "{}", diagnosis.sentence);
    assert!(diagnosis.findings.is_empty() && diagnosis.leads.is_empty());
}

#[test]
fn a_thermal_lag_is_named_with_its_time_constant_and_size() {
    let Some(diagnosis) = answer("case_006") else { return };
    assert_missing(&diagnosis, "thermal_lag");
    let finding = &diagnosis.findings[0];
    // planted: 73.9 s and 0.108 mg/K, 23 standard errors
    let [low, high] = finding.params_interval["tau_s"];
    assert!((low..=high).contains(&73.9), "{low} … {high}");
    let [low, high] = finding.sizes[0].interval;
    assert!((low..=high).contains(&0.108) && finding.sizes[0].unit == "mg/K", "{low} … {high}");
}

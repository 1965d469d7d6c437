//! The same samples give the same study and the same diagnosis to the last bit, in any format.

use std::fs;
use std::path::Path;

use crate::session::done;
use fos_testkit::foreign::{Flight, Rate, mcap, ulog};
use serde_json::Value;

/// Removes the sources of the data.
fn remove_sources(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.remove("sources");
            fields.values_mut().for_each(remove_sources);
        }
        Value::Array(items) => items.iter_mut().for_each(remove_sources),
        _ => {}
    }
}

/// Study of a log, and its diagnosis on the log, in a separate folder.
fn study_and_diagnosis(folder: &Path, log: &str) -> (Value, String) {
    let fit =
        ["fit", log, "--axis", "ax,az,gy", "--physical", "temp_c", "--max-terms", "4", "-o", "unit.json"];
    done(folder, &fit);
    let text = fs::read_to_string(folder.join("unit.json")).expect("written");
    let mut study: Value = serde_json::from_str(&text).expect("JSON");
    assert!(!study["data"]["sources"].is_null(), "{study:#}");
    remove_sources(&mut study);
    let diagnosis = done(folder, &["diagnose", "unit.json", "--from", log, "--axis", "gy", "--json"]);
    (study, diagnosis)
}

#[test]
fn the_format_of_a_log_changes_no_bit_of_its_study() {
    let flight = Flight::new(6000, 5000, 3);
    let mut studies = Vec::new();
    for (name, bytes) in [
        ("unit.csv", flight.csv().into_bytes()),
        ("unit.ulg", ulog(&flight, Rate::Full)),
        ("unit.mcap", mcap(&flight)),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join(name), bytes).expect("written");
        let (study, diagnosis) = study_and_diagnosis(folder.path(), name);
        let on_the_log = done(folder.path(), &["diagnose", name, "--axis", "gy", "--json"]);
        studies.push((name, study, diagnosis.replace(name, "LOG"), on_the_log.replace(name, "LOG")));
    }
    let (_, study, diagnosis, on_the_log) = &studies[0];
    assert!(diagnosis.contains("\"verdict\""), "{diagnosis}");
    for (name, other, other_diagnosis, other_on_the_log) in &studies[1..] {
        // as text, so that no digit is lost in comparing
        assert_eq!(other.to_string(), study.to_string(), "{name}");
        assert_eq!(other_diagnosis, diagnosis, "{name}");
        assert_eq!(other_on_the_log, on_the_log, "{name}");
    }
}

//! From a file written by a foreign program to a diagnosis of all its axes: one command, no option.

use std::fs;

use crate::session::{done, fails, stderr_of};
use fos_data::recording::KNOWN_FORMATS;
use fos_testkit::foreign::{Flight, Text, files};
use serde_json::Value;

#[test]
fn every_format_is_diagnosed_by_one_command_without_an_option() {
    let flight = Flight::new(3000, 5000, 4);
    // one file of each format
    let mut logs: Vec<&Text> = Vec::new();
    for log in files() {
        if !logs.iter().any(|(known, ..)| *known == log.0) {
            logs.push(log);
        }
    }
    for known in KNOWN_FORMATS {
        assert!(logs.iter().any(|(id, ..)| *id == known.id), "{}: no file of it", known.id);
    }
    let folder = tempfile::tempdir().expect("a folder");
    for &(id, name, write) in logs {
        fs::write(folder.path().join(name), write(&flight)).expect("written");
        let message = done(folder.path(), &["diagnose", name, "--json"]);
        let answers: Value =
            serde_json::from_str(&message).unwrap_or_else(|error| panic!("{id}: {error}: {message}"));
        let of = |answer: &Value| answer["target"].as_str().expect("a name").to_owned();
        let targets: Vec<String> = answers.as_array().expect("one for each axis").iter().map(of).collect();
        // whole degrees a second round the noise of this gyro away: an axis that does not change is excluded
        let all = &fos_data::column::AXES;
        let expected = if ["betaflight", "geneactiv"].contains(&id) { &all[..3] } else { &all[..] };
        assert_eq!(targets, expected, "{id}");
        for answer in answers.as_array().expect("one for each axis") {
            assert!(
                answer["sentence"].as_str().is_some_and(|sentence| !sentence.is_empty()),
                "{id}: {answer}"
            );
        }
    }
    let message = done(folder.path(), &["diagnose", "flight.ulg"]);
    assert!(fos_data::column::AXES.iter().all(|axis| message.contains(axis)), "{message}");
    assert!(message.starts_with("flight.ulg: read as PX4 ULog: sensor_accel 0"), "{message}");
    assert!(message.contains("rows are the samples of "), "{message}");
}

#[test]
fn excludes_a_constant_axis_unless_requested() {
    let mut flight = Flight::new(3000, 5000, 4);
    flight.rate.iter_mut().for_each(|rate| rate[0] = 0.0);
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("a.csv"), flight.csv()).expect("written");
    let report = stderr_of(folder.path(), &["diagnose", "a.csv", "--json"]);
    assert!(report.contains("excluded: gx_rads repeats one value, 0.0"), "{report}");
    let refused = fails(folder.path(), 1, &["diagnose", "a.csv", "--axis", "gx"]);
    assert!(refused.contains("gx_rads repeats one value, 0.0"), "{refused}");
    // an axis with a tenth of its samples prevents no other
    let mut sparse = Flight::new(8000, 5000, 4);
    let is_known = |row: usize| (row * 7919 + row * row) % 101 < 10;
    let tenth = |row: usize| if is_known(row) { 1e-3 * (row % 7) as f32 } else { f32::NAN };
    sparse.rate.iter_mut().enumerate().for_each(|(row, rate)| rate[0] = tenth(row));
    fs::write(folder.path().join("sparse.csv"), sparse.csv()).expect("written");
    for command in [&["fit", "sparse.csv", "-o", "unit.json"][..], &["noise", "sparse.csv"]] {
        let report = stderr_of(folder.path(), command);
        assert!(report.contains("excluded: gx_rads"), "{report}");
        fails(folder.path(), 1, &[command, &["--axis", "gx"]].concat());
    }
    flight.rate.iter_mut().for_each(|rate| *rate = [0.0; 3]);
    flight.acceleration.iter_mut().for_each(|force| *force = [0.0; 3]);
    fs::write(folder.path().join("a.csv"), flight.csv()).expect("written");
    let refused = fails(folder.path(), 1, &["diagnose", "a.csv"]);
    assert!(refused.contains("ax_mps2 repeats one value, 0.0"), "{refused}");
}

//! `calibrate-imu`: a readable summary, JSON, certificates, files for other programs, and refusals with a remedy.

use std::fs;

use fos_core::Validity;
use fos_embedded::telemetry::{Frame, SampleFrame, StartFrame, VERSION, encode};
use fos_testkit::turned::{ACCELEROMETER, GYRO, resting_log, turned_log};
use serde_json::Value;

use crate::session::{done, fails, stderr_of};

#[test]
fn a_turned_log_is_calibrated_in_a_few_lines() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("turned.csv"), turned_log()).expect("written");
    let message = done(folder, &["calibrate-imu", "turned.csv", "--latitude", "45.4", "--accuracy", "5mg"]);
    assert!(message.lines().count() <= 40, "{message}");
    for part in [
        "bias, mg",
        "sensitivity, %",
        "WGS84 at latitude 45.4°",
        "next: one dwell with",
        "accuracy of 5.00 mg",
    ] {
        assert!(message.contains(part), "{part}: {message}");
    }
    let all = done(folder, &["calibrate-imu", "turned.csv", "--details", "--units", "si"]);
    assert!(all.contains("bias, m/s²") && all.contains("from rest") && all.len() > message.len(), "{all}");

    let json: Value =
        serde_json::from_str(&done(folder, &["calibrate-imu", "turned.csv", "--json"])).expect("JSON");
    let found = &json["result"]["hand"];
    let value = |list: &Value, id: &str| {
        let one = list.as_array().expect("a list").iter().find(|one| one["id"] == id).expect(id).clone();
        (one["value"].as_f64().expect("a number"), one["half_width"].as_f64().expect("a number"))
    };
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let accelerometer = &found["accelerometer"]["parameters"];
        let gyro = &found["gyro"]["parameters"];
        // twice the interval, since twelve of them are checked
        for (list, id, truth) in [
            (accelerometer, "accelerometer.bias", ACCELEROMETER[axis].0),
            (accelerometer, "accelerometer.sensitivity", ACCELEROMETER[axis].1),
            (gyro, "gyro.bias", GYRO[axis].0),
            (gyro, "gyro.sensitivity", GYRO[axis].1),
        ] {
            let (value, half) = value(list, &format!("{id}.{name}"));
            assert!(
                (value - truth).abs() < 2.0 * half && half < 0.02,
                "{id}.{name}: {value} ± {half}, {truth}"
            );
        }
    }
    assert_eq!(json["schema"], "fos-certificate/1");
    assert_eq!(json["logs"][0]["sha256"].as_str().map(str::len), Some(64));
}

#[test]
fn certificate_states_known_facts_and_escapes_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("turned.csv"), turned_log()).expect("written");
    let device = "No. 7 <script>x()</script> | **b**";
    let read = |name: &str| fs::read_to_string(folder.join(name)).expect("written");
    for name in ["c.html", "c.md", "c.json"] {
        let message = done(folder, &["calibrate-imu", "turned.csv", "--device", device, "-o", name]);
        assert!(message.contains(&format!("{name}: certificate")), "{message}");
    }
    let (page, text) = (read("c.html"), read("c.md"));
    for part in ["Calibration certificate", "SHA-256", "|a| = g", "s², assumed", "accelerometer x bias"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(
        !page.contains("<script>") && page.contains("&lt;script&gt;") && page.contains("<svg"),
        "escaped"
    );
    assert!(text.contains("\\<script>") && text.contains("\\*\\*b"), "{text}");
    // nothing is invented
    assert!(!page.contains("<dt>date</dt>") && !page.contains("<dt>part</dt>"));
    let json: Value = serde_json::from_str(&read("c.json")).expect("JSON");
    assert_eq!(json["device"], device);
    assert!(json.get("date").is_none());
}

#[test]
fn files_of_other_programs_are_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("turned.csv"), turned_log()).expect("written");
    let files = [
        ("--px4", "CAL_ACC2_XOFF"),
        ("--ardupilot", "INS_ACC3SCAL_Y"),
        ("--kalibr", "C_gyro_i"),
        ("--imu-tk-acc", "e"),
        ("--imu-tk-gyro", "e"),
    ];
    for (option, part) in files {
        done(folder, &["calibrate-imu", "turned.csv", "--instance", "2", option, "out"]);
        let text = fs::read_to_string(folder.join("out")).expect("written");
        assert!(text.contains(part), "{option}: {text}");
    }
}

/// The calibration is exported with the model of a study, and the corrected specific force has the length of gravity.
#[test]
fn study_calibrates_its_corrected_values() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("turned.csv"), turned_log()).expect("written");
    fs::write(folder.join("rest.csv"), resting_log()).expect("written");
    done(folder, &["fit", "rest.csv", "--axis", "all", "--max-lag", "1", "-o", "unit.json"]);
    let residuals = || -> [f64; 2] {
        done(folder, &["export", "unit.json", "--image", "unit.fosm"]);
        let json = done(folder, &["replay", "unit.fosm", "turned.csv", "-o", "corrected.csv", "--json"]);
        let json: Value = serde_json::from_str(&json).expect("JSON");
        assert!(json["gravity"]["rests"].as_u64() >= Some(10), "{json}");
        serde_json::from_value(json["gravity"]["residual_mps2"].clone()).expect("two numbers")
    };
    let [measured, corrected] = residuals();
    assert!(measured > 0.1 && (measured - corrected).abs() < 0.02, "{measured} {corrected}");

    let message = done(folder, &["calibrate-imu", "turned.csv", "--study", "unit.json"]);
    assert!(message.contains("unit.json: study with the calibration"), "{message}");
    let [measured, corrected] = residuals();
    // below 1 mg
    assert!(measured > 0.1 && corrected < 0.01, "{measured} {corrected}");
    let text = done(folder, &["history", "unit.json"]);
    assert!(text.contains("calibration of accelerometer and gyro from 13 rests (turned.csv)"), "{text}");
    // exported source compiles in the same numbers
    done(folder, &["export", "unit.json", "--rust", "model.rs", "--c", "model.h"]);
    let source = fs::read_to_string(folder.join("model.rs")).expect("written");
    assert!(source.contains("calibration: Some(Calibration {"), "{source}");

    let message = done(folder, &["undo", "unit.json", "--calibration"]);
    assert!(message.starts_with("removed: calibration of"), "{message}");
    assert!(residuals()[1] > 0.1);
    let message = fails(folder, 1, &["undo", "unit.json", "--calibration"]);
    assert!(message.contains("has no calibration"), "{message}");
}

#[test]
fn rejects_logs_unfit_for_calibration_with_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["simulate", "rest.csv", "--minutes", "1", "--at-rest"]);
    let message = fails(folder, 1, &["calibrate-imu", "rest.csv"]);
    assert!(message.contains("orientation") && message.contains("help: record 12 orientations"), "{message}");
    let message = fails(folder, 1, &["calibrate-imu", "rest.csv", "--rate-table", "33.3333rpm"]);
    assert!(message.contains("no stretch of constant rate near 3.4907 rad/s"), "{message}");
    fs::write(folder.join("gyro.csv"), "t_s,gx_rads,gy_rads,gz_rads\n0,1,2,3\n0.1,1,2,3.1\n0.2,1,2,3\n")
        .expect("written");
    let message = fails(folder, 1, &["calibrate-imu", "gyro.csv"]);
    assert!(message.contains("no accelerometer") && message.contains("--rate-table"), "{message}");
    let message = fails(folder, 2, &["calibrate-imu", "rest.csv", "--accuracy", "2"]);
    assert!(message.contains("has no unit; known are mg"), "{message}");
}

/// The rows of a log in CSV, its time aside, as a device sends them.
fn telemetry_of(log: &str) -> Vec<u8> {
    let (header, rows) = log.split_once('\n').expect("a header");
    let axes = header.strip_prefix("t_s,").expect("time first").replace(',', "\n");
    let mut buffer = [0; 256];
    let start = StartFrame { version: VERSION, period_s: 0.02, axes: axes.as_str(), quantities: "" };
    let mut stream = encode(&Frame::Start(start), &mut buffer).expect("fits").to_vec();
    for (tick, row) in (0..).zip(rows.lines()) {
        let measured: Vec<f32> = row.split(',').skip(1).map(|cell| cell.parse().expect("a number")).collect();
        let (innovations, validity) = (vec![0.0; measured.len()], vec![Validity::VALID; measured.len()]);
        let sample = SampleFrame {
            tick,
            still: false,
            measured: &measured[..],
            quantities: &[],
            innovations: &innovations[..],
            validity: &validity[..],
        };
        let frame: Frame<&str, _, _> = Frame::Sample(sample);
        stream.extend(encode(&frame, &mut buffer).expect("fits").iter());
    }
    stream
}

#[test]
fn recording_is_guided_to_the_next_orientation() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("turned.stream"), telemetry_of(&turned_log())).expect("written");
    let guide =
        |purpose| stderr_of(folder, &["record", "turned.stream", "--guide", purpose, "-o", "log.csv"]);
    let printed = guide("calibration");
    let (first, last) = (printed.lines().next().expect("a line"), printed.lines().last().expect("a line"));
    assert!(first.contains("orientation") && first.contains("next: "), "{printed}");
    assert!(last.contains("rests in") && last.contains("mg at 1 g; next: "), "{printed}");
    assert!(guide("noise").contains("at rest"));
    // as the command says of the whole log
    assert!(done(folder, &["calibrate-imu", "log.csv"]).contains("next: "));
}

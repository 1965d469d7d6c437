//! `noise`: one set of numbers in table, figure, JSON and in the files of other stacks, in their units.

use std::collections::BTreeMap;
use std::path::Path;

use crate::session::{done, fails};
use serde_json::Value;

/// Simulates ten minutes at rest, and writes all outputs.
fn written(folder: &Path) -> Value {
    done(
        folder,
        &["simulate", "rest.parquet", "--minutes", "10", "--at-rest", "--temperature", "0", "--rate", "50"],
    );
    let files = ["--csv", "a.csv", "--svg", "a.svg", "--imu-yaml", "imu.yaml", "--orb-slam3", "orb.yaml"];
    let more = ["--vins", "vins.yaml", "--rostopic", "/my imu", "--json"];
    let report = done(folder, &[&["noise", "rest.parquet"][..], &files, &more].concat());
    serde_json::from_str(&report).expect("JSON and nothing else")
}

fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).expect("written")
}

/// Parses `key: number` of every line that is not a comment; keys of a block are prefixed by the block's name.
fn numbers(text: &str) -> BTreeMap<String, f64> {
    let mut block = String::new();
    let mut found = BTreeMap::new();
    for line in text.lines().filter(|line| !line.trim_start().starts_with('#')) {
        let Some((key, rest)) = line.split_once(": ") else {
            if let Some(name) = line.strip_suffix(':').filter(|name| !name.starts_with(' ')) {
                block = format!("{name}.");
            }
            continue;
        };
        let value = rest.split('#').next().unwrap_or_default().trim();
        let name = if key.starts_with(' ') { format!("{block}{}", key.trim()) } else { key.to_owned() };
        if let Ok(value) = value.parse() {
            found.insert(name, value);
        }
    }
    found
}

/// Largest level over three axes, or largest limit if no axis determines it.
fn worst(report: &Value, triad: &str, level: &str) -> f64 {
    let axes = report["axes"].as_array().expect("axes").iter();
    let three: Vec<&Value> =
        axes.filter(|axis| axis["column"].as_str().unwrap().starts_with(triad)).collect();
    assert_eq!(three.len(), 3);
    let of = |key: &str| three.iter().filter_map(|axis| axis[level][key].as_f64()).fold(0.0, f64::max);
    if of("value") > 0.0 { of("value") } else { of("high") }
}

#[test]
fn exports_table_values_in_the_units_of_other_stacks() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let report = written(folder);
    let rate = report["rate_hz"].as_f64().expect("a rate");
    let levels = [("a", "white"), ("a", "walk"), ("g", "white"), ("g", "walk")];
    let expected = levels.map(|(triad, level)| worst(&report, triad, level));
    let near =
        |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}"); // digits printed

    // kalibr_common/ConfigReader.py and ov_msckf/core/VioManagerOptions.h: continuous densities
    let kalibr = numbers(&text(folder, "imu.yaml"));
    let keys = [
        "accelerometer_noise_density",
        "accelerometer_random_walk",
        "gyroscope_noise_density",
        "gyroscope_random_walk",
    ];
    for (key, expected) in keys.iter().zip(expected) {
        near(kalibr[*key], expected);
        near(kalibr[&format!("imu0.{key}")], expected);
    }
    near(kalibr["update_rate"], rate);
    assert_eq!(text(folder, "imu.yaml").matches("rostopic: \"/my imu\"").count(), 2);

    // ORB_SLAM3/src/Tracking.cc: sf = √IMU.Frequency; it adds noise·sf and walk/sf per sample
    let orb = numbers(&text(folder, "orb.yaml"));
    for (key, expected) in
        ["IMU.NoiseAcc", "IMU.AccWalk", "IMU.NoiseGyro", "IMU.GyroWalk"].iter().zip(expected)
    {
        near(orb[*key], expected);
    }
    near(orb["IMU.Frequency"], rate);
    assert!(text(folder, "orb.yaml").starts_with("%YAML:1.0\n"));

    // VINS-Fusion/vins_estimator/src/factor/integration_base.h: V·noise·Vᵀ with V ∝ dt; the bias moves by dt·w a step
    let vins = numbers(&text(folder, "vins.yaml"));
    for (key, expected) in ["acc_n", "acc_w", "gyr_n", "gyr_w"].iter().zip(expected) {
        near(vins[*key], expected * rate.sqrt());
        assert!(text(folder, "vins.yaml").contains(&format!("# {key}: {expected:.6e}")), "{key} as density");
    }
}

#[test]
fn table_and_figure_show_the_same_numbers() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let report = written(folder);
    let csv = text(folder, "a.csv");
    let row = |start: &str| -> Vec<String> {
        let found = csv.lines().find(|line| line.starts_with(start)).expect(start);
        found.split(',').map(str::to_owned).collect()
    };
    let axis = &report["axes"][3];
    assert_eq!(axis["column"], "gx_rads");
    for (start, level, unit) in [
        ("gx_rads,N,", "white", "rad/s/sqrt(Hz)"),
        ("gx_rads,B,", "flicker", "rad/s"),
        ("gx_rads,K,", "walk", "rad/s^2/sqrt(Hz)"),
    ] {
        let cells = row(start);
        for (cell, key) in cells[3..6].iter().zip(["value", "low", "high"]) {
            assert_eq!(cell.parse().ok(), axis[level][key].as_f64(), "{start} {key}");
        }
        assert_eq!(cells[6], unit);
    }
    let points = csv.lines().filter(|line| line.starts_with("gx_rads,allan_deviation,")).count();
    assert_eq!(points, axis["allan"].as_array().expect("points").len());
    let svg = text(folder, "a.svg");
    for title in ["Gyro z", "N, B and K together"] {
        assert!(svg.contains(title), "{title}");
    }
    // three digits, in plain notation as far as it can be read
    let shown = |value: &Value| match value.as_f64().unwrap() {
        small @ 1e-5..1e-3 => format!("{small:.*}", (2.0 - small.log10().floor()) as usize),
        other => fos_data::text::rounded(other, 3),
    };
    let value = shown(&axis["white"]["value"]);
    assert!(svg.contains(&format!("N {value} (")), "{value}");
    let at_most = shown(&axis["walk"]["high"]);
    assert!(svg.contains(&at_most), "{at_most}");
}

#[test]
fn short_log_reports_the_required_length() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(
        folder,
        &["simulate", "rest.csv", "--minutes", "10", "--at-rest", "--temperature", "0", "--rate", "20"],
    );
    let report = done(folder, &["noise", "rest.csv", "--axis", "gx,gy,gz"]);
    assert!(report.contains("the log is too short for K: 10 min at rest show none"), "{report}");
    assert!(report.contains("would show half as much"), "{report}");
    assert!(report.contains("gx_rads: a drift with temperature ("), "{report}");

    let missing = fails(folder, 1, &["noise", "rest.csv", "--axis", "gx", "--imu-yaml", "imu.yaml"]);
    assert!(missing.contains("ax_mps2 is missing") && !folder.join("imu.yaml").exists(), "{missing}");
    done(folder, &["simulate", "short.csv", "--minutes", "0.2", "--at-rest"]);
    let short = fails(folder, 1, &["noise", "short.csv"]);
    assert!(short.contains("s at rest in stretches") && short.contains("help:"), "{short}");
}

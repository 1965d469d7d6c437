//! Temperature tables for autopilots: a log corrected by the written file, with the autopilot's own formula, has the
//! reported error.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use fos_testkit::foreign::{Flight, Rate, dataflash_of, ulog, ulog_of};
use fos_testkit::noise::Noise;

use crate::session::{done, fails, stderr_of};

const RATE_HZ: usize = 20;
const ROWS: usize = 20 * 1200;

/// Twenty minutes at rest while the temperature goes through `turns` of a cycle of ±`swing` K about 30 °C: cubics, and in
/// gyro y more than a cubic. Rows are time, six axes, temperature.
pub(crate) fn rows(turns: f64, swing: f64, seed: u32) -> Vec<[f64; 8]> {
    let mut noise = Noise::new(seed.into());
    let row = |n: usize| {
        let t = n as f64 / RATE_HZ as f64;
        let celsius = 30.0 - swing * (TAU * turns * n as f64 / ROWS as f64).cos();
        let d = celsius - 28.0;
        let cubic = |c: [f64; 4]| c[0] + d * (c[1] + d * (c[2] + d * c[3]));
        let mut cells = [
            t,
            cubic([0.05, 2e-3, 0.0, 1e-6]),
            cubic([-0.1, -1e-3, 2e-5, 0.0]),
            cubic([9.8, 3e-3, 0.0, 0.0]),
            cubic([0.01, 2e-4, 3e-6, 1e-7]),
            cubic([-0.004, -1e-4, 1e-6, 0.0]) + 2e-3 * (d / 3.0).sin(),
            cubic([0.002, 5e-5, 0.0, -5e-8]),
            celsius,
        ];
        cells[1..4].iter_mut().for_each(|value| *value += 0.0058 * noise.normal());
        cells[4..7].iter_mut().for_each(|value| *value += 0.00058 * noise.normal());
        cells
    };
    (0..ROWS).map(row).collect()
}

const COLUMNS: [&str; 6] = ["ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads"];

pub(crate) fn write(path: &Path, rows: &[[f64; 8]]) {
    let mut text = format!("t_s,{},temp_c,still\n", COLUMNS.join(","));
    for row in rows {
        let cells: Vec<String> = row.iter().map(f64::to_string).collect();
        writeln!(text, "{},1", cells.join(",")).expect("a string");
    }
    std::fs::write(path, text).expect("written");
}

/// Writes a study of a log that warms and cools by 18 K, and another log of the device with a slightly larger range.
fn study(folder: &Path) -> Vec<[f64; 8]> {
    write(&folder.join("warm.csv"), &rows(1.5, 18.0, 1));
    let later = rows(1.3, 20.0, 2);
    write(&folder.join("later.csv"), &later);
    done(folder, &["fit", "warm.csv", "--axis", "gx,gy", "--physical", "temp_c", "-o", "unit.json"]);
    later
}

/// RMS of 1-s means minus their mean.
fn left(rows: &[[f64; 8]], column: usize, correction: impl Fn(f64) -> f64) -> f64 {
    let corrected: Vec<f64> = rows.iter().map(|row| row[column + 1] - correction(row[7])).collect();
    let means: Vec<f64> =
        corrected.chunks_exact(RATE_HZ).map(|s| s.iter().sum::<f64>() / RATE_HZ as f64).collect();
    let mean = means.iter().sum::<f64>() / means.len() as f64;
    (means.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / means.len() as f64).sqrt()
}

/// Formula of `src/modules/temperature_compensation/TemperatureCompensation.cpp` of PX4-Autopilot,
/// `calc_thermal_offsets_3D`: the difference from TREF is clipped, X0 to X3 are coefficients of its powers; the result
/// is subtracted from the measurement.
fn px4(parameters: &BTreeMap<String, f64>, column: usize, celsius: f64) -> f64 {
    let (sensor, axis) = (["A0", "G0"][column / 3], column % 3);
    let of = |name: &str| parameters[&format!("TC_{sensor}_{name}")];
    let d = celsius.min(of("TMAX")).max(of("TMIN")) - of("TREF");
    (0..4).map(|power| of(&format!("X{power}_{axis}")) * d.powi(power)).sum()
}

/// Formula of `libraries/AP_InertialSensor/AP_InertialSensor_tempcal.cpp` of ardupilot, `correct_sensor` and
/// `polynomial_eval`: three orders about 35 °C, times 10⁻⁶, minus the value at the temperature of the calibration.
fn ardupilot(parameters: &BTreeMap<String, f64>, column: usize, celsius: f64) -> f64 {
    let (sensor, axis) = (["ACC", "GYR"][column / 3], ["X", "Y", "Z"][column % 3]);
    let of = |name: &str| parameters[&format!("INS_TCAL1_{name}")];
    let polynomial = |celsius: f64| -> f64 {
        let d = celsius.min(of("TMAX")).max(of("TMIN")) - 35.0;
        (1..4).map(|order| 1e-6 * of(&format!("{sensor}{order}_{axis}")) * d.powi(order)).sum()
    };
    polynomial(celsius) - polynomial(21.5)
}

/// Parses lines of five columns as read by QGroundControl, or of a name and a value.
fn parameters(text: &str) -> BTreeMap<String, f64> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(['\t', ' ']).collect();
            let (name, value) = match cells[..] {
                ["1", "1", name, value, kind] => {
                    assert_eq!(kind == "6", name.ends_with("ENABLE") || name.ends_with("ID"), "{line}");
                    (name, value)
                }
                [name, value] => (name, value),
                _ => panic!("{line}"),
            };
            assert!(name.len() <= 16, "{name}: longer than a MAVLink parameter may be");
            (name.to_owned(), value.parse().expect(line))
        })
        .collect()
}

#[test]
fn written_table_gives_the_reported_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let later = study(folder);
    let export =
        ["export", "unit.json", "--px4", "u.params", "--device-id", "77,88", "--ardupilot", "u.parm"];
    let rest = ["--instance", "0", "--evaluate-on", "later.csv", "--json"];
    let report = done(folder, &[&export[..], &rest].concat());
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON and nothing else");
    let report = &report["temperature"];
    assert_eq!(report["corrected_by"], serde_json::json!(["PX4", "ArduPilot"]));
    let read = |name: &str| parameters(&std::fs::read_to_string(folder.join(name)).expect("written"));
    let (for_px4, for_ardupilot) = (read("u.params"), read("u.parm"));
    assert_eq!((for_px4["TC_A0_ID"], for_px4["TC_G0_ID"]), (77.0, 88.0));
    assert_eq!((for_px4["TC_G_ENABLE"], for_ardupilot["INS_TCAL1_ENABLE"]), (1.0, 1.0));
    assert!(for_ardupilot["INS_TCAL1_TMAX"] >= for_ardupilot["INS_TCAL1_TMIN"] + 10.0);
    for (column, name) in COLUMNS.iter().enumerate() {
        let axis = &report["axes"][column];
        assert_eq!(axis["column"], *name);
        // offsets are single precision: 6e-8 of up to 0.1 m/s² or 0.02 rad/s, against errors of 1e-3 and 1e-4
        let same = |report: &serde_json::Value, found: f64| {
            let report = report.as_f64().expect("a number");
            assert!((report / found - 1.0).abs() < 1e-4, "{name}: {report} told, {found} found");
        };
        same(&axis["nothing"], left(&later, column, |_| 0.0));
        same(&axis["corrected"][0], left(&later, column, |celsius| px4(&for_px4, column, celsius)));
        same(
            &axis["corrected"][1],
            left(&later, column, |celsius| ardupilot(&for_ardupilot, column, celsius)),
        );
        assert_eq!(axis["study"].is_null(), !["gx_rads", "gy_rads"].contains(name));
        let (nothing, corrected) =
            (axis["nothing"].as_f64().unwrap(), axis["corrected"][0].as_f64().unwrap());
        assert!(corrected < 0.8 * nothing, "{name}: {corrected} of {nothing}");
    }
    // a cubic is corrected down to the noise, 0.00058/√20, and the remainder at the clipped ends
    assert!(report["axes"][3]["corrected"][0].as_f64().unwrap() < 6e-4, "{report}");
}

#[test]
fn warns_that_px4_ignores_a_table_without_device_id() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    study(folder);
    let warned = stderr_of(folder, &["export", "unit.json", "--instance", "0", "--px4", "u.params"]);
    assert!(warned.contains("PX4 ignores these tables") && warned.contains("--device-id"), "{warned}");
    let report = done(folder, &["export", "unit.json", "--instance", "0", "--ardupilot", "u.parm"]);
    for part in ["nothing corrected", "ArduPilot's cubic", "the study", "warm.csv that were not fitted"] {
        assert!(report.contains(part), "{part}: {report}");
    }
}

#[test]
fn rejects_a_log_without_temperature_change_with_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write(&folder.join("steady.csv"), &rows(1.5, 4.0, 3));
    done(folder, &["fit", "steady.csv", "--axis", "gx", "-o", "steady.json"]);
    let export = ["export", "steady.json", "--instance", "0", "--ardupilot", "u.parm", "--image", "u.fosm"];
    let narrow = fails(folder, 1, &export);
    assert!(
        narrow.contains("the temperature goes from 26.0") && narrow.contains("help: cool the unit"),
        "{narrow}"
    );
    assert!(!folder.join("u.parm").exists() && !folder.join("u.fosm").exists());

    let text = std::fs::read_to_string(folder.join("steady.csv")).expect("written");
    std::fs::write(folder.join("blind.csv"), text.replacen("temp_c", "other", 1)).expect("written");
    done(folder, &["fit", "blind.csv", "--axis", "gx", "-o", "blind.json"]);
    let blind = fails(folder, 1, &["export", "blind.json", "--instance", "0", "--px4", "u.params"]);
    assert!(blind.contains("blind.csv: it has no temperature") && blind.contains("help: log"), "{blind}");
}

/// Twenty minutes while the temperature rises by 24 K, with `factor` times the values of the gyros.
fn warming(seed: u32, factor: f64) -> Flight {
    let rows = rows(0.5, 12.0, seed);
    let triad = |values: [f64; 3]| values.map(|value| value as f32);
    Flight {
        stamps_us: rows.iter().map(|row| (row[0] * 1e6).round() as u64 + 1_000_000).collect(),
        acceleration: rows.iter().map(|row| triad([row[1] * 1e-2, row[2] * 1e-2, row[3]])).collect(),
        rate: rows.iter().map(|row| triad([row[4], row[5], row[6]].map(|value| value * factor))).collect(),
        temperature: rows.iter().map(|row| row[7] as f32).collect(),
    }
}

#[test]
fn the_table_of_an_imu_is_written_for_that_imu() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let log = dataflash_of([&warming(4, 1.0), &warming(4, -3.0)], &[("AHRS_ORIENTATION", 0.0)], false);
    std::fs::write(folder.join("two.bin"), log).expect("written");
    let mut slopes = Vec::new();
    for (topic, group) in [("0", "INS_TCAL1"), ("1", "INS_TCAL2")] {
        let fit =
            ["fit", "two.bin", "--topic", topic, "--axis", "gx", "--physical", "temp_c", "-o", "unit.json"];
        done(folder, &fit);
        done(folder, &["export", "unit.json", "--ardupilot", "u.parm"]);
        let written = parameters(&std::fs::read_to_string(folder.join("u.parm")).expect("written"));
        assert!(written.keys().all(|name| name.starts_with(group)), "{topic}: {written:?}");
        slopes.push(written[&format!("{group}_GYR1_X")]);
        // negative control: another IMU is stated
        let other = if topic == "0" { "1" } else { "0" };
        let refused =
            fails(folder, 1, &["export", "unit.json", "--instance", other, "--ardupilot", "other.parm"]);
        assert!(refused.contains(&format!("it is of IMU {topic}, but IMU {other} was stated")), "{refused}");
        // ArduPilot numbers its IMUs differently from PX4
        let refused = fails(folder, 1, &["export", "unit.json", "--px4", "other.params"]);
        assert!(refused.contains("the log does not identify the IMU"), "{refused}");
        assert!(!folder.join("other.parm").exists() && !folder.join("other.params").exists());
    }
    // the second gyro of this log has -3 times the values of the first
    assert!((slopes[1] / slopes[0] + 3.0).abs() < 0.05, "{slopes:?}");
}

#[test]
fn a_table_needs_a_sensor_that_the_autopilot_has() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    study(folder);
    let unknown = fails(folder, 1, &["export", "unit.json", "--ardupilot", "u.parm"]);
    assert!(unknown.contains("help: state it with --instance"), "{unknown}");
    for (option, last) in [("--px4", "3"), ("--ardupilot", "4")] {
        done(folder, &["export", "unit.json", "--instance", last, option, "u.txt"]);
        let names = parameters(&std::fs::read_to_string(folder.join("u.txt")).expect("written"));
        let group = if option == "--px4" { "TC_G3_TMIN" } else { "INS5_TCAL_TMIN" };
        assert!(names.contains_key(group), "{names:?}");
        let beyond = fails(folder, 1, &["export", "unit.json", "--instance", "5", option, "u.txt"]);
        assert!(beyond.contains(&format!("it has tables for 0 to {last} only")), "{beyond}");
    }
}

#[test]
fn corrected_px4_values_make_an_image_but_no_table() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let flight = warming(5, 1.0);
    // of the raw topics the second instance
    let raw = ulog_of(&[("sensor_accel", 1, 333, &flight), ("sensor_gyro", 1, 444, &flight)]);
    std::fs::write(folder.join("combined.ulg"), ulog(&flight, Rate::Decimated)).expect("written");
    std::fs::write(folder.join("raw.ulg"), raw).expect("written");
    let fit = |log: &str, topic: &str| {
        let fit = ["fit", log, "--topic", topic, "--axis", "gx", "--physical", "temp_c", "-o", "unit.json"];
        done(folder, &fit);
        done(folder, &["export", "unit.json", "--image", "unit.fosm"]);
        let image = done(folder, &["inspect", "unit.fosm", "--json"]);
        serde_json::from_str::<serde_json::Value>(&image).expect("JSON")
    };
    let image = fit("combined.ulg", "0");
    assert_eq!(image["fitted_on"], "FactoryCorrected", "{image}");
    let report = image["provenance"].as_str().expect("a text");
    assert!(report.contains("corrected by PX4"), "{report}");
    let refused = fails(
        folder,
        1,
        &["export", "unit.json", "--px4", "u.params", "--device-id", "111,222", "--instance", "0"],
    );
    assert!(
        refused.contains("corrected before they were logged, by PX4")
            && refused.contains("help: record sensor_accel"),
        "{refused}"
    );
    assert!(!folder.join("u.params").exists());
    // negative control: a study that contradicts its log was not written by this program
    let study = std::fs::read_to_string(folder.join("unit.json")).expect("written");
    let doctored = study.replacen("\"fitted_on\": \"FactoryCorrected\"", "\"fitted_on\": \"Raw\"", 2);
    std::fs::write(folder.join("doctored.json"), &doctored).expect("written");
    assert_ne!(doctored, study);
    let refused = fails(folder, 1, &["export", "doctored.json", "--image", "other.fosm"]);
    assert!(refused.contains("was corrected by PX4"), "{refused}");

    // and one without provenance, as of an earlier version, is read with a warning
    let mut cut: serde_json::Value = serde_json::from_str(&doctored).expect("JSON");
    let source = cut["data"]["sources"][0]["read_as"].as_object_mut().expect("another format");
    assert!(source.remove("provenance").is_some());
    std::fs::write(folder.join("cut.json"), cut.to_string()).expect("written");
    let warned = stderr_of(folder, &["export", "cut.json", "--image", "cut.fosm"]);
    assert!(warned.contains("help: fit the log again"), "{warned}");
    let refused = fails(folder, 1, &["export", "cut.json", "--instance", "0", "--px4", "u.params"]);
    assert!(refused.contains("corrected before they were logged"), "{refused}");

    // the second IMU, raw: its number and its device_id come from the log
    let image = fit("raw.ulg", "1");
    assert_eq!(image["fitted_on"], "Raw", "{image}");
    assert!(image["provenance"].as_str().expect("a text").contains("IMU 1, device_id 333, raw"), "{image}");
    done(folder, &["export", "unit.json", "--px4", "u.params"]);
    let written = parameters(&std::fs::read_to_string(folder.join("u.params")).expect("written"));
    assert_eq!((written["TC_A1_ID"], written["TC_G1_ID"]), (333.0, 444.0));
    assert!(written.keys().all(|name| name.ends_with("_ENABLE") || name.contains('1')), "{written:?}");
    let refused =
        fails(folder, 1, &["export", "unit.json", "--px4", "other.params", "--device-id", "111,222"]);
    assert!(refused.contains("it is of device_id 333, but device_id 111 was stated"), "{refused}");
}

//! Temperature tables for autopilots: a log corrected by the written file, with the autopilot's own formula, keeps the error
//! that was told.

mod session;

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use session::{done, fails, said};

const RATE_HZ: usize = 20;
const ROWS: usize = 20 * 1200;

/// Twenty minutes at rest while the temperature goes through `turns` of a cycle of ±`swing` K about 30 °C: cubics, and in
/// gyro y more than a cubic. Rows are time, six axes, temperature.
fn rows(turns: f64, swing: f64, seed: u32) -> Vec<[f64; 8]> {
    let mut state = seed;
    let mut noise = || {
        // the sum of four even ones is nearly normal
        (0..4).fold(-2.0, |sum, _| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sum + f64::from(state >> 8) / f64::from(1 << 24)
        })
    };
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
        cells[1..4].iter_mut().for_each(|value| *value += 0.01 * noise());
        cells[4..7].iter_mut().for_each(|value| *value += 0.001 * noise());
        cells
    };
    (0..ROWS).map(row).collect()
}

const COLUMNS: [&str; 6] = ["ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads"];

fn write(path: &Path, rows: &[[f64; 8]]) {
    let mut text = format!("t_s,{},temp_c,still\n", COLUMNS.join(","));
    for row in rows {
        let cells: Vec<String> = row.iter().map(f64::to_string).collect();
        writeln!(text, "{},1", cells.join(",")).expect("a string");
    }
    std::fs::write(path, text).expect("written");
}

/// A study of a log that warms and cools by 18 K, and another log of the unit that goes a little further.
fn study(folder: &Path) -> Vec<[f64; 8]> {
    write(&folder.join("warm.csv"), &rows(1.5, 18.0, 1));
    let later = rows(1.3, 20.0, 2);
    write(&folder.join("later.csv"), &later);
    done(folder, &["fit", "warm.csv", "--axis", "gx,gy", "--physical", "temp_c", "-o", "unit.json"]);
    later
}

/// Root mean square of 1-s means less their mean.
fn left(rows: &[[f64; 8]], column: usize, correction: impl Fn(f64) -> f64) -> f64 {
    let corrected: Vec<f64> = rows.iter().map(|row| row[column + 1] - correction(row[7])).collect();
    let means: Vec<f64> =
        corrected.chunks_exact(RATE_HZ).map(|s| s.iter().sum::<f64>() / RATE_HZ as f64).collect();
    let mean = means.iter().sum::<f64>() / means.len() as f64;
    (means.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / means.len() as f64).sqrt()
}

/// As `src/modules/temperature_compensation/TemperatureCompensation.cpp` of PX4-Autopilot, `calc_thermal_offsets_3D`: the
/// difference to TREF clipped, X0 to X3 in its powers; what comes out is subtracted from the sensor.
fn px4(parameters: &BTreeMap<String, f64>, column: usize, celsius: f64) -> f64 {
    let (sensor, axis) = (["A0", "G0"][column / 3], column % 3);
    let of = |name: &str| parameters[&format!("TC_{sensor}_{name}")];
    let d = celsius.min(of("TMAX")).max(of("TMIN")) - of("TREF");
    (0..4).map(|power| of(&format!("X{power}_{axis}")) * d.powi(power)).sum()
}

/// As `libraries/AP_InertialSensor/AP_InertialSensor_tempcal.cpp` of ardupilot, `correct_sensor` and `polynomial_eval`:
/// three orders about 35 °C, times 10⁻⁶, less the same at the temperature of the calibration.
fn ardupilot(parameters: &BTreeMap<String, f64>, column: usize, celsius: f64) -> f64 {
    let (sensor, axis) = (["ACC", "GYR"][column / 3], ["X", "Y", "Z"][column % 3]);
    let of = |name: &str| parameters[&format!("INS_TCAL1_{name}")];
    let polynomial = |celsius: f64| -> f64 {
        let d = celsius.min(of("TMAX")).max(of("TMIN")) - 35.0;
        (1..4).map(|order| 1e-6 * of(&format!("{sensor}{order}_{axis}")) * d.powi(order)).sum()
    };
    polynomial(celsius) - polynomial(21.5)
}

/// Lines of five columns as QGroundControl reads them, or of a name and a value.
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
fn a_log_corrected_by_the_written_file_keeps_the_error_that_was_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let later = study(folder);
    let export =
        ["export", "unit.json", "--px4", "u.params", "--device-id", "77,88", "--ardupilot", "u.parm"];
    let told = done(folder, &[&export[..], &["--judge", "later.csv", "--json"]].concat());
    let told: serde_json::Value = serde_json::from_str(&told).expect("JSON and nothing else");
    let told = &told["temperature"];
    assert_eq!(told["corrected_by"], serde_json::json!(["PX4", "ArduPilot"]));
    let read = |name: &str| parameters(&std::fs::read_to_string(folder.join(name)).expect("written"));
    let (for_px4, for_ardupilot) = (read("u.params"), read("u.parm"));
    assert_eq!((for_px4["TC_A0_ID"], for_px4["TC_G0_ID"]), (77.0, 88.0));
    assert_eq!((for_px4["TC_G_ENABLE"], for_ardupilot["INS_TCAL1_ENABLE"]), (1.0, 1.0));
    assert!(for_ardupilot["INS_TCAL1_TMAX"] >= for_ardupilot["INS_TCAL1_TMIN"] + 10.0);
    for (column, name) in COLUMNS.iter().enumerate() {
        let axis = &told["axes"][column];
        assert_eq!(axis["column"], *name);
        // offsets are single: 6e-8 of up to 0.1 m/s² or 0.02 rad/s, against errors of 1e-3 and 1e-4
        let same = |told: &serde_json::Value, found: f64| {
            let told = told.as_f64().expect("a number");
            assert!((told / found - 1.0).abs() < 1e-4, "{name}: {told} told, {found} found");
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
    // what is a cubic is taken out down to the noise, 0.001·0.577/√20 and what the clipped ends leave
    assert!(told["axes"][3]["corrected"][0].as_f64().unwrap() < 6e-4, "{told}");
}

#[test]
fn who_has_no_device_id_is_told_that_px4_ignores_the_table() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    study(folder);
    let warned = said(folder, &["export", "unit.json", "--px4", "u.params"]);
    assert!(warned.contains("PX4 ignores these tables") && warned.contains("--device-id"), "{warned}");
    let told = done(folder, &["export", "unit.json", "--ardupilot", "u.parm"]);
    for part in ["nothing corrected", "ArduPilot's cubic", "the study", "warm.csv that were not fitted"] {
        assert!(told.contains(part), "{part}: {told}");
    }
}

#[test]
fn a_log_without_warmth_or_thermometer_is_refused_with_what_to_record() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write(&folder.join("steady.csv"), &rows(1.5, 4.0, 3));
    done(folder, &["fit", "steady.csv", "--axis", "gx", "-o", "steady.json"]);
    let narrow = fails(folder, 1, &["export", "steady.json", "--ardupilot", "u.parm", "--image", "u.fosm"]);
    assert!(
        narrow.contains("the temperature goes from 26.0") && narrow.contains("help: cool the unit"),
        "{narrow}"
    );
    assert!(!folder.join("u.parm").exists() && !folder.join("u.fosm").exists());

    let text = std::fs::read_to_string(folder.join("steady.csv")).expect("written");
    std::fs::write(folder.join("blind.csv"), text.replacen("temp_c", "other", 1)).expect("written");
    done(folder, &["fit", "blind.csv", "--axis", "gx", "-o", "blind.json"]);
    let blind = fails(folder, 1, &["export", "blind.json", "--px4", "u.params"]);
    assert!(blind.contains("blind.csv: it has no temperature") && blind.contains("help: log"), "{blind}");
}

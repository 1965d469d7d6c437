//! Rows and populations from logs of simulated units with known bias and temperature slope.

use std::path::Path;

use fos_data::recording::{LoadOptions, write_columns};
use fos_diagnose::effects::Library;
use fos_fleet::{Asked, BIAS, Fleet, UnitRow, rows, rows_beside, unit_row, units_in};
use fos_simulate::{Simulation, simulate};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const UNITS: u64 = 14;

/// Standard deviations of gx between units: bias in rad/s, slope in (rad/s)/K.
const BIAS_SCATTER: f64 = 4e-3;
const SLOPE_SCATTER: f64 = 2e-4;

/// Writes the log of a unit at rest, with this bias of gx at 25 °C and this slope in addition to those of all units.
fn write_unit(path: &Path, seed: u64, bias: f64, slope: f64) {
    let simulation = Simulation { duration_s: 240.0, rate_hz: 100.0, seed, temperature: 0.0, motion: false };
    let mut columns = simulate(&simulation).columns;
    let temperature = columns.iter().find(|(name, _)| name == "temp_c").expect("a thermometer").1.clone();
    for (name, values) in &mut columns {
        if name == "gx_rads" {
            values.iter_mut().zip(&temperature).for_each(|(value, t)| *value += bias + slope * (t - 25.0));
        }
    }
    let columns: Vec<(&str, &[f64])> =
        columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
    write_columns(path, &columns).expect("a log");
}

fn asked() -> Asked {
    Asked { regressors: vec!["temp_c".to_owned()], diagnosed: false, read: LoadOptions::default() }
}

#[test]
fn estimates_differ_between_units_and_interrupted_fleet_resumes() {
    let folder = tempfile::tempdir().expect("a folder");
    let logs = folder.path().join("logs");
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut truth = Vec::new();
    for unit in 0..UNITS {
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let (bias, slope) = (BIAS_SCATTER * draw(), SLOPE_SCATTER * draw());
        let lot = logs.join(format!("lot{}", unit % 2));
        std::fs::create_dir_all(&lot).expect("a folder");
        write_unit(&lot.join(format!("{unit:02}.parquet")), 100 + unit, bias, slope);
        truth.push((format!("lot{}/{unit:02}", unit % 2), bias, slope));
    }
    std::fs::write(logs.join("lot0/cut.parquet"), b"PAR1 and no more").expect("a file");
    std::fs::write(logs.join("lot1/empty.csv"), b"").expect("a file");

    let (units, library, kept) =
        (units_in(&logs).expect("units"), Library::built_in(), folder.path().join("rows"));
    let found = rows(&units, &asked(), &library, "a test", "a build", &kept, |_| {}).expect("rows");
    assert_eq!(found.len(), UNITS as usize + 2);
    for row in &found {
        let Some((_, bias, slope)) = truth.iter().find(|(name, _, _)| *name == row.unit) else {
            assert!(row.axes.is_empty() && row.failed.len() == 1, "{row:?}");
            continue;
        };
        let gx = row.axes.iter().find(|axis| axis.estimate.column == "gx_rads").expect("gx");
        let estimate = &gx.estimate.coefficients;
        assert_eq!(estimate.names, [BIAS, "temp_c"]);
        // The simulated unit has a bias that is the same for all units.
        let error = estimate.standard_error("temp_c").expect("complete");
        assert!(
            (estimate.values[1] - slope).abs() < 4.5 * error,
            "{}: {} {slope} {error}",
            row.unit,
            estimate.values[1]
        );
        assert!(error < SLOPE_SCATTER, "{error}");
        assert!((estimate.values[0] - bias).abs() < 0.1, "{estimate:?}");
        // The bias of an accelerometer at rest is indistinguishable from gravity.
        let ax = row.axes.iter().find(|axis| axis.estimate.column == "ax_mps2").expect("ax");
        assert_eq!(ax.estimate.coefficients.names, ["temp_c"]);
    }

    // Interrupted after some rows, in the middle of a line.
    let whole = std::fs::read_to_string(&kept).expect("rows");
    let cut: String = whole.chars().take(whole.len() * 2 / 5).collect();
    std::fs::write(&kept, &cut).expect("rows");
    let again = rows(&units, &asked(), &library, "a test", "a build", &kept, |_| {}).expect("rows");
    assert_eq!(again, found);
    assert_eq!(std::fs::read_to_string(&kept).expect("rows"), whole, "the same bytes");
    // Another program computes its own rows.
    let other = rows(&units, &asked(), &library, "another", "another build", &kept, |_| {}).expect("rows");
    assert!(other.iter().all(|row| row.program == "another"));

    let fleet = Fleet::of(&found, &asked(), &library, "a test");
    assert_eq!(fleet.failed.len(), 2);
    let part = &fleet.parts[0];
    assert!(part.odd.is_empty(), "{:?}", part.odd);
    let gx = part.axes.iter().find(|axis| axis.column == "gx_rads").expect("gx");
    let population = gx.population.as_ref().expect("a population");
    let [low, high] = population.scatter[1].units_interval;
    // With 14 units, the scatter of the sample is within a third of the truth.
    assert!(low < SLOPE_SCATTER && SLOPE_SCATTER < high, "{low} {high}");

    // The file is read with its own rows and refused with others.
    let made_again: Vec<_> = found.iter().rev().cloned().collect();
    assert_eq!(Fleet::of(&made_again, &asked(), &library, "a test"), fleet, "whatever the order of the rows");
    let path = folder.path().join("population.json");
    std::fs::write(&path, serde_json::to_string(&fleet).expect("JSON")).expect("a file");
    assert!(Fleet::read(&path).expect_err("no rows").to_string().contains("population.json.rows"));
    std::fs::write(rows_beside(&path), &whole).expect("rows");
    assert_eq!(Fleet::read(&path).expect("what was written"), (fleet, found));
    std::fs::write(rows_beside(&path), &cut).expect("rows");
    let error = Fleet::read(&path).expect_err("rows are missing").to_string();
    assert!(error.contains(" rows of 16 devices") && error.contains("help: "), "{error}");
    std::fs::write(&path, "{}").expect("a file");
    assert!(Fleet::read(&path).expect_err("no population").to_string().contains("help: "));
}

#[test]
fn logs_of_a_unit_are_joined_without_damaged_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    for (name, seed) in [("monday.parquet", 1), ("friday.parquet", 2)] {
        write_unit(&path(name), seed, 3e-3, SLOPE_SCATTER);
    }
    std::fs::write(path("cut.parquet"), b"PAR1 and no more").expect("a file");
    let table = |names: &[&str]| {
        let lines: String = names.iter().map(|name| format!("7,imu,w12,{name}.parquet\n")).collect();
        std::fs::write(path("units.csv"), format!("unit,part,lot,log\n{lines}")).expect("a table");
        let units = units_in(folder.path()).expect("units");
        assert_eq!((units.len(), units[0].logs.len()), (1, names.len()));
        unit_row(&units[0], &asked(), &Library::built_in(), "a test")
    };
    let slope = |row: &UnitRow| {
        let gx = &row.axis("gx_rads").expect("gx").estimate.coefficients;
        (gx.values[1], gx.standard_error("temp_c").expect("complete"))
    };
    let (monday, friday) = (table(&["monday"]), table(&["friday"]));
    let both = table(&["monday", "friday"]);
    let rows = |row: &UnitRow| row.log.as_ref().expect("read").rows;
    assert_eq!(rows(&both), rows(&monday) + rows(&friday));
    // The error is that of twice the time or a little more, because slow drift is separated from the slope.
    let alone = slope(&monday).1.min(slope(&friday).1);
    assert!(slope(&both).1 < alone, "{:?} {alone}", slope(&both));
    assert!((slope(&both).0 - SLOPE_SCATTER).abs() < 4.5 * slope(&both).1, "{:?}", slope(&both));

    let without = table(&["monday", "cut"]);
    assert_eq!((&without.axes, &without.sha256), (&monday.axes, &monday.sha256));
    assert!(without.failed[0].contains("cut.parquet") && without.failed.len() == 1, "{:?}", without.failed);
    assert_ne!(both.sha256, table(&["friday", "monday"]).sha256, "the order is part of it");
}

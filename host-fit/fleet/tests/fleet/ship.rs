//! Files for the devices of a part: the record of a unit removes the error known from its log and population, the image that of the part.

use std::path::Path;

use fos_core::image::{UnitRecord, for_unit};
use fos_core::{FittedOn, Image, Predictor, Sample};
use fos_data::recording::{LoadOptions, write_columns};
use fos_diagnose::effects::Library;
use fos_fleet::{Asked, Fleet, ShipError, Shipment, UnitRow, rows, units_in};
use fos_simulate::{Simulation, simulate};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Standard deviations of gx between units: rad/s, (rad/s)/K, (rad/s)/K².
const OF_UNITS: [f64; 3] = [4e-3, 2e-4, 4e-6];

/// Mean of the part, in the same units.
const OF_PART: [f64; 3] = [2e-3, 3e-4, 1e-5];

type Coefficients = [f64; 3];

fn error_at(of: &Coefficients, temp_c: f64) -> f64 {
    let t = temp_c - 25.0;
    of[0] + of[1] * t + of[2] * t * t
}

/// Writes the log of a unit at rest with this error of gx, from 15 to 35 °C and back.
fn write_unit(path: &Path, seed: u64, unit: &Coefficients) {
    let simulation = Simulation { duration_s: 240.0, rate_hz: 100.0, seed, temperature: 0.0, motion: false };
    let mut columns = simulate(&simulation).columns;
    let time = columns[0].1.clone();
    let temperature: Vec<f64> =
        time.iter().map(|t_s| 25.0 - 10.0 * (std::f64::consts::TAU * t_s / 240.0).cos()).collect();
    // The simulated unit has a bias that is the same for all units.
    let of_all = 0.5_f64.to_radians();
    for (name, values) in &mut columns {
        match name.as_str() {
            "gx_rads" => values
                .iter_mut()
                .zip(&temperature)
                .for_each(|(value, temp_c)| *value += error_at(unit, *temp_c) - of_all),
            "temp_c" => values.clone_from(&temperature),
            _ => {}
        }
    }
    let columns: Vec<(&str, &[f64])> =
        columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
    write_columns(path, &columns).expect("a log");
}

fn asked(regressors: &[&str]) -> Asked {
    let regressors = regressors.iter().map(|text| (*text).to_owned()).collect();
    Asked { regressors, diagnosed: false, read: LoadOptions::default() }
}

/// RMS of the remaining error of gx from 15 to 35 °C, rad/s, computed in f32 as on a device.
fn left(image: &[u8], unit: &Coefficients) -> f64 {
    let image = Image::parse(image).expect("an image");
    let place = image.axes().position(|axis| axis.parameters.axis == fos_core::Axis::Gx).expect("gx");
    let mut predictor: Predictor<f32, 6, 8, 32, 64> = image.predictor().expect("it fits a device");
    let mut square = |temp_c: f64| {
        let mut measured = [0.0_f32; 6];
        measured[place] = error_at(unit, temp_c) as f32;
        let measured = &measured[..image.axes().count()];
        let corrected = predictor.coast(&Sample { measured, quantities: &[temp_c as f32] })[place].corrected;
        f64::from(corrected).powi(2)
    };
    (((15..=35).map(|t| square(f64::from(t))).sum::<f64>()) / 21.0).sqrt()
}

#[test]
fn record_removes_unit_error_and_image_removes_part_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let logs = folder.path().join("logs");
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut units: Vec<(String, Coefficients)> = Vec::new();
    for unit in 0..12_u64 {
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let of_unit = [0, 1, 2].map(|i| OF_PART[i] + OF_UNITS[i] * draw());
        std::fs::create_dir_all(logs.join("w7")).expect("a folder");
        write_unit(&logs.join(format!("w7/{unit:02}.parquet")), 300 + unit, &of_unit);
        units.push((format!("w7/{unit:02}"), of_unit));
    }
    std::fs::write(logs.join("w7/broken.csv"), b"t_s,gx_rads\n").expect("a file");
    let asked = asked(&["temp_c", "temp_c * temp_c"]);
    let library = Library::built_in();
    let found = rows(
        &units_in(&logs).expect("units"),
        &asked,
        &library,
        "a test",
        "a build",
        &folder.path().join("rows"),
        |_| {},
    )
    .expect("rows");
    let fleet = Fleet::of(&found, &asked, &library, "a test");
    let shipped = Shipment::of(&fleet.parts[0], &found, FittedOn::Raw, "imu", "a test").expect("a shipment");
    assert_eq!(shipped.without, ["w7/broken"]);
    assert_eq!(shipped.units.len(), 12);

    let (mut of_part, mut of_records) = (0.0, 0.0);
    let mut buffer = vec![0; shipped.image.len()];
    for ((name, truth), unit) in units.iter().zip(&shipped.units) {
        assert_eq!(*name, unit.unit);
        // Five axes with two slopes each, including three accelerometers without a bias; every axis has a place for one.
        assert!(unit.record.len() < 110, "{} bytes", unit.record.len());
        assert_eq!(UnitRecord::parse(&unit.record).expect("a record").name(), name);
        let own = for_unit(&shipped.image, &unit.record, &mut buffer).expect("its image");
        of_records += left(own, truth).powi(2);
        of_part += left(&shipped.image, truth).powi(2);
    }
    let [of_part, of_records] = [of_part, of_records].map(|sum: f64| (sum / 12.0).sqrt());
    let nothing = (units.iter().map(|(_, unit)| error_at(unit, 25.0).powi(2)).sum::<f64>() / 12.0).sqrt();
    println!(
        "left of the error: {of_part:.2e} with the image of the part, {of_records:.2e} with the records, rad/s"
    );
    assert!(of_part < nothing && of_part > 2e-3, "units differ by 4e-3: {of_part:e} of {nothing:e}");
    assert!(of_records < 0.1 * of_part, "{of_records:e} of {of_part:e}");

    // Extrapolation of a unit's record is limited to the range of the units of its part.
    let far = for_unit(&shipped.image, &shipped.units[0].record, &mut buffer).expect("its image");
    let far = Image::parse(far).expect("an image");
    let mut predictor: Predictor<f32, 6, 8, 32, 64> = far.predictor().expect("it fits a device");
    let measured = [0.0_f32; 6];
    let sample = Sample { measured: &measured[..far.axes().count()], quantities: &[1e6] };
    assert!(predictor.coast(&sample).iter().all(|axis| axis.corrected.abs() < 1.0));
}

#[test]
fn reports_parts_that_cannot_be_shipped() {
    let (asked, library) = (asked(&["temp_c"]), Library::built_in());
    let failed = UnitRow {
        unit: "7".to_owned(),
        part: "p".to_owned(),
        lot: None,
        program: String::new(),
        asked: asked.clone(),
        sha256: String::new(),
        log: None,
        axes: vec![],
        failed: vec!["no log".to_owned()],
    };
    let fleet = Fleet::of(std::slice::from_ref(&failed), &asked, &library, "");
    let error = Shipment::of(&fleet.parts[0], &[failed], FittedOn::Raw, "", "").expect_err("no population");
    assert!(matches!(&error, ShipError::NoPopulation(part) if part == "p"), "{error}");
    assert!(error.to_string().contains("help: "));
}

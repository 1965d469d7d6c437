//! Degenerate fleets: files can be read back, every number is finite, a log counts once, and an unusable log does not end the run.

use crate::drawn::{asked, row};
use fos_data::recording::Recording;
use fos_diagnose::effects::Library;
use fos_fleet::{Fleet, Gathered, Unit, UnitRow, check_regressors, row_of};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

fn fleet_of(rows: &[UnitRow]) -> Fleet {
    Fleet::of(rows, &asked(), &Library::built_in(), "a test")
}

/// Rows of devices of one lot, each modified by `change`.
fn rows(units: usize, change: impl Fn(usize, &mut UnitRow)) -> Vec<UnitRow> {
    (0..units)
        .map(|unit| {
            let mut row = row(unit);
            change(unit, &mut row);
            row
        })
        .collect()
}

/// Sets the coefficients and variances of all axes of a row.
fn set(row: &mut UnitRow, value: impl Fn(usize, f64) -> f64, variance: impl Fn(usize, f64) -> f64) {
    for axis in &mut row.axes {
        let estimate = &mut axis.estimate.coefficients;
        for place in 0..estimate.values.len() {
            estimate.values[place] = value(place, estimate.values[place]);
            estimate.covariance[place][place] = variance(place, estimate.covariance[place][place]);
        }
    }
}

fn without_slope(row: &mut UnitRow) {
    for axis in &mut row.axes {
        let estimate = &mut axis.estimate.coefficients;
        estimate.names.truncate(1);
        estimate.values.truncate(1);
        estimate.covariance = vec![vec![estimate.covariance[0][0]]];
    }
}

fn cases() -> Vec<(String, Vec<UnitRow>)> {
    let same = |_: usize, value: f64| value;
    let mut cases = vec![
        (
            "values that are equal".to_owned(),
            rows(6, |_, row| set(row, |place, _| [2e-3, 1e-4][place], same)),
        ),
        (
            "values that differ in the last bit".to_owned(),
            rows(6, |unit, row| {
                set(row, |place, _| [2e-3, 1e-4][place] * (1.0 + unit as f64 * f64::EPSILON), same)
            }),
        ),
        ("values without errors".to_owned(), rows(6, |_, row| set(row, same, |_, _| 0.0))),
        ("equal values without errors".to_owned(), rows(6, |_, row| set(row, |_, _| 2e-3, |_, _| 0.0))),
        ("zeros".to_owned(), rows(6, |_, row| set(row, |_, _| 0.0, |_, _| 0.0))),
        ("errors that dwarf values".to_owned(), rows(6, |_, row| set(row, same, |_, _| 1e12))),
        ("constant temperature".to_owned(), rows(6, |_, row| without_slope(row))),
        (
            "a slope of two devices".to_owned(),
            rows(6, |unit, row| {
                if unit > 1 {
                    without_slope(row)
                }
            }),
        ),
        (
            "a slope of three devices".to_owned(),
            rows(6, |unit, row| {
                if unit > 2 {
                    without_slope(row)
                }
            }),
        ),
        ("a device of each lot".to_owned(), rows(5, |unit, row| row.lot = Some(unit.to_string()))),
        ("two lots, one of one".to_owned(), rows(5, |unit, row| row.lot = Some((unit / 4).to_string()))),
        ("no lots".to_owned(), rows(5, |_, row| row.lot = None)),
        ("nothing read".to_owned(), rows(4, |_, row| row.axes.clear())),
    ];
    cases.extend((1..=4).map(|units| (format!("{units} devices"), rows(units, |_, _| {}))));
    // Random sizes over the whole range of a double, in any number of lots.
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for case in 0..40 {
        let (units, lots) = (random.random_range(1..9), random.random_range(1..4));
        let exponents: Vec<[f64; 2]> = (0..units)
            .map(|_| [random.random_range(-40.0..40.0), random.random_range(-60.0..60.0)])
            .collect();
        let of_case = rows(units, |unit, row| {
            let [value, variance] =
                exponents[if case % 2 == 0 { unit } else { 0 }].map(|exponent| 10_f64.powf(exponent));
            row.lot = Some((unit % lots).to_string());
            set(row, |_, drawn| drawn * value, |_, drawn| drawn * variance);
        });
        cases.push((format!("at random, {case}"), of_case));
    }
    cases
}

/// Defects in the file of a population and its rows.
fn failures(name: &str, fleet: &Fleet, rows: &[UnitRow], doctor: impl Fn(&str) -> String) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("population.json");
    let texts: Vec<String> = rows.iter().map(|row| serde_json::to_string(row).expect("JSON")).collect();
    fleet.write_with_rows(&path, &texts).expect("written");
    let text = doctor(&std::fs::read_to_string(&path).expect("JSON"));
    std::fs::write(&path, &text).expect("written");
    let mut found = Vec::new();
    match Fleet::read(&path) {
        Ok((read, _)) if read == *fleet => {}
        Ok(_) => found.push(format!("{name}: read as another")),
        Err(error) => found.push(format!("{name}: {error}")),
    }
    // The file may omit a value with null, but no number may become null.
    let value: Value = serde_json::from_str(&text).expect("JSON");
    for axis in value["parts"]
        .as_array()
        .expect("parts")
        .iter()
        .flat_map(|part| part["axes"].as_array().expect("axes"))
    {
        let mut population = axis["population"].clone();
        let scatter = population.get_mut("scatter").and_then(Value::as_array_mut);
        for scatter in scatter.into_iter().flatten() {
            scatter.as_object_mut().expect("scatter").remove("lots_alike");
        }
        if population.to_string().contains("null") && !population.is_null() {
            found.push(format!("{name}: {} has no number somewhere", axis["column"]));
        }
    }
    found
}

#[test]
fn degenerate_fleets_round_trip_with_finite_numbers() {
    let mut found = Vec::new();
    let cases = cases();
    for (name, rows) in &cases {
        found.extend(failures(name, &fleet_of(rows), rows, str::to_owned));
    }
    assert_eq!(found, [""; 0]);
    let rows = rows(6, |_, _| {});
    let mut fleet = fleet_of(&rows);
    if let Some(population) = &mut fleet.parts[0].axes[0].population {
        population.scatter[1].units = f64::NAN;
    }
    println!(
        "attack: degenerate fleets | {} fleets (equal rows, copies, a single temperature, one to three devices, random): every number written is finite, and every file written can be read | negative control: a scatter that is not finite is detected {} times",
        cases.len(),
        failures("noticed", &fleet, &rows, str::to_owned).len(),
    );
}

#[test]
fn check_detects_non_finite_numbers() {
    let rows = rows(6, |_, _| {});
    let mut fleet = fleet_of(&rows);
    assert_eq!(failures("sound", &fleet, &rows, str::to_owned), [""; 0]);
    let population = fleet.parts[0].axes[0].population.as_mut().expect("a population");
    population.scatter[1].units = f64::NAN;
    assert!(!failures("not a number", &fleet, &rows, str::to_owned).is_empty());
    let fleet = fleet_of(&rows);
    let mean = fleet.parts[0].axes[0].population.as_ref().expect("a population").mean[0];
    let doctored = failures("no mean", &fleet, &rows, |text| text.replacen(&mean.to_string(), "null", 1));
    assert!(!doctored.is_empty());
}

#[test]
fn equal_values_give_no_scatter_and_no_odd_device() {
    let rows = rows(6, |_, row| set(row, |place, _| [2e-3, 1e-4][place], |_, variance| variance));
    let fleet = fleet_of(&rows);
    assert!(fleet.parts[0].odd.is_empty() && fleet.duplicates.is_empty());
    for axis in &fleet.parts[0].axes {
        let population = axis.population.as_ref().expect("a population");
        assert!(
            (population.mean[0] / 2e-3 - 1.0).abs() < 1e-6 && (population.mean[1] / 1e-4 - 1.0).abs() < 1e-6
        );
        // The log errors are 2e-4 and 1e-4, times up to 2.
        assert!(population.scatter[0].units < 1e-4, "{:?}", population.scatter);
        let [low, high] = population.scatter[0].units_interval;
        assert!(low == 0.0 && high > 1e-5 && high < 4e-3, "{:?}", population.scatter);
    }
}

#[test]
fn duplicate_log_counts_once() {
    let sound = rows(8, |_, _| {});
    let mut copied = sound.clone();
    for copy in 0..5 {
        let mut row = sound[0].clone();
        row.unit = format!("v{copy}");
        copied.push(row);
    }
    let (fleet, with_copies) = (fleet_of(&sound), fleet_of(&copied));
    assert_eq!(with_copies.parts, fleet.parts, "the same populations, and nothing odd");
    assert_eq!((with_copies.units, with_copies.duplicates.len()), (13, 5));
    let message = with_copies.duplicates[0].to_string();
    assert_eq!(message, "v0 is the same log as u00000000: counted once.");

    // In another part the same log belongs to another device.
    copied.iter_mut().skip(8).for_each(|row| row.part = "another".to_owned());
    let apart = fleet_of(&copied);
    assert_eq!(apart.duplicates.len(), 4);
    // Rows without a log are not duplicates of each other.
    assert!(fleet_of(&rows(4, |_, row| row.sha256.clear())).duplicates.is_empty());
}

#[test]
fn three_devices_are_not_conclusive_for_odd_ones() {
    let part = |units: usize| fleet_of(&rows(units, |_, _| {})).parts[0].clone();
    for units in [1, 2, 3, 5] {
        let part = part(units);
        assert!(part.odd.is_empty(), "{:?}", part.odd);
        let (needed, message) = (part.units_needed.expect("too few"), part.not_conclusive().expect("said"));
        assert!(needed > units && message.contains(&format!("{needed} devices are needed")), "{message}");
        assert!(units < 3 || message.contains(&format!("{units} were read")), "{message}");
    }
    assert_eq!(part(30).units_needed, None);
}

/// One device is 8 standard deviations off; it must be found, by the right coefficient, where the fleet is large enough.
#[test]
fn finds_far_device_among_a_dozen() {
    let rows = rows(12, |unit, row| {
        if unit == 4 {
            row.axes[3].estimate.coefficients.values[0] += 8.0 * 4e-3;
        }
    });
    let part = &fleet_of(&rows).parts[0];
    assert_eq!(part.units_needed, None);
    let odd: Vec<_> = part.odd.iter().map(|odd| (odd.unit.as_str(), odd.distance.most.as_str())).collect();
    assert_eq!(odd, [("u00000004", "bias")]);
}

#[test]
fn panic_on_a_log_is_reported_in_its_row() {
    let unit = Unit { name: "7".to_owned(), part: String::new(), lot: None, logs: Vec::new() };
    let read = (0..2).map(|log| -> Result<Recording, String> {
        match log {
            0 => panic!("index out of bounds"),
            _ => Err("the file is empty".to_owned()),
        }
    });
    let row = row_of(&unit, read, &asked(), &Library::built_in(), "a test");
    assert!(row.axes.is_empty() && row.failed.len() == 2, "{row:?}");
    assert!(row.failed[0].contains("index out of bounds") && row.failed[0].contains("help: "), "{row:?}");
}

#[test]
fn rejects_regressors_with_the_same_coefficient() {
    let message = |regressors: &[&str]| {
        let regressors: Vec<String> = regressors.iter().map(|text| (*text).to_owned()).collect();
        check_regressors(&regressors).err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(message(&["temp_c", "temp_c * temp_c", "temp_c:lowpass(60)"]), "");
    for (twice, named) in [
        (["temp_c", "temp_c"], "\"temp_c\" is given twice"),
        (["temp_c * temp_c", "temp_c*temp_c"], "\"temp_c*temp_c\" is given twice"),
        (["temp_c", "bias"], "\"bias\" has the name of the constant coefficient"),
    ] {
        let message = message(&twice);
        assert!(message.contains(named) && message.contains("help: "), "{twice:?}: {message}");
    }
    // Rows of an earlier version may have the regressor twice.
    let rows = rows(5, |_, row| row.asked.regressors.push("temp_c".to_owned()));
    let mut gathered = Gathered::default();
    rows.iter().for_each(|row| gathered.add(row.clone()).expect("a row"));
    let refused = Fleet::of_gathered(&gathered, &Library::built_in(), "a test");
    assert!(refused.is_err_and(|error| error.to_string().contains("\"temp_c\" is given twice")));
}

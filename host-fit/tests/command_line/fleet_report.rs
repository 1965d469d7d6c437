//! The page of a population shows the population's numbers; files that do not match are rejected by name.

use std::fs;
use std::path::Path;

use crate::escaping::checks::page_differs;
use crate::session::{done, fails};
use fos_data::recording::LoadOptions;
use fos_data::text::rounded;
use fos_diagnose::effects::Library;
use fos_fit::noise::NoiseLevels;
use fos_fleet::{
    Asked, AxisDiagnosis, AxisEstimate, AxisRow, Estimate, Fleet, FoundEffect, LogSummary, UnitRow,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::{Value, json};

/// 1 °/s in rad/s.
const DPS: f64 = std::f64::consts::PI / 180.0;

const LOTS: usize = 4;

/// Device with an odd bias; unreadable device; device without a slope.
const ODD: usize = 7;
const UNREAD: usize = 12;
const NO_SLOPE: usize = 17;

fn asked() -> Asked {
    Asked { regressors: vec!["temp_c".to_owned()], diagnosed: true, read: LoadOptions::default() }
}

/// Rows of 40 devices in four lots, as from their logs; `name` is in every text.
fn rows(name: &str, seed: u64) -> Vec<UnitRow> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let of_lots: Vec<f64> = (0..LOTS).map(|_| 2e-3 * normal()).collect();
    let row = |place: usize| {
        let lot = place % LOTS;
        let bias = 5e-3 + of_lots[lot] + 4e-3 * normal() + if place == ODD { 0.03 } else { 0.0 };
        let slope = 1e-4 + 2e-4 * normal();
        let (names, values, errors) = match place {
            NO_SLOPE => (vec!["bias"], vec![bias], vec![1e-4]),
            _ => (vec!["bias", "temp_c"], vec![bias, slope], vec![1e-4, 1e-5]),
        };
        let covariance = |at: usize| {
            (0..errors.len()).map(|other| if other == at { errors[at] * errors[at] } else { 0.0 }).collect()
        };
        let noise = |normal: f64| NoiseLevels {
            white: 1e-4 * (0.1 * normal).exp(),
            flicker: 1e-5,
            walk: 1e-7,
            gauss_markov: None,
        };
        let coefficients = Estimate {
            names: names.into_iter().map(str::to_owned).collect(),
            values,
            covariance: (0..errors.len()).map(covariance).collect(),
        };
        let found = place
            .is_multiple_of(2)
            .then(|| FoundEffect { effect: "thermal_lag".to_owned(), predicted_reduction: 0.5 });
        let axis = AxisRow {
            estimate: AxisEstimate {
                column: "gx_rads".to_owned(),
                coefficients,
                noise: noise(normal()),
                seconds: 240.0,
            },
            diagnosis: Some(AxisDiagnosis {
                verdict: fos_diagnose::detect::Verdict::NothingMissing,
                effects: found.into_iter().collect(),
            }),
        };
        let log: LogSummary = serde_json::from_value(json!({
            "rows": 24_000, "seconds": 240.0, "rate_hz": 100.0, "temperature_c": [24.0, 31.0],
        }))
        .expect("as rows are kept");
        let is_read = place != UNREAD;
        UnitRow {
            unit: format!("{name}{place}"),
            part: name.to_owned(),
            lot: Some(format!("{name}W{}", lot + 8)),
            program: "a test".to_owned(),
            asked: asked(),
            sha256: String::new(),
            log: is_read.then_some(log),
            axes: is_read.then_some(axis).into_iter().collect(),
            failed: (!is_read)
                .then(|| format!("{name}: the file is empty\nhelp: {name}"))
                .into_iter()
                .collect(),
        }
    };
    (0..40).map(row).collect()
}

/// Writes a population and its rows to `folder`, as `fos fleet` does.
fn write(folder: &Path, rows: &[UnitRow]) -> Fleet {
    let fleet = Fleet::of(rows, &asked(), &Library::built_in(), "a test");
    fs::write(folder.join("population.json"), serde_json::to_vec(&fleet).expect("JSON")).expect("written");
    let line = |row: &UnitRow| format!("{}\n", json!({"key": row.unit, "row": row}));
    fs::write(folder.join("population.json.rows"), rows.iter().map(line).collect::<String>())
        .expect("written");
    fleet
}

fn near(found: &Value, expected: f64) {
    let found = found.as_f64().expect("a number");
    assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found} {expected}");
}

#[test]
fn page_shows_the_numbers_of_the_population() {
    let folder = tempfile::tempdir().expect("a folder");
    let fleet = write(folder.path(), &rows("unit ", 1));
    let printed: Value =
        serde_json::from_str(&done(folder.path(), &["fleet", "report", "population.json", "--json"]))
            .expect("JSON and nothing else");
    assert!(!folder.path().join("fleet.html").exists(), "JSON alone writes nothing");
    done(folder.path(), &["fleet", "report", "population.json"]);
    let page = fs::read_to_string(folder.path().join("fleet.html")).expect("a page");
    let shown = |value: f64| {
        // three digits, in plain notation as far as it can be read
        let text = match value.abs() {
            small @ 1e-5..1e-3 => format!("{value:.*}", (2.0 - small.log10().floor()) as usize),
            _ => rounded(value, 3),
        };
        let text = text.replace('-', "−");
        assert!(page.contains(&format!(">{text}")) || page.contains(&format!(" {text}")), "{text}");
    };

    let (part, of_part) = (&printed["parts"][0], &fleet.parts[0]);
    let population = of_part.axes[0].population.as_ref().expect("a population");
    for place in 0..2 {
        let coefficient = &part["axes"][0]["coefficients"][place];
        let scatter = population.scatter[place];
        assert_eq!(coefficient["unit"], ["°/s", "(°/s)/K"][place]);
        assert_eq!(coefficient["units"], population.units);
        near(&coefficient["mean"], population.mean[place] / DPS);
        near(&coefficient["between_units"], scatter.units / DPS);
        near(&coefficient["between_units_interval"][1], scatter.units_interval[1] / DPS);
        near(&coefficient["between_lots"], scatter.lots / DPS);
        near(&coefficient["lots_alike"], scatter.lots_alike.expect("four lots"));
        near(&coefficient["error_of_log"], scatter.measurement / DPS);
        for value in [population.mean[place], scatter.units, scatter.units_interval[1], scatter.measurement] {
            shown(value / DPS);
        }
        let shares: f64 = (0..3).map(|kind| coefficient["shares"][kind].as_f64().expect("a share")).sum();
        assert!((shares - 1.0).abs() < 1e-12);
        // corrections shipped: the mean alone leaves the largest error, a log with the population the smallest
        let left = |by: &str| coefficient["left"][by].as_f64().expect("a number");
        assert!(left("part_mean") > left("lot_mean") && left("lot_mean") > left("own_log"));
        assert!(left("own_log") > left("with_population"));
        // every device that determines the coefficient is a dot, in the order of the lots
        let panel = &coefficient["figure"]["panels"][1];
        assert_eq!(panel["x"]["names"], json!(["unit W8", "unit W9", "unit W10", "unit W11"]));
        let dots: usize = panel["series"]
            .as_array()
            .expect("series")
            .iter()
            .map(|series| series["shape"]["Points"].as_array().map_or(0, Vec::len))
            .sum();
        assert_eq!(dots, [39, 38][place]);
    }
    assert_eq!(part["read"]["whole"], 39);
    assert_eq!(part["read"]["not_read"][0]["unit"], format!("unit {UNREAD}"));
    assert!(page.contains("the file is empty"));
    let odd = &part["odd"];
    assert_eq!(odd.as_array().map(Vec::len), Some(of_part.odd.len()));
    assert_eq!(odd[0]["unit"], format!("unit {ODD}"));
    near(&odd[0]["by"], of_part.odd[0].distance.by);
    let effect = &part["axes"][0]["effects"][0];
    assert_eq!((&effect["units"], &effect["effect"]), (&json!([19, 39]), &json!("thermal_lag")));
    near(&effect["mean_reduction"], 0.5 * 19.0 / 39.0);
    assert!(page.contains("19 of 39") && !page.contains("<script"));
}

#[test]
fn fleet_of_three_devices_warns_about_its_limits() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut few: Vec<UnitRow> = rows("", 1).into_iter().take(3).collect();
    few.iter_mut().for_each(|row| row.lot = None);
    write(folder.path(), &few);
    done(folder.path(), &["fleet", "report", "population.json"]);
    let page = fs::read_to_string(folder.path().join("fleet.html")).expect("a page");
    assert!(page.contains("Caution: The scatter between devices is only known to lie between"));
    assert!(page.contains("Device by device") && page.contains("none named"));
}

/// The page of any fleet is complete: equal values, no errors, one to three devices, one log under several names.
#[test]
fn shows_degenerate_fleets_completely() {
    let change = |units: usize, change: &dyn Fn(usize, &mut UnitRow)| {
        let mut rows: Vec<UnitRow> = rows("", 1).into_iter().take(units).collect();
        rows.iter_mut().enumerate().for_each(|(place, row)| change(place, row));
        rows
    };
    let equal = |row: &mut UnitRow, with_errors: bool| {
        for axis in &mut row.axes {
            let estimate = &mut axis.estimate.coefficients;
            estimate.values.fill(2e-3);
            if !with_errors {
                estimate.covariance.iter_mut().for_each(|row| row.fill(0.0));
            }
        }
    };
    for (what, rows, message) in [
        ("equal values", change(6, &|_, row| equal(row, true)), "No device is unlike the others."),
        ("equal values without errors", change(6, &|_, row| equal(row, false)), ""),
        ("one device", change(1, &|_, _| {}), "no axis has a population"),
        ("two devices", change(2, &|_, _| {}), "no axis has a population"),
        ("three devices", change(3, &|_, _| {}), "(3 were read)"),
        ("a device of each lot", change(4, &|place, row| row.lot = Some(place.to_string())), "(4 were read)"),
        (
            "one log",
            change(8, &|place, row| row.sha256 = if place < 5 { "a".to_owned() } else { place.to_string() }),
            "4 is the same log as 0: counted once.",
        ),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path(), &rows);
        done(folder.path(), &["fleet", "report", "population.json"]);
        let page = fs::read_to_string(folder.path().join("fleet.html")).expect("a page");
        assert!(page.contains(message), "{what}: {message}");
        assert!(!page.contains("NaN") && !page.contains(">inf"), "{what}");
    }
}

#[test]
fn rejects_mismatched_files_without_writing() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let (population, kept) = (folder.join("population.json"), folder.join("population.json.rows"));
    let rows_of_one = rows("a", 1);
    write(folder, &rows_of_one);
    let (whole, sound) =
        (fs::read_to_string(&population).expect("there"), fs::read_to_string(&kept).expect("there"));
    let refused = |what: &str| {
        let message = fails(folder, 1, &["fleet", "report", "population.json"]);
        assert!(message.contains(what) && message.contains("help: "), "{what}: {message}");
        assert!(!folder.join("fleet.html").exists(), "{what}");
    };

    fs::remove_file(&kept).expect("removed");
    refused("population.json.rows");
    // another fleet of as many devices; one device less; another part
    write(folder, &rows("a", 2));
    fs::write(&population, &whole).expect("written");
    refused("population.json.rows: 40 rows of 40 devices");
    write(folder, &rows_of_one[1..]);
    fs::write(&population, &whole).expect("written");
    refused("population.json.rows: 39 rows of 40 devices");
    write(folder, &rows("b", 1));
    fs::write(&population, &whole).expect("written");
    refused("population.json.rows: 40 rows of 40 devices");
    // an invalid number, a number too large, an invalid matrix, a truncated line
    let third = sound.lines().nth(2).expect("a row").to_owned();
    let mut row: Value = serde_json::from_str(&third).expect("JSON");
    let values = &mut row["row"]["axes"][0]["coefficients"]["values"];
    *values = json!([null, 0.1]);
    let nan = row.to_string();
    for (instead, what) in [
        (nan.as_str(), ":3: "),
        (&nan.replace("[null,0.1]", "[1e999,0.1]"), ":3: "),
        (&nan.replace("[null,0.1]", "[0.1]"), ":3: not the row of a device: gx_rads: a number is missing"),
        (&third[..third.len() / 2], ":3: "),
        ("{}", ":3: "),
    ] {
        assert_ne!(instead, third);
        fs::write(&kept, sound.replace(&third, instead)).expect("written");
        refused(what);
    }
    fs::write(&kept, &sound).expect("written");
    let mut wrong: Value = serde_json::from_str(&whole).expect("JSON");
    wrong["parts"][0]["axes"][0]["population"]["mean"] = json!([1.0]);
    for (instead, what) in [
        (wrong.to_string(), "gx_rads: a number is missing"),
        (whole.replace("fos-population/1", "fos-population/9"), "fos-population/9"),
        ("{".to_owned(), "not a population"),
    ] {
        fs::write(&population, instead).expect("written");
        refused(what);
    }
    fs::write(&population, &whole).expect("written");
    done(folder, &["fleet", "report", "population.json"]);
}

#[test]
fn names_stay_text() {
    let hostile =
        "<script>injected()</script><img src=x onerror=injected()>&amp;\"'`]]>--> \u{1b}[31m\u{202e}\n";
    let page = |name: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path(), &rows(name, 1));
        done(folder.path(), &["fleet", "report", "population.json"]);
        fs::read_to_string(folder.path().join("fleet.html")).expect("a page")
    };
    let (plain, written) = (page("harmless"), page(hostile));
    assert_eq!(page_differs(&written, &plain), None);
    assert!(written.contains("injected"));
}

//! Required content of a study file, and the stored options of its logs.

use std::fs;
use std::path::Path;

use crate::session::{done, fails};
use fos_diagnose::study::Study;
use serde_json::{Value, json};

#[test]
fn rejects_an_inconsistent_study_with_the_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("study.json");
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/study_v1.json");
    let good: Value = serde_json::from_slice(&fs::read(fixture).expect("there")).expect("JSON");
    let read = |study: &Value| {
        fs::write(&path, study.to_string()).expect("written");
        Study::read(&path).map_err(|error| error.to_string())
    };
    read(&good).expect("sound");
    let step = "/refinements/0/steps/1";
    let axis = &good["refinements"][0]["steps"][1]["model"]["axes"][0];
    let two_axes = json!([axis, axis]);
    for (place, value, says) in [
        ("/model/axes", json!([]), "model: there is no axis"),
        ("/model/period_s", json!(0), "the sample period"),
        ("/model/inputs", json!([]), "an input that is not there"),
        ("/model/axes/0/physical/0/factors", json!([]), "1 to 3 factors"),
        ("/axes", json!([]), "those of the model"),
        ("/steps/0/errors", json!([]), "the errors of 0 axes"),
        ("/data/trained_rows", json!(u32::MAX), "more rows than there are"),
        ("/data/columns", json!(["gx_rads=gyro:furlong"]), "furlong"),
        ("/refinements/0/column", json!("gy_rads"), "no axis of the model"),
        ("/refinements/0/steps", json!([]), "there is no step"),
        ("/refinements/0/steps/0/model/axes", json!([]), "a model of one axis is needed; this one has 0"),
        (&format!("{step}/model/axes"), two_axes, "a model of one axis is needed; this one has 2"),
        (&format!("{step}/model/axes/0/column"), json!("gz_rads"), "the model is of gz_rads"),
        (&format!("{step}/added"), Value::Null, "each step but the first"),
        (&format!("{step}/added/effect/id"), json!("Thermal Lag"), "small letters"),
        (&format!("{step}/added/finding/effect"), json!("bias_ramp"), "the finding is"),
        (&format!("{step}/added/finding/correction/0/regressor"), json!("temp_c:lowpas(3)"), "lowpas"),
        (&format!("{step}/added/finding/limits"), json!({ "temp_c": [2, 1] }), "the wrong way round"),
    ] {
        let mut study = good.clone();
        *study.pointer_mut(place).unwrap_or_else(|| panic!("{place}: not there")) = value;
        let error = read(&study).expect_err(place);
        assert!(
            error.contains(says) && error.contains("study.json") && error.contains("help: "),
            "{place}: {error}"
        );
    }
}

/// An effect without a parameter that every log with a temperature determines.
const RATE: &str = r#"
id = "warming"
name = "rate of temperature change over 4 s"
band = "slow"
targets = "any"
mechanism = "A gradient over the die."
equation = "p(n) = c · (T(n) − LP₄(T)(n)) / 4 s"
typical_size = "not known"
source = "none"
experiment = "Ramps at two rates."
gives_away = "It follows the slope of the temperature."
device = "One low-pass and one multiplication a sample."

[[terms]]
regressor = "temp_c:rate(4)"
gyro = "dps/(K/s)"
gyro_typical = 16.0
"#;

#[test]
fn study_stores_the_options_of_its_logs() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, &["simulate", "plain.csv", "--minutes", "5", "--seed", "3", "--at-rest"]);
    let plain = fs::read_to_string(folder.join("plain.csv")).expect("written");
    // no timestamps, and a name that needs quotes
    let without_stamps: String =
        plain.lines().filter_map(|line| line.split_once(',')).fold(String::new(), |mut text, (_, rest)| {
            text.push_str(&rest.replace("gx_rads", "gyro:x"));
            text.push('\n');
            text
        });
    fs::write(folder.join("log.csv"), without_stamps).expect("written");
    fs::write(folder.join("map.toml"), "[columns]\ngx_rads = { column = \"gyro:x\" }\n").expect("written");
    fs::create_dir(folder.join("below")).expect("made");
    let fit = [
        "fit",
        "log.csv",
        "--axis",
        "gx",
        "--max-terms",
        "2",
        "--map-file",
        "map.toml",
        "--rate",
        "200",
        "--strict",
    ];
    done(folder, &[&fit[..], &["-o", "unit.json"]].concat());
    fs::remove_file(folder.join("map.toml")).expect("it was there");

    assert!(done(folder, &["compare", "unit.json"]).contains("gx_rads"));
    // the same log by another path, twice
    done(folder, &["add", "unit.json", "temp_linear", "--from", "log.csv"]);
    done(folder, &["undo", "unit.json"]);
    done(folder, &["add", "unit.json", "temp_linear", "--from", "log.csv"]);
    fs::write(folder.join("rate.toml"), RATE).expect("written");
    let second = ["add", "unit.json", "warming", "--from", "below/../log.csv", "--effect", "rate.toml"];
    let added = done(folder, &second);
    assert!(added.contains("temp_linear") && added.contains("warming"), "{added}");
    let study = Study::read(&folder.join("unit.json")).expect("a study");
    assert_eq!(study.data.read.columns.specs(), ["gx_rads=\"gyro:x\""]);
    assert_eq!(study.refinements[0].logs.read, study.data.read);
    assert_eq!((study.data.read.rate_hz, study.data.read.strict), (Some(200.0), false));
}

#[test]
fn flags_of_a_log_need_a_log() {
    let folder = tempfile::tempdir().expect("a folder");
    let message = fails(folder.path(), 1, &["serve", "--strict"]);
    assert!(message.contains("there is no log") && message.contains("help: "), "{message}");
    let message = fails(folder.path(), 1, &["serve", "absent/log.csv"]);
    assert!(message.contains("absent: cannot read it"), "{message}");
}

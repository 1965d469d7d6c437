//! Any bytes as a study or as the description of a case: refused with location and remedy, or written, read again,
//! exported, compared, diagnosed and undone.
#![no_main]

use std::sync::LazyLock;

use fos_core::Image;
use fos_fuzz::log;
use fos_data::case::CaseMeta;
use fos_diagnose::effects::Library;
use fos_export::{c_source, image, rust_source};
use fos_report::examine::examine;
use fos_diagnose::refine::Logs;
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_simulate::{Simulation, simulate};
use fos_diagnose::study::Study;
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(log::folder);

/// Logs of a study: too short for findings, long enough to run a model.
static LOGS: LazyLock<Logs> = LazyLock::new(|| {
    let columns = simulate(&Simulation { duration_s: 8.0, motion: false, ..Simulation::default() }).columns;
    let read = LoadOptions::default();
    let log = Recording::from_columns(Source::made_by("the fuzzer"), columns, &read).expect("a log");
    Logs { reference: Some(log.clone()), evaluation: Some(log.clone()), log, read }
});

static LIBRARY: LazyLock<Library> = LazyLock::new(Library::built_in);

fuzz_target!(|bytes: &[u8]| {
    case(bytes);
    let path = FOLDER.path().join("study.json");
    std::fs::write(&path, bytes).expect("the input is written");
    let study = match Study::read(&path) {
        Ok(study) => study,
        Err(error) => return assert!(is_clear(&error.to_string(), "study.json"), "{error}"),
    };
    let written = study.to_bytes();
    std::fs::write(&path, &written).expect("the study is written");
    let again = Study::read(&path).expect("what was written can be read");
    assert_eq!(again.to_bytes(), written);
    let provenance = study.provenance();
    if let Ok(image) = image(&study.model, "", &provenance) {
        assert!(Image::parse(&image).is_ok());
        let _ = (rust_source(&study.model, &provenance), c_source(&study.model, "unit", "", &provenance));
    }
    if study.refinements.iter().all(|refinement| refinement.steps.len() < 8) {
        grown(study);
    }
});

/// Exercises an axis with added effects.
fn grown(mut study: Study) {
    for refinement in study.refinements.clone() {
        let refiner = LOGS.refiner(&LIBRARY);
        let _ = examine(&study, &refinement, &LOGS, |_| {});
        let _ = refiner.diagnose(&refinement).map(|_| refiner.add_best(&refinement, |_, _| {}));
        let _ = refiner.begin(&study, &refinement.column, LOGS.named(refiner.fitted_rows()));
        while study.undo(&refinement.column).is_ok() {
            assert!(study.model.axes.iter().any(|axis| axis.column == refinement.column));
        }
        assert!(study.undo(&refinement.column).is_err());
    }
}

/// `meta.json` of a case.
fn case(bytes: &[u8]) {
    std::fs::write(FOLDER.path().join("meta.json"), bytes).expect("the input is written");
    match CaseMeta::read(FOLDER.path()) {
        Ok(meta) => {
            let _ = (meta.data_sheet(), meta.full_scale(), meta.lsb());
        }
        Err(error) => assert!(is_clear(&error.to_string(), "meta.json"), "{error}"),
    }
}

/// The error names the file and a remedy.
fn is_clear(error: &str, file: &str) -> bool {
    error.contains(file) && error.contains("\nhelp: ")
}

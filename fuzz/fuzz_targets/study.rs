//! Any bytes as a study: refused with a place, or one that can be written, read again and exported.
#![no_main]

use std::sync::LazyLock;

use fos_core::Image;
use fos_fuzz::log;
use host_fit::export::{c_source, image, rust_source};
use host_fit::study::Study;
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(log::folder);

fuzz_target!(|bytes: &[u8]| {
    let path = FOLDER.path().join("study.json");
    std::fs::write(&path, bytes).expect("the input is written");
    let study = match Study::read(&path) {
        Ok(study) => study,
        Err(error) => return assert!(error.to_string().contains("study.json"), "{error}"),
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
});

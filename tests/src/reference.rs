//! Answers that others computed or published, for tests; they are not part of the project.

use std::path::{Path, PathBuf};

use serde_json::Value;

/// A file of reference answers; `None`, saying so, if it is not there.
pub fn json(name: &str) -> Option<Value> {
    let path = folder()?.join(name).with_extension("json");
    match std::fs::read_to_string(&path) {
        Ok(text) => Some(serde_json::from_str(&text).expect("JSON")),
        Err(_) => {
            println!("skipped: no reference file {}", path.display());
            None
        }
    }
}

/// Its series, channel after channel.
pub fn samples(name: &str) -> Vec<f64> {
    let path = folder().expect("found before").join(name).with_extension("f64");
    let bytes = std::fs::read(path).expect("beside its JSON");
    bytes.as_chunks().0.iter().map(|eight| f64::from_le_bytes(*eight)).collect()
}

/// The folder `shared/reference` beside the repository, however deep the working tree is.
fn folder() -> Option<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let found = here.ancestors().map(|folder| folder.join("shared/reference")).find(|folder| folder.is_dir());
    if found.is_none() {
        println!("skipped: no folder shared/reference beside the repository");
    }
    found
}

/// # Panics
///
/// It is no number.
pub fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// # Panics
///
/// It is no list of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

/// Fails unless both lists are as long and every value is within `tolerance` times the largest expected.
pub fn assert_all_close(what: &str, values: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(values.len(), expected.len(), "{what}");
    let size = expected.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
    for (i, (value, expected)) in values.iter().zip(expected).enumerate() {
        let error = (value - expected).abs();
        assert!(error <= tolerance * size, "{what} [{i}]: {value} for {expected}, off by {error:e}");
    }
}

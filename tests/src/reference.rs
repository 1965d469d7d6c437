//! Reference answers: our own fixtures, computed independently (`tests/fixtures/reference`), and answers that others
//! computed or published, if available ([`outside()`]).

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::outside;

/// Answers with their series.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Name of the file, without its ending.
    pub name: String,
    /// Answers, in the structure of the file.
    pub answers: Value,
    /// Series, one per channel; empty if the answers contain their series.
    pub channels: Vec<Vec<f64>>,
}

/// Reads the fixture of that name.
///
/// # Panics
///
/// The fixture is missing or damaged.
pub fn own(name: &str) -> Reference {
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/reference").join(name))
}

/// Reads the answers of others under that name, if available.
///
/// # Panics
///
/// The file is missing and was promised ([`outside::path`]), or is damaged.
pub fn outside(name: &str) -> Option<Reference> {
    let path = outside::path(&format!("reference/{name}.json"))?;
    Some(read(&path.with_extension("")))
}

/// Our own answers, and those of others if available, in the same structure.
///
/// # Panics
///
/// Those of [`own`] and [`outside()`].
pub fn each(of_ours: &str, of_others: &str) -> impl Iterator<Item = Reference> {
    std::iter::once(own(of_ours)).chain(outside(of_others))
}

fn read(stem: &Path) -> Reference {
    let name = stem.file_name().expect("a name").to_string_lossy().into_owned();
    let beside = |extension: &str| stem.with_added_extension(extension);
    let bytes =
        |path: PathBuf| std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let answers: Value = serde_json::from_slice(&bytes(beside("json"))).expect("JSON");
    let series = &answers["series"];
    let samples: Vec<f64> = match series["dtype"].as_str() {
        None => series.as_array().map(|_| numbers(series)).unwrap_or_default(),
        Some("float64 little-endian") => {
            bytes(beside("f64")).as_chunks().0.iter().map(|code| f64::from_le_bytes(*code)).collect()
        }
        Some("int16 little-endian") => bytes(beside("i16"))
            .as_chunks()
            .0
            .iter()
            .map(|code| f64::from(i16::from_le_bytes(*code)))
            .collect(),
        Some(other) => panic!("{name}: series of {other}"),
    };
    let n_channels = series["channels"].as_array().map_or(1, Vec::len);
    let mut channels: Vec<Vec<f64>> = match samples.len() {
        0 => vec![],
        length => samples.chunks_exact(length / n_channels).map(<[f64]>::to_vec).collect(),
    };
    for (channel, lsb) in channels.iter_mut().zip(series["lsb"].as_array().into_iter().flatten()) {
        channel.iter_mut().for_each(|code| *code *= number(lsb));
    }
    Reference { name, answers, channels }
}

impl Reference {
    /// Series of answers that have exactly one.
    ///
    /// # Panics
    ///
    /// There are none or several.
    pub fn series(&self) -> &[f64] {
        assert_eq!(self.channels.len(), 1, "{}", self.name);
        &self.channels[0]
    }
}

/// # Panics
///
/// The value is no number.
pub fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// # Panics
///
/// The value is no list of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

/// Fails unless both lists are equally long and every value is within `tolerance` times the largest expected one.
pub fn assert_all_close(what: &str, values: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(values.len(), expected.len(), "{what}");
    let size = expected.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
    for (i, (value, expected)) in values.iter().zip(expected).enumerate() {
        let error = (value - expected).abs();
        assert!(error <= tolerance * size, "{what} [{i}]: {value} for {expected}, off by {error:e}");
    }
}

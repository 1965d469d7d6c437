//! Reference results: our own fixtures, computed independently (`tests/fixtures/reference`), and third-party results,
//! if available ([`outside()`]).

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::outside;

/// Reference results with their input series.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Name of the file without its extension.
    pub name: String,
    /// Content of the JSON file.
    pub answers: Value,
    /// Input series, one per channel; empty if the JSON contains them.
    pub channels: Vec<Vec<f64>>,
}

/// Reads the fixture of this name.
///
/// # Panics
///
/// It is missing or invalid.
pub fn own(name: &str) -> Reference {
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/reference").join(name))
}

/// Reads third-party results of this name, if available.
///
/// # Panics
///
/// They are missing although promised ([`outside::path`]), or invalid.
pub fn outside(name: &str) -> Option<Reference> {
    let path = outside::path(&format!("reference/{name}.json"))?;
    Some(read(&path.with_extension("")))
}

/// Our own results and, if available, third-party results of the same form.
///
/// # Panics
///
/// The conditions of [`own`] and [`outside()`].
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
    /// The only input series.
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
/// The value is not a number.
pub fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// # Panics
///
/// The value is not a list of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

/// Fails unless both lists have the same length and every value is within `tolerance` times the largest expected.
pub fn assert_all_close(what: &str, values: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(values.len(), expected.len(), "{what}");
    let size = expected.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
    for (i, (value, expected)) in values.iter().zip(expected).enumerate() {
        let error = (value - expected).abs();
        assert!(error <= tolerance * size, "{what} [{i}]: {value} for {expected}, off by {error:e}");
    }
}

//! Result of recognising a table by the names of its columns.

use super::super::provenance::Provenance;
use super::Format;

/// Channel, column, and the part after the column in an entry of a column map.
pub(super) type Entry = (&'static str, String, String);

/// A table of a known program.
pub(super) struct Found {
    pub(super) format: Format,
    pub(super) entries: Vec<Entry>,
    pub(super) assumed: String,
    /// Corrections and frame of the values.
    pub(super) provenance: Provenance,
    /// Column and unit of separate timestamps of the gyros.
    pub(super) gyro_clock: Option<(String, &'static str)>,
    /// Column of a clock that wraps, and its modulus.
    pub(super) counter: Option<(String, f64)>,
}

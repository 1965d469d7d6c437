//! What was found out of a table by the names of its columns.

use super::super::provenance::Provenance;
use super::Format;

/// Channel, column, and what stands behind the column in an entry of a column map.
pub(super) type Entry = (&'static str, String, String);

/// A table of a program that is known.
pub(super) struct Found {
    pub(super) format: Format,
    pub(super) entries: Vec<Entry>,
    pub(super) assumed: String,
    /// Corrections and frame of the values.
    pub(super) provenance: Provenance,
    /// The stamps of the gyros and their unit, where they have their own.
    pub(super) gyro_clock: Option<(String, &'static str)>,
    /// The column of a clock that wraps, and the count at which it does.
    pub(super) counter: Option<(String, f64)>,
}

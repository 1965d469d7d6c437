//! How many rows of a log may be unusable.

use std::path::Path;

use super::error::RecordingError;
use super::table::Table;

/// Highest fraction of rows that are skipped since they cannot be used; above it the log is refused.
pub const MAX_UNUSABLE: f64 = 0.05;

/// Refuses a log of which too many rows cannot be used.
pub(super) fn refuse_unusable(path: &Path, table: &Table, strict: bool) -> Result<(), RecordingError> {
    let quality = &table.quality;
    let Some(first) = quality.first_unusable.first() else { return Ok(()) };
    if strict {
        return Err(RecordingError::BadRow { path: path.to_owned(), row: Box::new(first.clone()) });
    }
    if quality.rows_unusable as f64 > MAX_UNUSABLE * quality.rows_in_file as f64 {
        return Err(RecordingError::TooManyBadRows {
            path: path.to_owned(),
            unusable: quality.rows_unusable,
            rows: quality.rows_in_file,
            first: Box::new(first.clone()),
            limit: MAX_UNUSABLE,
        });
    }
    Ok(())
}

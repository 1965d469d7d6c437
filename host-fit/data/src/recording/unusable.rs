//! Limit of unusable rows of a log.

use std::path::Path;

use super::error::RecordingError;
use super::table::Table;

/// Largest share of unusable rows that are skipped; above it the log is rejected.
pub const MAX_UNUSABLE: f64 = 0.05;

/// Rejects a log with too many unusable rows.
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

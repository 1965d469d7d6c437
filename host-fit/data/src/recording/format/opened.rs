//! What is in a file, and how much of it is looked at.

#[cfg(any(feature = "gzip", feature = "zip"))]
use std::io::ErrorKind;

#[cfg(any(feature = "gzip", feature = "zip"))]
use super::super::csv_file;
#[cfg(any(feature = "gzip", feature = "zip"))]
use super::super::error::RecordingError;
use super::super::stream::Stream;
use super::super::table::Table;
use super::ReadAs;
#[cfg(any(feature = "gzip", feature = "zip"))]
use crate::file::FileError;

/// Bytes read at once.
pub(super) const READ_BUFFER: usize = 1 << 18;

/// How much of a file is read.
#[derive(Clone, Copy, PartialEq)]
pub(in super::super) enum Extent {
    Whole,
    /// The first [`BEGIN_BYTES`] of text, or [`BEGIN_ROWS`] rows; formats that are not tables are read whole.
    Begin,
}

pub(in super::super) enum Opened {
    /// Columns that mean nothing yet.
    Table(Box<Table>),
    /// Sensors with stamps of their own.
    Streams(Vec<Stream>, ReadAs),
}

/// What does not come out of a container is damage of it, and no matter of the system's; or it is packed in a way that
/// is not known here, as Deflate64, which Windows takes for what is large.
#[cfg(any(feature = "gzip", feature = "zip"))]
pub(super) fn damage(error: RecordingError, format: &'static str) -> RecordingError {
    match error {
        RecordingError::File(FileError { path, source, .. }) if source.kind() == ErrorKind::Unsupported => {
            let is = format!("it cannot be unpacked: {source}");
            RecordingError::OtherFormat { path, is, help: "unpack it, and name the log itself" }
        }
        RecordingError::File(FileError { path, source, .. }) if csv_file::is_damage(&source) => {
            RecordingError::Damaged { path, format, at: None, problem: source.to_string() }
        }
        error => error,
    }
}

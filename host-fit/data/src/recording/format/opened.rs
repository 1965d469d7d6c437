//! Content of a file, and the extent to which it is read.

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

/// Size of the read buffer, bytes.
pub(super) const READ_BUFFER: usize = 1 << 18;

/// Extent to which a file is read.
#[derive(Clone, Copy, PartialEq)]
pub(in super::super) enum Extent {
    Whole,
    /// The first [`BEGIN_BYTES`] of text, or [`BEGIN_ROWS`] rows; formats that are not tables are read whole.
    Begin,
}

pub(in super::super) enum Opened {
    /// Columns without an interpretation.
    Table(Box<Table>),
    /// Sensors with separate timestamps.
    Streams(Vec<Stream>, ReadAs),
}

/// Converts a failure to decompress a container to an error of damage, or of an unsupported compression, such as
/// Deflate64, which Windows uses for large files; other errors of the system are kept.
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

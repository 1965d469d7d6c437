//! Writes columns of numbers as CSV, gzip'd CSV or Parquet, atomically.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::error::RecordingError;
use super::table::check_names;
use crate::file::{FileError, check_output, replace};

/// Writes columns of equal length, in the format given by the file name: `.csv`, `.csv.gz` or `.parquet`.
///
/// A reader sees the complete old or new file: the data are written next to it, synced, and renamed. Parquet preserves
/// every bit; CSV has the shortest digits that read back as the same number, and NaN as an empty cell.
///
/// # Errors
/// An unknown ending, columns of different lengths or of equal names, and errors of the system.
pub fn write_columns(path: impl AsRef<Path>, columns: &[(&str, &[f64])]) -> Result<(), RecordingError> {
    let path = path.as_ref();
    let format = Ending::of(path)?;
    check_columns(path, columns)?;
    let beside = |write: &dyn Fn(&File) -> io::Result<()>| {
        replace(path, write).map_err(FileError::writing(path)).map_err(RecordingError::from)
    };
    match format {
        Ending::Csv => beside(&|file| {
            let mut out = BufWriter::new(file);
            write_csv(&mut out, columns)?;
            out.flush()
        }),
        #[cfg(feature = "gzip")]
        Ending::PackedCsv => beside(&|file| {
            // the fast level: within a few per cent of the best on digits, in a fraction of the time
            let packed = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
            let mut out = BufWriter::new(packed);
            write_csv(&mut out, columns)?;
            out.into_inner().map_err(io::IntoInnerError::into_error)?.finish().map(drop)
        }),
        #[cfg(feature = "parquet")]
        Ending::Parquet => beside(&|file| super::parquet_write::write(file, columns)),
        #[cfg(not(feature = "gzip"))]
        Ending::PackedCsv => Err(RecordingError::not_built_in(path, "gzip")),
        #[cfg(not(feature = "parquet"))]
        Ending::Parquet => Err(RecordingError::not_built_in(path, "parquet")),
    }
}

/// Checks that a log can be written to `path`, before its content is computed.
///
/// # Errors
/// An unknown ending, an existing path that is no regular file, or an input of this process.
pub fn check_log_path(path: &Path) -> Result<(), RecordingError> {
    Ending::of(path)?;
    Ok(check_output(path)?)
}

enum Ending {
    Csv,
    PackedCsv,
    Parquet,
}

impl Ending {
    /// Format by the ending of the name.
    fn of(path: &Path) -> Result<Self, RecordingError> {
        let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
        let formats = [(".csv", Self::Csv), (".csv.gz", Self::PackedCsv), (".parquet", Self::Parquet)];
        let found = formats.into_iter().find(|(ending, _)| name.ends_with(ending));
        found.map(|(_, format)| format).ok_or_else(|| RecordingError::UnknownFormat { path: path.to_owned() })
    }
}

fn check_columns(path: &Path, columns: &[(&str, &[f64])]) -> Result<(), RecordingError> {
    let names: Vec<String> = columns.iter().map(|(name, _)| name.to_string()).collect();
    check_names(path, &names)?;
    let expected = columns.first().map_or(0, |(_, values)| values.len());
    match columns.iter().find(|(_, values)| values.len() != expected) {
        None => Ok(()),
        Some((name, values)) => {
            Err(RecordingError::Lengths { name: name.to_string(), expected, found: values.len() })
        }
    }
}

fn write_csv(out: &mut impl Write, columns: &[(&str, &[f64])]) -> io::Result<()> {
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    {
        // names may need quotation marks
        let mut header = csv::WriterBuilder::new().from_writer(&mut *out);
        header.write_record(&names)?;
        header.flush()?;
    }
    let n_rows = columns.first().map_or(0, |(_, values)| values.len());
    for row in 0..n_rows {
        for (i, (_, values)) in columns.iter().enumerate() {
            if i > 0 {
                out.write_all(b",")?;
            }
            // a single empty cell would make a blank line, which is no row
            if !values[row].is_nan() {
                write!(out, "{:?}", values[row])?;
            } else if columns.len() == 1 {
                out.write_all(b"nan")?;
            }
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

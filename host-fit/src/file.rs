//! Files are written beside and renamed: a reader sees the old one or the new one, whole.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// A file that could not be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot {action}: {source}", path.display())]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// What was tried.
    pub action: &'static str,
    /// Why it failed.
    pub source: io::Error,
}

/// Writes `path` by way of a temporary file in the same folder.
///
/// # Errors
///
/// The folder is not there or not writable, the disk is full. The old file, if any, is then untouched.
pub fn write_atomically(path: &Path, content: &[u8]) -> Result<(), FileError> {
    let failed = |action| move |source| FileError { path: path.to_owned(), action, source };
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut file = NamedTempFile::new_in(folder).map_err(failed("write to its folder"))?;
    file.write_all(content).map_err(failed("write it"))?;
    file.as_file().sync_all().map_err(failed("write it"))?;
    file.persist(path).map_err(|error| failed("replace it")(error.error))?;
    Ok(())
}

/// Reads the whole of `path`.
///
/// # Errors
///
/// It is not there or not readable.
pub fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    std::fs::read(path).map_err(|source| FileError { path: path.to_owned(), action: "read it", source })
}

//! Files are written beside and renamed: a reader sees the old one or the new one, whole.

use std::fs::File;
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

/// The name of a file without its folders.
pub(crate) fn name_of(path: &str) -> String {
    Path::new(path).file_name().map_or_else(|| path.to_owned(), |name| name.to_string_lossy().into_owned())
}

/// Writes `path` by way of a temporary file in the same folder.
///
/// # Errors
///
/// The folder is not there or not writable, the disk is full. The old file, if any, is then untouched.
pub fn write_atomically(path: &Path, content: &[u8]) -> Result<(), FileError> {
    replace(path, |mut file| file.write_all(content)).map_err(|source| FileError {
        path: path.to_owned(),
        action: "write it",
        source,
    })
}

/// Lets `write` fill a file beside `path`, brings it to the disk and renames it.
pub(crate) fn replace(path: &Path, write: impl FnOnce(&File) -> io::Result<()>) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let file = new_beside(folder)?;
    write(file.as_file())?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

/// An unnamed-as-yet file with the permissions a new file has; a temporary one could be read by its owner only.
fn new_beside(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".fos-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666)); // less the umask
    }
    builder.tempfile_in(folder)
}

/// Reads the whole of `path`.
///
/// # Errors
///
/// It is not there or not readable.
pub fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    std::fs::read(path).map_err(|source| FileError { path: path.to_owned(), action: "read it", source })
}

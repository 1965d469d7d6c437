//! Paths, and what lies at them: the folder of a file, what a link leads to, whether an open file still has a name.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// The name of a file without its folders.
pub fn name_of(path: &str) -> String {
    Path::new(path).file_name().map_or_else(|| path.to_owned(), |name| name.to_string_lossy().into_owned())
}

/// The folder that `path` is in.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// What a path leads to, where it is a link: the link stays, and what it leads to is replaced.
pub fn followed(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

/// Whether an open file still has a name.
#[cfg(unix)]
pub(super) fn is_linked(file: &File) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    Ok(file.metadata()?.nlink() > 0)
}

#[cfg(not(unix))]
pub(super) fn is_linked(_file: &File) -> io::Result<bool> {
    Ok(true)
}

/// Brings the names in `folder` to the disk: a cut of power after success does not take the new file back.
#[cfg(unix)]
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    // a folder that may be written to but not listed cannot be opened
    let Ok(folder) = File::open(folder) else { return Ok(()) };
    match folder.sync_all() {
        // some file systems know no such thing
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        done => done,
    }
}

#[cfg(not(unix))]
pub fn sync_folder(_folder: &Path) -> io::Result<()> {
    Ok(())
}

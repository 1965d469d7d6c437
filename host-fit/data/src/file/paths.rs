//! Paths and their targets: folder of a file, target of a link, existence of a name for an open file.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// File name without its folders.
pub fn name_of(path: &str) -> String {
    Path::new(path).file_name().map_or_else(|| path.to_owned(), |name| name.to_string_lossy().into_owned())
}

/// Folder that contains `path`.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Resolves links: a link stays in place and its target is replaced.
pub fn followed(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

/// Returns true while an open file still has a name.
#[cfg(unix)]
pub(super) fn is_linked(file: &File) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    Ok(file.metadata()?.nlink() > 0)
}

#[cfg(not(unix))]
pub(super) fn is_linked(_file: &File) -> io::Result<bool> {
    Ok(true)
}

/// Syncs the names in `folder` to the disk, so that a new file survives power loss after success.
#[cfg(unix)]
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    // a folder that is writable but not readable cannot be opened
    let Ok(folder) = File::open(folder) else { return Ok(()) };
    match folder.sync_all() {
        // some file systems do not support it
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        done => done,
    }
}

#[cfg(not(unix))]
pub fn sync_folder(_folder: &Path) -> io::Result<()> {
    Ok(())
}

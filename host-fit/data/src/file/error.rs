//! A file that could not be read or written, with what to do about it.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use super::inputs::OwnInput;

/// A file that could not be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot {action}: {source}{}", path.display(), help(action, source))]
pub struct FileError {
    pub path: PathBuf,
    pub action: &'static str,
    pub source: io::Error,
}

pub(super) const OPEN: &str = "open it";
pub(super) const READ: &str = "read it";
pub(super) const WRITE: &str = "write it";
pub(super) const COPY: &str = "copy what comes through it to a temporary file";
pub(super) const MAKE: &str = "make the folder";

fn help(action: &str, error: &io::Error) -> &'static str {
    let reads = [OPEN, READ].contains(&action);
    if error.get_ref().is_some_and(|error| error.is::<OwnInput>()) {
        return "\nhelp: write to another file";
    }
    match error.kind() {
        ErrorKind::StorageFull if action == COPY => {
            "\nhelp: the disk with temporary files is full: set TMPDIR to a folder with more room"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "\nhelp: the disk is full: make room, or write elsewhere; what was there before is as it was"
        }
        ErrorKind::NotFound if reads => "\nhelp: is the path right?",
        ErrorKind::PermissionDenied if reads => "\nhelp: you may not read it: ask its owner",
        ErrorKind::IsADirectory if reads => "\nhelp: it is a folder: name a file in it",
        _ if reads => "\nhelp: copy it to a disk of this machine, and read it there",
        ErrorKind::ReadOnlyFilesystem | ErrorKind::PermissionDenied => {
            "\nhelp: nothing can be written there: name another folder"
        }
        ErrorKind::NotFound => "\nhelp: is the folder there?",
        ErrorKind::AlreadyExists => "\nhelp: another file has this name: rename it, or name another folder",
        _ => "\nhelp: write elsewhere; what was there before is as it was",
    }
}

impl FileError {
    /// Returns a `map_err` closure for opening `path`.
    pub fn opening(path: &Path) -> impl FnOnce(io::Error) -> Self {
        Self::when(OPEN, path)
    }

    /// Returns a `map_err` closure for reading `path`.
    pub fn reading(path: &Path) -> impl FnOnce(io::Error) -> Self {
        Self::when(READ, path)
    }

    /// Returns a `map_err` closure for writing `path`.
    pub fn writing(path: &Path) -> impl FnOnce(io::Error) -> Self {
        Self::when(WRITE, path)
    }

    pub(super) fn when(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self { path: path.to_owned(), action, source }
    }
}

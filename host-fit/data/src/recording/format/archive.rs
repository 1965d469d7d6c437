//! Access to the files of one recording: a folder, or a zip archive of one.

use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use super::super::error::RecordingError;
use super::super::source::{Digest, Hashing, Source};
use super::opened::READ_BUFFER;
#[cfg(feature = "zip")]
use super::opened::damage;
use crate::file::{self, FileError};

/// Maximum depth of the search in folders: `bag/mav0/imu0/data.csv`.
const MAX_DEPTH: usize = 4;

/// Maximum number of files listed; a folder with more is no recording.
const MAX_FILES: usize = 10_000;

#[cfg(feature = "zip")]
const ZIP: &str = "zip archive";

/// Files of a recording, by names with `/` between folder and file.
pub(super) struct Archive {
    names: Vec<String>,
    files: Files,
    /// Checksum over the names and contents of the files, in the order they are read.
    digest: Digest,
}

enum Files {
    Folder(PathBuf),
    #[cfg(feature = "zip")]
    Zip {
        path: PathBuf,
        archive: Box<zip::ZipArchive<File>>,
    },
}

/// Opens a folder with a checksum of the files read from it.
pub(super) fn folder(path: &Path, digest: Digest) -> Result<Archive, RecordingError> {
    let mut names = Vec::new();
    list(path, "", MAX_DEPTH, &mut names).map_err(FileError::reading(path))?;
    names.sort();
    Ok(Archive { names, files: Files::Folder(path.to_owned()), digest })
}

fn list(folder: &Path, begin: &str, deep: usize, names: &mut Vec<String>) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = format!("{begin}{}", entry.file_name().to_string_lossy());
        let kind = entry.file_type()?;
        if names.len() >= MAX_FILES {
            break;
        }
        if kind.is_dir() && deep > 1 {
            list(&entry.path(), &format!("{name}/"), deep - 1, names)?;
        } else if kind.is_file() || kind.is_symlink() {
            names.push(name);
        }
    }
    Ok(())
}

/// Opens an archive; its checksum is that of the archive file, computed by the caller.
#[cfg(feature = "zip")]
pub(super) fn zip(path: &Path, file: File) -> Result<Archive, RecordingError> {
    let archive = crate::catch_panic::catch_panic(|| zip::ZipArchive::new(file))
        .unwrap_or_else(|_| Err(zip::result::ZipError::InvalidArchive("it cannot be read".into())))
        .map_err(|source| damaged(path, &source.to_string()))?;
    let files = archive.file_names().take(MAX_FILES).filter_map(Result::ok);
    let mut names: Vec<String> =
        files.filter(|name| !name.ends_with('/')).map(|name| name.into_owned()).collect();
    names.sort();
    let files = Files::Zip { path: path.to_owned(), archive: Box::new(archive) };
    Ok(Archive { names, files, digest: Digest::none() })
}

#[cfg(not(feature = "zip"))]
pub(super) fn zip(path: &Path, _: File) -> Result<Archive, RecordingError> {
    Err(RecordingError::not_built_in(path, "zip"))
}

/// Path of a member for messages; its name may begin like that of any file.
pub(super) fn member_path(archive: &Path, name: &str) -> PathBuf {
    archive.join(name.trim_start_matches(['/', '\\']))
}

#[cfg(feature = "zip")]
fn damaged(path: &Path, problem: &str) -> RecordingError {
    RecordingError::Damaged { path: path.to_owned(), format: ZIP, at: None, problem: problem.to_owned() }
}

impl Archive {
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// Reads a file by name; `read` gets its path for messages, which contains that of the archive.
    pub(super) fn read<T>(
        &mut self,
        name: &str,
        read: impl FnOnce(&Path, &mut dyn BufRead) -> Result<T, RecordingError>,
    ) -> Result<T, RecordingError> {
        self.open(name, |path, input, digest| {
            digest.take_name(name);
            read(path, &mut Hashing::new(input, digest))
        })
    }

    /// The same for a file without data: it is excluded from the checksum.
    pub(super) fn look_into<T>(
        &mut self,
        name: &str,
        read: impl FnOnce(&Path, &mut dyn BufRead) -> Result<T, RecordingError>,
    ) -> Result<T, RecordingError> {
        self.open(name, |path, input, _| read(path, input))
    }

    fn open<T>(
        &mut self,
        name: &str,
        read: impl FnOnce(&Path, &mut dyn BufRead, &mut Digest) -> Result<T, RecordingError>,
    ) -> Result<T, RecordingError> {
        match &mut self.files {
            Files::Folder(folder) => {
                let path = folder.join(name);
                let mut input = BufReader::with_capacity(READ_BUFFER, file::open(&path)?);
                read(&path, &mut input, &mut self.digest)
            }
            #[cfg(feature = "zip")]
            Files::Zip { path, archive } => {
                let member =
                    archive.by_name(name).map_err(|error| damaged(path, &format!("{name}: {error}")))?;
                let mut input = BufReader::with_capacity(READ_BUFFER, member);
                let path = member_path(path, name);
                read(&path, &mut input, &mut self.digest).map_err(|error| damage(error, ZIP))
            }
        }
    }

    /// Source of the files read from a folder, with its name.
    pub(super) fn source(self, path: &Path) -> Source {
        self.digest.finish(path)
    }
}

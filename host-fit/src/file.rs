//! Files are written beside and renamed: a reader sees the old one or the new one, whole, whenever the writer is killed or the
//! power is cut. What was read is not replaced (`inputs.rs`).

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::inputs;

/// What is written beside a file is named `.fos-…….tmp`, with random letters.
const BESIDE: (&str, &str) = (".fos-", ".tmp");

/// A file that could not be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot {action}: {source}{}", path.display(), help(action, source))]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// What was tried.
    pub action: &'static str,
    /// Why it failed.
    pub source: io::Error,
}

const OPEN: &str = "open it";
const READ: &str = "read it";
const WRITE: &str = "write it";
const COPY: &str = "copy what comes through it to a temporary file";
const MAKE: &str = "make the folder";

/// What to do about it, where that is known.
fn help(action: &str, error: &io::Error) -> &'static str {
    let reads = [OPEN, READ].contains(&action);
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
        _ if reads => "",
        ErrorKind::ReadOnlyFilesystem | ErrorKind::PermissionDenied => {
            "\nhelp: nothing can be written there: name another folder"
        }
        ErrorKind::NotFound => "\nhelp: is the folder there?",
        _ => "",
    }
}

impl FileError {
    pub(crate) fn opening(path: &Path) -> impl FnOnce(io::Error) -> Self {
        Self::when(OPEN, path)
    }

    pub(crate) fn reading(path: &Path) -> impl FnOnce(io::Error) -> Self {
        Self::when(READ, path)
    }

    pub(crate) fn writing(path: &Path) -> impl FnOnce(io::Error) -> Self {
        Self::when(WRITE, path)
    }

    fn when(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self { path: path.to_owned(), action, source }
    }
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
    replace(path, |mut file| file.write_all(content)).map_err(FileError::writing(path))
}

/// Lets `write` fill a file beside `path`, brings it to the disk and renames it.
pub(crate) fn replace(path: &Path, write: impl FnOnce(&File) -> io::Result<()>) -> io::Result<()> {
    let beside = Beside::of(path)?;
    write(beside.file())?;
    beside.put()
}

/// Reads the whole of `path`.
///
/// # Errors
///
/// It is not there or not readable.
pub fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    let mut content = Vec::new();
    let mut file = File::open(path).map_err(FileError::reading(path))?;
    inputs::note_read(&file, path)
        .and_then(|()| file.read_to_end(&mut content))
        .map_err(FileError::reading(path))?;
    Ok(content)
}

/// Opens `path`, to be read.
///
/// # Errors
///
/// It is not there or not readable.
pub fn open(path: &Path) -> Result<File, FileError> {
    let file = File::open(path).map_err(FileError::opening(path))?;
    inputs::note_read(&file, path).map_err(FileError::opening(path))?;
    Ok(file)
}

/// The same, and what comes through a pipe, which can be read but once and in order, copied to a file that has no name.
///
/// # Errors
///
/// As of [`open`], or there is no room for the copy.
pub(crate) fn open_to_seek(path: &Path) -> Result<File, FileError> {
    let mut file = open(path)?;
    // a folder, too, is refused by whoever reads it
    if file.stream_position().is_ok() || file.metadata().is_ok_and(|about| about.is_dir()) {
        return Ok(file);
    }
    let copy = tempfile::tempfile().and_then(|mut copy| {
        io::copy(&mut file, &mut copy)?;
        copy.rewind()?;
        Ok(copy)
    });
    copy.map_err(FileError::when(COPY, path))
}

/// Standard input as a file, to be read: it may be one.
pub(crate) fn standard_input() -> io::Result<File> {
    #[cfg(unix)]
    let input = std::os::fd::AsFd::as_fd(&io::stdin()).try_clone_to_owned()?;
    #[cfg(windows)]
    let input = std::os::windows::io::AsHandle::as_handle(&io::stdin()).try_clone_to_owned()?;
    let file = File::from(input);
    inputs::note_read(&file, Path::new("standard input"))?;
    Ok(file)
}

/// # Errors
///
/// Nothing can be written to `path`: it is there and no file, or it was read.
pub(crate) fn check_output(path: &Path) -> Result<(), FileError> {
    may_be_replaced(path).and_then(|()| inputs::refuse_to_replace(path)).map_err(FileError::writing(path))
}

fn may_be_replaced(path: &Path) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(old) if !old.is_file() => {
            Err(io::Error::new(ErrorKind::InvalidInput, "it is there and is no file"))
        }
        _ => Ok(()),
    }
}

/// Makes the folder `path`, and those above it, where they are not there.
///
/// # Errors
///
/// It cannot be made.
pub fn make_folder(path: &Path) -> Result<(), FileError> {
    let missing: Vec<&Path> =
        path.ancestors().take_while(|above| !above.as_os_str().is_empty() && !above.exists()).collect();
    fs::create_dir_all(path)
        .and_then(|()| missing.into_iter().try_for_each(|made| sync_folder(folder_of(made))))
        .map_err(FileError::when(MAKE, path))
}

/// The folder that `path` is in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// What a path leads to, where it is a link: the link stays, and what it leads to is replaced.
pub(crate) fn followed(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

/// A file beside its place, which it takes once it is whole. Dropped before, it is gone.
#[derive(Debug)]
pub(crate) struct Beside {
    file: NamedTempFile,
    path: PathBuf,
}

impl Beside {
    /// A new one for `path`, with the permissions of what is there.
    pub(crate) fn of(path: &Path) -> io::Result<Self> {
        let path = followed(path);
        may_be_replaced(&path)?;
        let old = fs::metadata(&path).ok();
        let folder = folder_of(&path);
        remove_stale(folder);
        let file = new_in(folder)?;
        if let Some(old) = old {
            file.as_file().set_permissions(old.permissions())?;
        }
        Ok(Self { file, path })
    }

    /// To be written to.
    pub(crate) fn file(&self) -> &File {
        self.file.as_file()
    }

    /// Gives it the first of `names`, all in its folder, that is free: of two at once each gets one.
    pub(crate) fn put_as_new(self, names: impl IntoIterator<Item = PathBuf>) -> io::Result<PathBuf> {
        self.file.as_file().sync_all()?;
        let mut beside = self.file;
        for name in names {
            match beside.persist_noclobber(&name) {
                Ok(file) => {
                    inputs::note_written(&file, &name)?;
                    sync_folder(folder_of(&name))?;
                    return Ok(name);
                }
                Err(taken) if taken.error.kind() == ErrorKind::AlreadyExists => beside = taken.file,
                Err(other) => return Err(other.error),
            }
        }
        Err(ErrorKind::AlreadyExists.into())
    }

    /// Brings it to the disk and gives it its name, and brings that to the disk too; not over what was read, unless it is the same.
    pub(crate) fn put(self) -> io::Result<()> {
        if let Err(refused) = inputs::refuse_to_replace(&self.path) {
            // the example of the workbench, once its logs have been opened as logs
            let is_same = fs::read(self.file.path())? == fs::read(&self.path)?;
            return if is_same { Ok(()) } else { Err(refused) };
        }
        let (file, path) = self.replace()?;
        inputs::note_written(&file, &path)
    }

    /// The same, also over what was read: it is what was read, changed, and is not replaced by anything else either.
    pub(crate) fn put_back(self) -> io::Result<()> {
        let (file, path) = self.replace()?;
        inputs::note_read(&file, &path)
    }

    fn replace(self) -> io::Result<(File, PathBuf)> {
        self.file.as_file().sync_all()?;
        let file = self.file.persist(&self.path).map_err(|error| error.error)?;
        sync_folder(folder_of(&self.path))?;
        Ok((file, self.path))
    }
}

/// An empty file with the permissions a new file has; a temporary one could be read by its owner only. It is locked until it is
/// closed: as long as somebody writes it.
fn new_in(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(BESIDE.0).suffix(BESIDE.1);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666)); // less the umask
    }
    // ends: only a writer that looks around in this very moment can take it, once
    loop {
        let file = builder.tempfile_in(folder)?;
        // another process may have taken it for a stale one before it was locked
        if file.as_file().lock().is_err() || is_linked(file.as_file())? {
            return Ok(file);
        }
    }
}

/// Removes what writers that were killed have left in `folder`: nobody holds its lock. Where this cannot be told, it stays.
#[cfg(unix)]
fn remove_stale(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_ours =
            name.to_str().is_some_and(|name| name.starts_with(BESIDE.0) && name.ends_with(BESIDE.1));
        if is_ours
            && entry.file_type().is_ok_and(|kind| kind.is_file())
            && let Ok(file) = File::options().write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            // what cannot be removed harms nobody
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(not(unix))]
fn remove_stale(_folder: &Path) {}

/// Whether an open file still has a name.
#[cfg(unix)]
pub(crate) fn is_linked(file: &File) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    Ok(file.metadata()?.nlink() > 0)
}

#[cfg(not(unix))]
pub(crate) fn is_linked(_file: &File) -> io::Result<bool> {
    Ok(true)
}

/// Brings the names in `folder` to the disk: a cut of power after success does not take the new file back.
#[cfg(unix)]
pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    // a folder that may be written to but not listed cannot be opened
    let Ok(folder) = File::open(folder) else { return Ok(()) };
    match folder.sync_all() {
        // some file systems know no such thing
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        done => done,
    }
}

#[cfg(not(unix))]
pub(crate) fn sync_folder(_folder: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn a_writer_that_fails_leaves_the_old_file_and_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        write_atomically(&path, b"old").unwrap();
        let error = replace(&path, |mut file| {
            file.write_all(b"ne")?;
            Err(ErrorKind::StorageFull.into())
        });
        let said = error.map_err(FileError::writing(&path)).unwrap_err().to_string();
        assert!(said.contains("a.json") && said.contains("help: the disk is full"), "{said}");
        assert_eq!(read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.json"]);
    }

    #[test]
    fn what_is_no_file_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("folder");
        make_folder(&path).unwrap();
        assert!(write_atomically(&path, b"new").unwrap_err().to_string().contains("is no file"));
    }

    #[cfg(unix)]
    #[test]
    fn what_a_killed_writer_left_is_removed_and_what_is_being_written_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        fs::write(folder.path().join(".fos-killed.tmp"), b"half").unwrap();
        fs::write(folder.path().join(".fos-notes"), b"somebody's").unwrap();
        let mut all = Vec::new();
        for _ in 0..3 {
            all.push(Beside::of(&path).unwrap());
        }
        assert_eq!(names(folder.path()).len(), 4, "{:?}", names(folder.path()));
        for beside in all {
            beside.file().write_all(b"whole").unwrap();
            beside.put().unwrap();
        }
        let mut left = names(folder.path());
        left.sort_unstable();
        assert_eq!(left, [".fos-notes", "a.json"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_one_and_permissions_stay() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("a.json"), folder.path().join("link.json"));
        write_atomically(&path, b"old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write_atomically(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(read(&path).unwrap(), b"new");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
    }
}

//! The only writer of files: writes a temporary sibling, then renames it.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::error::{FileError, MAKE};
use super::inputs::{note_read, note_written, refuse_to_replace};
use super::paths::{folder_of, followed, is_linked, sync_folder};

/// A temporary sibling is named `.fos-…….tmp`, with random letters.
const SIBLING: (&str, &str) = (".fos-", ".tmp");

/// Writes `path` by way of a temporary file in the same folder. On an error an existing file is untouched.
pub fn write_atomically(path: &Path, content: &[u8]) -> Result<(), FileError> {
    replace(path, |mut file| file.write_all(content)).map_err(FileError::writing(path))
}

/// Lets `write` fill a file next to `path`, syncs it to the disk and renames it.
pub fn replace(path: &Path, write: impl FnOnce(&File) -> io::Result<()>) -> io::Result<()> {
    let sibling = TemporarySibling::of(path)?;
    write(sibling.file())?;
    sibling.put()
}

/// Rejects a path that exists and is no regular file, or is an input of this process.
pub fn check_output(path: &Path) -> Result<(), FileError> {
    may_be_replaced(path).and_then(|()| refuse_to_replace(path)).map_err(FileError::writing(path))
}

fn may_be_replaced(path: &Path) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(old) if !old.is_file() => {
            Err(io::Error::new(ErrorKind::InvalidInput, "it is there and is no file"))
        }
        _ => Ok(()),
    }
}

/// Creates the folder `path` and its missing parents.
pub fn make_folder(path: &Path) -> Result<(), FileError> {
    let missing: Vec<&Path> =
        path.ancestors().take_while(|above| !above.as_os_str().is_empty() && !above.exists()).collect();
    fs::create_dir_all(path)
        .and_then(|()| missing.into_iter().try_for_each(|made| sync_folder(folder_of(made))))
        .map_err(FileError::when(MAKE, path))
}

/// Temporary file next to its destination, which it replaces once complete. Removed if dropped before.
#[derive(Debug)]
pub struct TemporarySibling {
    file: NamedTempFile,
    path: PathBuf,
}

impl TemporarySibling {
    /// Creates one for `path`, with the permissions of the existing file.
    pub fn of(path: &Path) -> io::Result<Self> {
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

    pub fn file(&self) -> &File {
        self.file.as_file()
    }

    /// Renames it to the first of `names`, all in its folder, that is free; concurrent callers get different names.
    pub fn put_as_new(self, names: impl IntoIterator<Item = PathBuf>) -> io::Result<PathBuf> {
        self.file.as_file().sync_all()?;
        let mut sibling = self.file;
        for name in names {
            match sibling.persist_noclobber(&name) {
                Ok(file) => {
                    note_written(&file, &name)?;
                    sync_folder(folder_of(&name))?;
                    return Ok(name);
                }
                Err(taken) if taken.error.kind() == ErrorKind::AlreadyExists => sibling = taken.file,
                Err(other) => return Err(other.error),
            }
        }
        Err(ErrorKind::AlreadyExists.into())
    }

    /// Syncs it to the disk, renames it and syncs the folder. An input of this process is not replaced, unless the
    /// content is identical.
    pub fn put(self) -> io::Result<()> {
        if let Err(refused) = refuse_to_replace(&self.path) {
            // the example of the workbench, once its logs have been opened as logs
            let is_same = fs::read(self.file.path())? == fs::read(&self.path)?;
            return if is_same { Ok(()) } else { Err(refused) };
        }
        let (file, path) = self.replace()?;
        note_written(&file, &path)
    }

    /// The same, and may replace an input of this process: the new content is an edit of the old, and stays protected.
    pub fn put_back(self) -> io::Result<()> {
        let (file, path) = self.replace()?;
        note_read(&file, &path)
    }

    fn replace(self) -> io::Result<(File, PathBuf)> {
        self.file.as_file().sync_all()?;
        let file = self.file.persist(&self.path).map_err(|error| error.error)?;
        sync_folder(folder_of(&self.path))?;
        Ok((file, self.path))
    }
}

/// An empty file with the permissions of a new file; a temporary file would be readable by its owner only. It stays
/// locked until it is closed, that is, while it is written.
fn new_in(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(SIBLING.0).suffix(SIBLING.1);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666)); // less the umask
    }
    // terminates: only a concurrent writer that scans the folder at this moment can take the file, and only once
    loop {
        let file = builder.tempfile_in(folder)?;
        // another process may have removed it as stale before it was locked
        if file.as_file().lock().is_err() || is_linked(file.as_file())? {
            return Ok(file);
        }
    }
}

/// Removes leftovers of killed writers in `folder`: files without a lock. On a file system without locks they stay.
#[cfg(unix)]
fn remove_stale(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_ours =
            name.to_str().is_some_and(|name| name.starts_with(SIBLING.0) && name.ends_with(SIBLING.1));
        if is_ours
            && entry.file_type().is_ok_and(|kind| kind.is_file())
            && let Ok(file) = File::options().write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            // a leftover that cannot be removed is harmless
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(not(unix))]
fn remove_stale(_folder: &Path) {}

#[cfg(test)]
mod tests {
    use super::super::read::read;
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn failed_writer_leaves_only_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        write_atomically(&path, b"old").unwrap();
        let error = replace(&path, |mut file| {
            file.write_all(b"ne")?;
            Err(ErrorKind::StorageFull.into())
        });
        let message = error.map_err(FileError::writing(&path)).unwrap_err().to_string();
        assert!(message.contains("a.json") && message.contains("help: the disk is full"), "{message}");
        assert_eq!(read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.json"]);
    }

    #[test]
    fn replaces_regular_files_only() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("folder");
        make_folder(&path).unwrap();
        assert!(write_atomically(&path, b"new").unwrap_err().to_string().contains("is no file"));
    }

    #[cfg(unix)]
    #[test]
    fn removes_leftovers_of_killed_writers_only() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        fs::write(folder.path().join(".fos-killed.tmp"), b"half").unwrap();
        fs::write(folder.path().join(".fos-notes"), b"somebody's").unwrap();
        let mut all = Vec::new();
        for _ in 0..3 {
            all.push(TemporarySibling::of(&path).unwrap());
        }
        assert_eq!(names(folder.path()).len(), 4, "{:?}", names(folder.path()));
        for sibling in all {
            sibling.file().write_all(b"whole").unwrap();
            sibling.put().unwrap();
        }
        let mut left = names(folder.path());
        left.sort_unstable();
        assert_eq!(left, [".fos-notes", "a.json"]);
    }

    #[cfg(unix)]
    #[test]
    fn keeps_links_and_permissions() {
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

//! Protects the inputs of this process from being overwritten by its outputs.
//!
//! One list for the whole process, since an input may be named by a study or found in a folder, and an output may be one of
//! many in a folder. The command line adds its paths ([`protect`]), the functions that open user files
//! ([`open`](crate::file::open), [`read`](crate::file::read)) what they open, and the only writer
//! ([`TemporarySibling::put`](crate::file::TemporarySibling)) checks the list before it renames. A file is identified by
//! device and inode rather than by path: other spellings, symbolic and hard links lead to the same one.
//!
//! Files written by this process are exempt: it may read and rewrite them, as the workbench does with its example.
//! A changed study replaces its input by [`FileVersion`](crate::file::compare_and_swap::FileVersion), which ensures that
//! nothing is lost.

use std::collections::{HashMap, HashSet};
use std::fs::{self, File, Metadata};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use super::paths::folder_of;

/// Identity of a file, independent of its path.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Identity {
    #[cfg(unix)]
    device: u64,
    #[cfg(unix)]
    inode: u64,
    /// Inodes are reused: the creation time, where the file system stores it, distinguishes a later file.
    #[cfg(unix)]
    made: Option<std::time::SystemTime>,
    #[cfg(not(unix))]
    path: PathBuf,
}

impl Identity {
    #[cfg(unix)]
    fn new(about: &Metadata, _: &Path) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self { device: about.dev(), inode: about.ino(), made: about.created().ok() }
    }

    #[cfg(not(unix))]
    fn new(_: &Metadata, path: &Path) -> Self {
        Self { path: super::paths::followed(path) }
    }

    /// Identity of the target of `path`, if it is a file or folder.
    fn of(path: &Path) -> Option<Self> {
        fs::metadata(path).ok().map(|about| Self::new(&about, path))
    }
}

/// Present or future location of a file.
#[derive(Debug, PartialEq, Eq)]
enum Location {
    Taken(Identity),
    /// A free name in a folder.
    Free(Identity, PathBuf),
    /// Path into a folder that does not exist.
    Nowhere(PathBuf),
}

impl Location {
    fn of(path: &Path) -> Self {
        match (Identity::of(path), Identity::of(folder_of(path))) {
            (Some(identity), _) => Self::Taken(identity),
            (None, Some(folder)) => Self::Free(folder, path.file_name().unwrap_or_default().into()),
            (None, None) => Self::Nowhere(path.to_owned()),
        }
    }
}

/// Returns true if both paths lead to the same file, whether or not it exists.
pub fn is_same_file(first: &Path, second: &Path) -> bool {
    Location::of(first) == Location::of(second)
}

/// Reason why a file is not replaced.
#[derive(Debug, thiserror::Error)]
#[error("it is an input, {}, and would be lost", input.display())]
pub(super) struct OwnInput {
    input: PathBuf,
}

#[derive(Default)]
struct Known {
    /// Files that are read, with the paths used.
    inputs: HashMap<Identity, PathBuf>,
    written: HashSet<Identity>,
}

static KNOWN: LazyLock<Mutex<Known>> = LazyLock::new(Mutex::default);

fn known() -> MutexGuard<'static, Known> {
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Records that the file at `path`, if there is one, will be read.
pub fn protect(path: &Path) {
    if let Ok(about) = fs::metadata(path) {
        note(&about, path);
    }
}

/// Records that `file` was opened as `path` for reading.
pub(super) fn note_read(file: &File, path: &Path) -> io::Result<()> {
    file.metadata().map(|about| note(&about, path))
}

fn note(about: &Metadata, path: &Path) {
    // a pipe or a device is never replaced
    if about.is_file() {
        let identity = Identity::new(about, path);
        let mut known = known();
        if !known.written.contains(&identity) {
            known.inputs.entry(identity).or_insert_with(|| path.to_owned());
        }
    }
}

/// Records that `file`, written by this process, is now at `path`.
pub(super) fn note_written(file: &File, path: &Path) -> io::Result<()> {
    let identity = Identity::new(&file.metadata()?, path);
    let mut known = known();
    known.inputs.remove(&identity);
    known.written.insert(identity);
    Ok(())
}

/// Rejects a path that leads to an input.
pub(super) fn refuse_to_replace(path: &Path) -> io::Result<()> {
    let Some(identity) = Identity::of(path) else { return Ok(()) };
    match known().inputs.get(&identity) {
        None => Ok(()),
        Some(input) => Err(io::Error::other(OwnInput { input: input.clone() })),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::file::{read, write_atomically};

    #[test]
    fn inputs_are_protected_under_any_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("log.csv"), b"measured").unwrap();
        fs::hard_link(at("log.csv"), at("hard.csv")).unwrap();
        std::os::unix::fs::symlink(at("log.csv"), at("link.csv")).unwrap();
        fs::copy(at("log.csv"), at("copy.csv")).unwrap();
        read(&at("log.csv")).unwrap();
        for name in ["log.csv", "./log.csv", "hard.csv", "link.csv"] {
            let message = write_atomically(&at(name), b"made").unwrap_err().to_string();
            let wanted = "log.csv, and would be lost\nhelp: write to another file";
            assert!(message.contains("it is an input, ") && message.ends_with(wanted), "{message}");
        }
        assert_eq!(fs::read(at("log.csv")).unwrap(), b"measured");
        write_atomically(&at("copy.csv"), b"made").unwrap();
        // nothing is lost
        write_atomically(&at("hard.csv"), b"measured").unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4, "nothing is left beside it");
    }

    #[test]
    fn own_outputs_may_be_rewritten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("example.csv");
        for content in [&b"one"[..], b"two", b"three"] {
            write_atomically(&path, content).unwrap();
            assert_eq!(read(&path).unwrap(), content);
        }
    }

    #[test]
    fn two_paths_of_one_file_are_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("below")).unwrap();
        std::os::unix::fs::symlink(at("below"), at("link")).unwrap();
        assert!(is_same_file(&at("below/new.csv"), &at("link/../below/new.csv")));
        assert!(is_same_file(&at("below/new.csv"), &at("link/new.csv")));
        assert!(!is_same_file(&at("below/new.csv"), &at("new.csv")));
        assert!(!is_same_file(&at("below/new.csv"), &at("below/other.csv")));
    }
}

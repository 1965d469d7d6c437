//! Read, change and write back a file: it is written only if no other process has changed it meanwhile.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::error::FileError;
use super::paths::{folder_of, followed, is_linked};
use super::replace::TemporarySibling;

/// State of a file at one moment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileVersion {
    path: PathBuf,
    /// SHA-256 of the content; `None` if the file did not exist.
    digest: Option<[u8; 32]>,
    /// Read to be changed: the new content is the same study and may replace it.
    is_changed: bool,
}

/// A file that cannot be written back.
#[derive(Debug, thiserror::Error)]
pub enum CompareAndSwapError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(
        "{}: changed meanwhile by another process, whose version is kept; nothing was written\nhelp: run the command again",
        .0.display()
    )]
    Changed(PathBuf),
}

impl FileVersion {
    /// Present state of `path`, which need not exist.
    pub fn now(path: &Path) -> Result<Self, FileError> {
        let digest = digest_of(path).map_err(FileError::reading(path))?;
        Ok(Self { path: path.to_owned(), digest, is_changed: false })
    }

    /// State of `path` with `content`, which was just read, to be changed.
    pub fn of(path: &Path, content: &[u8]) -> Self {
        Self { path: path.to_owned(), digest: Some(Sha256::digest(content).into()), is_changed: true }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Replaces the file if it is unchanged; no other process replaces it between the comparison and the rename.
    /// On an error its present content is untouched.
    pub fn replace(&self, content: &[u8]) -> Result<(), CompareAndSwapError> {
        let failed = || FileError::writing(&self.path);
        let sibling = TemporarySibling::of(&self.path).map_err(failed())?;
        sibling.file().write_all(content).map_err(failed())?;
        let _lock = Lock::of(&self.path).map_err(failed())?;
        if digest_of(&self.path).map_err(FileError::reading(&self.path))? != self.digest {
            return Err(CompareAndSwapError::Changed(self.path.clone()));
        }
        let put = if self.is_changed { TemporarySibling::put_back } else { TemporarySibling::put };
        Ok(put(sibling).map_err(failed())?)
    }
}

fn digest_of(path: &Path) -> io::Result<Option<[u8; 32]>> {
    match fs::read(path) {
        Ok(content) => Ok(Some(Sha256::digest(&content).into())),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// Keeps other processes from replacing a file. It locks a file next to it, `.fos-NAME.lock`: the file itself is a
/// different one after every rename, and scripts may lock it, or its folder, around this very program.
struct Lock {
    _file: File,
    path: PathBuf,
}

impl Lock {
    /// Waits until the lock is free: others hold it no longer than a rename takes.
    fn of(path: &Path) -> io::Result<Self> {
        let path = followed(path);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let path = folder_of(&path).join(format!(".fos-{name}.lock"));
        loop {
            let file = File::options().create(true).truncate(false).write(true).open(&path)?;
            match file.lock() {
                // on a file system without locks the comparison alone must do
                Err(error) if error.kind() == ErrorKind::Unsupported => {}
                done => done?,
            }
            // its last holder has removed it: try again with a new file
            if is_linked(&file)? {
                return Ok(Self { _file: file, path });
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // while it is locked; if it stays, the next writer takes it
        if cfg!(unix) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    #[test]
    fn does_not_replace_a_changed_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        let absent = FileVersion::now(&path).unwrap();
        absent.replace(b"one").unwrap();
        let one = FileVersion::of(&path, b"one");
        assert_eq!(one.digest, FileVersion::now(&path).unwrap().digest);
        let message = absent.replace(b"two").unwrap_err().to_string();
        assert!(message.contains("a.json: changed meanwhile") && message.contains("help: run"), "{message}");
        one.replace(b"two").unwrap();
        assert!(matches!(one.replace(b"three"), Err(CompareAndSwapError::Changed(_))));
        fs::remove_file(&path).unwrap();
        assert!(matches!(
            FileVersion::of(&path, b"two").replace(b"three"),
            Err(CompareAndSwapError::Changed(_))
        ));
        assert_eq!(
            fs::read_dir(folder.path()).unwrap().count(),
            0,
            "neither lock nor half of a file is left"
        );
    }

    /// Each writer adds a line to what it read and retries if another process was first: no line is lost.
    #[test]
    fn concurrent_writers_lose_no_line() {
        const WRITERS: usize = 8;
        const LINES: usize = 20;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lines");
        fs::write(&path, b"").unwrap();
        let write = |writer: usize| {
            for line in 0..LINES {
                loop {
                    let mut content = fs::read(&path).unwrap();
                    let seen = FileVersion::of(&path, &content);
                    content.extend(format!("{writer} {line}\n").bytes());
                    match seen.replace(&content) {
                        Ok(()) => break,
                        Err(CompareAndSwapError::Changed(_)) => {}
                        Err(other) => panic!("{other}"),
                    }
                }
            }
        };
        thread::scope(|scope| {
            let write = &write;
            (0..WRITERS).for_each(|writer| drop(scope.spawn(move || write(writer))));
        });
        assert_eq!(fs::read_to_string(&path).unwrap().lines().count(), WRITERS * LINES);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

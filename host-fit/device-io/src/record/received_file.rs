//! Stores received bytes beside the log until the log is written. After a crash or power loss the log is made from this file.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use fos_data::file::{FileError, folder_of, sync_folder};

/// Appended to the name of the log.
const ENDING: &str = ".telemetry";

/// Interval between syncs to disk: the most that a power loss can cost.
const SYNC_EVERY: Duration = Duration::from_secs(1);

/// File beside the log with the bytes of a stream as they came. It can itself be recorded as a stream.
#[derive(Debug)]
pub struct ReceivedFile {
    file: File,
    path: PathBuf,
    synced: Instant,
}

/// A stream cannot be stored.
#[derive(Debug, thiserror::Error)]
pub enum KeepError {
    #[error(transparent)]
    File(#[from] FileError),
    /// Another recording writes to the same log and would be overwritten.
    #[error(
        "{}: another recording is keeping there what arrives\nhelp: end that one first, or give this one another log with -o",
        .0.display()
    )]
    Running(PathBuf),
}

impl ReceivedFile {
    /// Creates the file `NAME.telemetry` for a log at `output`. Files of interrupted recordings of the same name are preserved and
    /// returned; the new one is then `NAME.2.telemetry`, and so on.
    pub fn beside(output: &Path) -> Result<(Self, Vec<PathBuf>), KeepError> {
        let mut left = Vec::new();
        let named = |number: usize| {
            let mut name = output.as_os_str().to_owned();
            if number > 1 {
                name.push(format!(".{number}"));
            }
            name.push(ENDING);
            PathBuf::from(name)
        };
        for number in 1.. {
            let path = named(number);
            let failed = || FileError::writing(&path);
            match File::options().write(true).create_new(true).open(&path) {
                Ok(file) => {
                    lock(&file).map_err(failed())?;
                    sync_folder(folder_of(&path)).map_err(failed())?;
                    return Ok((Self { file, path, synced: Instant::now() }, left));
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                    if is_being_written(&path) {
                        return Err(KeepError::Running(path));
                    }
                    left.push(path);
                }
                Err(error) => return Err(failed()(error).into()),
            }
        }
        unreachable!("there are more numbers than files in a folder")
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Unbuffered writer: its bytes are in the file even if this process is killed.
    pub fn writer(&self) -> io::Result<impl Write + Send + use<>> {
        self.file.try_clone()
    }

    /// Time of the next sync.
    pub fn due(&self) -> Instant {
        self.synced + SYNC_EVERY
    }

    /// Syncs the file to disk if it is due.
    pub fn sync_if_due(&mut self) -> io::Result<()> {
        if Instant::now() < self.due() {
            return Ok(());
        }
        let synced = self.file.sync_data();
        self.synced = Instant::now();
        synced
    }

    /// Removes the file because the log is written or there are no data. A failure to remove it does no harm.
    pub fn remove(self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// Locks the file while the recording runs; without a lock if the file system has none.
fn lock(file: &File) -> io::Result<()> {
    match file.lock() {
        Err(error) if error.kind() == ErrorKind::Unsupported => Ok(()),
        done => done,
    }
}

fn is_being_written(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preserves_files_of_other_recordings() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("field.parquet");
        let (first, left) = ReceivedFile::beside(&output).unwrap();
        assert_eq!(left, [""; 0].map(PathBuf::from));
        first.writer().unwrap().write_all(b"first").unwrap();
        let message = ReceivedFile::beside(&output).unwrap_err().to_string();
        assert!(message.contains("another recording") && message.contains("help: "), "{message}");
        // The process was killed.
        let path = first.path().to_owned();
        drop(first);
        let (second, left) = ReceivedFile::beside(&output).unwrap();
        assert_eq!(left, std::slice::from_ref(&path));
        assert_eq!(second.path(), folder.path().join("field.parquet.2.telemetry"));
        second.remove();
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

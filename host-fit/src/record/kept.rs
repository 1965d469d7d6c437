//! What arrives is kept beside the log until the log is written: a recording that is killed, or whose power is cut, is
//! made a log of from there.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use fos_data::file::{FileError, folder_of, sync_folder};

/// Behind the name of the log stands this.
const ENDING: &str = ".telemetry";

/// What arrived is brought to the disk so often: a cut of power costs no more.
const SYNC_EVERY: Duration = Duration::from_secs(1);

/// The bytes of a stream as they came, in a file beside the log: itself a stream that can be recorded.
#[derive(Debug)]
pub struct Kept {
    file: File,
    path: PathBuf,
    synced: Instant,
}

/// What stands in the way of keeping a stream.
#[derive(Debug, thiserror::Error)]
pub enum KeepError {
    /// The system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// Two recordings of one log: the second would replace the first.
    #[error(
        "{}: another recording is keeping there what arrives\nhelp: end that one first, or give this one another log with -o",
        .0.display()
    )]
    Running(PathBuf),
}

impl Kept {
    /// An empty file for a log at `output`, `NAME.telemetry`; and what recordings of the same name left that were
    /// broken off, which stays: the new one is then `NAME.2.telemetry`, and so on.
    ///
    /// # Errors
    ///
    /// It cannot be made, or another recording of this log is running.
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

    /// The file of bytes as they arrived.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What is written to it is there at once for whoever reads the file, also if this process is killed.
    ///
    /// # Errors
    ///
    /// What the system refuses.
    pub fn writer(&self) -> io::Result<impl Write + Send + use<>> {
        self.file.try_clone()
    }

    /// When it is to be brought to the disk next.
    pub fn due(&self) -> Instant {
        self.synced + SYNC_EVERY
    }

    /// Brings it to the disk if it is time.
    ///
    /// # Errors
    ///
    /// What the system refuses.
    pub fn sync_if_due(&mut self) -> io::Result<()> {
        if Instant::now() < self.due() {
            return Ok(());
        }
        let synced = self.file.sync_data();
        self.synced = Instant::now();
        synced
    }

    /// Takes it away: the log is written, or there is nothing in it. If it cannot be removed, it harms nobody.
    pub fn remove(self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// As long as the recording runs; a file system without locks does without.
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
    fn what_another_recording_left_or_is_writing_stays() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("field.parquet");
        let (first, left) = Kept::beside(&output).unwrap();
        assert_eq!(left, [""; 0].map(PathBuf::from));
        first.writer().unwrap().write_all(b"first").unwrap();
        let said = Kept::beside(&output).unwrap_err().to_string();
        assert!(said.contains("another recording") && said.contains("help: "), "{said}");
        // killed
        let path = first.path().to_owned();
        drop(first);
        let (second, left) = Kept::beside(&output).unwrap();
        assert_eq!(left, std::slice::from_ref(&path));
        assert_eq!(second.path(), folder.path().join("field.parquet.2.telemetry"));
        second.remove();
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

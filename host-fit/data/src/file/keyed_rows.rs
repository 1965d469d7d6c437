//! Results stored in a file as each is computed, so that an interrupted run resumes: a line of JSON for each, with the key of everything
//! that it depends on.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{FileError, write_atomically};

/// A line of the file.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct KeyedRow<T> {
    /// Text that is equal only where everything that the row depends on is.
    pub key: String,
    pub row: T,
}

impl<T: Serialize> KeyedRow<T> {
    /// The row as a line.
    pub fn line(&self) -> Vec<u8> {
        let mut line = serde_json::to_vec(self).expect("rows have only string keys");
        line.push(b'\n');
        line
    }
}

/// Stored rows, and the file that new ones are appended to.
#[derive(Debug)]
pub struct KeyedRows<T> {
    path: PathBuf,
    file: Mutex<Appended>,
    stored: HashMap<String, T>,
}

/// The rows of a file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum KeyedRowsError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error("{}: a file of that name has other content, which would be lost\nhelp: write to another file, or move that one away", .0.display())]
    Foreign(PathBuf),
}

impl<T: Serialize + DeserializeOwned> KeyedRows<T> {
    /// Opens the file, or creates it.
    pub fn open(path: &Path) -> Result<Self, KeyedRowsError> {
        let (stored, in_line) = read(path)?;
        let file =
            OpenOptions::new().create(true).append(true).open(path).map_err(FileError::writing(path))?;
        Ok(Self { path: path.to_owned(), file: Mutex::new(Appended { file, in_line }), stored })
    }

    /// Checks that the file has nothing but rows, or does not exist.
    pub fn check(path: &Path) -> Result<(), KeyedRowsError> {
        read::<T>(path).map(drop)
    }

    /// Returns the row that was stored with this key when the file was opened.
    pub fn get(&self, key: &str) -> Option<&T> {
        self.stored.get(key)
    }

    /// Appends a row, and waits until the disk has it.
    pub fn append(&self, row: &KeyedRow<T>) -> Result<(), FileError> {
        let mut appended = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        appended.append(&row.line()).map_err(FileError::writing(&self.path))
    }

    /// Replaces the content of the file by these rows. On an error it is unchanged.
    pub fn replace(self, rows: &[KeyedRow<T>]) -> Result<(), FileError> {
        write_atomically(&self.path, &rows.iter().flat_map(KeyedRow::line).collect::<Vec<u8>>())
    }

    /// Removes the file. A failure does no harm.
    pub fn remove(self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// The file, which is appended to.
#[derive(Debug)]
struct Appended {
    file: File,
    /// The file does not end with a newline, after an interruption or a failed write.
    in_line: bool,
}

impl Appended {
    /// Appends a line. A line that was cut off is ended first, because a row behind it on the same line would be unreadable.
    fn append(&mut self, line: &[u8]) -> std::io::Result<()> {
        if std::mem::replace(&mut self.in_line, true) {
            self.file.write_all(b"\n")?;
        }
        self.file.write_all(line)?;
        self.in_line = false;
        self.file.sync_data()
    }
}

/// Returns the rows by key, and true if the file does not end with a newline. Lines that were cut off are ignored.
fn read<T: DeserializeOwned>(path: &Path) -> Result<(HashMap<String, T>, bool), KeyedRowsError> {
    let (mut rows, mut in_line, mut is_foreign) = (HashMap::new(), false, false);
    let file = match File::open(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok((rows, in_line)),
        file => file.map_err(FileError::opening(path))?,
    };
    let (mut file, mut line) = (BufReader::new(file), Vec::new());
    while file.read_until(b'\n', &mut line).map_err(FileError::reading(path))? > 0 {
        in_line = line.pop_if(|byte| *byte == b'\n').is_none();
        match serde_json::from_slice::<KeyedRow<T>>(&line) {
            Ok(KeyedRow { key, row }) => drop(rows.insert(key, row)),
            Err(error) => is_foreign |= !(error.is_eof() && is_start_of_row(&line)),
        }
        line.clear();
    }
    if is_foreign && rows.is_empty() {
        return Err(KeyedRowsError::Foreign(path.to_owned()));
    }
    Ok((rows, in_line))
}

/// Returns true for a line that was cut off: it starts with the key, or is shorter.
fn is_start_of_row(line: &[u8]) -> bool {
    const START: &[u8] = b"{\"key\":\"";
    line.starts_with(START) || START.starts_with(line)
}

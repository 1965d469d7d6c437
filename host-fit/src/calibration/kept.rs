//! Stores outcomes in a file as they are computed, so that an interrupted calibration resumes.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::cases::Cases;
use super::outcome::Outcome;
use crate::program::this_build;
use fos_data::file::{FileError, write_atomically};
use fos_data::text::hexadecimal;
use fos_diagnose::effects::Library;

/// Appended to the name of the file of outcomes.
const ENDING: &str = ".partial";

/// Outcomes of the finished cases, one line of JSON each, each synced to disk.
#[derive(Debug)]
pub struct KeptOutcomes {
    path: PathBuf,
    file: Mutex<File>,
    done: BTreeMap<usize, Outcome>,
}

/// First line: everything the outcomes depend on.
#[derive(Clone, Serialize, Deserialize, PartialEq)]
struct Heading {
    cases: String,
}

impl Heading {
    fn of(cases: &Cases, library: &Library) -> Self {
        let mut digest = Sha256::new();
        digest.update(this_build());
        digest.update(serde_json::to_vec(cases).unwrap_or_default());
        digest.update(serde_json::to_vec(library.effects()).unwrap_or_default());
        Self { cases: hexadecimal(&digest.finalize()) }
    }
}

impl KeptOutcomes {
    /// Opens the file beside `outcomes`, with the outcomes stored by an interrupted run of the same program on the same cases.
    ///
    /// # Errors
    ///
    /// A file operation fails, or the file is not one of outcomes.
    pub fn beside(outcomes: &Path, cases: &Cases, library: &Library) -> Result<Self, FileError> {
        let mut path = outcomes.as_os_str().to_owned();
        path.push(ENDING);
        let path = PathBuf::from(path);
        let heading = Heading::of(cases, library);
        let left = match fs::read_to_string(&path) {
            Ok(left) => left,
            Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
            Err(error) => return Err(FileError::reading(&path)(error)),
        };
        let mut lines = left.lines();
        let found = lines.next().map(serde_json::from_str::<Heading>).transpose();
        let found = found.map_err(|_| FileError::writing(&path)(ErrorKind::AlreadyExists.into()))?;
        let same = found.as_ref() == Some(&heading);
        // The last line may be truncated.
        let done = lines.filter(|_| same).filter_map(|line| serde_json::from_str::<Outcome>(line).ok());
        let done: BTreeMap<usize, Outcome> = done.map(|outcome| (outcome.case, outcome)).collect();
        let mut text = line(&heading);
        done.values().for_each(|outcome| text.extend(line(outcome)));
        write_atomically(&path, &text)?;
        let file = File::options().append(true).open(&path).map_err(FileError::writing(&path))?;
        Ok(Self { path, file: Mutex::new(file), done })
    }

    /// Number of stored outcomes.
    pub fn len(&self) -> usize {
        self.done.len()
    }

    /// No outcomes are stored.
    pub fn is_empty(&self) -> bool {
        self.done.is_empty()
    }

    /// Stored outcome of a case.
    pub(super) fn of(&self, case: usize) -> Option<Outcome> {
        self.done.get(&case).cloned()
    }

    /// Stores the outcome of a case.
    pub(super) fn add(&self, outcome: &Outcome) -> Result<(), FileError> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(&line(outcome)).and_then(|()| file.sync_data()).map_err(FileError::writing(&self.path))
    }

    /// Removes the file after all outcomes are written. A failure to remove it does no harm.
    pub fn remove(self) {
        let _ = fs::remove_file(&self.path);
    }
}

fn line(value: &impl Serialize) -> Vec<u8> {
    let mut line = serde_json::to_vec(value).expect("outcomes have only string keys");
    line.push(b'\n');
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::calibrate;
    use fos_simulate::Disturbance;

    #[test]
    fn interrupted_calibration_resumes() {
        let folder = tempfile::tempdir().unwrap();
        let (outcomes, library) = (folder.path().join("outcomes.json"), Library::built_in());
        let cases = |seed| Cases { seed, count: 3, world: Disturbance::Clean, every_axis: false };
        let kept = |seed| KeptOutcomes::beside(&outcomes, &cases(seed), &library).unwrap();
        let whole = calibrate(cases(1), &library, Some(&kept(1)), |_| {}).unwrap();
        let path = folder.path().join("outcomes.json.partial");
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().count(), 4);
        // Killed while writing the last line.
        fs::write(&path, &text[..text.len() - 9]).unwrap();
        let left = kept(1);
        assert_eq!(left.len(), 2);
        let computed = Mutex::new(0);
        let again = calibrate(cases(1), &library, Some(&left), |_| *computed.lock().unwrap() += 1).unwrap();
        assert_eq!(*computed.lock().unwrap(), 3, "all are counted");
        // Equal except for the measured times.
        let but_times = |calibration: &crate::calibration::Calibration| {
            let mut outcomes = calibration.outcomes.clone();
            outcomes.iter_mut().for_each(|outcome| outcome.seconds = 0.0);
            serde_json::to_string(&outcomes).unwrap()
        };
        assert_eq!(but_times(&whole), but_times(&again));
        // Outcomes of other cases are not reused.
        assert!(kept(2).is_empty());
        // Another file is not overwritten.
        fs::write(&path, "my notes\n").unwrap();
        assert!(KeptOutcomes::beside(&outcomes, &cases(1), &library).is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "my notes\n");
    }
}

//! Outcomes stored as they are computed, so that an interrupted calibration resumes.

use std::path::Path;

use sha2::{Digest, Sha256};

use super::cases::Cases;
use super::outcome::Outcome;
use crate::program::this_build;
use fos_data::file::FileError;
use fos_data::file::keyed_rows::{KeyedRow, KeyedRows, KeyedRowsError};
use fos_data::text::hexadecimal;
use fos_diagnose::effects::Library;

/// Appended to the name of the file of outcomes.
const ENDING: &str = ".partial";

/// Outcomes of finished cases.
#[derive(Debug)]
pub struct StoredOutcomes {
    rows: KeyedRows<Outcome>,
    /// Digest of everything that the outcomes depend on.
    digest: String,
}

impl StoredOutcomes {
    /// Opens the file beside `outcomes`, which may hold outcomes of an interrupted run.
    pub fn beside(outcomes: &Path, cases: &Cases, library: &Library) -> Result<Self, KeyedRowsError> {
        let mut path = outcomes.as_os_str().to_owned();
        path.push(ENDING);
        let mut digest = Sha256::new();
        digest.update(this_build());
        digest.update(serde_json::to_vec(cases).unwrap_or_default());
        digest.update(serde_json::to_vec(library.effects()).unwrap_or_default());
        Ok(Self { rows: KeyedRows::open(Path::new(&path))?, digest: hexadecimal(&digest.finalize()) })
    }

    fn key(&self, case: usize) -> String {
        format!("{} {case}", self.digest)
    }

    /// Stored outcome of a case.
    pub(super) fn of(&self, case: usize) -> Option<Outcome> {
        self.rows.get(&self.key(case)).cloned()
    }

    /// Stores the outcome of a case.
    pub(super) fn add(&self, outcome: &Outcome) -> Result<(), FileError> {
        self.rows.append(&KeyedRow { key: self.key(outcome.case), row: outcome.clone() })
    }

    /// Removes the file after all outcomes are written.
    pub fn remove(self) {
        self.rows.remove();
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::sync::Mutex;

    use super::*;
    use crate::calibration::calibrate;
    use fos_simulate::Disturbance;

    #[test]
    fn interrupted_calibration_resumes() {
        let folder = tempfile::tempdir().unwrap();
        let (outcomes, library) = (folder.path().join("outcomes.json"), Library::built_in());
        let cases = |seed| Cases { seed, count: 2, world: Disturbance::Clean, every_axis: false };
        let stored_outcomes = |seed| StoredOutcomes::beside(&outcomes, &cases(seed), &library).unwrap();
        let n_stored = |stored_outcomes: &StoredOutcomes| {
            (0..2).filter(|case| stored_outcomes.of(*case).is_some()).count()
        };
        let whole = calibrate(cases(1), &library, Some(&stored_outcomes(1)), |_| {}).unwrap();
        let path = folder.path().join("outcomes.json.partial");
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().count(), 2);
        // Killed while writing the last line.
        fs::write(&path, &text[..text.len() - 9]).unwrap();
        let left = stored_outcomes(1);
        assert_eq!(n_stored(&left), 1);
        let computed = Mutex::new(0);
        let again = calibrate(cases(1), &library, Some(&left), |_| *computed.lock().unwrap() += 1).unwrap();
        assert_eq!(*computed.lock().unwrap(), 2, "all are counted");
        assert_eq!(n_stored(&stored_outcomes(1)), 2);
        // Equal except for the measured times.
        let but_times = |calibration: &crate::calibration::Calibration| {
            let mut outcomes = calibration.outcomes.clone();
            outcomes.iter_mut().for_each(|outcome| outcome.seconds = 0.0);
            serde_json::to_string(&outcomes).unwrap()
        };
        assert_eq!(but_times(&whole), but_times(&again));
        // Outcomes of other cases are not reused.
        assert_eq!(n_stored(&stored_outcomes(2)), 0);
        // Another file is not overwritten.
        fs::write(&path, "my notes\n").unwrap();
        assert!(StoredOutcomes::beside(&outcomes, &cases(1), &library).is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "my notes\n");
    }
}

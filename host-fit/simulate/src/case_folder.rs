//! Writes a simulated case as a folder.

use std::path::{Path, PathBuf};

use super::case::{LogTruth, SimulatedCase};
use super::disturbance::Disturbance;
use super::regressors::NamedSeries;
use fos_data::file::{FileError, make_folder, write_atomically};
use fos_data::recording::{Recording, RecordingError, write_columns};

/// Error of writing a case folder.
#[derive(Debug, thiserror::Error)]
pub enum CaseFolderError {
    #[error(transparent)]
    Log(#[from] RecordingError),
    /// A JSON file, or the folder.
    #[error(transparent)]
    File(#[from] FileError),
    /// A value that JSON cannot represent.
    #[error("{}: {source}", path.display())]
    Json { path: PathBuf, source: serde_json::Error },
}

impl SimulatedCase {
    /// Writes `reference.parquet`, `log.parquet` and `evaluation.parquet`.
    pub(super) fn write_logs(&self, folder: &Path) -> Result<(), RecordingError> {
        if self.truth.plan.disturbance == Disturbance::Streams {
            // a table cannot hold streams: they are written resampled
            for (name, joined) in ["reference", "log", "evaluation"].into_iter().zip(self.recordings()?) {
                write(folder, name, columns_of(&joined).iter())?;
            }
            return Ok(());
        }
        write(folder, "reference", self.reference.iter())?;
        write(folder, "log", self.log.iter())?;
        write(folder, "evaluation", self.evaluation.iter())
    }

    /// Writes `meta.json`, `reference.parquet`, `log.parquet`, `evaluation.parquet`; and the truth, which a real device
    /// does not have: `truth.json`, and by rows `truth_log.parquet`, `truth_evaluation.parquet` (columns `error` and
    /// the regressors). The case is named after the folder.
    pub fn write(&self, folder: impl AsRef<Path>) -> Result<(), CaseFolderError> {
        let folder = folder.as_ref();
        make_folder(folder)?;
        let mut meta = self.meta.clone();
        if let Some(name) = folder.file_name() {
            meta.case = name.to_string_lossy().into_owned();
        }
        self.write_logs(folder)?;
        for (name, truth) in [("truth_log", &self.truth.log), ("truth_evaluation", &self.truth.evaluation)] {
            let LogTruth { error, motion, regressors } = truth;
            let mut columns: Vec<NamedSeries> = vec![("error".to_owned(), error.clone())];
            if motion.iter().any(|moved| *moved != 0.0) {
                columns.push(("motion".to_owned(), motion.clone()));
            }
            write(folder, name, columns.iter().chain(regressors))?;
        }
        json(folder.join("truth.json"), &self.truth)?;
        // last: a folder with a meta.json is complete
        json(folder.join("meta.json"), &meta)
    }
}

/// Columns of a recording, named as in a log.
fn columns_of(recording: &Recording) -> Vec<NamedSeries> {
    let channels = recording.channels().iter().map(|channel| (channel.name.clone(), channel.values.to_vec()));
    let flag = |still: &bool| f64::from(u8::from(*still));
    let still = recording.still.iter().map(|still| ("still".to_owned(), still.iter().map(flag).collect()));
    std::iter::once(("t_s".to_owned(), recording.time_s.clone())).chain(channels).chain(still).collect()
}

fn write<'a>(
    folder: &Path,
    name: &str,
    columns: impl Iterator<Item = &'a NamedSeries>,
) -> Result<(), RecordingError> {
    let columns: Vec<(&str, &[f64])> =
        columns.map(|(name, values)| (name.as_str(), values.as_slice())).collect();
    write_columns(folder.join(format!("{name}.parquet")), &columns)
}

fn json(path: PathBuf, value: &impl serde::Serialize) -> Result<(), CaseFolderError> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|source| CaseFolderError::Json { path: path.clone(), source })?;
    Ok(write_atomically(&path, text.as_bytes())?)
}

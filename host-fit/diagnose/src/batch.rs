//! Diagnoses and corrects every case in a folder, in parallel. Results are stored, so an interrupted run resumes.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::case::question;
use crate::detect::{DiagnoseError, Diagnosis, correction, diagnose, is_fast};
use crate::effects::Library;
use crate::study::Tool;
use fos_data::case::{Case, CaseError};
use fos_data::file::keyed_rows::{KeyedRow, KeyedRows, KeyedRowsError};
use fos_data::file::{self, FileError};
use fos_data::recording::{Recording, RecordingError, write_columns};
use fos_data::text::hexadecimal;

/// Schema of the stored answers.
pub const SCHEMA: &str = "fos-answers/1";

/// Answers of earlier runs, in the folder of the answers.
const STORED: &str = "answers.rows";

/// Rate at which slow corrections are written, Hz.
const SLOW_RATE_HZ: f64 = 10.0;

/// Answers to a folder of cases.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answers {
    /// [`SCHEMA`].
    pub schema: String,
    /// Program that computed the answers.
    pub tool: Tool,
    /// One answer per case, in the order of their folders.
    pub cases: Vec<Answer>,
}

/// Answer to one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// Name of its folder, which is unique; the name in `meta.json` need not be.
    pub case: String,
    /// The diagnosis; absent if the case could not be read or diagnosed.
    #[serde(flatten)]
    pub diagnosis: Option<Diagnosis>,
    /// Reason for a missing diagnosis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Correction of the evaluation log: `t_s,corr`, relative to the answers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correction_eval_csv: Option<String>,
    /// Correction of the log to explain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correction_field_csv: Option<String>,
    /// Computing time, s.
    pub seconds: f64,
}

/// Error that stops a batch.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// A file cannot be read or written; holds the message of the system.
    #[error(transparent)]
    File(#[from] FileError),
    /// The stored answers cannot be used.
    #[error(transparent)]
    Rows(#[from] KeyedRowsError),
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error(transparent)]
    Case(#[from] CaseError),
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    #[error("{}: no folder in it has a meta.json\nhelp: each case is a folder with a meta.json and its logs", .0.display())]
    NoCases(PathBuf),
    #[error("{}: {source}", path.display())]
    Folder { path: PathBuf, source: std::io::Error },
}

/// Diagnoses every case in `folder` and writes `answers.json` and the corrections to `output`. Calls `progress` with
/// the number of cases done, the number of cases and the name of the last one. Stored answers are reused if their case,
/// the library and `program` are unchanged; `program` is any text that differs between builds. A case that cannot be
/// read becomes an answer with an error.
pub fn run(
    folder: &Path,
    output: &Path,
    library: &Library,
    program: &str,
    progress: impl Fn(usize, usize, &str) + Sync,
) -> Result<Answers, BatchError> {
    let cases = case_folders(folder)?;
    file::make_folder(&output.join("corr"))?;
    let (stored, done) = (KeyedRows::open(&output.join(STORED))?, AtomicUsize::new(0));
    let rows: Vec<KeyedRow<Answer>> = cases
        .par_iter()
        .map(|case| -> Result<KeyedRow<Answer>, BatchError> {
            let answer = answer(case, output, library, program, &stored)?;
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, cases.len(), &answer.row.case);
            Ok(answer)
        })
        .collect::<Result<_, _>>()?;
    stored.replace(&rows)?;
    let answers = rows.into_iter().map(|stored| stored.row).collect();
    let answers = Answers { schema: SCHEMA.to_owned(), tool: Tool::this(), cases: answers };
    write_json(&output.join("answers.json"), &answers)?;
    Ok(answers)
}

fn write_json(path: &Path, value: &impl Serialize) -> Result<(), FileError> {
    let mut text = serde_json::to_vec_pretty(value).expect("answers have only string keys");
    text.push(b'\n');
    file::write_atomically(path, &text)
}

/// Returns the folders with a `meta.json`, by name.
fn case_folders(folder: &Path) -> Result<Vec<PathBuf>, BatchError> {
    let listed =
        std::fs::read_dir(folder).map_err(|source| BatchError::Folder { path: folder.to_owned(), source })?;
    let mut cases: Vec<PathBuf> = listed
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.join("meta.json").exists())
        .collect();
    cases.sort_unstable();
    if cases.is_empty() { Err(BatchError::NoCases(folder.to_owned())) } else { Ok(cases) }
}

/// Returns the stored answer of an earlier run if nothing has changed since, else computes it.
fn answer(
    folder: &Path,
    output: &Path,
    library: &Library,
    program: &str,
    stored: &KeyedRows<Answer>,
) -> Result<KeyedRow<Answer>, BatchError> {
    let name = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let key = key(&name, folder, library, program);
    if let Some(answer) = stored.get(&key)
        && corrections(answer).all(|path| output.join(path).exists())
    {
        return Ok(KeyedRow { key, row: answer.clone() });
    }
    let start = Instant::now();
    let mut answer = match examine(folder, output, &name, library) {
        Ok(answer) => answer,
        // an error in one case does not stop the others; an error of the output does
        Err(error @ (BatchError::Case(_) | BatchError::Diagnose(_))) => Answer {
            case: name,
            diagnosis: None,
            error: Some(error.to_string()),
            correction_eval_csv: None,
            correction_field_csv: None,
            seconds: 0.0,
        },
        Err(error) => return Err(error),
    };
    answer.seconds = start.elapsed().as_secs_f64();
    let answer = KeyedRow { key, row: answer };
    stored.append(&answer)?;
    Ok(answer)
}

fn corrections(answer: &Answer) -> impl Iterator<Item = &String> {
    answer.correction_eval_csv.iter().chain(&answer.correction_field_csv)
}

/// Digest of the case's name, the names, sizes and modification times of its files, the program and the library.
fn key(name: &str, folder: &Path, library: &Library, program: &str) -> String {
    let mut digest = Sha256::new();
    digest.update(format!("{program} {name}"));
    digest.update(serde_json::to_vec(library.effects()).unwrap_or_default());
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(|entry| {
            let entry = entry.ok()?;
            let about = entry.metadata().ok()?;
            Some(format!("{:?} {} {:?}", entry.file_name(), about.len(), about.modified().ok()))
        })
        .collect();
    files.sort_unstable();
    files.iter().for_each(|file| digest.update(file));
    hexadecimal(&digest.finalize())
}

fn examine(folder: &Path, output: &Path, name: &str, library: &Library) -> Result<Answer, BatchError> {
    let case = Case::read(folder)?;
    let diagnosis = diagnose(&question(&case, library))?;
    let write = |log: &Recording, which: &str| -> Result<String, BatchError> {
        let path = format!("corr/{name}_{which}.csv");
        write_correction(&output.join(&path), &diagnosis, &case.log, log)?;
        Ok(path)
    };
    let correction_eval_csv = case.evaluation.as_ref().map(|eval| write(eval, "eval")).transpose()?;
    let correction_field_csv = Some(write(&case.log, "field")?);
    Ok(Answer {
        case: name.to_owned(),
        diagnosis: Some(diagnosis),
        error: None,
        correction_eval_csv,
        correction_field_csv,
        seconds: 0.0,
    })
}

/// Writes `t_s,corr`, as means over 0.1 s if the correction is slow.
fn write_correction(
    path: &Path,
    diagnosis: &Diagnosis,
    fitted: &Recording,
    log: &Recording,
) -> Result<(), BatchError> {
    let values = correction(&diagnosis.findings, fitted, log)?;
    let chunk = match is_fast(&diagnosis.findings) {
        true => 1,
        false => ((log.rate.true_hz / SLOW_RATE_HZ).round() as usize).max(1),
    };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let time: Vec<f64> = log.time_s.chunks(chunk).map(mean).collect();
    let values: Vec<f64> = values.chunks(chunk).map(mean).collect();
    Ok(write_columns(path, &[("t_s", &time), ("corr", &values)])?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_simulate::{Axis, CasePlan, Durations, Setup, simulate_case};

    #[test]
    fn answers_have_the_names_of_their_folders() {
        let folder = tempfile::tempdir().expect("a folder");
        let (cases, output) = (folder.path().join("cases"), folder.path().join("answers"));
        let mut plan = CasePlan::new(1, "lsm6dso", Setup::Bench, Axis::Gx);
        plan.durations = Durations { reference_s: 60.0, log_s: 60.0, evaluation_s: 60.0 };
        // a case states the name of the folder that it was written to
        let written = cases.join("before");
        simulate_case(&plan).expect("a case").write(&written).expect("a case folder");
        std::fs::rename(&written, cases.join("one")).expect("renamed");
        std::fs::create_dir(cases.join("two")).expect("a folder");
        std::fs::write(cases.join("two/meta.json"), r#"{"case": "another"}"#).expect("a broken case");
        let answers = run(&cases, &output, &Library::built_in(), "test", |_, _, _| {}).expect("answers");
        let names: Vec<(&str, bool)> =
            answers.cases.iter().map(|answer| (answer.case.as_str(), answer.error.is_some())).collect();
        assert_eq!(names, [("one", false), ("two", true)]);
    }
}

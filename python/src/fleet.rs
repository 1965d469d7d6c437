//! Row of a unit, and populations of many rows.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use fos_data::file::write_atomically;
use fos_data::recording::load;
use fos_fleet::{Asked, FleetError, Gathered, PROGRAM, Unit, UnitRow, check_regressors, row_of};
use pyo3::prelude::*;
use serde_json::json;

use crate::diagnosis::library;
use crate::error::{py_error, raised};
use crate::recording::{Recording, options};
use crate::work;

/// Name, part and lot of a unit.
type Named = (String, String, Option<String>);

fn asked(py: Python<'_>, regressors: Vec<String>, diagnosed: bool) -> PyResult<Asked> {
    check_regressors(&regressors).map_err(|wrong| py_error(py, "FleetError", &wrong.to_string()))?;
    Ok(Asked { regressors, diagnosed, read: Default::default() })
}

fn unit((name, part, lot): Named) -> Unit {
    Unit { name, part, lot: lot.filter(|lot| !lot.is_empty()), logs: Vec::new() }
}

fn text_of(row: &UnitRow) -> String {
    json!(row).to_string()
}

/// Row of the logs in files, as JSON. It reports failures of logs; `shown_as` has the names of the files in messages.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "they are the keywords of `fos_imu.unit_row`")]
pub(crate) fn unit_row(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    shown_as: Vec<String>,
    named: Named,
    regressors: Vec<String>,
    diagnosed: bool,
    effects: Vec<PathBuf>,
    largest_bytes: Option<u64>,
    map: Vec<String>,
    rate_hz: Option<f64>,
    format: Option<String>,
    topic: Option<String>,
    strict: bool,
    keep_moved: bool,
) -> PyResult<String> {
    let read = options(py, &map, rate_hz, format.as_deref(), topic, (strict, keep_moved))?;
    let asked = Asked { read, ..asked(py, regressors, diagnosed)? };
    let library = library(py, &effects)?;
    work::run(py, || {
        let read = |path: &PathBuf| {
            let bytes = path.metadata().map_or(0, |about| about.len());
            match largest_bytes.filter(|largest| bytes > *largest) {
                Some(largest) => Err(format!(
                    "{}: {bytes} bytes are more than largest_bytes, {largest}\nhelp: a shorter log, or a larger limit",
                    path.display()
                )),
                None => load(path, &asked.read).map_err(|error| error.to_string()),
            }
        };
        let mut row = row_of(&unit(named), paths.iter().map(read), &asked, &library, PROGRAM);
        for (path, name) in paths.iter().zip(shown_as) {
            let path = path.display().to_string();
            row.failed.iter_mut().for_each(|reason| *reason = reason.replace(&path, &name));
        }
        text_of(&row)
    })
}

/// Row of recordings, as JSON.
#[pyfunction]
pub(crate) fn recording_row(
    py: Python<'_>,
    logs: Vec<PyRef<'_, Recording>>,
    named: Named,
    regressors: Vec<String>,
    diagnosed: bool,
    effects: Vec<PathBuf>,
) -> PyResult<String> {
    let read = logs.first().map(|log| log.read.clone()).unwrap_or_default();
    let asked = Asked { read, ..asked(py, regressors, diagnosed)? };
    let library = library(py, &effects)?;
    let logs: Vec<Arc<_>> = logs.iter().map(|log| Arc::clone(&log.log)).collect();
    work::run(py, || {
        let read = logs.iter().map(|log| Ok::<_, String>(log.as_ref().clone()));
        text_of(&row_of(&unit(named), read, &asked, &library, PROGRAM))
    })
}

/// Gathers the data of rows for populations.
#[pyclass(frozen, module = "fos_imu._engine")]
pub(crate) struct Rows(Mutex<Gathered>);

#[pymethods]
impl Rows {
    #[new]
    fn new() -> Self {
        Self(Mutex::default())
    }

    /// Adds rows, each as JSON.
    fn extend(&self, py: Python<'_>, texts: Vec<String>) -> PyResult<()> {
        let taken = work::run(py, || {
            let mut gathered = self.held();
            texts.iter().try_for_each(|text| {
                let row: UnitRow = serde_json::from_str(text).map_err(|error| {
                    let start: String = text.chars().take(60).collect();
                    format!("{start:?} … is not the row of a device: {error}\nhelp: pass results of `unit_row`, or their `to_json()`")
                })?;
                gathered.add(row).map_err(|error| error.to_string())
            })
        })?;
        taken.map_err(|error: String| py_error(py, "FleetError", &error))
    }

    /// Computes the populations.
    fn population(&self, py: Python<'_>, effects: Vec<PathBuf>) -> PyResult<Fleet> {
        let library = library(py, &effects)?;
        let found = work::run(py, || fos_fleet::Fleet::of_gathered(&self.held(), &library, PROGRAM))?;
        found.map(Fleet).map_err(|error| py_error(py, "FleetError", &error.to_string()))
    }
}

impl Rows {
    fn held(&self) -> MutexGuard<'_, Gathered> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Populations of a fleet.
#[pyclass(frozen, module = "fos_imu._engine")]
pub(crate) struct Fleet(fos_fleet::Fleet);

#[pymethods]
impl Fleet {
    /// Content as JSON.
    fn json(&self) -> String {
        json!(self.0).to_string()
    }

    /// Writes the file as the program does, with `rows` beside it if they are given.
    fn save(&self, py: Python<'_>, path: PathBuf, rows: Option<Vec<String>>) -> PyResult<()> {
        let Some(rows) = rows else {
            return work::run(py, || write_atomically(&path, &self.0.to_bytes()))?.map_err(raised(py));
        };
        work::run(py, || self.0.write_with_rows(&path, &rows))?.map_err(|error| match error {
            FleetError::File(error) => raised(py)(error),
            other => py_error(py, "FleetError", &other.to_string()),
        })
    }
}

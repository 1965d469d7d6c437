//! A unit in one row, and the populations behind the rows of many.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use fos_data::file::write_atomically;
use fos_diagnose::effects::Regressor;
use fos_fleet::{Asked, EstimateError, PROGRAM, Unit, UnitRow, asked_of, row_of};
use pyo3::prelude::*;
use serde_json::json;

use crate::diagnosis::library;
use crate::error::{raised, said};
use crate::recording::{Recording, options};
use crate::work;

/// A unit's name, its part, its lot.
type Named = (String, String, Option<String>);

fn asked(py: Python<'_>, regressors: Vec<String>, diagnosed: bool) -> PyResult<Asked> {
    for regressor in &regressors {
        Regressor::parse(regressor).map_err(|reason| {
            let wrong = EstimateError::Regressor { regressor: regressor.clone(), reason };
            said(py, "FleetError", &wrong.to_string())
        })?;
    }
    Ok(Asked { regressors, diagnosed, read: Default::default() })
}

fn unit((name, part, lot): Named, log: PathBuf) -> Unit {
    Unit { name, part, lot: lot.filter(|lot| !lot.is_empty()), log }
}

fn text_of(row: &UnitRow) -> String {
    json!(row).to_string()
}

/// The row of a log in a file, as JSON. What went wrong with the log is in it; `shown_as` is how it calls the file.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "they are the keywords of `fos_imu.unit_row`")]
pub(crate) fn unit_row(
    py: Python<'_>,
    path: PathBuf,
    shown_as: Option<String>,
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
        let unit = unit(named, path.clone());
        let bytes = path.metadata().map_or(0, |about| about.len());
        let mut row = match largest_bytes.filter(|largest| bytes > *largest) {
            Some(largest) => {
                let reason = format!(
                    "{}: {bytes} bytes are more than largest_bytes, {largest}\nhelp: a shorter log, or a larger limit",
                    path.display()
                );
                row_of(&unit, Err(&reason), &asked, &library, PROGRAM)
            }
            None => fos_fleet::unit_row(&unit, &asked, &library, PROGRAM),
        };
        if let Some(name) = shown_as {
            let path = path.display().to_string();
            row.failed.iter_mut().for_each(|reason| *reason = reason.replace(&path, &name));
        }
        text_of(&row)
    })
}

/// The row of a recording, as JSON.
#[pyfunction]
pub(crate) fn recording_row(
    py: Python<'_>,
    log: &Recording,
    named: Named,
    regressors: Vec<String>,
    diagnosed: bool,
    effects: Vec<PathBuf>,
) -> PyResult<String> {
    let asked = Asked { read: log.read.clone(), ..asked(py, regressors, diagnosed)? };
    let (library, log) = (library(py, &effects)?, Arc::clone(&log.log));
    work::run(py, || text_of(&row_of(&unit(named, PathBuf::new()), Ok(&log), &asked, &library, PROGRAM)))
}

/// Rows as they come, each held as numbers and not as text.
#[pyclass(frozen, module = "fos_imu._engine")]
pub(crate) struct Rows(Mutex<Vec<UnitRow>>);

#[pymethods]
impl Rows {
    #[new]
    fn new() -> Self {
        Self(Mutex::default())
    }

    /// Takes rows, JSON each.
    fn extend(&self, py: Python<'_>, texts: Vec<String>) -> PyResult<()> {
        let read = work::run(py, || -> Result<Vec<UnitRow>, (serde_json::Error, String)> {
            texts.into_iter().map(|text| serde_json::from_str(&text).map_err(|error| (error, text))).collect()
        })?;
        let rows = read.map_err(|(error, text)| {
            let start: String = text.chars().take(60).collect();
            let wrong = format!("{start:?} … is no row of a unit: {error}\nhelp: rows are what `unit_row` gives, or its `to_json()`");
            said(py, "FleetError", &wrong)
        })?;
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend(rows);
        Ok(())
    }

    /// What they come to.
    fn population(&self, py: Python<'_>, effects: Vec<PathBuf>) -> PyResult<Fleet> {
        let library = library(py, &effects)?;
        let found = work::run(py, || {
            let rows = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let asked = asked_of(&rows).map_err(|error| error.to_string())?;
            Ok(fos_fleet::Fleet::of(&rows, &asked, &library, PROGRAM))
        })?;
        found.map(Fleet).map_err(|error: String| said(py, "FleetError", &error))
    }
}

/// What a fleet comes to.
#[pyclass(frozen, module = "fos_imu._engine")]
pub(crate) struct Fleet(fos_fleet::Fleet);

#[pymethods]
impl Fleet {
    /// As JSON.
    fn json(&self) -> String {
        json!(self.0).to_string()
    }

    /// Writes it as the program does.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        work::run(py, || write_atomically(&path, &self.0.to_bytes()))?.map_err(raised(py))
    }
}

//! A study: fitted, compared, diagnosed, refined, and saved in the program's format.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use fos_data::file::compare_and_swap::FileVersion;
use fos_data::recording::{self as data, LoadOptions};
use fos_diagnose::compare::{Evaluation, compare_study, lags_off, study_of};
use fos_diagnose::effects::Library;
use fos_diagnose::refine::{Logs, Refiner};
use fos_diagnose::session::{Addition, NamedLogs, Wanted, add};
use fos_diagnose::study::{Refinement, Study as StudyFile, load_again};
use fos_figures::compare::View;
use fos_figures::curves::AxisCurves;
use fos_figures::moved;
use fos_figures::plots::figures;
use fos_figures::staircase::staircase;
use fos_fit::cost::Cost;
use fos_fit::export::image;
use fos_fit::fit::{fit_axes, rest};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::json;

use crate::diagnosis::{evidence_and_cost, library};
use crate::error::{Raised, py_error, raised};
use crate::options::Given;
use crate::recording::Recording;
use crate::work;

/// A model of one device with its logs and added effects. Changes from several threads are serialised, and become
/// visible when they are complete.
#[pyclass(frozen, module = "fos_imu._engine")]
pub(crate) struct Study {
    state: Mutex<State>,
    /// Held during a change.
    changing: Mutex<()>,
}

#[derive(Clone)]
struct State {
    study: StudyFile,
    /// Log of the fit, if it is in memory.
    own: Option<Arc<data::Recording>>,
    /// Path from which it was loaded or to which it was saved, and the version of that file.
    file: Option<FileVersion>,
    /// Logs on which an axis was refined, by its column.
    logs: Vec<(String, Arc<Logs>)>,
}

/// Logs given in a call, and how the log to explain was read.
struct GivenLogs {
    named: NamedLogs<Arc<data::Recording>>,
    read: Option<LoadOptions>,
}

impl GivenLogs {
    fn of(log: Option<&Recording>, reference: Option<&Recording>, evaluation: Option<&Recording>) -> Self {
        let recording = |log: Option<&Recording>| log.map(|log| Arc::clone(&log.log));
        Self {
            named: NamedLogs {
                log: recording(log),
                reference: recording(reference),
                evaluation: recording(evaluation),
            },
            read: log.map(|log| log.read.clone()),
        }
    }
}

/// Fits `axes` of the logs, which are used together.
#[pyfunction]
pub(crate) fn fit(
    py: Python<'_>,
    recordings: Vec<PyRef<'_, Recording>>,
    axes: Option<Vec<String>>,
    options: Given,
) -> PyResult<Study> {
    let options = options.options(py)?;
    let read = recordings.first().map(|first| first.read.clone()).unwrap_or_default();
    let logs: Vec<Arc<data::Recording>> = recordings.iter().map(|log| Arc::clone(&log.log)).collect();
    drop(recordings);
    let joined = match &logs[..] {
        [one] => Ok(Arc::clone(one)),
        several => data::Recording::join(several.iter().map(|log| (**log).clone()).collect()).map(Arc::new),
    };
    let log = joined.map_err(raised(py))?;
    let columns: Result<Vec<String>, _> = match &axes {
        None => log.axes(),
        Some(names) => names.iter().map(|name| Ok(log.axis(name)?.name.clone())).collect(),
    };
    let columns = columns.map_err(raised(py))?;
    if columns.is_empty() {
        return Err(py_error(py, "FitError", "no axis was named\nhelp: name one, as gx"));
    }
    let (stillness, fits) = work::run(py, || {
        let stillness = rest(&log, options.train);
        let fits: Result<Vec<_>, _> =
            fit_axes(&log, &stillness, &columns, &options, &|| {}).into_iter().collect();
        (stillness, fits)
    })?;
    let fits = fits.map_err(raised(py))?;
    let study = work::run(py, || study_of(&log, &stillness, fits, options, read, &mut |_| {}))?
        .map_err(raised(py))?;
    Ok(Study::of(State { study, own: Some(log), file: None, logs: Vec::new() }))
}

/// Reads a study written by this package or the program.
#[pyfunction]
pub(crate) fn load_study(py: Python<'_>, path: PathBuf) -> PyResult<Study> {
    let read = work::run(py, || StudyFile::read_to_change(&path))?;
    let (study, file) = read.map_err(raised(py))?;
    Ok(Study::of(State { study, own: None, file: Some(file), logs: Vec::new() }))
}

impl Study {
    fn of(state: State) -> Self {
        Self { state: Mutex::new(state), changing: Mutex::new(()) }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // Nothing panics while it holds the lock; if it did, the published study would still be complete.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn snapshot(&self) -> State {
        self.lock().clone()
    }

    /// Runs a change of the study after any change in progress.
    fn change<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut State) -> Result<T, Raised> + Send,
    ) -> PyResult<T> {
        work::run(py, || {
            let _turn = self.changing.lock().unwrap_or_else(PoisonError::into_inner);
            let mut state = self.snapshot();
            let result = work(&mut state)?;
            *self.lock() = state;
            Ok(result)
        })?
        .map_err(|raised: Raised| raised.exception(py))
    }
}

impl State {
    /// A log of the study: from memory, or read again from its path in the study.
    fn load(&self, source: &data::Source, read: &LoadOptions) -> Result<data::Recording, Raised> {
        let refined = self.logs.iter().flat_map(|(_, logs)| {
            [Some(&logs.log), logs.reference.as_ref(), logs.evaluation.as_ref()].into_iter().flatten()
        });
        let is_it = |log: &&data::Recording| log.sources.first() == Some(source);
        match (self.own.as_deref().into_iter().chain(refined).find(is_it), &self.file) {
            (Some(log), _) => Ok(log.clone()),
            (None, Some(file)) => Ok(load_again(source, file.path(), read)?),
            (None, None) => Err(Raised::of_study(format!(
                "{}: the log is not at hand\nhelp: give it in the call",
                source.path
            ))),
        }
    }

    /// Log of the fit.
    fn own(&self) -> Result<Arc<data::Recording>, Raised> {
        match &self.own {
            Some(own) => Ok(Arc::clone(own)),
            None => self.study.fitted_log(|source| self.load(source, &self.study.data.read)).map(Arc::new),
        }
    }

    /// Logs of a call: those given, otherwise those on which the axis was refined.
    fn logs(&self, column: &str, given: GivenLogs) -> Result<Arc<Logs>, Raised> {
        let GivenLogs { named, read } = given;
        let known = self.logs.iter().find(|(of, _)| of == column).map(|(_, logs)| Arc::clone(logs));
        if let (Some(known), NamedLogs { log: None, reference: None, evaluation: None }) = (known, &named) {
            return Ok(known);
        }
        let read = read.unwrap_or_else(|| self.study.read_options(column).clone());
        let may_be = |log: &Arc<data::Recording>, own: &data::Source| log.sources.first() == Some(own);
        let logs = named.load(&self.study, column, read.clone(), may_be, |wanted| match wanted {
            Wanted::Named(log) => Ok((**log).clone()),
            Wanted::Stored(source) => self.load(source, &read),
        })?;
        Ok(Arc::new(logs))
    }

    fn refinement(&self, refiner: &Refiner<'_>, logs: &Logs, column: &str) -> Result<Refinement, Raised> {
        Ok(match self.study.refinement_of(column) {
            Some(refinement) => refinement.clone(),
            None => refiner.begin(&self.study, column, logs.named(refiner.fitted_rows()))?,
        })
    }

    fn remember(&mut self, column: &str, logs: Arc<Logs>) {
        self.logs.retain(|(of, _)| of != column);
        self.logs.push((column.to_owned(), logs));
    }
}

/// Rows of a comparison of one axis: measured values, innovations, residual while coasting.
type AxisRows<'py> = [Bound<'py, PyArray1<f64>>; 3];

/// A model on a log, with the rows behind its figures.
#[pyclass(frozen, module = "fos_imu._engine")]
pub(crate) struct Evaluated {
    found: Evaluation,
    log: Arc<data::Recording>,
    /// Relative error of the lags in time, on a log of another rate.
    lags_off: Option<f64>,
}

#[pymethods]
impl Evaluated {
    /// The comparison as JSON.
    fn json(&self) -> String {
        json!(self.found.comparison).to_string()
    }

    #[getter]
    fn lags_off(&self) -> Option<f64> {
        self.lags_off
    }

    /// Timestamps of the evaluated rows, and the rows of each axis.
    fn rows<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f64>>, Vec<AxisRows<'py>>) {
        let trace = &self.found.trace;
        let array = |values: &[f64]| PyArray1::from_slice(py, values);
        let axes = trace.axes.iter().map(|axis| [&axis.measured, &axis.one_step, &axis.coast]);
        (
            array(&self.log.time_s[trace.rows.clone()]),
            axes.map(|series| series.map(|values| array(values))).collect(),
        )
    }

    /// Figures of an axis by name, as JSON.
    fn figures(&self, py: Python<'_>, index: usize) -> PyResult<String> {
        let Evaluation { comparison, trace, stillness } = &self.found;
        work::run(py, || {
            let axis = &comparison.axes[index];
            let curves = AxisCurves::of(axis, trace, index, &self.log);
            let moved = moved(&self.log, stillness);
            let is_of_order = |letter: char| !letter.is_alphabetic();
            let drawn = figures(View { axis, curves: &curves, moved: &moved }).into_iter();
            let named = drawn.map(|(name, figure)| (name.trim_start_matches(is_of_order), figure));
            json!(named.collect::<BTreeMap<_, _>>()).to_string()
        })
    }
}

#[pymethods]
impl Study {
    /// Content of the study's file.
    fn json(&self) -> PyResult<String> {
        let bytes = self.lock().study.to_bytes();
        String::from_utf8(bytes)
            .map_err(|error| pyo3::exceptions::PyUnicodeDecodeError::new_err(error.to_string()))
    }

    /// Refined axes with the figure of their steps, as JSON.
    fn history(&self) -> String {
        let study = self.snapshot().study;
        let entry = |refinement| json!({ "refinement": refinement, "figure": staircase(refinement) });
        json!(study.refinements.iter().map(entry).collect::<Vec<_>>()).to_string()
    }

    /// Columns of the axes.
    fn columns(&self) -> Vec<String> {
        self.lock().study.columns()
    }

    /// Cost of the whole model on the device, as JSON.
    fn cost(&self) -> String {
        json!(Cost::of(&self.lock().study.model)).to_string()
    }

    /// Path of the file, if it was loaded or saved.
    fn path(&self) -> Option<PathBuf> {
        self.lock().file.as_ref().map(|file| file.path().to_owned())
    }

    /// Compares the model with a log and with its rivals.
    fn compare(&self, py: Python<'_>, log: Option<&Recording>) -> PyResult<Evaluated> {
        let state = self.snapshot();
        let given = log.map(|log| Arc::clone(&log.log));
        let evaluation = work::run(py, || -> Result<_, Raised> {
            let (log, own) = match given {
                // The fitted log improves the noise estimate but is not required.
                Some(log) => (log, state.own().ok()),
                None => state.own().map(|own| (Arc::clone(&own), Some(own)))?,
            };
            let columns = state.study.columns();
            Ok((compare_study(&state.study, &columns, &log, own.as_deref(), &mut |_| {}), log))
        })?;
        let (found, log) = evaluation.map_err(|raised| raised.exception(py))?;
        let found = found.map_err(raised(py))?;
        Ok(Evaluated { found, lags_off: lags_off(&state.study.model, &log), log })
    }

    /// Diagnosis of the model of an axis on a log as JSON, with the evidence of each finding and its cost on the
    /// device.
    fn diagnose(
        &self,
        py: Python<'_>,
        log: Option<&Recording>,
        axis: Option<&str>,
        reference: Option<&Recording>,
        evaluation: Option<&Recording>,
        effects: Vec<PathBuf>,
    ) -> PyResult<(String, String)> {
        let library = library(py, &effects)?;
        let given = GivenLogs::of(log, reference, evaluation);
        let state = self.snapshot();
        work::run(py, || -> Result<_, Raised> {
            let column = state.study.column(axis)?;
            let logs = state.logs(&column, given)?;
            let refiner = logs.refiner(&library);
            let refinement = state.refinement(&refiner, &logs, &column)?;
            let diagnosis = refiner.diagnose(&refinement)?;
            let mut speaks = Vec::new();
            for finding in &diagnosis.findings {
                let evidence = refiner.evidence(&refinement, &diagnosis.findings, finding)?;
                let cost = refiner.price(&refinement, finding)?;
                let found = evidence.as_ref();
                speaks.push(evidence_and_cost(&logs.log, &column, &library, finding, found, cost)?);
            }
            Ok((json!(diagnosis).to_string(), json!(speaks).to_string()))
        })?
        .map_err(|raised| raised.exception(py))
    }

    /// Adds an effect, or the findings of the diagnosis until nothing is worth adding. Returns the column of the
    /// axis.
    #[expect(clippy::too_many_arguments, reason = "they are the keywords of `Study.add`")]
    fn add(
        &self,
        py: Python<'_>,
        effect: Option<String>,
        log: Option<&Recording>,
        axis: Option<String>,
        reference: Option<&Recording>,
        evaluation: Option<&Recording>,
        effects: Vec<PathBuf>,
    ) -> PyResult<String> {
        let library: Library = library(py, &effects)?;
        let given = GivenLogs::of(log, reference, evaluation);
        self.change(py, |state| {
            let column = state.study.column(axis.as_deref())?;
            let logs = state.logs(&column, given)?;
            let addition = effect.as_deref().map_or(Addition::Best, Addition::Effect);
            add(&mut state.study, &column, &logs, &library, addition, &mut |_, _| {})?;
            state.remember(&column, Arc::clone(&logs));
            Ok(column)
        })
    }

    /// Removes the effect that was added last and returns its identifier.
    fn undo(&self, py: Python<'_>, axis: Option<String>) -> PyResult<String> {
        self.change(py, |state| {
            let column = state.study.column_to_undo(axis.as_deref())?;
            Ok(state.study.undo(&column)?)
        })
    }

    /// Writes the study. Its own file is overwritten only if it is unchanged since; another file only with
    /// `replace`.
    fn save(&self, py: Python<'_>, path: PathBuf, replace: bool) -> PyResult<()> {
        self.change(py, |state| {
            let file = match &state.file {
                Some(file) if file.path() == path => file.clone(),
                _ => FileVersion::now(&path).map_err(Raised::of_study)?,
            };
            let is_own = state.file.as_ref().is_some_and(|known| known.path() == path);
            if !is_own && !replace && path.exists() {
                return Err(Raised::of_study(format!(
                    "{}: there is a file already\nhelp: save it with replace=True, or under another name",
                    path.display()
                )));
            }
            state.study.write(&file).map_err(Raised::of_study)?;
            state.file = Some(FileVersion::of(&path, &state.study.to_bytes()));
            Ok(())
        })
    }

    /// Image for a device.
    fn export_image<'py>(&self, py: Python<'py>, sensor: &str) -> PyResult<Bound<'py, PyBytes>> {
        let study = self.snapshot().study;
        let bytes = image(&study.model, sensor, &study.provenance());
        let bytes = bytes.map_err(|error| py_error(py, "ImageError", &error.to_string()))?;
        Ok(PyBytes::new(py, &bytes))
    }
}

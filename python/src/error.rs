//! Errors of the engine as exceptions of `fos_imu.errors`, with message, remedy, and file, line and column if known.

use std::fmt::Display;
use std::path::Path;

use fos_calibrate::CalibrateError;
use fos_data::file::FileError;
use fos_data::file::compare_and_swap::CompareAndSwapError;
use fos_data::recording::{BadRow, Place, RecordingError};
use fos_diagnose::compare::CompareError;
use fos_diagnose::detect::DiagnoseError;
use fos_diagnose::effects::EffectError;
use fos_diagnose::refine::RefineError;
use fos_diagnose::session::NoLog;
use fos_diagnose::study::{LogAgainError, StudyAxisError, StudyError};
use fos_fit::fit::AxisError;
use fos_fit::noise::AxisNoiseError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Location of an error, as far as it is known.
#[derive(Debug, Default)]
pub(crate) struct Location {
    file: Option<String>,
    line: Option<u64>,
    column: Option<String>,
}

impl Location {
    fn file(path: &Path) -> Self {
        Self { file: Some(path.display().to_string()), ..Self::default() }
    }

    fn row(path: &Path, row: &BadRow) -> Self {
        let line = match row.place {
            Place::Line { line, .. } | Place::Row(line) => line,
        };
        Self { line: Some(line), column: row.column.clone(), ..Self::file(path) }
    }

    fn column(name: &str) -> Self {
        Self { column: Some(name.to_owned()), ..Self::default() }
    }

    fn in_column(self, name: &str) -> Self {
        Self { column: Some(name.to_owned()), ..self }
    }
}

/// An error of the engine.
pub(crate) trait EngineError: Display {
    /// Class of its exception in `fos_imu.errors`, and its location.
    fn class_and_location(&self) -> (&'static str, Location);
}

/// Conversion for `map_err` on a call of the engine.
pub(crate) fn raised<E: EngineError>(py: Python<'_>) -> impl FnOnce(E) -> PyErr {
    move |error| Raised::from(error).exception(py)
}

/// An exception to be raised, made without Python.
pub(crate) struct Raised {
    class: &'static str,
    text: String,
    location: Location,
}

impl<E: EngineError> From<E> for Raised {
    fn from(error: E) -> Self {
        let (class, location) = error.class_and_location();
        Self { class, text: error.to_string(), location }
    }
}

impl From<NoLog> for Raised {
    fn from(none: NoLog) -> Self {
        Self::of_study(format!("{none}\nhelp: give it in the call"))
    }
}

impl Raised {
    pub(crate) fn of_study(text: impl Display) -> Self {
        Self { class: "StudyError", text: text.to_string(), location: Location::default() }
    }

    pub(crate) fn exception(self, py: Python<'_>) -> PyErr {
        exception(py, self.class, &self.text, self.location)
    }
}

/// Exception of this class with a message, and a remedy after `help:`.
pub(crate) fn py_error(py: Python<'_>, class: &str, text: &str) -> PyErr {
    exception(py, class, text, Location::default())
}

/// Exception for a defect of the engine.
pub(crate) fn defect(py: Python<'_>) -> PyErr {
    py_error(
        py,
        "InternalError",
        "an error in fos itself, which said what it was on standard error\nhelp: please report it, with what it said",
    )
}

fn exception(py: Python<'_>, class: &str, text: &str, location: Location) -> PyErr {
    let (message, remedy) = match text.split_once("\nhelp: ") {
        Some((message, remedy)) => (message, Some(remedy)),
        None => (text, None),
    };
    let made = || -> PyResult<PyErr> {
        let arguments = PyDict::new(py);
        arguments.set_item("remedy", remedy)?;
        arguments.set_item("file", location.file)?;
        arguments.set_item("line", location.line)?;
        arguments.set_item("column", location.column)?;
        let class = py.import("fos_imu.errors")?.getattr(class)?;
        Ok(PyErr::from_value(class.call((message,), Some(&arguments))?))
    };
    made().unwrap_or_else(|error| error)
}

impl EngineError for FileError {
    fn class_and_location(&self) -> (&'static str, Location) {
        ("FileError", Location::file(&self.path))
    }
}

impl EngineError for CalibrateError {
    fn class_and_location(&self) -> (&'static str, Location) {
        ("CalibrateError", Location::default())
    }
}

impl EngineError for RecordingError {
    fn class_and_location(&self) -> (&'static str, Location) {
        use RecordingError as E;
        let location = match self {
            E::File(error) => return error.class_and_location(),
            E::BadRow { path, row } | E::TooManyBadRows { path, first: row, .. } => Location::row(path, row),
            E::TextColumn { path, column, first } => match first {
                Some(row) => Location::row(path, row),
                None => Location::file(path),
            }
            .in_column(column),
            E::NotUnpacked { path, line, .. } => Location { line: Some(*line), ..Location::file(path) },
            E::OutOfOrder { path, column, .. }
            | E::UnknownColumn { path, column, .. }
            | E::NoClock { path, column }
            | E::HeaderUnit { path, column, .. }
            | E::NoSuchClock { path, column, .. } => Location::file(path).in_column(column),
            E::DuplicateColumn { path, name } => Location::file(path).in_column(name),
            E::Parquet { path, .. }
            | E::NotALog { path, .. }
            | E::NotBuiltIn { path, .. }
            | E::OtherFormat { path, .. }
            | E::NotOfFormat { path, .. }
            | E::Damaged { path, .. }
            | E::NoSensors { path, .. }
            | E::SeveralLogs { path, .. }
            | E::Undecided { path, .. }
            | E::NoEffect { path, .. }
            | E::NoHeader { path, .. }
            | E::TwoDevices { path }
            | E::GravityUnit { path, .. }
            | E::NoTime { path, .. }
            | E::TooFewRows { path, .. }
            | E::UnknownFormat { path } => Location::file(path),
            E::RatesDiffer { path, .. }
            | E::NothingInCommon { path, .. }
            | E::OtherSensor { path, .. }
            | E::Moves { path, .. }
            | E::NoAxes { path, .. } => Location::file(Path::new(path)),
            E::NoValues { path, name, .. } => Location::file(Path::new(path)).in_column(name),
            E::NoChannel { name, .. } | E::Lengths { name, .. } => Location::column(name),
            E::NothingToJoin | E::BadRate { .. } | E::Map(_) => Location::default(),
        };
        ("RecordingError", location)
    }
}

impl EngineError for AxisError {
    fn class_and_location(&self) -> (&'static str, Location) {
        let column = match self {
            Self::Recording(error) => return error.class_and_location(),
            Self::TooShort { column, .. }
            | Self::TooMany { column, .. }
            | Self::TwoPoses { column, .. }
            | Self::Constant { column, .. }
            | Self::Diverges { column, .. }
            | Self::Steady { column, .. }
            | Self::NotKnown { column }
            | Self::Candidates { column, .. }
            | Self::Search { column, .. }
            | Self::Autoregression { column, .. }
            | Self::Model { column, .. }
            | Self::TooManyPoses { column, .. } => column,
        };
        ("FitError", Location::column(column))
    }
}

impl EngineError for CompareError {
    fn class_and_location(&self) -> (&'static str, Location) {
        match self {
            Self::Recording(error) => error.class_and_location(),
            _ => ("CompareError", Location::default()),
        }
    }
}

impl EngineError for DiagnoseError {
    fn class_and_location(&self) -> (&'static str, Location) {
        let location = match self {
            Self::Recording(error) => return error.class_and_location(),
            Self::Effect(error) => return error.class_and_location(),
            Self::Stuck { column, .. } | Self::TooShort { column, .. } => Location::column(column),
            _ => Location::default(),
        };
        ("DiagnoseError", location)
    }
}

impl EngineError for EffectError {
    fn class_and_location(&self) -> (&'static str, Location) {
        let location = match self {
            Self::File(error) => return error.class_and_location(),
            Self::NotAnEffect { place, .. } | Self::Taken { place, .. } | Self::NoRival { place, .. } => {
                placed(place)
            }
            _ => Location::default(),
        };
        ("EffectError", location)
    }
}

/// Parses `file:line:column`, of which the last two may be missing.
fn placed(place: &str) -> Location {
    let mut parts = place.rsplitn(3, ':');
    let (last, before, file) = (parts.next(), parts.next(), parts.next());
    match (last.and_then(|n| n.parse::<u64>().ok()), before.and_then(|n| n.parse().ok()), file) {
        (Some(column), Some(line), Some(file)) => {
            Location { file: Some(file.to_owned()), line: Some(line), column: Some(column.to_string()) }
        }
        _ => Location::file(Path::new(place)),
    }
}

impl EngineError for RefineError {
    fn class_and_location(&self) -> (&'static str, Location) {
        match self {
            Self::Recording(error) => error.class_and_location(),
            Self::Diagnose(error) => error.class_and_location(),
            Self::Effect(error) => error.class_and_location(),
            Self::Study(error) => error.class_and_location(),
            Self::OtherLogs { column, .. } => ("RefineError", Location::column(column)),
            _ => ("RefineError", Location::default()),
        }
    }
}

impl EngineError for StudyAxisError {
    fn class_and_location(&self) -> (&'static str, Location) {
        let class = match self {
            Self::NoAxis { .. } | Self::SeveralAxes(_) => "StudyError",
            _ => "RefineError",
        };
        (class, Location::default())
    }
}

impl EngineError for StudyError {
    fn class_and_location(&self) -> (&'static str, Location) {
        let location = match self {
            Self::File(error) | Self::Unchanged(CompareAndSwapError::File(error)) => {
                return error.class_and_location();
            }
            Self::Unchanged(CompareAndSwapError::Changed(path)) => Location::file(path),
            Self::NotAStudy { path, line, column, .. } => Location {
                line: Some(*line as u64),
                column: Some(column.to_string()),
                ..Location::file(Path::new(path))
            },
            Self::Unsound { path, .. } | Self::Schema { path, .. } => Location::file(Path::new(path)),
        };
        ("StudyError", location)
    }
}

impl EngineError for LogAgainError {
    fn class_and_location(&self) -> (&'static str, Location) {
        let location = match self {
            Self::Recording(error) => return error.class_and_location(),
            Self::NotThere { log, .. } => Location::file(Path::new(log)),
            Self::Another { log, .. } => Location::file(log),
        };
        ("RecordingError", location)
    }
}

impl EngineError for AxisNoiseError {
    fn class_and_location(&self) -> (&'static str, Location) {
        let column = match self {
            Self::Recording(error) => return error.class_and_location(),
            Self::TooShort { column, .. } | Self::Constant { column, .. } => column,
        };
        ("NoiseError", Location::column(column))
    }
}

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
use fos_diagnose::study::{LogAgainError, StudyAxisError, StudyError};
use fos_fit::fit::AxisError;
use fos_fit::noise::AxisNoiseError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Location of an error.
#[derive(Debug, Default)]
struct Location {
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

/// An error of the engine, with the class of its exception and its location.
pub(crate) trait EngineError: Display {
    /// Class in `fos_imu.errors`.
    fn class(&self) -> &'static str;
    /// Location of the error.
    fn location(&self) -> Where {
        Where(Location::default())
    }
}

/// Location of an error, as far as it is known.
#[derive(Debug, Default)]
pub(crate) struct Where(Location);

/// Conversion for `map_err` on a call of the engine.
pub(crate) fn raised<E: EngineError>(py: Python<'_>) -> impl FnOnce(E) -> PyErr {
    move |error| exception(py, error.class(), &error.to_string(), error.location().0)
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
    fn class(&self) -> &'static str {
        "FileError"
    }

    fn location(&self) -> Where {
        Where(Location::file(&self.path))
    }
}

impl EngineError for CalibrateError {
    fn class(&self) -> &'static str {
        "CalibrateError"
    }
}

impl EngineError for RecordingError {
    fn class(&self) -> &'static str {
        match self {
            Self::File(error) => error.class(),
            _ => "RecordingError",
        }
    }

    fn location(&self) -> Where {
        use RecordingError as E;
        Where(match self {
            E::File(error) => return error.location(),
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
        })
    }
}

impl EngineError for AxisError {
    fn class(&self) -> &'static str {
        match self {
            Self::Recording(error) => error.class(),
            _ => "FitError",
        }
    }

    fn location(&self) -> Where {
        Where(match self {
            Self::Recording(error) => return error.location(),
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
            | Self::TooManyPoses { column, .. } => Location::column(column),
        })
    }
}

impl EngineError for CompareError {
    fn class(&self) -> &'static str {
        match self {
            Self::Recording(error) => error.class(),
            _ => "CompareError",
        }
    }

    fn location(&self) -> Where {
        match self {
            Self::Recording(error) => error.location(),
            _ => Where::default(),
        }
    }
}

impl EngineError for DiagnoseError {
    fn class(&self) -> &'static str {
        match self {
            Self::Recording(error) => error.class(),
            Self::Effect(error) => error.class(),
            _ => "DiagnoseError",
        }
    }

    fn location(&self) -> Where {
        match self {
            Self::Recording(error) => error.location(),
            Self::Effect(error) => error.location(),
            Self::Stuck { column, .. } | Self::TooShort { column, .. } => Where(Location::column(column)),
            _ => Where::default(),
        }
    }
}

impl EngineError for EffectError {
    fn class(&self) -> &'static str {
        match self {
            Self::File(error) => error.class(),
            _ => "EffectError",
        }
    }

    fn location(&self) -> Where {
        match self {
            Self::File(error) => error.location(),
            Self::NotAnEffect { place, .. } | Self::Taken { place, .. } | Self::NoRival { place, .. } => {
                Where(placed(place))
            }
            _ => Where::default(),
        }
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
    fn class(&self) -> &'static str {
        match self {
            Self::Recording(error) => error.class(),
            Self::Diagnose(error) => error.class(),
            Self::Effect(error) => error.class(),
            Self::Study(StudyAxisError::NoAxis { .. } | StudyAxisError::SeveralAxes(_)) => "StudyError",
            _ => "RefineError",
        }
    }

    fn location(&self) -> Where {
        match self {
            Self::Recording(error) => error.location(),
            Self::Diagnose(error) => error.location(),
            Self::Effect(error) => error.location(),
            Self::OtherLogs { column, .. } => Where(Location::column(column)),
            _ => Where::default(),
        }
    }
}

impl EngineError for StudyError {
    fn class(&self) -> &'static str {
        match self {
            Self::File(error) | Self::Unchanged(CompareAndSwapError::File(error)) => error.class(),
            _ => "StudyError",
        }
    }

    fn location(&self) -> Where {
        Where(match self {
            Self::File(error) | Self::Unchanged(CompareAndSwapError::File(error)) => return error.location(),
            Self::Unchanged(CompareAndSwapError::Changed(path)) => Location::file(path),
            Self::NotAStudy { path, line, column, .. } => Location {
                line: Some(*line as u64),
                column: Some(column.to_string()),
                ..Location::file(Path::new(path))
            },
            Self::Unsound { path, .. } | Self::Schema { path, .. } => Location::file(Path::new(path)),
        })
    }
}

impl EngineError for LogAgainError {
    fn class(&self) -> &'static str {
        match self {
            Self::Recording(error) => error.class(),
            _ => "RecordingError",
        }
    }

    fn location(&self) -> Where {
        match self {
            Self::Recording(error) => error.location(),
            Self::NotThere { log, .. } => Where(Location::file(Path::new(log))),
            Self::Another { log, .. } => Where(Location::file(log)),
        }
    }
}

impl EngineError for AxisNoiseError {
    fn class(&self) -> &'static str {
        match self {
            Self::Recording(error) => error.class(),
            _ => "NoiseError",
        }
    }

    fn location(&self) -> Where {
        Where(match self {
            Self::Recording(error) => return error.location(),
            Self::TooShort { column, .. } | Self::Constant { column, .. } => Location::column(column),
        })
    }
}

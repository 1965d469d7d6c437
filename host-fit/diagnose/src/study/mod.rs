//! A study: the user's work in one file, with the data and their digest, the settings, the model, and the errors of
//! every step.

mod axes;
mod calibration;
mod check;
mod logs;
mod refinement;

use std::path::Path;

use serde::{Deserialize, Serialize};

pub use axes::StudyAxisError;
pub use calibration::OtherDevice;
pub use logs::{LogAgainError, load_again};
pub use refinement::{Added, Left, LogSources, Refinement, RefinementStep};

use fos_data::file::compare_and_swap::{CompareAndSwapError, FileVersion};
use fos_data::file::{self, FileError};
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::schema::{Refused, from_json};
use fos_data::stillness::KnownBy;
use fos_data::visible::visible;
use fos_fit::evaluate::ModelErrors;
use fos_fit::fit::{AxisReport, FitOptions};
use fos_fit::model::UnitModel;

/// Schema that this program writes, the only one it reads.
pub const SCHEMA: &str = "fos-study/1";

/// A self-contained study: with its data, every result can be reproduced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// [`SCHEMA`].
    pub schema: String,
    /// Program that wrote the study.
    pub tool: Tool,
    /// Recording that was fitted.
    pub data: Data,
    pub settings: FitOptions,
    /// Model in its present state.
    pub model: UnitModel,
    /// Report of the fit of each axis.
    pub axes: Vec<AxisReport>,
    /// Simpler rivals and states of the model, in order, with their errors on data that were not fitted.
    pub steps: Vec<StudyStep>,
    /// Axes that effects were added to.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refinements: Vec<Refinement>,
}

/// Program that wrote a study.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Tool {
    /// Name of the program on the command line.
    pub name: String,
    pub version: String,
}

/// Recording behind a study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Data {
    /// File, size and digest of every log.
    pub sources: Vec<Source>,
    #[serde(flatten)]
    pub read: LoadOptions,
    /// Number of rows read.
    pub rows: usize,
    /// Number of rows, from the first on, that the model was fitted to.
    pub trained_rows: usize,
    /// True sampling rate, Hz.
    pub true_rate_hz: f64,
    /// Number of stretches without gaps.
    pub segments: usize,
    /// Source of the information where the device is at rest.
    pub still_known_by: KnownBy,
    /// Share of the rows at rest.
    pub still_share: f64,
}

/// State of the model, with its errors on the evaluation rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StudyStep {
    /// Name of the rival or of the step.
    pub name: String,
    pub errors: Vec<ModelErrors>,
}

/// A study that cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    #[error(transparent)]
    File(#[from] FileError),
    /// The file cannot be written back.
    #[error(transparent)]
    Unchanged(#[from] CompareAndSwapError),
    #[error("{path}:{line}:{column}: not a study: {reason}\nhelp: a study is what a fit writes")]
    NotAStudy {
        path: String,
        /// Line of the error, from 1.
        line: usize,
        /// Column of the error, from 1.
        column: usize,
        reason: String,
    },
    /// The fields contradict one another.
    #[error("{path}: {reason}: such a study was not written by this program\nhelp: fit the log again")]
    Unsound { path: String, reason: String },
    #[error(
        "{path}: schema {found:?}; this program reads {SCHEMA:?}\nhelp: fit again, or use the program that wrote it"
    )]
    Schema { path: String, found: String },
}

impl Tool {
    pub fn this() -> Self {
        Self { name: "fos".to_owned(), version: env!("CARGO_PKG_VERSION").to_owned() }
    }
}

impl Data {
    /// Returns true if `recording` is the one that was fitted.
    pub fn is(&self, recording: &Recording) -> bool {
        self.rows == recording.n_rows() && self.sources == recording.sources
    }
}

impl Study {
    /// Reads a study.
    pub fn read(path: &Path) -> Result<Self, StudyError> {
        Ok(Self::read_to_change(path)?.0)
    }

    /// Reads a study that will be written back.
    pub fn read_to_change(path: &Path) -> Result<(Self, FileVersion), StudyError> {
        let bytes = file::read(path)?;
        let refused = |refused| match (refused, path.display().to_string()) {
            (Refused::NotJson { line, column, reason }, path) => {
                StudyError::NotAStudy { path, line, column, reason }
            }
            (Refused::Schema(found), path) => StudyError::Schema { path, found },
        };
        let study: Self = from_json(&bytes, SCHEMA).map_err(refused)?;
        study.check().map_err(|reason| StudyError::Unsound { path: path.display().to_string(), reason })?;
        Ok((study, FileVersion::of(path, &bytes)))
    }

    /// Writes the study atomically, provided that the file is unchanged since it was read; stores the paths of its logs
    /// relative to it. A file that cannot be written, or that another process has written meanwhile, is unchanged.
    pub fn write(&mut self, file: &FileVersion) -> Result<(), StudyError> {
        self.note_places(file.path());
        Ok(file.replace(&self.to_bytes())?)
    }

    /// Returns the bytes of the study's file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut text = serde_json::to_vec_pretty(self).expect("a study has only string keys");
        text.push(b'\n');
        text
    }

    /// Joins studies of single axes that were fitted to one log with the same settings; `None` without any.
    pub fn joined(studies: impl IntoIterator<Item = Self>) -> Option<Self> {
        studies.into_iter().reduce(|mut all, other| {
            all.model.absorb(other.model);
            all.axes.extend(other.axes);
            for (step, other) in all.steps.iter_mut().zip(other.steps) {
                step.errors.extend(other.errors);
            }
            all
        })
    }

    /// Describes the origin of the model in a few lines.
    pub fn provenance(&self) -> String {
        let data = self
            .data
            .sources
            .iter()
            .map(|Source { path, sha256, read_as, .. }| {
                let stated = read_as.as_ref().and_then(|read_as| read_as.provenance.as_ref());
                let stated = stated.map_or_else(String::new, |stated| format!(", {stated}"));
                format!("data {}, sha256 {sha256}{stated}", file::name_of(path))
            })
            .map(|line| visible(&line).into_owned());
        let data = data.collect::<Vec<_>>().join("\n");
        let calibrated = self.model.calibration.iter().flat_map(|calibration| &calibration.sources);
        let calibrated = calibrated.map(|source| {
            format!("calibrated with {}, sha256 {}", file::name_of(&source.path), source.sha256)
        });
        let calibrated: String = calibrated.map(|line| format!("\n{}", visible(&line))).collect();
        format!(
            "{} {}\n{data}{calibrated}\nfitted to {} of {} rows at {:.3} Hz",
            visible(&self.tool.name),
            visible(&self.tool.version),
            self.data.trained_rows,
            self.data.rows,
            self.data.true_rate_hz
        )
    }
}

//! Pieces of work on one study.

use std::sync::Arc;

use fos_data::column::Column;
use fos_data::file::name_of;
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_diagnose::refine::Logs;
use fos_diagnose::study::{LogSources, Study};
use serde::Serialize;

use super::job::Job;

/// A piece of work on one study.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Task {
    /// Read the logs.
    Read(Open),
    /// Fit an axis.
    Fit(String),
    /// Compare its model with the log to explain.
    Examine(String),
    /// Identify the effects missing from its model.
    Diagnose(String),
    /// Look for a slow signal that the diagnosed axes share.
    ShareSignal,
    /// Add an effect to an axis.
    Add {
        /// Column, such as `gx_rads`.
        column: String,
        /// Identifier of the effect, such as `thermal_lag`.
        effect: String,
    },
    /// Remove the last effects of an axis.
    Undo {
        /// Column, such as `gx_rads`.
        column: String,
        /// Number of effects that stay.
        keep: usize,
    },
}

/// Logs that a study is opened with.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Open {
    /// The built-in example, written to this folder.
    Example(std::path::PathBuf),
    /// Logs of the user.
    Logs(LogFiles),
    /// The logs of a study that was stored.
    Stored(Arc<Study>),
}

/// Paths of the logs of a study, and how they are read.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct LogFiles {
    /// The log to explain.
    pub(super) log: String,
    /// The reference log.
    pub(super) reference: Option<String>,
    /// The evaluation log.
    pub(super) evaluation: Option<String>,
    pub(super) read: LoadOptions,
}

impl LogFiles {
    /// Files of the logs of a stored study.
    fn of_stored(logs: &LogSources) -> Self {
        let path = |source: &Source| source.path.clone();
        Self {
            log: path(&logs.log),
            reference: logs.reference.as_ref().map(path),
            evaluation: logs.evaluation.as_ref().map(path),
            read: logs.read.clone(),
        }
    }

    /// Files of logs that were read.
    pub(super) fn of(logs: &Logs) -> Self {
        Self {
            log: logs.log.paths(),
            reference: logs.reference.as_ref().map(Recording::paths),
            evaluation: logs.evaluation.as_ref().map(Recording::paths),
            read: logs.read.clone(),
        }
    }
}

impl Open {
    /// Returns the logs; none for an example that is not written yet.
    pub(super) fn files(&self) -> Option<LogFiles> {
        match self {
            Self::Example(_) => None,
            Self::Logs(files) => Some(files.clone()),
            Self::Stored(study) => {
                study.refinements.first().map(|refinement| LogFiles::of_stored(&refinement.logs))
            }
        }
    }

    pub(super) fn name(&self) -> String {
        match self {
            Self::Example(_) => "Example".to_owned(),
            Self::Logs(LogFiles { log, .. }) => name_of(log),
            Self::Stored(_) => self.files().map_or_else(String::new, |files| name_of(&files.log)),
        }
    }
}

impl Task {
    /// Returns the job that describes the task.
    pub(super) fn job(&self, asked_for: bool) -> Job {
        let words = match self {
            Self::Read(Open::Example(_)) => "simulating the example".to_owned(),
            Self::Read(open) => format!("reading {}", open.name()),
            Self::Fit(column) => format!("fitting {}", Column::named(column).label()),
            Self::Examine(column) => format!("comparing {}", Column::named(column).label()),
            Self::Diagnose(column) => {
                format!("diagnosing {}", Column::named(column).label())
            }
            Self::ShareSignal => "looking for a slow signal that axes share".to_owned(),
            Self::Add { column, effect } => format!("adding {effect} to {}", Column::named(column).label()),
            Self::Undo { column, .. } => format!("removing effects of {}", Column::named(column).label()),
        };
        Job::new(words, asked_for)
    }

    /// Returns true for a task that gives an axis another model.
    pub(super) fn changes_model(&self) -> bool {
        matches!(self, Self::Fit(_) | Self::Add { .. } | Self::Undo { .. })
    }

    /// Returns the axis of the task; none for a task on all axes.
    pub(super) fn column(&self) -> Option<&str> {
        match self {
            Self::Read(_) | Self::ShareSignal => None,
            Self::Fit(column) | Self::Examine(column) | Self::Diagnose(column) => Some(column),
            Self::Add { column, .. } | Self::Undo { column, .. } => Some(column),
        }
    }
}

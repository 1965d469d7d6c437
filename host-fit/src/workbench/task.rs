//! A piece of work on one study, as it waits to be done.

use fos_data::column::Column;
use fos_data::file::name_of;
use fos_data::recording::{LoadOptions, Recording};
use fos_diagnose::refine::Logs;

use super::job::Job;

/// A piece of work on one study.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Task {
    /// Read the logs.
    Read(Open),
    /// Fit an axis.
    Fit(String),
    /// Hold its model against the field log.
    Examine(String),
    /// Say what is missing from it.
    Diagnose(String),
    /// Look for a slow signal that the diagnosed axes share.
    ShareSignal,
    /// Add an effect to it.
    Add {
        /// Its column, as `gx_rads`.
        column: String,
        /// Its identifier, as `thermal_lag`.
        effect: String,
    },
    /// Take effects back.
    Undo {
        /// Its column, as `gx_rads`.
        column: String,
        /// So many are kept.
        keep: usize,
    },
}

/// Which logs a study is of.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Open {
    /// The built-in example, written to this folder.
    Example(std::path::PathBuf),
    /// Logs of the user's.
    Logs {
        /// Where the model fails.
        field: String,
        /// A quiet log.
        quiet: Option<String>,
        /// A log to judge on.
        judged: Option<String>,
        /// How they are read.
        read: LoadOptions,
    },
}

impl Open {
    /// The same logs, read in another way.
    pub(super) fn again(logs: &Logs, read: LoadOptions) -> Self {
        Self::Logs {
            field: logs.field.paths(),
            quiet: logs.quiet.as_ref().map(Recording::paths),
            judged: logs.judged.as_ref().map(Recording::paths),
            read,
        }
    }

    pub(super) fn name(&self) -> String {
        match self {
            Self::Example(_) => "Example".to_owned(),
            Self::Logs { field, .. } => name_of(field),
        }
    }
}

impl Task {
    /// The job of doing it.
    pub(super) fn job(&self, asked_for: bool) -> Job {
        let words = match self {
            Self::Read(Open::Example(_)) => "simulating the example".to_owned(),
            Self::Read(open) => format!("reading {}", open.name()),
            Self::Fit(column) => format!("fitting {}", Column::named(column).label()),
            Self::Examine(column) => format!("comparing {}", Column::named(column).label()),
            Self::Diagnose(column) => {
                format!("looking for what is missing from {}", Column::named(column).label())
            }
            Self::ShareSignal => "looking for a slow signal that axes share".to_owned(),
            Self::Add { column, effect } => format!("adding {effect} to {}", Column::named(column).label()),
            Self::Undo { column, .. } => format!("taking effects of {} back", Column::named(column).label()),
        };
        Job::new(words, asked_for)
    }

    /// The axis that it is of; none if it is of all.
    pub(super) fn column(&self) -> Option<&str> {
        match self {
            Self::Read(_) | Self::ShareSignal => None,
            Self::Fit(column) | Self::Examine(column) | Self::Diagnose(column) => Some(column),
            Self::Add { column, .. } | Self::Undo { column, .. } => Some(column),
        }
    }
}

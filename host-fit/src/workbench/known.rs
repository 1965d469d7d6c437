//! What is known of a study: its logs, its axes as far as they are computed; what a task sees of it, and what it
//! changes.

use std::sync::Arc;

use crate::examine::Examination;
use crate::report::{AxisSection, Summaries};
use fos_diagnose::detect::Diagnosis;
use fos_diagnose::refine::Logs;
use fos_diagnose::study::{Refinement, Study};

/// The logs of a study, as read.
pub(super) struct Read {
    pub(super) logs: Logs,
    pub(super) summaries: Summaries,
    /// The axes that the log to explain has.
    pub(super) axes: Vec<String>,
    /// The study that the logs were stored with.
    pub(super) stored: Option<Arc<Study>>,
}

/// An axis as far as it is known.
#[derive(Clone)]
pub(super) struct KnownAxis {
    /// The axis alone, as it was fitted.
    pub(super) fitted: Option<Arc<Study>>,
    /// Why the axis has no model, comparison or diagnosis: not tried again unless somebody looks at the axis.
    pub(super) failure: Option<String>,
    pub(super) refinement: Option<Refinement>,
    pub(super) examination: Option<Arc<Examination>>,
    /// It is of the model as it is; otherwise of the one before, whose picture stays until there is another.
    pub(super) examined: bool,
    /// The model before any effect was added, while there are any.
    pub(super) before: Option<Arc<Examination>>,
    /// The diagnosis as it is without the other axes; that of the section also states a signal that axes share.
    pub(super) alone: Option<Diagnosis>,
    pub(super) section: AxisSection,
}

impl KnownAxis {
    pub(super) fn unknown(column: &str) -> Self {
        Self {
            fitted: None,
            failure: None,
            refinement: None,
            examination: None,
            examined: false,
            before: None,
            alone: None,
            section: AxisSection::empty(column),
        }
    }
}

/// What a task may look at: as it was when the task began.
pub(super) struct Snapshot {
    pub(super) read: Option<Arc<Read>>,
    pub(super) axes: Vec<KnownAxis>,
}

impl Snapshot {
    /// The logs.
    ///
    /// # Errors
    ///
    /// They are not read.
    pub(super) fn read(&self) -> Result<&Read, String> {
        self.read.as_deref().ok_or_else(|| "the logs could not be read".to_owned())
    }

    /// An axis that is fitted: the axis alone, and its refinement.
    ///
    /// # Errors
    ///
    /// It is not fitted.
    pub(super) fn fitted(&self, column: &str) -> Result<(&Study, &Refinement), String> {
        let known = self.axes.iter().find(|axis| axis.section.column == column);
        known
            .and_then(|axis| axis.fitted.as_deref().zip(axis.refinement.as_ref()))
            .ok_or_else(|| format!("{column} could not be fitted"))
    }
}

/// What a task changes, once it is done.
pub(super) enum Change {
    /// The logs are there.
    Read {
        /// Logs, what is said of them, and their axes.
        read: Box<Read>,
        /// The axis to look at first.
        first: Option<String>,
    },
    /// The diagnoses of several axes, by column.
    Diagnoses(Vec<Diagnosis>),
    /// What is known of an axis.
    Axis {
        /// Its column, as `gx_rads`.
        column: String,
        /// How it changes.
        edit: Box<dyn FnOnce(&mut KnownAxis) + Send>,
    },
}

//! Results of a study: its logs, and its axes as far as they are computed; input and output of a task.

use std::sync::Arc;

use fos_calibrate::Calibration;
use fos_diagnose::detect::Diagnosis;
use fos_diagnose::refine::Logs;
use fos_diagnose::study::{Refinement, Study};
use fos_report::examine::Examination;
use fos_report::{AxisSection, Summaries};

/// The logs of a study, as read.
pub(super) struct Read {
    pub(super) logs: Logs,
    pub(super) summaries: Summaries,
    /// Axes of the log to explain.
    pub(super) axes: Vec<String>,
    /// Calibration by hand, if the log to explain has enough orientations.
    pub(super) calibration: Option<Calibration>,
    /// Study that the logs were stored with.
    pub(super) stored: Option<Arc<Study>>,
}

/// Results for an axis so far.
#[derive(Clone, Default)]
pub(super) struct KnownAxis {
    /// Study of the axis alone, as fitted.
    pub(super) fitted: Option<Arc<Study>>,
    /// Reason why the axis has no model, comparison or diagnosis: not tried again unless a user opens the axis.
    pub(super) failure: Option<String>,
    pub(super) refinement: Option<Refinement>,
    pub(super) examination: Option<Arc<Examination>>,
    /// True if `examination` is of the present model; otherwise it is of the one before, shown until the new one is
    /// there.
    pub(super) examined: bool,
    /// Examination of the model before any effect was added, while there are any.
    pub(super) before: Option<Arc<Examination>>,
    /// Diagnosis without the other axes; that of the section also states a signal that axes share.
    pub(super) alone: Option<Diagnosis>,
    pub(super) section: AxisSection,
}

impl KnownAxis {
    pub(super) fn unknown(column: &str) -> Self {
        Self { section: AxisSection::empty(column), ..Self::default() }
    }
}

/// Input of a task: the state at its start.
pub(super) struct Snapshot {
    pub(super) read: Option<Arc<Read>>,
    pub(super) axes: Vec<KnownAxis>,
}

impl Snapshot {
    /// Returns the logs.
    pub(super) fn read(&self) -> Result<&Read, String> {
        self.read.as_deref().ok_or_else(|| "the logs could not be read".to_owned())
    }

    /// Returns a fitted axis: the study of the axis alone, and its refinement.
    pub(super) fn fitted(&self, column: &str) -> Result<(&Study, &Refinement), String> {
        let known = self.axes.iter().find(|axis| axis.section.column == column);
        known
            .and_then(|axis| axis.fitted.as_deref().zip(axis.refinement.as_ref()))
            .ok_or_else(|| format!("{column} could not be fitted"))
    }
}

/// Output of a task.
pub(super) enum Change {
    /// The logs were read.
    Read {
        /// Logs with their summaries and axes.
        read: Box<Read>,
        /// Axis to open first.
        first: Option<String>,
    },
    /// The diagnoses of several axes, by column.
    Diagnoses(Vec<Diagnosis>),
    /// Results for an axis.
    Axis {
        /// Column, such as `gx_rads`.
        column: String,
        /// Function that updates the results.
        edit: Box<dyn FnOnce(&mut KnownAxis) + Send>,
    },
}

//! Data of a study for the page: with every change, in the list of all studies, and when the study is open.

use serde::Serialize;

use super::job::Job;
use super::known::KnownAxis;
use super::standing::{Outcome, Standing, pays};
use super::state::State;
use super::task::LogFiles;
use fos_diagnose::compare::AxisComparison;
use fos_diagnose::study::Refinement;
use fos_report::command_lines::command_lines;
use fos_report::{AxisSection, AxisUnits, Summaries, UnitChoice};

/// Status that is sent to the page with every change.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct StatusEvent {
    pub(super) revision: u64,
    pub(super) job: Option<Job>,
}

/// A study in a list.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Entry {
    id: u64,
    name: String,
    /// Worst outcome of its axes.
    outcome: Option<Outcome>,
    working: bool,
    /// Open axis with its results, for comparing studies side by side.
    axis: Option<AxisEntry>,
}

/// An axis in a list.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
struct AxisEntry {
    column: String,
    label: String,
    unit: String,
    sentence: Option<String>,
    /// Effects that were added, in order.
    added: Vec<String>,
    /// RMS of the slow error in a free run, in `unit`, as in [`AxisPage`]: of the constant mean, and of the model.
    slow_error: Option<[Option<f64>; 2]>,
    errors_in: UnitChoice,
}

fn slow_error(section: &AxisSection) -> Option<[Option<f64>; 2]> {
    section.comparison.as_ref().map(AxisComparison::slow_errors)
}

impl AxisEntry {
    fn of(axis: &KnownAxis) -> Self {
        Self {
            column: axis.section.column.clone(),
            label: axis.section.label.clone(),
            unit: axis.section.unit.clone(),
            sentence: axis.section.diagnosis.as_ref().map(|found| found.sentence.clone()),
            added: axis
                .refinement
                .iter()
                .flat_map(Refinement::added)
                .map(|added| added.effect.id.clone())
                .collect(),
            slow_error: slow_error(&axis.section),
            errors_in: AxisUnits::of(&axis.section).errors,
        }
    }
}

/// Everything that a page shows of a study, except time series.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Page {
    id: u64,
    name: String,
    revision: u64,
    job: Option<Job>,
    error: Option<String>,
    /// Logs that were requested last; none for an example that is not written yet.
    files: Option<LogFiles>,
    logs: Option<Summaries>,
    /// True if rows with detected motion are used like any others.
    keeps_moved: bool,
    /// Worst outcome of its axes; an all-clear only once all are diagnosed.
    outcome: Option<Outcome>,
    /// True if the log to explain has enough orientations for a calibration by hand.
    is_turned: bool,
    /// True if every axis that can have a model has one, so that the study can be exported.
    is_whole: bool,
    axis: Option<String>,
    axes: Vec<AxisPage>,
    commands: Vec<String>,
}

/// Axis with its standing and the units in which its numbers are shown.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct AxisPage {
    #[serde(flatten)]
    section: AxisSection,
    standing: Option<Standing>,
    /// Reason why there is no model, comparison or diagnosis.
    failure: Option<String>,
    /// RMS of the slow error in a free run, in the axis' unit: of the constant mean, and of the model.
    slow_error: Option<[Option<f64>; 2]>,
    /// One entry per refinement step: true if its effect reduces the error by more than noise.
    pays: Vec<bool>,
    units: AxisUnits,
}

impl AxisPage {
    fn of(axis: &KnownAxis) -> Self {
        let section = axis.section.clone();
        let refinement = axis.refinement.as_ref();
        let steps = refinement.map_or(&[][..], |refinement| &refinement.steps);
        Self {
            standing: section.diagnosis.as_ref().map(|diagnosis| Standing::of(diagnosis, refinement)),
            failure: axis.failure.clone(),
            slow_error: slow_error(&section),
            pays: steps
                .iter()
                .take(1)
                .map(|_| true)
                .chain(steps.windows(2).map(|two| pays(&two[0], &two[1])))
                .collect(),
            units: AxisUnits::of(&section),
            section,
        }
    }
}

impl StatusEvent {
    pub(super) fn of(state: &State) -> Self {
        Self { revision: state.revision, job: state.queue.job() }
    }
}

impl Entry {
    pub(super) fn of(id: u64, state: &State, has_begun: bool) -> Self {
        let looked_at = state.looked_at.as_ref().and_then(|column| state.known(column).ok());
        Self {
            id,
            name: state.name.clone(),
            outcome: state.outcome(),
            working: has_begun && state.queue.job().is_some(),
            axis: looked_at.map(AxisEntry::of),
        }
    }
}

impl Page {
    pub(super) fn of(id: u64, state: &State) -> Self {
        let fitted = state.axes.iter().find_map(|axis| axis.fitted.as_deref());
        let seen = state.axes.iter().filter(|axis| axis.examination.is_some());
        let refined = seen.map(|axis| (axis.section.column.as_str(), axis.refinement.as_ref()));
        let commands = match (fitted, &state.read) {
            (Some(fitted), Some(read)) => {
                command_lines(&fitted.data.sources, &fitted.settings, &read.logs, refined)
            }
            _ => Vec::new(),
        };
        Self {
            id,
            name: state.name.clone(),
            revision: state.revision,
            job: state.queue.job(),
            error: state.error.clone(),
            files: state.files.clone(),
            logs: state.read.as_ref().map(|read| read.summaries.clone()),
            keeps_moved: state.read.as_ref().is_some_and(|read| read.logs.read.keep_moved),
            outcome: state.outcome(),
            is_turned: state.read.as_ref().is_some_and(|read| read.calibration.is_some()),
            is_whole: fitted.is_some() && state.unfitted().next().is_none(),
            axis: state.looked_at.clone(),
            axes: state.axes.iter().map(AxisPage::of).collect(),
            commands,
        }
    }
}

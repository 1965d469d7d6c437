//! What a page is told of a study: with every change, in the list of all, and when it is looked at.

use serde::Serialize;

use super::job::Job;
use super::known::KnownAxis;
use super::standing::{Outcome, Standing, pays};
use super::state::State;
use super::task::LogFiles;
use crate::command_lines::command_lines;
use crate::report::{AxisSection, AxisUnits, Summaries, UnitChoice};
use fos_diagnose::compare::AxisComparison;
use fos_diagnose::study::{Refinement, RefinementStep};

/// What a page is told without asking.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Beat {
    pub(super) revision: u64,
    pub(super) job: Option<Job>,
}

/// A study in a list.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Entry {
    id: u64,
    name: String,
    /// The worst of its axes.
    outcome: Option<Outcome>,
    working: bool,
    /// The axis that is looked at, with what is known of it: what studies are held side by side by.
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
    /// Root of the variance of the 1-s means that are left on unseen data, before the first effect and now, in the
    /// unit.
    slow_before: Option<f64>,
    slow_now: Option<f64>,
    errors_in: UnitChoice,
}

impl AxisEntry {
    fn of(axis: &KnownAxis) -> Self {
        let steps = axis.refinement.as_ref().map_or(&[][..], |refinement| &refinement.steps);
        let slow = |step: Option<&RefinementStep>| step.map(|step| step.left.slow.sqrt());
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
            slow_before: slow(steps.first()),
            slow_now: slow(steps.last()),
            errors_in: AxisUnits::of(&axis.section).errors,
        }
    }
}

/// All that a page shows of a study, but for what is drawn sample by sample.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Page {
    id: u64,
    name: String,
    revision: u64,
    job: Option<Job>,
    error: Option<String>,
    /// The logs that were asked for last; absent of an example that is not written yet.
    files: Option<LogFiles>,
    logs: Option<Summaries>,
    /// Rows in which the unit was moved count as any others.
    keeps_moved: bool,
    /// The worst of its axes; an all-clear only once all are diagnosed.
    outcome: Option<Outcome>,
    /// Every axis that can have a model has one: it can be exported.
    is_whole: bool,
    axis: Option<String>,
    axes: Vec<AxisPage>,
    commands: Vec<String>,
}

/// An axis with its standing and the units that its numbers are shown in.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct AxisPage {
    #[serde(flatten)]
    section: AxisSection,
    standing: Option<Standing>,
    /// Why there is no model, comparison or diagnosis.
    failure: Option<String>,
    /// RMS of the slow error in a free run, in the unit: of the constant mean, and of the model.
    slow_error: Option<[Option<f64>; 2]>,
    /// Of each refinement step: whether its effect reduces the error by more than noise.
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
            slow_error: section.comparison.as_ref().map(AxisComparison::slow_errors),
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

impl Beat {
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
            (Some(fitted), Some(read)) => command_lines(&fitted.data.sources, &read.logs, refined),
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
            is_whole: fitted.is_some() && state.unfitted().next().is_none(),
            axis: state.looked_at.clone(),
            axes: state.axes.iter().map(AxisPage::of).collect(),
            commands,
        }
    }
}

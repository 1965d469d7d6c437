//! State of a study: results, requested tasks, errors; it changes under one lock.

use std::sync::Arc;

use super::known::{Change, KnownAxis, Read};
use super::queue::Queue;
use super::standing::{Outcome, Standing, worst};
use super::task::{LogFiles, Task};

/// State under the lock of a study.
#[derive(Default)]
pub(super) struct State {
    pub(super) name: String,
    pub(super) revision: u64,
    /// Logs that were requested last, read or not; none for an example that is not written yet.
    pub(super) files: Option<LogFiles>,
    pub(super) read: Option<Arc<Read>>,
    pub(super) axes: Vec<KnownAxis>,
    pub(super) looked_at: Option<String>,
    pub(super) queue: Queue,
    pub(super) error: Option<String>,
    pub(super) closed: bool,
}

impl State {
    pub(super) fn known(&self, column: &str) -> Result<&KnownAxis, String> {
        self.axes.iter().find(|axis| axis.section.column == column).ok_or_else(|| {
            let axes: Vec<&str> = self.axes.iter().map(|axis| axis.section.column.as_str()).collect();
            format!("there is no axis {column}; there is {}", axes.join(", "))
        })
    }

    /// Returns the tasks that complete the results of an axis.
    pub(super) fn missing_of(&self, column: &str) -> Vec<Task> {
        let Ok(axis) = self.known(column) else { return Vec::new() };
        let mut tasks = Vec::new();
        if axis.fitted.is_none() {
            tasks.push(Task::Fit(column.to_owned()));
        }
        if !axis.examined {
            tasks.push(Task::Examine(column.to_owned()));
        }
        if axis.section.diagnosis.is_none() {
            tasks.push(Task::Diagnose(column.to_owned()));
        }
        tasks
    }

    /// Returns the axes that have no model and may get one.
    pub(super) fn unfitted(&self) -> impl Iterator<Item = &KnownAxis> {
        self.axes.iter().filter(|axis| axis.fitted.is_none() && axis.failure.is_none())
    }

    /// Requests these tasks; then, in the background and again after a stop, fits of the other axes, so that there is a
    /// complete model to export, and their diagnoses.
    pub(super) fn ask(&mut self, tasks: impl IntoIterator<Item = Task>) {
        self.queue.ask(tasks);
        let fits: Vec<Task> = self.unfitted().map(|axis| Task::Fit(axis.section.column.clone())).collect();
        self.queue.ask_in_background(fits);
        let open = self.axes.iter().filter(|axis| axis.failure.is_none());
        let diagnoses: Vec<Task> = open
            .flat_map(|axis| self.missing_of(&axis.section.column))
            .filter(|task| !matches!(task, Task::Fit(_)))
            .collect();
        self.queue.ask_in_background(diagnoses);
    }

    /// Returns the outcome of the study: the worst of its axes.
    pub(super) fn outcome(&self) -> Option<Outcome> {
        worst(self.axes.iter().map(|axis| match (&axis.failure, &axis.section.diagnosis) {
            (Some(_), None) => Some(Outcome::NotEnoughData),
            (_, diagnosis) => {
                diagnosis.as_ref().map(|diagnosis| Standing::of(diagnosis, axis.refinement.as_ref()).outcome)
            }
        }))
    }

    /// Returns true once every axis that can be diagnosed is.
    fn is_diagnosed(&self) -> bool {
        self.axes.iter().all(|axis| axis.failure.is_some() || axis.section.diagnosis.is_some())
    }

    pub(super) fn stopped(&mut self) {
        // later tasks were dropped when the stop was requested; tasks requested since then stay
        self.error = Some("stopped; what was computed before is still there".to_owned());
    }

    pub(super) fn failed(&mut self, task: &Task, reason: String) {
        self.queue.drop_after(task);
        let is_of_axis = matches!(task, Task::Fit(_) | Task::Examine(_) | Task::Diagnose(_));
        match self.axes.iter_mut().find(|axis| is_of_axis && task.column() == Some(&axis.section.column)) {
            Some(axis) => {
                axis.failure = Some(reason);
                self.share_signal();
            }
            None => self.error = Some(reason),
        }
    }

    /// Requests the comparison of all axes once they are diagnosed, and again when one of them has changed.
    fn share_signal(&mut self) {
        if self.is_diagnosed() {
            self.queue.ask_in_background([Task::ShareSignal]);
        }
    }

    /// Applies the output of a task.
    pub(super) fn apply(&mut self, change: Change) {
        match change {
            Change::Read { read, first } => {
                self.axes = read.axes.iter().map(|column| KnownAxis::unknown(column)).collect();
                // after another read, the same axis stays open
                let before = self.looked_at.take().filter(|column| read.axes.contains(column));
                self.looked_at = before.or(first);
                self.files = Some(LogFiles::of(&read.logs));
                self.read = Some(Arc::from(read));
                let tasks = self.looked_at.clone().map_or_else(Vec::new, |first| self.missing_of(&first));
                self.ask(tasks);
            }
            Change::Axis { column, edit } => {
                if let Some(axis) = self.axes.iter_mut().find(|axis| axis.section.column == column) {
                    edit(axis);
                    axis.failure = None;
                }
                self.share_signal();
            }
            Change::Diagnoses(diagnoses) => {
                for diagnosis in diagnoses {
                    let axis = self.axes.iter_mut().find(|axis| axis.section.column == diagnosis.target);
                    if let Some(axis) = axis {
                        axis.section.diagnosis = Some(diagnosis);
                    }
                }
            }
        }
    }
}

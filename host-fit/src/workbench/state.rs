//! The state of a study: what is known, what is asked for, what went wrong; it changes under one lock.

use std::sync::Arc;

use super::known::{Change, KnownAxis, Read};
use super::queue::Queue;
use super::standing::{Outcome, Standing, worst};
use super::task::{LogFiles, Task};

/// What is under the lock of a study.
#[derive(Default)]
pub(super) struct State {
    pub(super) name: String,
    pub(super) revision: u64,
    /// The logs that were asked for last, read or not; none of an example that is not written yet.
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

    /// The tasks after which all is known of an axis.
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

    /// The axes that have no model and may get one.
    pub(super) fn unfitted(&self) -> impl Iterator<Item = &KnownAxis> {
        self.axes.iter().filter(|axis| axis.fitted.is_none() && axis.failure.is_none())
    }

    /// Does these; then, in the background and again after a stop, fits the other axes, so that there is a whole model to
    /// export, and diagnoses them.
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

    /// Outcome of the study: the worst of its axes.
    pub(super) fn outcome(&self) -> Option<Outcome> {
        worst(self.axes.iter().map(|axis| match (&axis.failure, &axis.section.diagnosis) {
            (Some(_), None) => Some(Outcome::NotEnoughData),
            (_, diagnosis) => {
                diagnosis.as_ref().map(|diagnosis| Standing::of(diagnosis, axis.refinement.as_ref()).outcome)
            }
        }))
    }

    /// True once every axis is diagnosed that can be.
    fn is_diagnosed(&self) -> bool {
        self.axes.iter().all(|axis| axis.failure.is_some() || axis.section.diagnosis.is_some())
    }

    pub(super) fn stopped(&mut self) {
        // what was to come after it was taken off when the stop was asked for; what was asked since then stays
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

    /// Compares the axes once all are diagnosed, and again when one of them has changed.
    fn share_signal(&mut self) {
        if self.is_diagnosed() {
            self.queue.ask_in_background([Task::ShareSignal]);
        }
    }

    /// Takes in what a task has changed.
    pub(super) fn apply(&mut self, change: Change) {
        match change {
            Change::Read { read, first } => {
                self.axes = read.axes.iter().map(|column| KnownAxis::unknown(column)).collect();
                // read anew, the same axis is looked at
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

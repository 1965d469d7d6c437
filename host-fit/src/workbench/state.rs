//! The state of a study: what is known, what is asked for, what went wrong; it changes under one lock.

use std::sync::Arc;

use super::known::{Change, KnownAxis, Read};
use super::queue::Queue;
use super::task::Task;

/// What is under the lock of a study.
#[derive(Default)]
pub(super) struct State {
    pub(super) name: String,
    pub(super) revision: u64,
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
        self.axes.iter().filter(|axis| axis.fitted.is_none() && !axis.cannot_be_fitted)
    }

    /// Does these, and fits the other axes in the background, so that there is a whole unit to take away; again after a
    /// stop.
    pub(super) fn ask(&mut self, tasks: impl IntoIterator<Item = Task>) {
        self.queue.ask(tasks);
        let fits: Vec<Task> = self.unfitted().map(|axis| Task::Fit(axis.section.column.clone())).collect();
        self.queue.ask(fits);
    }

    pub(super) fn stopped(&mut self) {
        // what was to come after it was taken off when the stop was asked for; what was asked since then stays
        self.error = Some("stopped; what was computed before is still there".to_owned());
    }

    pub(super) fn failed(&mut self, task: &Task, reason: String) {
        self.queue.drop_after(task);
        if let Task::Fit(column) = task
            && let Some(axis) = self.axes.iter_mut().find(|axis| axis.section.column == *column)
        {
            axis.cannot_be_fitted = true;
        }
        self.error = Some(reason);
    }

    /// Takes in what a task has changed.
    pub(super) fn apply(&mut self, change: Change) {
        match change {
            Change::Read { read, first } => {
                self.axes = read.axes.iter().map(|column| KnownAxis::unknown(column)).collect();
                // read anew, the same axis is looked at
                let before = self.looked_at.take().filter(|column| read.axes.contains(column));
                self.looked_at = before.or(first);
                self.read = Some(Arc::from(read));
                let tasks = self.looked_at.clone().map_or_else(Vec::new, |first| self.missing_of(&first));
                self.ask(tasks);
            }
            Change::Axis { column, edit } => {
                if let Some(axis) = self.axes.iter_mut().find(|axis| axis.section.column == column) {
                    edit(axis);
                }
            }
        }
    }
}

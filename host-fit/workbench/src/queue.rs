//! Tasks of a study: one at a time, those that a user waits for before those in the background.

use std::collections::VecDeque;

use super::job::Job;
use super::task::Task;
use fos_data::interrupt::StopRequest;

/// Tasks of a study in their order, and the running one.
#[derive(Default)]
pub(super) struct Queue {
    waiting: VecDeque<Waiting>,
    running: Option<Running>,
}

struct Waiting {
    task: Task,
    asked_for: bool,
}

/// Running task.
struct Running {
    task: Task,
    asked_for: bool,
    job: Job,
    stop: StopRequest,
}

impl Queue {
    /// Puts tasks that a user waits for before those in the background.
    pub(super) fn ask(&mut self, tasks: impl IntoIterator<Item = Task>) {
        for task in tasks {
            if matches!(task, Task::Fit(_)) && self.is_running(&task) {
                continue;
            }
            // requested again: moved back, so that it sees the results of the tasks now before it
            self.waiting.retain(|waiting| waiting.task != task);
            let place =
                self.waiting.iter().position(|waiting| !waiting.asked_for).unwrap_or(self.waiting.len());
            self.waiting.insert(place, Waiting { task, asked_for: true });
        }
    }

    /// Adds tasks in the background; tasks that already wait are not added twice.
    pub(super) fn ask_in_background(&mut self, tasks: impl IntoIterator<Item = Task>) {
        for task in tasks {
            if !self.is_running(&task) && self.waiting.iter().all(|waiting| waiting.task != task) {
                self.waiting.push_back(Waiting { task, asked_for: false });
            }
        }
    }

    fn is_running(&self, task: &Task) -> bool {
        self.running.as_ref().is_some_and(|running| running.task == *task && !running.stop.is_asked())
    }

    /// Returns true if a user waits for the running task.
    pub(super) fn is_asked_for(&self) -> bool {
        self.running.as_ref().is_some_and(|running| running.asked_for)
    }

    /// Begins the next task, if there is one; it ends early if its `StopRequest` is set.
    pub(super) fn begin(&mut self) -> Option<(Task, StopRequest)> {
        let Waiting { task, asked_for } = self.waiting.pop_front()?;
        let stop = StopRequest::default();
        let job = task.job(asked_for);
        self.running = Some(Running { task: task.clone(), asked_for, job, stop: stop.clone() });
        Some((task, stop))
    }

    /// Updates the progress of the running task.
    pub(super) fn progress(&mut self, job: Job) {
        if let Some(running) = &mut self.running {
            running.job = job;
            running.job.asked_for = running.asked_for;
        }
    }

    /// Removes the running task, which has ended.
    pub(super) fn end(&mut self) {
        self.running = None;
    }

    /// Requests the running task to stop, and drops all waiting ones.
    pub(super) fn stop(&mut self) {
        self.waiting.clear();
        if let Some(running) = &self.running {
            running.stop.ask();
        }
    }

    /// Drops the waiting tasks on the axis of a failed task, which need its result; those on other axes stay.
    pub(super) fn drop_after(&mut self, failed: &Task) {
        self.waiting.retain(|waiting| waiting.task.column() != failed.column());
    }

    /// Returns the running job, or the next one: a study does not rest between two tasks, or a page would offer actions
    /// that are then refused.
    pub(super) fn job(&self) -> Option<Job> {
        let running = self.running.as_ref().map(|running| running.job.clone());
        let next = || self.waiting.front().map(|waiting| waiting.task.job(waiting.asked_for));
        let mut job = running.or_else(next)?;
        job.asked_for |= self.waiting.iter().any(|waiting| waiting.asked_for);
        Some(job)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(column: &str) -> Task {
        Task::Fit(column.to_owned())
    }

    fn examine(column: &str) -> Task {
        Task::Examine(column.to_owned())
    }

    fn diagnose(column: &str) -> Task {
        Task::Diagnose(column.to_owned())
    }

    fn add(column: &str) -> Task {
        Task::Add { column: column.to_owned(), effect: "thermal_lag".to_owned() }
    }

    fn tasks(queue: &Queue) -> Vec<&Task> {
        queue.waiting.iter().map(|waiting| &waiting.task).collect()
    }

    #[test]
    fn a_study_rests_when_nothing_is_left_and_is_free_while_nobody_waits() {
        let mut queue = Queue::default();
        assert_eq!(queue.job(), None);
        queue.ask_in_background([fit("gx"), diagnose("gx"), fit("gy")]);
        assert!(!queue.job().unwrap().asked_for, "in the background");
        queue.begin().unwrap();
        queue.ask([add("gx")]);
        assert!(queue.job().unwrap().asked_for, "it waits for the fit that runs");
        queue.end();
        assert!(queue.job().unwrap().asked_for, "between two tasks");
    }

    #[test]
    fn an_axis_that_somebody_looks_at_comes_before_the_background() {
        let mut queue = Queue::default();
        queue.ask([fit("gx"), examine("gx"), diagnose("gx")]);
        queue.ask_in_background([
            fit("gy"),
            fit("gz"),
            examine("gy"),
            diagnose("gy"),
            examine("gz"),
            diagnose("gz"),
        ]);
        queue.begin().unwrap();
        queue.ask([fit("gx")]);
        queue.ask_in_background([fit("gx"), examine("gy")]);
        queue.ask([fit("gz"), examine("gz"), diagnose("gz")]);
        let expected = [
            examine("gx"),
            diagnose("gx"),
            fit("gz"),
            examine("gz"),
            diagnose("gz"),
            fit("gy"),
            examine("gy"),
            diagnose("gy"),
        ];
        assert_eq!(tasks(&queue), expected.iter().collect::<Vec<_>>(), "nothing twice");
    }

    #[test]
    fn failed_task_cancels_only_its_dependents() {
        let mut queue = Queue::default();
        queue.ask([add("gx"), examine("gx"), fit("gz"), fit("ax")]);
        queue.drop_after(&fit("gz"));
        assert_eq!(tasks(&queue), [&add("gx"), &examine("gx"), &fit("ax")]);
        queue.drop_after(&add("gx"));
        assert_eq!(tasks(&queue), [&fit("ax")]);
    }

    #[test]
    fn a_stop_is_told_to_what_runs_and_leaves_nothing() {
        let mut queue = Queue::default();
        queue.ask([examine("gx"), diagnose("gx")]);
        let (task, stop) = queue.begin().unwrap();
        assert_eq!((task, stop.is_asked()), (examine("gx"), false));
        queue.stop();
        assert!(stop.is_asked());
        queue.end();
        assert_eq!(queue.job(), None);
        // a task that is being stopped has no result
        queue.ask([fit("gx")]);
        queue.begin().unwrap();
        queue.stop();
        queue.ask([fit("gx"), examine("gx")]);
        assert_eq!(tasks(&queue), [&fit("gx"), &examine("gx")]);
    }
}

//! What a study is to do: one task at a time, those that somebody waits for before those that nobody does.

use std::collections::VecDeque;

use super::job::Job;
use super::task::Task;
use fos_data::interrupt::StopRequest;

/// The tasks of a study, in their order, and the one that is being done.
#[derive(Default)]
pub(super) struct Queue {
    waiting: VecDeque<Task>,
    running: Option<Running>,
}

/// What is being done.
struct Running {
    task: Task,
    job: Job,
    stop: StopRequest,
}

impl Queue {
    /// Puts tasks before the fits that wait in the background; what waits already is not done twice.
    pub(super) fn ask(&mut self, tasks: impl IntoIterator<Item = Task>) {
        for task in tasks {
            if matches!(task, Task::Fit(_)) {
                let is_running = self
                    .running
                    .as_ref()
                    .is_some_and(|running| running.task == task && !running.stop.is_asked());
                if is_running || self.waiting.contains(&task) {
                    continue;
                }
            } else {
                // asked again: it is to see what comes before it now
                self.waiting.retain(|waiting| *waiting != task);
            }
            self.waiting.push_back(task);
        }
        // a fit goes with what needs it
        let needed: Vec<String> = self
            .waiting
            .iter()
            .filter(|task| task.is_asked_for())
            .filter_map(|task| task.column().map(str::to_owned))
            .collect();
        let is_needed = |task: &Task| task.column().is_none_or(|column| needed.iter().any(|it| it == column));
        let (mut asked, mut background): (VecDeque<Task>, VecDeque<Task>) =
            std::mem::take(&mut self.waiting).into_iter().partition(is_needed);
        asked.append(&mut background);
        self.waiting = asked;
    }

    /// Begins the next task, if there is one; it ends early where `StopRequest` is asked.
    pub(super) fn begin(&mut self) -> Option<(Task, StopRequest)> {
        let task = self.waiting.pop_front()?;
        let stop = StopRequest::default();
        self.running = Some(Running { task: task.clone(), job: task.job(), stop: stop.clone() });
        Some((task, stop))
    }

    /// How far the task is that is being done.
    pub(super) fn progress(&mut self, job: Job) {
        if let Some(running) = &mut self.running {
            running.job = job;
        }
    }

    /// The task that was begun has ended.
    pub(super) fn end(&mut self) {
        self.running = None;
    }

    /// Asks the running task to stop, and forgets what should come after it.
    pub(super) fn stop(&mut self) {
        self.waiting.clear();
        if let Some(running) = &self.running {
            running.stop.ask();
        }
    }

    /// What was to come after a task that failed needs what it did not give; what is of other axes does not.
    pub(super) fn drop_after(&mut self, failed: &Task) {
        self.waiting.retain(|waiting| waiting.column() != failed.column());
    }

    /// What is being done, or is next: between two tasks a study does not rest, or a page would offer what it then
    /// refuses.
    pub(super) fn job(&self) -> Option<Job> {
        let running = self.running.as_ref().map(|running| running.job.clone());
        let mut job = running.or_else(|| self.waiting.front().map(Task::job))?;
        job.asked_for |= self.waiting.iter().any(Task::is_asked_for);
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

    #[test]
    fn a_study_rests_when_nothing_is_left_and_is_free_while_nobody_waits() {
        let mut queue = Queue::default();
        assert_eq!(queue.job(), None);
        queue.ask([fit("gx_rads"), fit("gy_rads")]);
        assert!(!queue.job().unwrap().asked_for, "the other axes, in the background");
        queue.begin().unwrap();
        queue.ask([add("gx_rads")]);
        assert!(queue.job().unwrap().asked_for, "it waits for the fit that runs");
        queue.end();
        assert!(queue.job().unwrap().asked_for, "between two tasks");
    }

    #[test]
    fn a_fit_goes_with_what_needs_it_and_the_others_come_last() {
        let mut queue = Queue::default();
        queue.ask([fit("gx"), examine("gx"), diagnose("gx"), fit("gy"), fit("gz"), fit("ax")]);
        queue.begin().unwrap();
        queue.ask([fit("gx")]);
        queue.ask([fit("gy"), examine("gy"), diagnose("gy")]);
        queue.ask([fit("gz"), examine("gz"), diagnose("gz")]);
        let expected = [
            examine("gx"),
            diagnose("gx"),
            fit("gy"),
            examine("gy"),
            diagnose("gy"),
            fit("gz"),
            examine("gz"),
            diagnose("gz"),
            fit("ax"),
        ];
        // stable: an axis that was asked for earlier comes earlier, each in its own order
        let of = |column: &str| -> Vec<&Task> {
            queue.waiting.iter().filter(|task| task.column() == Some(column)).collect()
        };
        for column in ["gx", "gy", "gz", "ax"] {
            let own: Vec<&Task> = expected.iter().filter(|task| task.column() == Some(column)).collect();
            assert_eq!(of(column), own);
        }
        assert_eq!(queue.waiting.len(), expected.len(), "nothing twice");
        assert_eq!(queue.waiting.back(), Some(&fit("ax")));
    }

    #[test]
    fn what_fails_takes_along_only_what_needs_it() {
        let mut queue = Queue::default();
        queue.ask([add("gx"), examine("gx"), fit("gz"), fit("ax")]);
        queue.drop_after(&fit("gz"));
        assert_eq!(queue.waiting, [add("gx"), examine("gx"), fit("ax")]);
        queue.drop_after(&add("gx"));
        assert_eq!(queue.waiting, [fit("ax")]);
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
        // one that is being stopped gives nothing
        queue.ask([fit("gx")]);
        queue.begin().unwrap();
        queue.stop();
        queue.ask([fit("gx"), examine("gx")]);
        assert_eq!(queue.waiting, [fit("gx"), examine("gx")]);
    }
}

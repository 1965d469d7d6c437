//! One study: its logs, its axes, and the one job that runs.
//!
//! A thread of its own takes one task after the other. What it computes is published whole, under a new revision; a task that
//! fails or is stopped changes nothing.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use fos_core::Image;
use serde::Serialize;
use tokio::sync::watch;

use super::job::Job;
use super::queue::Queue;
use super::tasks::{self, Open, Task};
use crate::examine::{Examination, command_lines};
use crate::replay::{self, Summary};
use crate::report::{AxisSection, LogSummary};
use fos_data::interrupt::{Interrupted, Stop, interruptible};
use fos_data::stillness;
use fos_diagnose::detect::Verdict;
use fos_diagnose::effects::Library;
use fos_diagnose::refine::Logs;
use fos_diagnose::study::Study as StudyFile;
use fos_diagnose::study::{Refinement, RefinementStep};

/// A study that is open.
pub(super) struct Study {
    pub(super) id: u64,
    inner: Mutex<Inner>,
    wake: Condvar,
    beat: watch::Sender<Beat>,
    /// The last image that was run over a log, and what came of it: windows on one study ask for the same.
    replayed: Mutex<Option<(Vec<u8>, Summary)>>,
}

/// What a page is told without asking.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Beat {
    pub(super) revision: u64,
    pub(super) job: Option<Job>,
}

/// The logs of a study, as read.
pub(super) struct Read {
    pub(super) logs: Logs,
    pub(super) summaries: Summaries,
    /// The axes that the field log has.
    pub(super) axes: Vec<String>,
}

/// The logs in a few facts.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Summaries {
    pub(super) field: LogSummary,
    pub(super) quiet: Option<LogSummary>,
    pub(super) judged: Option<LogSummary>,
}

/// An axis as far as it is known.
#[derive(Clone)]
pub(super) struct KnownAxis {
    /// The axis alone, as it was fitted.
    pub(super) fitted: Option<Arc<StudyFile>>,
    /// A fit has failed: it is not tried again unless somebody looks at the axis.
    pub(super) cannot_be_fitted: bool,
    pub(super) growth: Option<Refinement>,
    pub(super) examination: Option<Arc<Examination>>,
    /// It is of the model as it is; otherwise of the one before, whose picture stays until there is another.
    pub(super) examined: bool,
    pub(super) section: AxisSection,
}

#[derive(Default)]
struct Inner {
    name: String,
    revision: u64,
    read: Option<Arc<Read>>,
    axes: Vec<KnownAxis>,
    looked_at: Option<String>,
    queue: Queue,
    error: Option<String>,
    closed: bool,
}

/// A study in a list.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Entry {
    id: u64,
    name: String,
    verdict: Option<Verdict>,
    working: bool,
    /// The axis that is looked at, with what is known of it: what studies are held side by side by.
    axis: Option<AxisEntry>,
}

/// An axis in a list.
#[derive(Debug, Clone, Serialize)]
struct AxisEntry {
    column: String,
    label: String,
    unit: String,
    sentence: Option<String>,
    /// Effects that were added, in order.
    added: Vec<String>,
    /// Root of the variance of the 1-s means that are left on unseen data, before the first effect and now, in the unit.
    slow_before: Option<f64>,
    slow_now: Option<f64>,
}

impl AxisEntry {
    fn of(axis: &KnownAxis) -> Self {
        let stairs = axis.growth.as_ref().map_or(&[][..], |growth| &growth.steps);
        let slow = |stair: Option<&RefinementStep>| stair.map(|stair| stair.left.slow.sqrt());
        Self {
            column: axis.section.column.clone(),
            label: axis.section.label.clone(),
            unit: axis.section.unit.clone(),
            sentence: axis.section.diagnosis.as_ref().map(|found| found.sentence.clone()),
            added: axis
                .growth
                .iter()
                .flat_map(Refinement::added)
                .map(|added| added.effect.id.clone())
                .collect(),
            slow_before: slow(stairs.first()),
            slow_now: slow(stairs.last()),
        }
    }
}

/// All that a page shows of a study, but for what is drawn sample by sample.
#[derive(Debug, Clone, Serialize)]
pub(super) struct State {
    id: u64,
    name: String,
    revision: u64,
    job: Option<Job>,
    error: Option<String>,
    logs: Option<Summaries>,
    axis: Option<String>,
    axes: Vec<AxisSection>,
    commands: Vec<String>,
}

impl Study {
    /// Begins to read the logs of a new study.
    pub(super) fn open(id: u64, open: Open, library: Arc<Library>) -> Arc<Self> {
        let (beat, _) = watch::channel(Beat { revision: 0, job: None });
        let mut inner = Inner { name: open.name(), ..Inner::default() };
        inner.queue.ask([Task::Read(open)]);
        let study = Arc::new(Self {
            id,
            inner: Mutex::new(inner),
            wake: Condvar::new(),
            beat,
            replayed: Mutex::default(),
        });
        let worker = Arc::clone(&study);
        thread::spawn(move || worker.work(&library));
        study
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        // nothing panics while it holds the lock; if it did, what is published is still whole
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes one task after the other until the study is closed.
    fn work(&self, library: &Library) {
        while let Some((task, stop)) = self.next() {
            let outcome = interruptible(&stop, || {
                let progress = |job| self.progress(job);
                tasks::run(&task, &self.snapshot(), library, &progress)
            });
            let mut inner = self.lock();
            inner.queue.end();
            match outcome {
                // asked to stop when it was done already
                Ok(_) if stop.is_asked() => inner.stopped(),
                Ok(Ok(change)) => change.apply(&mut inner),
                Ok(Err(reason)) => inner.failed(&task, reason),
                Err(Interrupted::Stopped) => inner.stopped(),
                Err(Interrupted::Panicked) => inner.failed(
                    &task,
                    "an error in this program; what was computed before is still there\nhelp: please report it, with what it printed in the terminal".to_owned(),
                ),
            }
            self.publish(inner);
        }
    }

    /// The next task, when there is one; none when the study is closed.
    fn next(&self) -> Option<(Task, Stop)> {
        let mut inner = self.lock();
        loop {
            if inner.closed {
                return None;
            }
            if let Some((task, stop)) = inner.queue.begin() {
                if task.is_asked_for() {
                    inner.error = None;
                }
                self.publish(inner);
                return Some((task, stop));
            }
            inner = self.wake.wait(inner).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// What a task may look at.
    fn snapshot(&self) -> Snapshot {
        let inner = self.lock();
        Snapshot { read: inner.read.clone(), axes: inner.axes.clone() }
    }

    fn progress(&self, job: Job) {
        let mut inner = self.lock();
        inner.queue.progress(job);
        self.tell(&inner);
    }

    fn publish(&self, mut inner: MutexGuard<'_, Inner>) {
        inner.revision += 1;
        self.tell(&inner);
    }

    /// Under the lock, so that what is told last is how it is.
    fn tell(&self, inner: &Inner) {
        self.beat.send_replace(Beat { revision: inner.revision, job: inner.queue.job() });
    }

    /// Looks at an axis: what is not known of it is computed next.
    ///
    /// # Errors
    ///
    /// There is no such axis.
    pub(super) fn look_at(&self, column: &str) -> Result<(), String> {
        let mut inner = self.lock();
        inner.known(column)?;
        inner.looked_at = Some(column.to_owned());
        let tasks = inner.missing_of(column);
        inner.ask(tasks);
        self.publish(inner);
        self.wake.notify_one();
        Ok(())
    }

    /// Adds an effect to an axis.
    ///
    /// # Errors
    ///
    /// There is no such axis, or no model of it yet.
    pub(super) fn add(&self, column: &str, effect: &str) -> Result<(), String> {
        self.regrow(column, Task::Add { column: column.to_owned(), effect: effect.to_owned() })
    }

    /// Keeps the first `keep` effects of an axis.
    ///
    /// # Errors
    ///
    /// There is no such axis, or no model of it yet.
    pub(super) fn undo(&self, column: &str, keep: usize) -> Result<(), String> {
        self.regrow(column, Task::Undo { column: column.to_owned(), keep })
    }

    /// A task that changes the model of an axis, then all that is said of it anew.
    fn regrow(&self, column: &str, task: Task) -> Result<(), String> {
        let mut inner = self.lock();
        if inner.known(column)?.growth.is_none() {
            return Err(format!("{column} has no model yet\nhelp: wait until it is fitted"));
        }
        inner.ask([task, Task::Examine(column.to_owned()), Task::Diagnose(column.to_owned())]);
        self.publish(inner);
        self.wake.notify_one();
        Ok(())
    }

    /// Ends what is being done, and what should come after it.
    pub(super) fn stop(&self) {
        let mut inner = self.lock();
        inner.queue.stop();
        self.publish(inner);
    }

    /// Ends the study.
    pub(super) fn close(&self) {
        self.lock().closed = true;
        self.stop();
        self.wake.notify_one();
    }

    /// The beats from now on.
    pub(super) fn beats(&self) -> watch::Receiver<Beat> {
        self.beat.subscribe()
    }

    pub(super) fn entry(&self) -> Entry {
        let inner = self.lock();
        let looked_at = inner.looked_at.as_ref().and_then(|column| inner.known(column).ok());
        Entry {
            id: self.id,
            name: inner.name.clone(),
            verdict: looked_at.and_then(|axis| axis.section.diagnosis.as_ref()).map(|found| found.verdict),
            working: inner.queue.job().is_some(),
            axis: looked_at.map(AxisEntry::of),
        }
    }

    pub(super) fn state(&self) -> State {
        let inner = self.lock();
        let fitted = inner.axes.iter().find_map(|axis| axis.fitted.as_deref());
        let seen = inner.axes.iter().filter(|axis| axis.examination.is_some());
        let grown = seen.map(|axis| (axis.section.column.as_str(), axis.growth.as_ref()));
        let commands = match (fitted, &inner.read) {
            (Some(fitted), Some(read)) => command_lines(&fitted.data.sources, &read.logs, grown),
            _ => Vec::new(),
        };
        State {
            id: self.id,
            name: inner.name.clone(),
            revision: inner.revision,
            job: inner.queue.job(),
            error: inner.error.clone(),
            logs: inner.read.as_ref().map(|read| read.summaries.clone()),
            axis: inner.looked_at.clone(),
            axes: inner.axes.iter().map(|axis| axis.section.clone()).collect(),
            commands,
        }
    }

    /// The logs, once they are read.
    pub(super) fn read(&self) -> Result<Arc<Read>, String> {
        self.lock().read.clone().ok_or_else(|| "the logs are being read\nhelp: wait a moment".to_owned())
    }

    /// What is known of an axis.
    pub(super) fn axis(&self, column: &str) -> Result<KnownAxis, String> {
        self.lock().known(column).cloned()
    }

    /// What an image of this study does to the log that errors are of; computed once for each image.
    ///
    /// # Errors
    ///
    /// It cannot be run.
    pub(super) fn replay(&self, image: Vec<u8>) -> Result<Summary, String> {
        // who comes while it is computed waits here for the same answer
        let mut last = self.replayed.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, summary)) = last.as_ref().filter(|(known, _)| *known == image) {
            return Ok(summary.clone());
        }
        let read = self.read()?;
        let parsed = Image::parse(&image).map_err(|error| error.to_string())?;
        let log = read.logs.judged.as_ref().unwrap_or(&read.logs.field);
        let summary =
            replay::summary(&parsed, log, &stillness::find(log)).map_err(|error| error.to_string())?;
        *last = Some((image, summary.clone()));
        Ok(summary)
    }

    /// The study as a file: all axes that are fitted, as they have grown.
    ///
    /// # Errors
    ///
    /// None is fitted yet.
    pub(super) fn file(&self) -> Result<StudyFile, String> {
        let inner = self.lock();
        let fitted = inner.axes.iter().filter_map(|axis| axis.fitted.as_deref().cloned());
        let mut file = StudyFile::joined(fitted)
            .ok_or("there is no model yet\nhelp: wait until the first axis is fitted")?;
        for growth in inner.axes.iter().filter_map(|axis| axis.growth.as_ref()) {
            if growth.added().next().is_some() {
                file.keep(growth.clone());
            }
        }
        Ok(file)
    }

    /// The same, once every axis is fitted that can be: half a model is not given away.
    ///
    /// # Errors
    ///
    /// An axis is not fitted yet.
    pub(super) fn whole_file(&self) -> Result<StudyFile, String> {
        {
            let inner = self.lock();
            let missing: Vec<&str> = inner.unfitted().map(|axis| axis.section.label.as_str()).collect();
            if !missing.is_empty() {
                let help = match inner.queue.job() {
                    Some(_) => "wait a moment",
                    None => "it was stopped; look at an axis, and it goes on",
                };
                return Err(format!("not fitted yet: {}\nhelp: {help}", missing.join(", ")));
            }
        }
        self.file()
    }
}

/// What a task may look at: as it was when the task began.
pub(super) struct Snapshot {
    pub(super) read: Option<Arc<Read>>,
    axes: Vec<KnownAxis>,
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

    /// An axis that is fitted: the axis alone, and how it grew.
    ///
    /// # Errors
    ///
    /// It is not fitted.
    pub(super) fn fitted(&self, column: &str) -> Result<(&StudyFile, &Refinement), String> {
        let known = self.axes.iter().find(|axis| axis.section.column == column);
        known
            .and_then(|axis| axis.fitted.as_deref().zip(axis.growth.as_ref()))
            .ok_or_else(|| format!("{column} could not be fitted"))
    }
}

/// What a task changes, once it is done.
pub(super) enum Change {
    /// The logs are there.
    Read {
        /// They.
        read: Box<Read>,
        /// The axis to look at first.
        first: Option<String>,
    },
    /// What is known of an axis.
    Axis {
        /// Which.
        column: String,
        /// How it changes.
        edit: Box<dyn FnOnce(&mut KnownAxis) + Send>,
    },
}

impl Change {
    fn apply(self, inner: &mut Inner) {
        match self {
            Self::Read { read, first } => {
                inner.axes = read.axes.iter().map(|column| KnownAxis::unknown(column)).collect();
                inner.read = Some(Arc::from(read));
                inner.looked_at = first;
                let tasks = inner.looked_at.clone().map_or_else(Vec::new, |first| inner.missing_of(&first));
                inner.ask(tasks);
            }
            Self::Axis { column, edit } => {
                if let Some(axis) = inner.axes.iter_mut().find(|axis| axis.section.column == column) {
                    edit(axis);
                }
            }
        }
    }
}

impl KnownAxis {
    fn unknown(column: &str) -> Self {
        Self {
            fitted: None,
            cannot_be_fitted: false,
            growth: None,
            examination: None,
            examined: false,
            section: AxisSection::empty(column),
        }
    }
}

impl Inner {
    fn known(&self, column: &str) -> Result<&KnownAxis, String> {
        self.axes.iter().find(|axis| axis.section.column == column).ok_or_else(|| {
            let axes: Vec<&str> = self.axes.iter().map(|axis| axis.section.column.as_str()).collect();
            format!("there is no axis {column}; there is {}", axes.join(", "))
        })
    }

    /// The tasks after which all is known of an axis.
    fn missing_of(&self, column: &str) -> Vec<Task> {
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
    fn unfitted(&self) -> impl Iterator<Item = &KnownAxis> {
        self.axes.iter().filter(|axis| axis.fitted.is_none() && !axis.cannot_be_fitted)
    }

    /// Does these, and fits the other axes in the background, so that there is a whole unit to take away; again after a stop.
    fn ask(&mut self, tasks: impl IntoIterator<Item = Task>) {
        self.queue.ask(tasks);
        let fits: Vec<Task> = self.unfitted().map(|axis| Task::Fit(axis.section.column.clone())).collect();
        self.queue.ask(fits);
    }

    fn stopped(&mut self) {
        // what was to come after it was taken off when the stop was asked for; what was asked since then stays
        self.error = Some("stopped; what was computed before is still there".to_owned());
    }

    fn failed(&mut self, task: &Task, reason: String) {
        self.queue.drop_after(task);
        if let Task::Fit(column) = task
            && let Some(axis) = self.axes.iter_mut().find(|axis| axis.section.column == *column)
        {
            axis.cannot_be_fitted = true;
        }
        self.error = Some(reason);
    }
}

//! One study and its thread, which runs one task after the other.
//!
//! The output of a task is published as a whole, under a new revision; a task that fails or is stopped changes nothing.

use std::fs;
use std::io::ErrorKind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use fos_core::Image;
use tokio::sync::watch;

use super::job::Job;
use super::known::{Change, KnownAxis, Read, Snapshot};
use super::state::State;
use super::task::{LogFiles, Open, Task};
use super::tasks;
use super::view::{Entry, Page, StatusEvent};
use fos_data::file::compare_and_swap::FileVersion;
use fos_data::file::{FileError, name_of};
use fos_data::interrupt::{Interrupted, StopRequest, interruptible};
use fos_data::recording::LoadOptions;
use fos_data::stillness;
use fos_device_io::replay::{self, Summary};
use fos_diagnose::compare::strapdown;
use fos_diagnose::effects::Library;
use fos_diagnose::study::Study as StudyFile;
use fos_fit::evaluate::UnaidedError;
use fos_fit::model::UnitModel;
use fos_fit::noise::{AxisNoise, axis_noise};

/// A study that is open.
pub(super) struct Study {
    pub(super) id: u64,
    state: Mutex<State>,
    wake: Condvar,
    status: watch::Sender<StatusEvent>,
    begun: AtomicBool,
    library: Arc<Library>,
    /// File that the study is stored in, as it was last written.
    file: Mutex<FileVersion>,
    /// Last run of an image: several windows on a study request the same one.
    replayed: Mutex<Option<Replayed>>,
    noise: Mutex<Vec<NoiseOfAxis>>,
    strapdown: Mutex<Option<StrapdownOfModel>>,
}

/// N, B and K of an axis of a log.
struct NoiseOfAxis {
    column: String,
    /// Logs, among them the one that the noise was computed from.
    read: Arc<Read>,
    /// None where the log is too short.
    noise: Option<AxisNoise>,
}

/// Errors of a model of six axes without aiding.
struct StrapdownOfModel {
    model: UnitModel,
    /// Logs, among them the one that the model was evaluated on.
    read: Arc<Read>,
    errors: Vec<[UnaidedError; 2]>,
}

/// Image that was run over a log.
struct Replayed {
    image: Vec<u8>,
    /// Logs, among them the one that the image was run over.
    read: Arc<Read>,
    summary: Summary,
}

impl Study {
    /// Creates a study that will be stored in `file`. Its logs are read once it begins; if `open` is an error, it shows
    /// the reason.
    pub(super) fn new(
        id: u64,
        name: String,
        open: Result<Open, String>,
        file: FileVersion,
        library: Arc<Library>,
    ) -> Arc<Self> {
        let files = open.as_ref().ok().and_then(Open::files);
        let mut state = State { name, files, ..State::default() };
        let (status, _) = watch::channel(StatusEvent::of(&state));
        match open {
            Ok(open) => state.queue.ask([Task::Read(open)]),
            Err(reason) => state.error = Some(reason),
        }
        Arc::new(Self {
            id,
            state: Mutex::new(state),
            wake: Condvar::new(),
            status,
            begun: AtomicBool::new(false),
            library,
            file: Mutex::new(file),
            replayed: Mutex::default(),
            noise: Mutex::default(),
            strapdown: Mutex::default(),
        })
    }

    /// Starts the thread, unless it was started before.
    pub(super) fn begin(self: &Arc<Self>) {
        if !self.begun.swap(true, Ordering::Relaxed) {
            let worker = Arc::clone(self);
            thread::spawn(move || worker.work());
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // nothing panics while it holds the lock; if it did, what is published is still whole
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs one task after the other until the study is closed.
    fn work(&self) {
        while let Some((task, stop)) = self.next() {
            let outcome = interruptible(&stop, || {
                let progress = |job| self.progress(job);
                tasks::run(&task, &self.snapshot(), &self.library, &progress)
            });
            let is_new_model = matches!(outcome, Ok(Ok(Change::Axis { .. }))) && task.changes_model();
            let mut state = self.lock();
            state.queue.end();
            match outcome {
                // the stop was requested after the task had finished
                Ok(_) if stop.is_asked() => state.stopped(),
                Ok(Ok(change)) => state.apply(change),
                Ok(Err(reason)) => state.failed(&task, reason),
                Err(Interrupted::Stopped) => state.stopped(),
                Err(Interrupted::Panicked) => state.failed(
                    &task,
                    "an error in this program; what was computed before is still there\nhelp: please report it, with what it printed in the terminal".to_owned(),
                ),
            }
            self.publish(state);
            if is_new_model && let Err(reason) = self.store() {
                let mut state = self.lock();
                state.error = Some(format!("the study could not be stored: {reason}"));
                self.publish(state);
            }
        }
    }

    /// Writes the study to its file, so that the next server shows it again.
    fn store(&self) -> Result<(), String> {
        let mut stored = match self.file() {
            // a restored study replaces its file only when it is as complete as the file
            Ok(stored) if self.is_complete() => stored,
            _ => return Ok(()),
        };
        // refinements without an effect record the logs
        let refinements = self.lock().axes.iter().filter_map(|axis| axis.refinement.clone()).collect();
        stored.refinements = refinements;
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        // closing deletes the file
        if self.lock().closed {
            return Ok(());
        }
        stored.write(&file).map_err(|error| error.to_string())?;
        *file = FileVersion::of(file.path(), &stored.to_bytes());
        Ok(())
    }

    /// Returns false while axes of a restored study are still to be restored.
    fn is_complete(&self) -> bool {
        let state = self.lock();
        let is_restored = state.read.as_ref().is_some_and(|read| read.stored.is_some());
        !is_restored || state.unfitted().next().is_none()
    }

    /// Waits for the next task; none once the study is closed.
    fn next(&self) -> Option<(Task, StopRequest)> {
        let mut state = self.lock();
        loop {
            if state.closed {
                return None;
            }
            if let Some((task, stop)) = state.queue.begin() {
                if state.queue.is_asked_for() {
                    state.error = None;
                }
                self.publish(state);
                return Some((task, stop));
            }
            state = self.wake.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Returns the input of a task: the present state.
    fn snapshot(&self) -> Snapshot {
        let state = self.lock();
        Snapshot { read: state.read.clone(), axes: state.axes.clone() }
    }

    fn progress(&self, job: Job) {
        let mut state = self.lock();
        state.queue.progress(job);
        self.tell(&state);
    }

    fn publish(&self, mut state: MutexGuard<'_, State>) {
        state.revision += 1;
        self.tell(&state);
    }

    /// Sends the status while the lock is held, so that the last one sent is current.
    fn tell(&self, state: &State) {
        self.status.send_replace(StatusEvent::of(state));
    }

    /// Opens an axis: its missing results are computed next.
    pub(super) fn look_at(&self, column: &str) -> Result<(), String> {
        let mut state = self.lock();
        state.known(column)?;
        state.looked_at = Some(column.to_owned());
        if let Some(axis) = state.axes.iter_mut().find(|axis| axis.section.column == column) {
            axis.failure = None;
        }
        let tasks = state.missing_of(column);
        state.ask(tasks);
        self.publish(state);
        self.wake.notify_one();
        Ok(())
    }

    /// Adds an effect to an axis.
    pub(super) fn add(&self, column: &str, effect: &str) -> Result<(), String> {
        self.refine_anew(column, Task::Add { column: column.to_owned(), effect: effect.to_owned() })
    }

    /// Keeps the first `keep` effects of an axis.
    pub(super) fn undo(&self, column: &str, keep: usize) -> Result<(), String> {
        self.refine_anew(column, Task::Undo { column: column.to_owned(), keep })
    }

    /// Requests a task that changes the model of an axis, then its examination and diagnosis.
    fn refine_anew(&self, column: &str, task: Task) -> Result<(), String> {
        let mut state = self.lock();
        if state.known(column)?.refinement.is_none() {
            return Err(format!("{column} has no model yet\nhelp: wait until it is fitted"));
        }
        state.ask([task, Task::Examine(column.to_owned()), Task::Diagnose(column.to_owned())]);
        self.publish(state);
        self.wake.notify_one();
        Ok(())
    }

    /// Reads the logs again with their rows of detected motion kept or excluded, and repeats all computations. Works too
    /// if the logs could not be used because of that motion.
    pub(super) fn keep_moved(&self, keep: bool) -> Result<(), String> {
        let requested = || self.files().ok_or("the logs are being read\nhelp: wait a moment".to_owned());
        let files = self.read().map(|read| LogFiles::of(&read.logs)).or_else(|_| requested())?;
        self.read_again(LogFiles { read: LoadOptions { keep_moved: keep, ..files.read }, ..files });
        Ok(())
    }

    /// Reads these logs in place of the present ones, and repeats all computations. The present ones stay if the new
    /// ones cannot be read.
    pub(super) fn read_again(&self, files: LogFiles) {
        let mut state = self.lock();
        // The running task works on the present logs.
        state.queue.stop();
        if state.files.as_ref().is_some_and(|before| before.log != files.log) {
            state.name = name_of(&files.log);
        }
        state.files = Some(files.clone());
        state.queue.ask([Task::Read(Open::Logs(files))]);
        self.publish(state);
        self.wake.notify_one();
    }

    /// Returns the logs that were requested last.
    pub(super) fn files(&self) -> Option<LogFiles> {
        self.lock().files.clone()
    }

    /// Stops the running task, and drops the waiting ones.
    pub(super) fn stop(&self) {
        let mut state = self.lock();
        state.queue.stop();
        self.publish(state);
    }

    /// Ends the study and deletes its file.
    pub(super) fn close(&self) -> Result<(), String> {
        self.lock().closed = true;
        self.stop();
        self.wake.notify_one();
        let file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        match fs::remove_file(file.path()) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                Err(FileError::writing(file.path())(error).to_string())
            }
            _ => Ok(()),
        }
    }

    /// Subscribes to the status from now on.
    pub(super) fn status_events(&self) -> watch::Receiver<StatusEvent> {
        self.status.subscribe()
    }

    /// Returns the entry in the list of all studies.
    pub(super) fn entry(&self) -> Entry {
        Entry::of(self.id, &self.lock(), self.begun.load(Ordering::Relaxed))
    }

    /// Returns everything that a page shows of the study.
    pub(super) fn page(&self) -> Page {
        Page::of(self.id, &self.lock())
    }

    /// Returns the logs, once they are read.
    pub(super) fn read(&self) -> Result<Arc<Read>, String> {
        self.lock().read.clone().ok_or_else(|| "the logs are being read\nhelp: wait a moment".to_owned())
    }

    /// Returns the results for an axis.
    pub(super) fn axis(&self, column: &str) -> Result<KnownAxis, String> {
        self.lock().known(column).cloned()
    }

    /// Returns the summary of running an image of this study over the evaluation log, or over the log to explain if
    /// there is none. The result for the last image is cached.
    pub(super) fn replay(&self, image: Vec<u8>) -> Result<Summary, String> {
        // concurrent requests wait here for the same answer
        let mut last = self.replayed.lock().unwrap_or_else(PoisonError::into_inner);
        let read = self.read()?;
        let is_same = |last: &&Replayed| last.image == image && Arc::ptr_eq(&last.read, &read);
        if let Some(same) = last.as_ref().filter(is_same) {
            return Ok(same.summary.clone());
        }
        let parsed = Image::parse(&image).map_err(|error| error.to_string())?;
        let log = read.logs.evaluation.as_ref().unwrap_or(&read.logs.log);
        let summary =
            replay::summary(&parsed, log, &stillness::find(log)).map_err(|error| error.to_string())?;
        *last = Some(Replayed { image, read, summary: summary.clone() });
        Ok(summary)
    }

    /// N, B and K of an axis on the log to explain, computed once; none where the log is too short.
    pub(super) fn noise(&self, column: &str) -> Result<Option<AxisNoise>, String> {
        // as for a replay
        let mut known = self.noise.lock().unwrap_or_else(PoisonError::into_inner);
        let read = self.read()?;
        known.retain(|known| Arc::ptr_eq(&known.read, &read));
        if let Some(same) = known.iter().find(|known| known.column == column) {
            return Ok(same.noise.clone());
        }
        let log = &read.logs.log;
        let noise = axis_noise(log, &stillness::find(log), column).ok();
        let column = column.to_owned();
        known.push(NoiseOfAxis { column, read: Arc::clone(&read), noise: noise.clone() });
        Ok(noise)
    }

    /// Heading and position errors of all six axes of `file`, this study, on the log to explain; computed once for a model.
    pub(super) fn strapdown(&self, file: &StudyFile) -> Result<Vec<[UnaidedError; 2]>, String> {
        // as for a replay
        let mut last = self.strapdown.lock().unwrap_or_else(PoisonError::into_inner);
        let read = self.read()?;
        let is_same = |last: &&StrapdownOfModel| last.model == file.model && Arc::ptr_eq(&last.read, &read);
        if let Some(same) = last.as_ref().filter(is_same) {
            return Ok(same.errors.clone());
        }
        let (log, own) = (&read.logs.log, read.logs.reference.as_ref());
        let errors = strapdown(file, log, own).map_err(|error| error.to_string())?;
        *last = Some(StrapdownOfModel { model: file.model.clone(), read, errors: errors.clone() });
        Ok(errors)
    }

    /// Returns the study as a file: all fitted axes, as refined.
    pub(super) fn file(&self) -> Result<StudyFile, String> {
        let state = self.lock();
        let fitted = state.axes.iter().filter_map(|axis| axis.fitted.as_deref().cloned());
        let mut file = StudyFile::joined(fitted)
            .ok_or("there is no model yet\nhelp: wait until the first axis is fitted")?;
        for refinement in state.axes.iter().filter_map(|axis| axis.refinement.as_ref()) {
            if refinement.added().next().is_some() {
                file.keep(refinement.clone());
            }
        }
        Ok(file)
    }

    /// Returns the study as a file once every axis that can be fitted is: an incomplete model is not exported.
    pub(super) fn whole_file(&self) -> Result<StudyFile, String> {
        {
            let state = self.lock();
            let missing: Vec<&str> = state.unfitted().map(|axis| axis.section.label.as_str()).collect();
            if !missing.is_empty() {
                let help = match state.queue.job() {
                    Some(_) => "wait a moment",
                    None => "it was stopped; look at an axis, and it goes on",
                };
                return Err(format!("not fitted yet: {}\nhelp: {help}", missing.join(", ")));
            }
        }
        self.file()
    }
}

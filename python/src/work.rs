//! Runs a long call so that other Python threads continue and Ctrl-C ends it.

use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use fos_data::interrupt::{Interrupted, StopRequest, interruptible};
use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;

use crate::error::defect;

/// Interval between checks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// Stack size of a main thread, bytes: a predictor of the host's capacities is moved by value.
const STACK: usize = 8 << 20;

/// Runs `work` on another thread, without the lock of the interpreter. If a signal raises a Python exception, the
/// engine is asked to stop at its next check, and the exception is raised then.
///
/// # Errors
///
/// The exception of the signal; a defect of the engine.
pub(crate) fn run<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let stop = StopRequest::default();
    thread::scope(|scope| {
        let (done, mut waiting) = channel::<()>();
        let (wish, worker) = (stop.clone(), thread::Builder::new().stack_size(STACK));
        let worker = worker.spawn_scoped(scope, move || {
            // Dropped at the end of the thread, which wakes the receiver.
            let _done = done;
            let work = || interruptible(&wish, work);
            // A pool for this call only. Shared threads could deadlock: a call that changes a study and
            // waits for a part of its work would run another call that waits for this study. And after a
            // fork, as in `multiprocessing`, the threads of the parent do not exist.
            match ThreadPoolBuilder::new().stack_size(STACK).build() {
                Ok(threads) => threads.install(work),
                Err(_) => work(),
            }
        })?;
        let mut raised = None;
        loop {
            let heard;
            (heard, waiting) = py.detach(move || (waiting.recv_timeout(LOOK), waiting));
            if heard != Err(RecvTimeoutError::Timeout) {
                break;
            }
            if let Err(signal) = py.check_signals() {
                stop.ask();
                raised = Some(signal);
            }
        }
        let ended = py.detach(|| worker.join()).unwrap_or_else(|panic| resume_unwind(panic));
        match (raised, ended) {
            // The work may have finished before the request; its result is still unwanted.
            (Some(signal), _) => Err(signal),
            (None, Ok(result)) => Ok(result),
            (None, Err(Interrupted::Stopped | Interrupted::Panicked)) => Err(defect(py)),
        }
    })
}

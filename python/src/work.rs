//! A long call: the interpreter goes on with other threads meanwhile, and Ctrl-C ends it.

use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use fos_data::interrupt::{Interrupted, StopRequest, interruptible};
use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;

use crate::error::defect;

/// How often it is looked for Ctrl-C while the engine works.
const LOOK: Duration = Duration::from_millis(50);

/// As the main thread of a program has it: a predictor of the host's capacities is moved about by value.
const STACK: usize = 8 << 20;

/// Runs `work` on a thread of its own, without the lock of the interpreter. A signal that Python takes for an exception
/// asks the engine to stop where it next checks, and is raised once it has.
///
/// # Errors
///
/// What the signal was taken for; a defect of the engine.
pub(crate) fn run<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let stop = StopRequest::default();
    thread::scope(|scope| {
        let (done, mut waiting) = channel::<()>();
        let (wish, worker) = (stop.clone(), thread::Builder::new().stack_size(STACK));
        let worker = worker.spawn_scoped(scope, move || {
            // dropped with the thread, which is heard
            let _done = done;
            let work = || interruptible(&wish, work);
            // Of this call alone. Threads of several calls would be lent to one another: one that holds the study it
            // changes, and waits for a part of its work, would begin a call that waits for this study. And a process
            // that is forked, as `multiprocessing` does it, has none of its parent's threads to wait for.
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
            // it may have ended by itself before it was heard: what was asked for is still not wanted
            (Some(signal), _) => Err(signal),
            (None, Ok(result)) => Ok(result),
            (None, Err(Interrupted::Stopped | Interrupted::Panicked)) => Err(defect(py)),
        }
    })
}

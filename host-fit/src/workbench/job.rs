//! What a job is doing, and how far it is.

use serde::Serialize;

/// What a job is doing.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Job {
    /// As in `fitting gyro x`.
    what: String,
    /// Steps done.
    done: Option<usize>,
    /// Steps in all; none where that is not known.
    of: Option<usize>,
    /// Somebody waits for it, or for what comes after it: what else could be asked for should wait for the answer.
    pub(super) asked_for: bool,
}

impl Job {
    /// Work of unknown length.
    pub(super) fn new(what: impl Into<String>, asked_for: bool) -> Self {
        Self { what: what.into(), done: None, of: None, asked_for }
    }

    /// A step of several that somebody waits for.
    pub(super) fn step(what: impl Into<String>, done: usize, of: usize) -> Self {
        Self { what: what.into(), done: Some(done), of: Some(of), asked_for: true }
    }
}

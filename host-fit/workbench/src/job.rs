//! Description and progress of a job.

use serde::Serialize;

/// Description and progress of a job.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Job {
    /// Description, such as `fitting gyro x`.
    what: String,
    /// Number of steps done; none where it is unknown.
    done: Option<usize>,
    /// Total number of steps; none where it is unknown.
    of: Option<usize>,
    /// True if a user waits for the job, or for a later one: other requests should wait for the answer.
    pub(super) asked_for: bool,
}

impl Job {
    /// Job of unknown length.
    pub(super) fn new(what: impl Into<String>, asked_for: bool) -> Self {
        Self { what: what.into(), done: None, of: None, asked_for }
    }

    /// One of several steps that a user waits for.
    pub(super) fn step(what: impl Into<String>, done: usize, of: usize) -> Self {
        Self { what: what.into(), done: Some(done), of: Some(of), asked_for: true }
    }
}

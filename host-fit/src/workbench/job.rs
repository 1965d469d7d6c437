//! What a job is doing, and how far it is.

use serde::Serialize;

/// What a job is doing.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct Job {
    /// In words.
    what: String,
    /// Steps done.
    done: Option<usize>,
    /// Steps in all; none where that is not known.
    of: Option<usize>,
}

impl Job {
    /// Work of unknown length.
    pub(super) fn new(what: impl Into<String>) -> Self {
        Self { what: what.into(), done: None, of: None }
    }

    /// A step of several.
    pub(super) fn step(what: impl Into<String>, done: usize, of: usize) -> Self {
        Self { what: what.into(), done: Some(done), of: Some(of) }
    }
}

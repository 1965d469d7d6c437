//! Logs used to refine one axis.

use super::refiner::Refiner;
use crate::effects::Library;
use crate::study::LogSources;
use fos_data::recording::{LoadOptions, Recording, Source};

/// Logs that effects are estimated from and evaluated on, and the options of reading them.
#[derive(Debug, Clone)]
pub struct Logs {
    /// Log to explain.
    pub field: Recording,
    /// Reference log of the same device.
    pub quiet: Option<Recording>,
    /// Evaluation log; without one the last part of the log to explain is reserved.
    pub judged: Option<Recording>,
    pub read: LoadOptions,
}

impl Logs {
    /// Returns a refiner of these logs.
    pub fn refiner<'a>(&'a self, library: &'a Library) -> Refiner<'a> {
        Refiner::new(&self.field, self.quiet.as_ref(), self.judged.as_ref(), library)
    }

    /// Returns the sources as a study stores them; effects are estimated from `fitted_rows` of the log to explain.
    pub fn named(&self, fitted_rows: usize) -> LogSources {
        let source = |recording: &Recording| {
            recording.sources.first().cloned().unwrap_or_else(|| Source::made_by("nothing"))
        };
        LogSources {
            field: source(&self.field),
            quiet: self.quiet.as_ref().map(source),
            judged: self.judged.as_ref().map(source),
            fitted_rows,
            read: self.read.clone(),
        }
    }
}

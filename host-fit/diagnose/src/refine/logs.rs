//! Logs used to refine one axis.

use super::refiner::Refiner;
use crate::effects::Library;
use crate::study::LogSources;
use fos_data::recording::{LoadOptions, Recording, Source};

/// Logs that effects are estimated from and evaluated on, and the options of reading them.
#[derive(Debug, Clone)]
pub struct Logs {
    /// Log to explain.
    pub log: Recording,
    /// Reference log of the same device.
    pub reference: Option<Recording>,
    /// Evaluation log; without one the last part of the log to explain is reserved.
    pub evaluation: Option<Recording>,
    pub read: LoadOptions,
}

impl Logs {
    /// Returns a refiner of these logs.
    pub fn refiner<'a>(&'a self, library: &'a Library) -> Refiner<'a> {
        Refiner::new(&self.log, self.reference.as_ref(), self.evaluation.as_ref(), library)
    }

    /// Returns the sources as a study stores them; effects are estimated from `fitted_rows` of the log to explain.
    pub fn named(&self, fitted_rows: usize) -> LogSources {
        let source = |recording: &Recording| {
            recording.sources.first().cloned().unwrap_or_else(|| Source::made_by("nothing"))
        };
        LogSources {
            log: source(&self.log),
            reference: self.reference.as_ref().map(source),
            evaluation: self.evaluation.as_ref().map(source),
            fitted_rows,
            read: self.read.clone(),
        }
    }
}

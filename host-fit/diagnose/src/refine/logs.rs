//! The logs that an axis grows on, as read.

use super::refiner::Refiner;
use crate::effects::Library;
use crate::study::LogSources;
use fos_data::recording::{LoadOptions, Recording, Source};

/// The logs that effects are estimated from and judged on, and how they were read.
#[derive(Debug, Clone)]
pub struct Logs {
    /// The log where the model fails.
    pub field: Recording,
    /// A quiet log of the same unit.
    pub quiet: Option<Recording>,
    /// The log that errors are of; without one the last part of the field log is kept back.
    pub judged: Option<Recording>,
    pub read: LoadOptions,
}

impl Logs {
    /// What an axis grows on.
    pub fn refiner<'a>(&'a self, library: &'a Library) -> Refiner<'a> {
        Refiner::new(&self.field, self.quiet.as_ref(), self.judged.as_ref(), library)
    }

    /// As a study remembers them; `fitted_rows` of the field log are estimated from.
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

//! The user's work on a study, a step at a time: the logs of a step, and the effects that it adds. The command line and Python share it;
//! they differ in where a log comes from.

use fos_data::recording::{LoadOptions, Recording, Source};

use crate::detect::Diagnosis;
use crate::effects::Library;
use crate::refine::{Logs, RefineError};
use crate::study::{Refinement, RefinementStep, Study};

/// Logs that the user names for a step. Those of the step before stand in for the others.
#[derive(Debug, Clone)]
pub struct NamedLogs<L> {
    /// Log to explain.
    pub log: Option<L>,
    /// Reference log; before the first step the log that the study was fitted to, unless it is the log to explain.
    pub reference: Option<L>,
    /// Evaluation log.
    pub evaluation: Option<L>,
}

/// A log to load.
#[derive(Debug)]
pub enum Wanted<'a, L> {
    Named(&'a L),
    Stored(&'a Source),
}

/// No step was made before, and no log to explain is named.
#[derive(Debug, thiserror::Error)]
#[error("no log to explain")]
pub struct NoLog;

impl<L: Sync> NamedLogs<L> {
    /// Loads the logs of a step on `column`, in parallel; `read` are the options that they are read with. A log to explain
    /// that `may_be` the one that the study was fitted to is loaded before that, which is then seldom needed. Fails with
    /// [`NoLog`] or the first error of `load`.
    pub fn load<E: From<NoLog> + Send>(
        &self,
        study: &Study,
        column: &str,
        read: LoadOptions,
        may_be: impl Fn(&L, &Source) -> bool,
        load: impl Fn(Wanted<'_, L>) -> Result<Recording, E> + Sync,
    ) -> Result<Logs, E> {
        let before = study.refinement_of(column).map(|refinement| &refinement.logs);
        let own = match (before, &study.data.sources[..]) {
            (None, [own]) => Some(own),
            _ => None,
        };
        let wanted =
            |named, stored: Option<_>| Option::map(named, Wanted::Named).or(stored.map(Wanted::Stored));
        let log = wanted(self.log.as_ref(), before.map(|logs| &logs.log)).ok_or(NoLog)?;
        let reference =
            wanted(self.reference.as_ref(), own.or(before.and_then(|logs| logs.reference.as_ref())));
        // the stored evaluation log is of the stored log to explain
        let continued = before.filter(|_| self.log.is_none()).and_then(|logs| logs.evaluation.as_ref());
        let evaluation = wanted(self.evaluation.as_ref(), continued);
        let optional = |wanted: Option<_>| wanted.map(&load).transpose();
        let (at_once, later) = match (&self.log, &self.reference, own) {
            (Some(log), None, Some(own)) if may_be(log, own) => (None, reference),
            _ => (reference, None),
        };
        let (log, (reference, evaluation)) =
            rayon::join(|| load(log), || rayon::join(|| optional(at_once), || optional(evaluation)));
        let log = log?;
        // the model fails on its own log
        let is_own = self.reference.is_none() && own.is_some() && own == log.sources.first();
        let reference = if is_own { None } else { reference?.or(optional(later)?) };
        Ok(Logs { log, reference, evaluation: evaluation?, read })
    }
}

/// Effects to add in a step.
#[derive(Debug, Clone, Copy)]
pub enum Addition<'a> {
    /// One effect, by its identifier.
    Effect(&'a str),
    /// The findings of the diagnosis, until nothing is worth adding.
    Best,
}

/// Adds effects to an axis of a study, estimated on these logs. `progress` is called with each diagnosis and step of [`Addition::Best`].
/// The study is unchanged if it fails, as when the model with all axes exceeds the limits of a predictor.
pub fn add(
    study: &mut Study,
    column: &str,
    logs: &Logs,
    library: &Library,
    addition: Addition<'_>,
    progress: &mut dyn FnMut(&Diagnosis, Option<&RefinementStep>),
) -> Result<Refinement, RefineError> {
    let refiner = logs.refiner(library);
    let mut refinement = refiner.resume(study, column, logs.named(refiner.fitted_rows()))?;
    match addition {
        Addition::Effect(id) => refinement.steps.push(refiner.add(&refinement, library.get(id)?)?),
        Addition::Best => refinement.steps.extend(refiner.add_best(&refinement, progress)?),
    }
    let mut grown = study.clone();
    grown.keep(refinement.clone());
    // an axis may be within the limits of a predictor alone, and exceed them with the others
    grown.model.predictor::<f64>()?;
    *study = grown;
    Ok(refinement)
}

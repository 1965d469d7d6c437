//! A diagnosis in three stages: the logs are prepared, every search runs, and the results become findings.

use std::sync::Arc;

use super::answer::{Diagnosis, Finding};
use super::findings::Composer;
use super::prepared::Prepared;
use super::question::{DiagnoseError, Question};
use super::search::SearchResults;
use super::testable::lacking;
use crate::effects::Detector;

/// Diagnoses the missing effects of an axis.
pub fn diagnose(question: &Question<'_>) -> Result<Diagnosis, DiagnoseError> {
    let mut prepared = Prepared::new(question)?;
    let lines = prepared.remove_lines()?;
    let results = SearchResults::of(&prepared, lines)?;
    Composer { prepared: &prepared, results }.diagnosis()
}

/// Estimates effects together, whether or not they are missing, in this order: parameters, sizes, and the reduction by
/// each with those before it in the model. Spectral lines are assigned in order of strength.
pub fn estimate(question: &Question<'_>, effects: &[String]) -> Result<Vec<Finding>, DiagnoseError> {
    let prepared = Prepared::new(question)?;
    prepared.long_enough()?;
    let not_there = |effect: &str, reason: &str| DiagnoseError::NotThere {
        effect: effect.to_owned(),
        reason: reason.to_owned(),
    };
    let mut wanted = Vec::new();
    for id in effects {
        let effect = question.library.get(id)?;
        match lacking(effect, prepared.inputs(), &prepared.column) {
            None => return Err(not_there(id, &format!("it does not strike {}", prepared.column))),
            Some(missing) if !missing.is_empty() => {
                return Err(not_there(id, &format!("the log has no {}", missing.join(", "))));
            }
            Some(_) if matches!(effect.search, Detector::Terms | Detector::Step) => {
                wanted.push(Arc::new(effect.clone()));
            }
            Some(_) => {}
        }
    }
    let results = SearchResults::of_effects(&prepared, &wanted)?;
    let mut findings = Composer { prepared: &prepared, results }.estimates()?;
    effects
        .iter()
        .map(|id| {
            let at = findings.iter().position(|finding| finding.effect == *id);
            let found = at.map(|at| findings.remove(at));
            found.filter(|finding| !finding.correction.is_empty()).ok_or_else(|| {
                let experiment = question.library.get(id).map_or("", |effect| effect.experiment.as_str());
                let reason = format!(
                    "its inputs do not change, or it stays within the noise\nhelp: record a log that shows it: {experiment}"
                );
                not_there(id, &reason)
            })
        })
        .collect()
}

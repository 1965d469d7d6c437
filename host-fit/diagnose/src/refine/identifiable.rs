//! Check that the log in which an effect was found determines it.

use super::error::RefineError;
use crate::detect::{Finding, Verdict, not_identifiable};
use crate::effects::{Effect, Library};
use crate::study::{Left, Refinement};
use fos_data::column::Column;
use fos_data::text::rounded;

/// Least relative increase of an RMS that counts. Over the 400 s of an evaluation log the RMS of 1-s means is known to
/// 7 % if they are independent, which they are not.
pub(super) const SAME_RMS: f64 = 0.1;

/// Rejects an effect that its log does not determine.
pub(super) fn identified(finding: &Finding, effect: &Effect, column: &str) -> Result<(), RefineError> {
    match not_identifiable(finding, effect, column) {
        Some(reason) => {
            let (effect, experiment) = (effect.id.clone(), effect.experiment.clone());
            Err(RefineError::NotIdentifiable { effect, reason, experiment })
        }
        None => Ok(()),
    }
}

/// Rejects the last of the effects of a model if the log does not determine it, or if with it another effect is no
/// longer determined.
pub(super) fn identifiable(findings: &[Finding], library: &Library, column: &str) -> Result<(), RefineError> {
    let Some(added) = findings.last() else { return Ok(()) };
    for finding in findings.iter().rev() {
        let effect = library.get(&finding.effect)?;
        let Some(reason) = not_identifiable(finding, effect, column) else { continue };
        let reason = match finding.effect == added.effect {
            true => reason,
            false => {
                format!("in this log {} of the model is indistinguishable from it: {reason}", finding.name)
            }
        };
        let experiment = library.get(&added.effect)?.experiment.clone();
        return Err(RefineError::NotIdentifiable { effect: added.effect.clone(), reason, experiment });
    }
    Ok(())
}

/// Returns the reason why a refined model is not an all-clear: an effect that its log does not determine, or an error,
/// the mean included, that is larger than before any effect was added. `continues` is true if the slow error contains the
/// mean, because the evaluation rows continue the log to explain.
pub(super) fn all_clear_refuted(refinement: &Refinement, continues: bool) -> Option<(Verdict, String)> {
    let undetermined = refinement.added().find_map(|added| {
        let why = not_identifiable(&added.finding, &added.effect, &refinement.column)?;
        Some(format!(
            "Not enough data: {} in the model is not identifiable from the log it was added from: {why}. Take it back.",
            added.finding.name
        ))
    });
    if let Some(sentence) = undetermined {
        return Some((Verdict::NotEnoughData, sentence));
    }
    let [first, .., last] = &refinement.steps[..] else { return None };
    let rms = |left: &Left| match left.bias.filter(|_| !continues) {
        Some(bias) => (left.slow + bias * bias).sqrt(),
        None => left.slow.sqrt(),
    };
    let (before, after) = (rms(&first.left), rms(&last.left));
    (after > (1.0 + SAME_RMS) * before).then(|| {
        let unit = Column::named(&refinement.column).unit().label();
        let sentence = format!(
            "The effects that were added make the slow error larger, its mean included ({} to {} {unit} RMS). Take them back.",
            rounded(before, 3),
            rounded(after, 3)
        );
        (Verdict::Unexplained, sentence)
    })
}

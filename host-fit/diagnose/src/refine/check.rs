//! What an effect must satisfy before it is added: the log determines it, and no other log gets worse by it, in its mean
//! or in its scatter.

use super::error::RefineError;
use super::refiner::Refiner;
use crate::detect::{Finding, Verdict, is_bias_known, is_step, not_identifiable};
use crate::effects::{Band, Effect, Library};
use crate::study::{Left, Refinement};
use fos_data::column::Column;
use fos_data::text::rounded;
use fos_fit::model::UnitModel;
use fos_fit::signal;

/// Equal parts of a log whose means scatter as the mean of the whole log does: of flicker noise the mean over a longer
/// time is hardly known better.
const PARTS: usize = 8;

/// A mean error that grows by so many standard deviations grows: those of a 95 % interval.
const TWO_SIDED_95: f64 = 1.96;

/// An RMS that grows by a smaller share has not grown: over the 400 s of an evaluation log the RMS of 1-s means is known to
/// 7 % if they are independent, and they are not.
const SAME_RMS: f64 = 0.1;

/// Refuses the last of the effects that a model would have if the log does not determine it, or with it no longer
/// another.
pub(super) fn identifiable(
    findings: &[Finding],
    library: &Library,
    column: &str,
) -> Result<(), RefineError> {
    let Some(added) = findings.last() else { return Ok(()) };
    for finding in findings.iter().rev() {
        let effect = library.get(&finding.effect)?;
        let Some(reason) = not_identifiable(finding, effect, column) else { continue };
        let reason = match finding.effect == added.effect {
            true => reason,
            false => format!("{} of the model cannot be told from it: {reason}", finding.name),
        };
        let experiment = library.get(&added.effect)?.experiment.clone();
        return Err(RefineError::NotIdentifiable { effect: added.effect.clone(), reason, experiment });
    }
    Ok(())
}

/// What refutes that nothing is missing from a refined model: an effect that its log does not determine, or an error
/// that is larger than before anything was added, the mean included.
pub(super) fn all_clear_refuted(refinement: &Refinement) -> Option<(Verdict, String)> {
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
    let rms = |left: &Left| (left.slow + left.bias.unwrap_or(0.0).powi(2)).sqrt();
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

/// The error of a log: the mean less that of the field log, where both are known, and the RMS about it.
struct Errors {
    mean: Option<f64>,
    rms: f64,
    /// Standard deviation of the mean.
    deviation: f64,
}

impl Refiner<'_> {
    /// Refuses the effect at `place` of `findings` if with it the error of another log grows by more than its interval.
    /// All others are taken off before and after: of two effects that cancel in part each alone makes an error larger.
    pub(super) fn check_errors(
        &self,
        base: &UnitModel,
        findings: &[Finding],
        place: usize,
        effect: &Effect,
    ) -> Result<(), RefineError> {
        let Some(finding) = findings.get(place) else { return Ok(()) };
        let mut without = findings.to_vec();
        without.remove(place);
        let column = &base.axes[0].column;
        let unit = Column::named(column).unit().label();
        for (at, (name, log, rows)) in self.checked_logs().into_iter().enumerate() {
            // a reference log may be older than a step, and its power may have come on long before it
            if at > 0 && (is_step(finding) || effect.follows_clock_alone()) {
                continue;
            }
            let errors = |findings: &[Finding]| -> Result<Errors, RefineError> {
                let (field, of_field) = self.reduced_without(base, findings, self.field_at_rest())?;
                let (reduced, left) = self.reduced_without(base, findings, log)?;
                let all = 0..of_field.len();
                let is_known = is_bias_known(log, column) && is_bias_known(self.field_at_rest(), column);
                let mean = reduced.slow_mean(&left, &rows) - field.slow_mean(&of_field, &all);
                let parts = |reduced: &crate::detect::ErrorInBlocks, left: &[f64], rows: &std::ops::Range<usize>| {
                    let length = rows.len().div_ceil(PARTS).max(1);
                    let starts = rows.clone().step_by(length);
                    let means = starts.map(|start| {
                        reduced.slow_mean(left, &(start..(start + length).min(rows.end)))
                    });
                    let means: Vec<f64> = means.filter(|mean| mean.is_finite()).collect();
                    signal::variance(&[&means])
                };
                Ok(Errors {
                    mean: is_known.then_some(mean),
                    rms: match effect.band {
                        Band::Wide => reduced.wide_variance(&left, &rows).sqrt(),
                        _ => reduced.slow_variance(&left, &rows).sqrt(),
                    },
                    deviation: (parts(&field, &of_field, &all) + parts(&reduced, &left, &rows)).sqrt(),
                })
            };
            // a reference log need not have every input
            let (before, after) = match (errors(&without), errors(findings)) {
                (Ok(before), Ok(after)) => (before, after),
                (Err(RefineError::Recording(_)), _) | (_, Err(RefineError::Recording(_))) if at > 0 => continue,
                (Err(error), _) | (_, Err(error)) => return Err(error),
            };
            let worse = |what: &'static str, before: f64, after: f64, margin: f64| {
                let [before, after, margin] = [before, after, margin].map(|value| rounded(value, 3));
                let (log, experiment) = (name.to_owned(), effect.experiment.clone());
                let effect = effect.id.clone();
                RefineError::MakesWorse { effect, what, log, before, after, margin, unit, experiment }
            };
            if let (Some(was), Some(is)) = (before.mean, after.mean) {
                let margin = TWO_SIDED_95 * before.deviation.min(after.deviation);
                if is.abs() > was.abs() + margin {
                    return Err(worse("mean error", was.abs(), is.abs(), margin));
                }
            }
            // the reference log shows no effect, and scatters as its noise does whatever is taken off
            let margin = SAME_RMS * before.rms;
            if at == 0 && after.rms > before.rms + margin {
                return Err(worse("slow error", before.rms, after.rms, margin));
            }
        }
        Ok(())
    }
}

//! What an effect must satisfy before it is added: the log determines it, and the evaluation log does not get worse by it,
//! in its mean or in its scatter.

use std::ops::Range;

use super::error::RefineError;
use super::refiner::Refiner;
use crate::detect::{ErrorInBlocks, Finding, Verdict, is_bias_known, not_identifiable};
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

/// Refuses an effect that the log it was found in does not determine.
pub(super) fn identified(finding: &Finding, effect: &Effect, column: &str) -> Result<(), RefineError> {
    match not_identifiable(finding, effect, column) {
        Some(reason) => {
            let (effect, experiment) = (effect.id.clone(), effect.experiment.clone());
            Err(RefineError::NotIdentifiable { effect, reason, experiment })
        }
        None => Ok(()),
    }
}

/// Refuses the last of the effects that a model would have if the log does not determine it, or with it no longer
/// another.
pub(super) fn identifiable(findings: &[Finding], library: &Library, column: &str) -> Result<(), RefineError> {
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

/// The error of the evaluation log: the mean less that of the field log, where both are known, and the RMS about it.
struct Errors {
    mean: Option<f64>,
    rms: f64,
    /// Standard deviation of the mean.
    deviation: f64,
}

impl Refiner<'_> {
    /// Refuses the effect at `place` of `findings` if with it the error of the evaluation log grows by more than its
    /// interval. All others are taken off before and after: of two effects that cancel in part each alone makes an error
    /// larger. The reference log is not asked: by what it is for, it may be one without the effect.
    pub(super) fn check_errors(
        &self,
        base: &UnitModel,
        findings: &[Finding],
        place: usize,
        effect: &Effect,
    ) -> Result<(), RefineError> {
        let mut without = findings.to_vec();
        if place < without.len() {
            without.remove(place);
        }
        let (before, after) =
            (self.errors(base, &without, effect.band)?, self.errors(base, findings, effect.band)?);
        let unit = Column::named(&base.axes[0].column).unit().label();
        let worse = |what: &'static str, values: [f64; 3]| {
            let [before, after, margin] = values.map(|value| rounded(value, 3));
            let (effect, experiment) = (effect.id.clone(), effect.experiment.clone());
            RefineError::MakesWorse { effect, what, before, after, margin, unit, experiment }
        };
        if let (Some(was), Some(is)) = (before.mean, after.mean) {
            let margin = TWO_SIDED_95 * before.deviation.min(after.deviation);
            if is.abs() > was.abs() + margin {
                return Err(worse("mean error", [was.abs(), is.abs(), margin]));
            }
        }
        let margin = SAME_RMS * before.rms;
        if after.rms > before.rms + margin {
            return Err(worse("RMS error", [before.rms, after.rms, margin]));
        }
        Ok(())
    }

    /// The errors of the evaluation log without the physical part of `base` and without `findings`.
    fn errors(&self, base: &UnitModel, findings: &[Finding], band: Band) -> Result<Errors, RefineError> {
        let (column, judged, rows) = (&base.axes[0].column, self.judged(), self.judged_rows());
        let (field, left_of_field) = self.reduced_without(base, findings, self.field())?;
        let (reduced, left) = self.reduced_without(base, findings, judged)?;
        let all = 0..left_of_field.len();
        let parts = |reduced: &ErrorInBlocks, left: &[f64], rows: &Range<usize>| {
            let length = rows.len().div_ceil(PARTS).max(1);
            let ends = |start: usize| (start + length).min(rows.end);
            let starts = rows.clone().step_by(length);
            let means = starts.map(|start| reduced.slow_mean(left, &(start..ends(start))));
            signal::variance(&[&means.filter(|mean| mean.is_finite()).collect::<Vec<f64>>()])
        };
        let mean = reduced.slow_mean(&left, &rows) - field.slow_mean(&left_of_field, &all);
        let is_known = is_bias_known(judged, column) && is_bias_known(self.field(), column);
        Ok(Errors {
            mean: is_known.then_some(mean),
            rms: match band {
                Band::Wide => reduced.wide_variance(&left, &rows).sqrt(),
                _ => reduced.slow_variance(&left, &rows).sqrt(),
            },
            deviation: (parts(&field, &left_of_field, &all) + parts(&reduced, &left, &rows)).sqrt(),
        })
    }
}

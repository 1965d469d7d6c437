//! Validation of findings on another log: an effect that makes the error worse there is rejected.

use std::borrow::Cow;
use std::ops::Range;

use super::answer::{Diagnosis, Finding, Verdict};
use super::correction::{correction, is_step};
use super::diagnose::diagnose;
use super::error_in_blocks::ErrorInBlocks;
use super::findings::{is_confirmed, sentence, verdict};
use super::open::{Lead, LeadKind};
use super::question::{DiagnoseError, Question, keeps_bias};
use crate::effects::Band;
use crate::rms::rms_reduction;
use fos_data::disturbance;
use fos_data::recording::Recording;

/// Largest relative increase of the variance that counts as no change.
const LEAST_RISE: f64 = 0.005;

/// Diagnoses the missing effects of an axis, and measures their reductions if there is an evaluation log. One that begins
/// where the log to explain ends is evaluated after it, so that lags and hysteresis have their states.
pub fn diagnose_and_measure(question: &Question<'_>) -> Result<Diagnosis, DiagnoseError> {
    let Some(evaluation) = question.evaluation else { return diagnose(question) };
    let (log, from) = match question.evaluation_from {
        0 => evaluation.led_in_by(question.log),
        from => (Cow::Borrowed(evaluation), from),
    };
    let diagnosis = diagnose(&Question { evaluation: Some(&log), evaluation_from: from, ..*question })?;
    with_measured_reduction(diagnosis, question.log, &log, &(from..log.n_rows()))
}

/// Adds to every finding the reduction measured on `rows` of `evaluation`, with the findings before it in the model. A slow
/// effect that makes the error worse than predicted becomes a lead if its predicted interval excludes 0, else it is not
/// conclusive; in either case the next ones are measured without it.
pub fn with_measured_reduction(
    mut diagnosis: Diagnosis,
    fitted: &Recording,
    evaluation: &Recording,
    rows: &Range<usize>,
) -> Result<Diagnosis, DiagnoseError> {
    let (evaluation, fitted) = (&*disturbance::marked(evaluation).0, &*disturbance::marked(fitted).0);
    let reduced = ErrorInBlocks::in_slow_blocks(evaluation, &diagnosis.target)?;
    let own = ErrorInBlocks::in_slow_blocks(fitted, &diagnosis.target)?;
    let continues = keeps_bias(evaluation, &diagnosis.target, rows.start);
    let residual_of =
        |reduced: &ErrorInBlocks, log: &Recording, findings: &[Finding]| -> Result<Vec<f64>, DiagnoseError> {
            let taken = correction(findings, fitted, log)?;
            Ok(reduced.error.iter().zip(&taken).map(|(error, taken)| error - taken).collect())
        };
    let error = |findings: &[Finding], as_of: &Finding| -> Result<f64, DiagnoseError> {
        let residual = residual_of(&reduced, evaluation, findings)?;
        Ok(match as_of.band {
            Band::Wide => reduced.wide_variance(&residual, rows),
            // the error counts from the bias of the log in which the effect was found, if that is known here; a step is a
            // constant
            _ if continues || is_step(as_of) => {
                let bias = own.slow_mean(&residual_of(&own, fitted, findings)?, &(0..fitted.n_rows()));
                reduced.slow_mean_square(&residual, rows, bias)
            }
            _ => reduced.slow_variance(&residual, rows),
        })
    };
    let mut accepted: Vec<Finding> = Vec::new();
    // those of them whose effects are subtracted when the next one is measured
    let mut model: Vec<Finding> = Vec::new();
    let mut has_changed = false;
    let unmeasured = std::mem::take(&mut diagnosis.findings);
    for mut finding in unmeasured.clone() {
        if finding.correction.is_empty() {
            accepted.push(finding);
            continue;
        }
        if is_step(&finding) && !continues && !evaluation.is_bias_known(&diagnosis.target) {
            accepted.push(finding);
            continue;
        }
        let before = error(&model, &finding)?;
        let mut with = model.clone();
        with.push(finding.clone());
        let reduction = 1.0 - error(&with, &finding)? / before;
        finding.measured_reduction = Some(reduction);
        // the evaluation log may confirm an effect that its own log leaves open; but not a function of the clock, which
        // fits any drift, nor an implausible size
        if finding.shows_against.is_some()
            && finding.predicted_reduction_interval[0] <= 0.0
            && is_confirmed(&finding)
        {
            has_changed |= finding.doubt.take().is_some();
        }
        let least = finding.predicted_reduction_interval[0];
        if finding.band == Band::Slow && reduction < least.min(-LEAST_RISE) {
            let growth = -100.0 * rms_reduction(reduction);
            let growth = format!("it increases the RMS on the evaluation log by {growth:.0} %");
            if least > 0.0 {
                let follows = format!("{} in this log, but {growth}", finding.name);
                let score = finding.score.unwrap_or(0.0);
                diagnosis.leads.push(Lead {
                    gain: finding.gain.unwrap_or(0.0),
                    share: finding.predicted_reduction,
                    ..Lead::new(LeadKind::Refuted, follows, finding.band, score)
                });
                continue;
            }
            has_changed |= finding.doubt.is_none();
            finding.doubt.get_or_insert(growth);
            accepted.push(finding);
            continue;
        }
        if finding.band == Band::Slow && finding.predicted_reduction_interval[1] > 0.0 && reduction <= 0.0 {
            has_changed |= finding.doubt.is_none();
            finding
                .doubt
                .get_or_insert_with(|| "it does not reduce the RMS on the evaluation log".to_owned());
        }
        model.push(finding.clone());
        accepted.push(finding);
    }
    let measured = accepted.len();
    diagnosis.findings = accepted;
    if (has_changed || !diagnosis.leads.is_empty()) && diagnosis.verdict != Verdict::NotEnoughData {
        diagnosis.leads.sort_by(|a, b| b.score.total_cmp(&a.score));
        diagnosis.verdict = verdict(&mut diagnosis.findings, &diagnosis.leads, !diagnosis.tested.is_empty());
        diagnosis.sentence = sentence(diagnosis.verdict, &diagnosis.findings, &diagnosis.leads);
    }
    if diagnosis.findings.len() < measured {
        // the others were measured with the withheld findings in the model
        let is_reported = |finding: &Finding| {
            diagnosis
                .findings
                .iter()
                .any(|other| other.effect == finding.effect && other.params == finding.params)
        };
        diagnosis.findings = unmeasured.into_iter().filter(is_reported).collect();
        return with_measured_reduction(diagnosis, fitted, evaluation, rows);
    }
    Ok(diagnosis)
}

//! Validation of findings on another log: an effect that makes the error worse there is rejected.

use std::ops::Range;

use super::answer::{Diagnosis, Finding, Verdict};
use super::correction::{correction, is_step};
use super::error_in_blocks::ErrorInBlocks;
use super::findings::{is_confirmed, sentence, verdict};
use super::open::{Lead, LeadKind};
use super::question::{DiagnoseError, is_bias_known};
use crate::effects::Band;
use crate::rms::rms_reduction;
use fos_data::disturbance;
use fos_data::recording::Recording;

/// Largest relative increase of the variance that counts as no change.
const LEAST_RISE: f64 = 0.005;

/// Adds to every finding the reduction measured on `rows` of `judged`, with the findings before it in the model. A slow
/// effect whose predicted interval excludes 0 and that makes the error worse becomes a lead.
///
/// # Errors
///
/// A column is missing.
pub fn with_measured_reduction(
    mut diagnosis: Diagnosis,
    field: &Recording,
    judged: &Recording,
    rows: &Range<usize>,
) -> Result<Diagnosis, DiagnoseError> {
    let (judged, field) = (&*disturbance::marked(judged).0, &*disturbance::marked(field).0);
    let reduced = ErrorInBlocks::in_slow_blocks(judged, &diagnosis.target)?;
    let own = ErrorInBlocks::in_slow_blocks(field, &diagnosis.target)?;
    let residual_of =
        |reduced: &ErrorInBlocks, log: &Recording, findings: &[Finding]| -> Result<Vec<f64>, DiagnoseError> {
            let taken = correction(findings, field, log)?;
            Ok(reduced.error.iter().zip(&taken).map(|(error, taken)| error - taken).collect())
        };
    let error = |findings: &[Finding], as_of: &Finding| -> Result<f64, DiagnoseError> {
        let residual = residual_of(&reduced, judged, findings)?;
        Ok(match as_of.band {
            Band::Wide => reduced.wide_variance(&residual, rows),
            // a step is constant here: its error counts from the bias of the log in which it was found
            _ if is_step(as_of) => {
                let bias = own.slow_mean(&residual_of(&own, field, findings)?, &(0..field.n_rows()));
                reduced.slow_variance(&residual, rows) + (reduced.slow_mean(&residual, rows) - bias).powi(2)
            }
            _ => reduced.slow_variance(&residual, rows),
        })
    };
    let mut accepted: Vec<Finding> = Vec::new();
    let mut has_new_claim = false;
    for mut finding in std::mem::take(&mut diagnosis.findings) {
        if finding.correction.is_empty() {
            accepted.push(finding);
            continue;
        }
        if is_step(&finding) && !is_bias_known(judged, &diagnosis.target) {
            accepted.push(finding);
            continue;
        }
        let before = error(&accepted, &finding)?;
        let mut with = accepted.clone();
        with.push(finding.clone());
        let reduction = 1.0 - error(&with, &finding)? / before;
        finding.measured_reduction = Some(reduction);
        // the evaluation log may confirm an effect that its own log leaves open; but not a function of the clock, which
        // fits any drift, nor an implausible size
        if finding.shows_against.is_some()
            && finding.predicted_reduction_interval[0] <= 0.0
            && is_confirmed(&finding)
        {
            has_new_claim |= finding.doubt.take().is_some();
        }
        if finding.band == Band::Slow
            && reduction < -LEAST_RISE
            && finding.predicted_reduction_interval[0] > 0.0
        {
            diagnosis.leads.push(Lead {
                kind: LeadKind::Refuted,
                follows: format!(
                    "{} in this log, but it increases the RMS on the evaluation log by {:.0} %",
                    finding.name,
                    -100.0 * rms_reduction(reduction)
                ),
                gain: finding.gain.unwrap_or(0.0),
                score: finding.score.unwrap_or(0.0),
                share: finding.predicted_reduction,
                band: finding.band,
                decides: true,
            });
        } else {
            accepted.push(finding);
        }
    }
    diagnosis.findings = accepted;
    if (has_new_claim || !diagnosis.leads.is_empty()) && diagnosis.verdict != Verdict::NotEnoughData {
        diagnosis.leads.sort_by(|a, b| b.score.total_cmp(&a.score));
        diagnosis.verdict = verdict(&mut diagnosis.findings, &diagnosis.leads, !diagnosis.tested.is_empty());
        diagnosis.sentence = sentence(diagnosis.verdict, &diagnosis.findings, &diagnosis.leads);
    }
    Ok(diagnosis)
}

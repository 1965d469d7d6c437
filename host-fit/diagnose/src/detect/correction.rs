//! Correction by the findings of a diagnosis.

use super::answer::{CorrectionTerm, Finding};
use crate::effects::{Band, Inputs, Regressor};
use fos_data::recording::{Recording, RecordingError};

/// Returns the values to subtract, one per row of `log`, in the unit of the axis: the sum over all findings. `fitted`
/// is the log of the diagnosis. On its mean the correction of a slow effect is 0, since the mean belongs to the bias.
///
/// A step that was found in one log is a constant in the next. Before its first value a quantity is taken as constant.
pub fn correction(
    findings: &[Finding],
    fitted: &Recording,
    log: &Recording,
) -> Result<Vec<f64>, RecordingError> {
    let (own, other) = (Inputs::new(fitted), Inputs::new(log));
    let mut sum = vec![0.0; log.n_rows()];
    for finding in findings {
        for CorrectionTerm { regressor, coefficient, .. } in &finding.correction {
            if let Some(time_s) = step_time(regressor) {
                add_step(&mut sum, *coefficient, time_s, fitted, log);
                continue;
            }
            let Ok(regressor) = Regressor::parse(regressor) else { continue };
            let mean = mean_at_fit(&own, &regressor)?;
            let values = other.regressor_within(&regressor, &finding.limits)?;
            for (sum, value) in sum.iter_mut().zip(values.iter()) {
                *sum += coefficient * (value - mean);
            }
        }
    }
    Ok(sum)
}

/// Returns the mean of a regressor over the log that the effect was found in: there its correction is 0.
pub(super) fn mean_at_fit(fitted: &Inputs<'_>, regressor: &Regressor) -> Result<f64, RecordingError> {
    Ok(fos_fit::signal::mean(&[&fitted.regressor(regressor)?]))
}

/// Adds a step about its mean in the log that it was found in; in another log it is a constant.
fn add_step(sum: &mut [f64], coefficient: f64, time_s: f64, fitted: &Recording, log: &Recording) {
    let mean = step_share(fitted, time_s);
    let own = fitted.sources == log.sources;
    for (sum, time) in sum.iter_mut().zip(&log.time_s) {
        let after = !own || *time - log.time_s[0] > time_s;
        *sum += coefficient * (f64::from(u8::from(after)) - mean);
    }
}

/// Returns the share of a log that lies after a step.
pub(super) fn step_share(log: &Recording, time_s: f64) -> f64 {
    let after = log.time_s.iter().filter(|time| **time - log.time_s[0] > time_s).count();
    after as f64 / log.n_rows() as f64
}

/// Removes the detected steps from the log that they were found in: returns the values as if every step had happened
/// before the log began, as it has in every later log.
pub(crate) fn as_after_steps(
    findings: &[Finding],
    column: &str,
    log: &Recording,
) -> Result<Recording, RecordingError> {
    let terms = findings.iter().flat_map(|finding| &finding.correction);
    let steps: Vec<(f64, f64)> =
        terms.filter_map(|term| Some((step_time(&term.regressor)?, term.coefficient))).collect();
    if steps.is_empty() {
        return Ok(log.clone());
    }
    let to_come = |time: f64| -> f64 {
        steps.iter().filter(|(at, _)| time - log.time_s[0] <= *at).map(|(_, size)| size).sum()
    };
    let values = log.channel(column)?.values.iter().zip(&log.time_s);
    Ok(log.with_values(column, values.map(|(value, time)| value + to_come(*time)).collect()))
}

/// Returns the time of a step, s after the first sample, if the text of a product is a step.
pub(crate) fn step_time(product: &str) -> Option<f64> {
    product.strip_prefix("clock:step(")?.strip_suffix(')')?.parse().ok()
}

/// Returns true if the correction consists of steps alone, which are constants in every later log.
pub(crate) fn is_step(finding: &Finding) -> bool {
    let mut terms = finding.correction.iter();
    !finding.correction.is_empty() && terms.all(|term| step_time(&term.regressor).is_some())
}

/// Returns true if a correction changes from sample to sample, so that it must run at the full sampling rate.
pub fn is_fast(findings: &[Finding]) -> bool {
    let terms = || findings.iter().flat_map(|finding| &finding.correction);
    findings.iter().any(|finding| finding.band == Band::Wide && !finding.correction.is_empty())
        || terms().any(|term| term.regressor.contains("ref_"))
}

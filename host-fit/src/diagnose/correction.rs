//! What the findings of a diagnosis take out of a log.

use super::answer::{CorrectionTerm, Finding};
use crate::effects::{Band, Inputs, Regressor};
use crate::recording::{Recording, RecordingError};

/// What to subtract, one value per row of `log`, in the axis' unit: the sum of all findings. `fitted` is the log they were
/// found in: the correction of a slow effect is 0 on its mean, since the mean belongs to the bias.
///
/// A step that was found in one log is a constant in the next. Before a quantity has its first value it is taken to have stood
/// at it.
///
/// # Errors
///
/// A column is missing.
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
            let at_fit = own.regressor(&regressor)?;
            let mean = at_fit.iter().sum::<f64>() / at_fit.len().max(1) as f64;
            let values = other.regressor_within(&regressor, &finding.limits)?;
            for (sum, value) in sum.iter_mut().zip(values.iter()) {
                *sum += coefficient * (value - mean);
            }
        }
    }
    Ok(sum)
}

/// Adds a step about its mean in the log that it was found in; in another log all of it has happened.
fn add_step(sum: &mut [f64], coefficient: f64, time_s: f64, fitted: &Recording, log: &Recording) {
    let after = |log: &Recording, time: f64| f64::from(u8::from(time - log.time_s[0] > time_s));
    let mean = fitted.time_s.iter().map(|time| after(fitted, *time)).sum::<f64>() / fitted.n_rows() as f64;
    let own = fitted.sources == log.sources;
    for (sum, time) in sum.iter_mut().zip(&log.time_s) {
        *sum += coefficient * (if own { after(log, *time) } else { 1.0 } - mean);
    }
}

/// The time of a step, s after the first sample, if the text of a product is one.
pub(crate) fn step_time(product: &str) -> Option<f64> {
    product.strip_prefix("clock:step(")?.strip_suffix(')')?.parse().ok()
}

/// Whether a correction changes from one sample to the next, so that it is needed at the full rate.
pub fn is_fast(findings: &[Finding]) -> bool {
    let terms = || findings.iter().flat_map(|finding| &finding.correction);
    findings.iter().any(|finding| finding.band == Band::Wide && !finding.correction.is_empty())
        || terms().any(|term| term.regressor.contains("ref_"))
}

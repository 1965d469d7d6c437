//! What the findings of a diagnosis take out of a log.

use super::answer::{CorrectionTerm, Finding};
use crate::effects::{Band, Inputs, Product};
use crate::recording::{Recording, RecordingError};

/// What to subtract, one value per row of `log`, in the axis' unit: the sum of all findings. `fitted` is the log they were
/// found in: the correction of a slow effect is 0 on its mean, since the mean belongs to the bias.
///
/// A step that was found in one log is a constant in the next.
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
    for CorrectionTerm { product, coefficient, .. } in findings.iter().flat_map(|finding| &finding.correction)
    {
        let Ok(product) = Product::parse(product) else { continue };
        let at_fit = own.product(&product)?;
        let finite = || at_fit.iter().copied().filter(|value| value.is_finite());
        let mean = finite().sum::<f64>() / finite().count().max(1) as f64;
        for (sum, value) in sum.iter_mut().zip(other.product(&product)?.iter()) {
            // a quantity that was not logged yet takes nothing out
            if value.is_finite() {
                *sum += coefficient * (value - mean);
            }
        }
    }
    Ok(sum)
}

/// Whether a correction changes from one sample to the next, so that it is needed at the full rate.
pub fn is_fast(findings: &[Finding]) -> bool {
    let terms = || findings.iter().flat_map(|finding| &finding.correction);
    findings.iter().any(|finding| finding.band == Band::Wide && !finding.correction.is_empty())
        || terms().any(|term| term.product.contains("ref_"))
}

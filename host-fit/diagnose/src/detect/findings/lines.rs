//! Spectral lines as findings: amplitude, frequency, the two terms of the correction, and the predicted reduction.

use super::Composer;
use super::faults_and_noise::{TWO_SIDED_95, bare, param};
use crate::detect::answer::{CorrectionTerm, Finding, Size};
use crate::detect::lines;
use crate::detect::question::DiagnoseError;
use crate::effects::{Detector, SizeUnit};
use fos_data::column::Column;

/// Quantile of 90 % intervals.
const TWO_SIDED_90: f64 = 1.645;

/// Relative uncertainty of the variance of the samples of another log, due to its drift.
const SPREAD_OF_VARIANCE: f64 = 0.01;

impl Composer<'_> {
    pub(super) fn line_findings(&self) -> Result<Vec<Finding>, DiagnoseError> {
        let known = self.prepared.reduced.blocks.known();
        let samples: Vec<f64> = self
            .prepared
            .reduced
            .error
            .iter()
            .zip(known)
            .filter(|(_, known)| **known)
            .map(|(e, _)| *e)
            .collect();
        let variance = fos_fit::signal::variance(&[&samples]);
        let steady = self.results.lines.iter().filter(|line| line.duty >= lines::STEADY);
        steady
            .map(|line| {
                let search = if line.coherent { Detector::Line } else { Detector::WanderingLine };
                let effect = self.found_as(search, line.frequency_hz)?;
                let unit = SizeUnit::of_axis(Column::named(&self.prepared.column));
                let half = TWO_SIDED_95 * line.amplitude_error;
                let mut finding = Finding {
                    params: param(effect, line.frequency_hz),
                    sizes: vec![Size::around("amplitude", line.amplitude, half, unit.si, &unit)],
                    score: Some(line.score),
                    gain: Some(line.score),
                    ..bare(effect)
                };
                finding.params_interval = finding
                    .params
                    .keys()
                    .map(|name| {
                        let error = TWO_SIDED_95 * line.frequency_error;
                        (name.clone(), [line.frequency_hz - error, line.frequency_hz + error])
                    })
                    .collect();
                if line.coherent {
                    let (sin, cos) = line.phase.sin_cos();
                    let hz = line.frequency_hz;
                    finding.correction = [("sine", cos), ("cosine", sin)]
                        .map(|(transform, part)| CorrectionTerm {
                            regressor: format!("clock:{transform}({hz})"),
                            coefficient: line.amplitude * part,
                            standard_error: line.amplitude_error,
                        })
                        .to_vec();
                    // E Â² = A² + 2σ²; the errors of Â and of the phase leave another 2σ²
                    let square = |a: f64| {
                        (0.5 * (a * a - 4.0 * line.amplitude_error.powi(2)) / variance).clamp(0.0, 1.0)
                    };
                    let error = TWO_SIDED_90 * line.amplitude_error + SPREAD_OF_VARIANCE * line.amplitude;
                    finding.predicted_reduction = square(line.amplitude);
                    finding.predicted_reduction_interval =
                        [square(line.amplitude - error), square(line.amplitude + error)];
                }
                Ok(finding)
            })
            .collect()
    }
}

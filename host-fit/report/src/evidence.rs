//! Evidence for a finding, as data: its shape in the slow error, or its line in the spectrum.

use fos_data::recording::Recording;
use fos_diagnose::detect::{Diagnosis, Finding};
use fos_diagnose::refine::{Evidence as SlowEvidence, RefineError, Refiner, line_spectrum};
use fos_diagnose::study::Refinement;
use fos_figures::Figure;
use fos_figures::compare::Subject;
use fos_figures::evidence::{evidence, line_evidence};
use fos_fit::signal::spectrum::Spectrum;

/// Evidence for a finding.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Evidence {
    /// Shape in the slow error.
    Slow {
        /// Slow error without all other findings, and the contribution of the effect.
        found: SlowEvidence,
        /// First and last second of the range in which the effect is largest.
        largest_s: Option<[f64; 2]>,
    },
    /// Line in the spectrum.
    Line {
        /// Spectrum of the error as logged, unit²/Hz.
        spectrum: Spectrum,
        /// Frequency of the line, Hz.
        frequency_hz: f64,
    },
}

impl Evidence {
    /// Returns the evidence for a finding of a diagnosis of `refinement` on the log `field`; none where there is
    /// nothing to show.
    pub(super) fn of(
        refiner: &Refiner<'_>,
        refinement: &Refinement,
        diagnosis: &Diagnosis,
        finding: &Finding,
        field: &Recording,
    ) -> Result<Option<Self>, RefineError> {
        if let Some(found) = refiner.evidence(refinement, &diagnosis.findings, finding)? {
            return Ok(Some(Self::Slow { found, largest_s: finding.shows_from_to_s }));
        }
        let Some(&frequency_hz) = finding.params.get("freq_hz") else { return Ok(None) };
        let spectrum = line_spectrum(field, &refinement.column)?;
        Ok(spectrum.map(|spectrum| Self::Line { spectrum, frequency_hz }))
    }

    /// Draws the evidence; `effect` is the name of the effect in a sentence.
    pub(super) fn drawn(&self, subject: Subject<'_>, effect: &str) -> Figure {
        match self {
            Self::Slow { found, largest_s } => evidence(subject, effect, found, *largest_s),
            Self::Line { spectrum, frequency_hz } => line_evidence(subject, effect, spectrum, *frequency_hz),
        }
    }
}

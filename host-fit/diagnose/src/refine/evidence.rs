//! Evidence for an effect, for plots: the error to explain, and the part that the effect explains.

use std::ops::Range;

use serde::Serialize;

use super::error::RefineError;
use super::refiner::Refiner;
use super::terms;
use crate::detect::{ErrorInBlocks, Finding, correction};
use crate::effects::Band;
use crate::study::Refinement;
use fos_data::recording::{Recording, RecordingError, runs};
use fos_fit::cost::Cost;
use fos_fit::signal::centred;
use fos_fit::signal::spectrum::{Spectrum, welch};

/// Approximate number of blocks, limited by the resolution of a plot.
const BLOCKS: f64 = 400.0;

/// Shortest block, s.
const SHORTEST_S: f64 = 1.0;

/// Length of the windows of the spectrum around a line, s.
const LINE_WINDOW_S: f64 = 30.0;

/// Frequencies shown around a line, as a ratio.
const NEAR_LINE: Range<f64> = 0.8..1.25;

/// Slow error in blocks of the log to explain, and the effect of a finding.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// Length of the blocks, s.
    pub block_s: f64,
    /// Middles of the blocks as timestamps, s.
    pub time_s: Vec<f64>,
    /// Centred block means of the error after the model's physical part and all other findings are subtracted, in the
    /// axis' unit.
    pub error: Vec<f64>,
    /// Centred block means of the finding's correction.
    pub effect: Vec<f64>,
    /// Column against which the effect shows best.
    pub against: Option<Against>,
}

/// A column in the same blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct Against {
    /// Name in the log format, as `temp_c`.
    pub column: String,
    pub values: Vec<f64>,
}

impl Evidence {
    /// Returns the evidence in `log`; `without` is `log` after everything except the finding is subtracted.
    fn of(
        log: &Recording,
        without: &Recording,
        column: &str,
        finding: &Finding,
    ) -> Result<Self, RecordingError> {
        let seconds = log.n_rows() as f64 * log.rate.period_s;
        let length_s = (seconds / BLOCKS).max(SHORTEST_S);
        let reduced = ErrorInBlocks::in_blocks_of(without, column, &[], length_s)?;
        let blocks = &reduced.blocks;
        let effect = blocks.means(&correction(std::slice::from_ref(finding), log, log)?);
        let against = match &finding.shows_against {
            Some(column) => {
                let held = log.held_from_first(log.channel(column)?);
                Some(Against { column: column.clone(), values: blocks.means(&held) })
            }
            None => None,
        };
        let middle = |block: &fos_fit::noise::Block| log.time_s[(block.rows.start + block.rows.end) / 2];
        Ok(Self {
            block_s: blocks.length_s,
            time_s: blocks.blocks.iter().map(middle).collect(),
            error: centred(reduced.means.clone()),
            effect: centred(effect),
            against,
        })
    }
}

fn shows_in_blocks(finding: &Finding) -> bool {
    finding.band == Band::Slow && !finding.correction.is_empty()
}

/// Returns the evidence for one of the `findings` of a diagnosis of `log` without a model; none for an effect that
/// does not show in blocks.
pub fn evidence_without_model(
    log: &Recording,
    column: &str,
    findings: &[Finding],
    finding: &Finding,
) -> Result<Option<Evidence>, RecordingError> {
    if !shows_in_blocks(finding) {
        return Ok(None);
    }
    let others: Vec<Finding> = findings.iter().filter(|other| *other != finding).cloned().collect();
    let taken = correction(&others, log, log)?;
    let measured = log.channel(column)?.values.iter();
    let without = measured.zip(&taken).map(|(measured, taken)| measured - taken).collect();
    let without = log.with_values(column, without);
    Ok(Some(Evidence::of(log, &without, column, finding)?))
}

/// Spectrum around a line.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LineEvidence {
    /// Frequency of the line, Hz.
    pub line_hz: f64,
    /// Frequencies of the bins, Hz.
    pub frequency_hz: Vec<f64>,
    /// Power spectral density in each bin, unit²/Hz.
    pub density: Vec<f64>,
}

/// Returns the evidence for a finding of a line in `column`; none for other findings, and if the log is too short.
pub fn line_evidence(
    log: &Recording,
    column: &str,
    finding: &Finding,
) -> Result<Option<LineEvidence>, RecordingError> {
    let Some(&line_hz) = finding.params.get("freq_hz") else { return Ok(None) };
    let Some(spectrum) = line_spectrum(log, column)? else { return Ok(None) };
    let bins = spectrum.frequency_hz.into_iter().zip(spectrum.density);
    let (frequency_hz, density) = bins.filter(|(hz, _)| NEAR_LINE.contains(&(hz / line_hz))).unzip();
    Ok(Some(LineEvidence { line_hz, frequency_hz, density }))
}

/// Returns the spectrum of the error of `column` as logged, unit²/Hz, in bins narrow enough to show a line. None if the
/// log is too short.
fn line_spectrum(log: &Recording, column: &str) -> Result<Option<Spectrum>, RecordingError> {
    let error = log.error_series(column)?.values;
    let finite = |rows: Range<usize>| -> Vec<Range<usize>> { runs(rows, |row| error[row].is_finite()) };
    let segments = log.segments.iter();
    let stretches: Vec<&[f64]> =
        segments.flat_map(|segment| finite(segment.rows.clone())).map(|rows| &error[rows]).collect();
    let longest = stretches.iter().map(|stretch| stretch.len()).max().unwrap_or(0);
    // half a minute, if available
    let length = ((LINE_WINDOW_S * log.rate.true_hz) as usize).min(longest);
    Ok(welch(&stretches, log.rate.true_hz, length))
}

impl Refiner<'_> {
    /// Returns the evidence for one of the `findings` of a diagnosis of `refinement`; none for an effect that does not
    /// show in blocks.
    pub fn evidence(
        &self,
        refinement: &Refinement,
        findings: &[Finding],
        finding: &Finding,
    ) -> Result<Option<Evidence>, RefineError> {
        if !shows_in_blocks(finding) {
            return Ok(None);
        }
        let mut others: Vec<Finding> = refinement.added().map(|added| added.finding.clone()).collect();
        others.extend(findings.iter().filter(|other| *other != finding).cloned());
        let without = self.without_base(refinement, &others)?;
        Ok(Some(Evidence::of(&self.log.whole, &without, &refinement.column, finding)?))
    }

    /// Returns the additional cost of `finding` on the device.
    pub fn price(&self, refinement: &Refinement, finding: &Finding) -> Result<Option<Cost>, RefineError> {
        let Some(last) = refinement.last().filter(|_| !finding.correction.is_empty()) else {
            return Ok(None);
        };
        let mut grown = last.model.clone();
        terms::add(&mut grown, std::slice::from_ref(finding), &self.log.whole)?;
        Ok(Some(Cost::of(&grown).beyond(&last.cost)))
    }
}

//! Diagnosis of a log without a model, with the evidence of each finding.

use std::path::PathBuf;
use std::sync::Arc;

use fos_data::recording::{Recording as Log, RecordingError};
use fos_diagnose::detect::{self, Finding, Question};
use fos_diagnose::effects::{Effect, Library};
use fos_diagnose::refine::{Evidence, evidence_without_model, line_spectrum};
use fos_figures::Figure;
use fos_figures::evidence::evidence;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::error::raised;
use crate::recording::{Recording, unit_of};
use crate::work;

/// Range of frequencies shown around a line, as a ratio.
const NEAR: f64 = 1.25;

/// The built-in effects and those of these files.
pub(crate) fn library(py: Python<'_>, files: &[PathBuf]) -> PyResult<Library> {
    Library::with_files(files).map_err(raised(py))
}

/// Evidence of a finding that shows in block means, as JSON.
pub(crate) fn evidence_json(evidence: &Evidence) -> Value {
    json!({
        "block_s": evidence.block_s,
        "time_s": evidence.time_s,
        "error": evidence.error,
        "effect": evidence.effect,
        "against": evidence.against.as_ref().map(|against| &against.column),
        "against_unit": evidence.against.as_ref().map(|against| unit_of(&against.column)),
        "against_values": evidence.against.as_ref().map(|against| &against.values),
    })
}

/// Evidence of a line, as JSON: the spectrum around it.
pub(crate) fn line_json(log: &Log, column: &str, finding: &Finding) -> Result<Option<Value>, RecordingError> {
    let Some(frequency_hz) = finding.params.get("freq_hz") else { return Ok(None) };
    let Some(spectrum) = line_spectrum(log, column)? else { return Ok(None) };
    let bins = spectrum.frequency_hz.iter().zip(&spectrum.density);
    let near = bins.filter(|(hz, _)| (1.0 / NEAR..NEAR).contains(&(**hz / frequency_hz)));
    let (hz, density): (Vec<f64>, Vec<f64>) = near.map(|(hz, density)| (*hz, *density)).unzip();
    Ok(Some(json!({ "line_hz": frequency_hz, "frequency_hz": hz, "density": density })))
}

/// Figure of the evidence of a finding.
pub(crate) fn figure(
    log: &Log,
    column: &str,
    library: &Library,
    finding: &Finding,
    found: Option<&Evidence>,
) -> Result<Option<Figure>, RecordingError> {
    let name = library.get(&finding.effect).map_or(finding.effect.as_str(), |effect| &effect.name);
    evidence(column, name, finding, found, log)
}

/// Diagnosis of an axis of a log as JSON, with the evidence of each finding.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "they are the keywords of `fos_imu.diagnose`")]
pub(crate) fn diagnose(
    py: Python<'_>,
    log: &Recording,
    axis: &str,
    reference: Option<&Recording>,
    evaluation: Option<&Recording>,
    full_scale: Option<f64>,
    lsb: Option<f64>,
    effects: Vec<PathBuf>,
) -> PyResult<(String, String)> {
    let library = library(py, &effects)?;
    let target = log.axis(py, axis)?;
    let shared = |recording: &Recording| Arc::clone(&recording.log);
    let (log, reference, evaluation) = (shared(log), reference.map(shared), evaluation.map(shared));
    work::run(py, || {
        let diagnosis = detect::diagnose_and_measure(&Question {
            reference: reference.as_deref(),
            evaluation: evaluation.as_deref(),
            full_scale,
            lsb,
            ..Question::new(&log, &target, &library)
        })?;
        let mut speaks = Vec::new();
        for finding in &diagnosis.findings {
            let evidence = evidence_without_model(&log, &target, &diagnosis.findings, finding)?;
            speaks.push(json!({
                "evidence": evidence.as_ref().map(evidence_json),
                "line": line_json(&log, &target, finding)?,
                "figure": figure(&log, &target, &library, finding, evidence.as_ref())?,
                "cost": null,
            }));
        }
        Ok((json!(diagnosis).to_string(), json!(speaks).to_string()))
    })?
    .map_err(raised::<detect::DiagnoseError>(py))
}

/// Known effects, as JSON.
#[pyfunction]
pub(crate) fn effects(py: Python<'_>, files: Vec<PathBuf>) -> PyResult<String> {
    let library = library(py, &files)?;
    let entry = |effect: &Effect| {
        json!({
            "id": effect.id,
            "name": effect.name,
            "band": effect.band,
            "mechanism": effect.mechanism,
            "equation": effect.equation,
            "experiment": effect.experiment,
            "typical_size": effect.typical_size,
            "source": effect.source,
            "gives_away": effect.gives_away,
            "device": effect.device,
        })
    };
    Ok(Value::Array(library.effects().iter().map(entry).collect()).to_string())
}

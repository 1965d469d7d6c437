//! Diagnosis of a log without a model, with the evidence of each finding.

use std::path::PathBuf;
use std::sync::Arc;

use fos_data::recording::{Recording as Log, RecordingError};
use fos_diagnose::detect::{self, Finding, Question};
use fos_diagnose::effects::Library;
use fos_diagnose::refine::{Evidence, evidence_without_model, line_evidence};
use fos_figures::evidence::evidence;
use fos_fit::cost::Cost;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::error::raised;
use crate::recording::{Recording, unit_of};
use crate::work;

/// The built-in effects and those of these files.
pub(crate) fn library(py: Python<'_>, files: &[PathBuf]) -> PyResult<Library> {
    Library::with_files(files).map_err(raised(py))
}

/// Evidence of a finding that shows in block means, as JSON.
fn evidence_json(evidence: &Evidence) -> Value {
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

/// Evidence and cost of a finding, as JSON. `found` is its evidence in block means.
pub(crate) fn evidence_and_cost(
    log: &Log,
    column: &str,
    library: &Library,
    finding: &Finding,
    found: Option<&Evidence>,
    cost: Option<Cost>,
) -> Result<Value, RecordingError> {
    let name = library.get(&finding.effect).map_or(finding.effect.as_str(), |effect| &effect.name);
    let line = line_evidence(log, column, finding)?;
    Ok(json!({
        "evidence": found.map(evidence_json),
        "figure": evidence(column, name, finding, found, line.as_ref()),
        "line": line,
        "cost": cost,
    }))
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
            speaks.push(evidence_and_cost(&log, &target, &library, finding, evidence.as_ref(), None)?);
        }
        Ok((json!(diagnosis).to_string(), json!(speaks).to_string()))
    })?
    .map_err(raised::<detect::DiagnoseError>(py))
}

/// Known effects, as JSON.
#[pyfunction]
pub(crate) fn effects(py: Python<'_>, files: Vec<PathBuf>) -> PyResult<String> {
    Ok(json!(library(py, &files)?.effects()).to_string())
}

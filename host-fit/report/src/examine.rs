//! Examination of one axis on the log to explain: the current model against the measurements.

use serde::Serialize;

use fos_diagnose::compare::{AxisComparison, CompareError, Evaluation, compare_on};
use fos_diagnose::refine::Logs;
use fos_diagnose::study::{Refinement, Study};
use fos_figures::curves::AxisCurves;
use fos_fit::evaluate::Trace;
use fos_fit::model::UnitModel;

/// Comparison of an axis with its log.
#[derive(Debug, Clone, Serialize)]
pub struct Examination {
    /// First and last timestamp of the evaluated rows, s.
    pub evaluated_s: (f64, f64),
    /// Errors, worst stretches and dependences on the evaluated rows.
    pub comparison: AxisComparison,
    /// Residual, row by row.
    #[serde(skip)]
    pub trace: Trace,
    /// Data of the figures, over all evaluated rows.
    #[serde(skip)]
    pub curves: AxisCurves,
}

/// Evaluates the current model of `refinement` on the log to explain, on rows not used for the fit.
pub fn examine(
    study: &Study,
    refinement: &Refinement,
    logs: &Logs,
    progress: &mut dyn FnMut(&str),
) -> Result<Examination, CompareError> {
    // A refinement recalibrates its first model on the log to explain; that model is exported only after an effect is added.
    let added = refinement.last().filter(|last| last.added.is_some());
    let alone = study.axis_alone(&refinement.column).ok();
    let model: &UnitModel = added.map(|last| &*last.model).or(alone.as_deref()).unwrap_or(&study.model);
    let report = study.axes.iter().find(|report| report.column == refinement.column);
    let lag_1: Vec<f64> = report.map(|report| report.lag_1).into_iter().collect();
    let (field, own) = (&logs.log, logs.reference.as_ref());
    let Evaluation { comparison, trace, .. } = compare_on(&study.data, model, &lag_1, field, own, progress)?;
    let evaluated_s = comparison.evaluated_s;
    // A refinement has one axis.
    let comparison = comparison.axes.into_iter().next().ok_or(CompareError::NothingLeft { trained: 0 })?;
    let curves = AxisCurves::of(&comparison, &trace, 0, field);
    Ok(Examination { evaluated_s, comparison, trace, curves })
}

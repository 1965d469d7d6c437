//! Examination of one axis on the log to explain: the current model against the measurements.

use serde::Serialize;

use crate::curves::AxisCurves;
use fos_data::recording::Recording;
use fos_data::stillness;
use fos_diagnose::compare::{AxisComparison, CompareError, compare};
use fos_diagnose::dependence::Trained;
use fos_diagnose::refine::Logs;
use fos_diagnose::study::{Refinement, Study};
use fos_fit::evaluate::Trace;
use fos_fit::model::UnitModel;

/// Comparison of an axis with its log.
#[derive(Debug, Clone, Serialize)]
pub struct Examination {
    /// First and last timestamp of the evaluated rows, s.
    pub judged_s: (f64, f64),
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
///
/// # Errors
///
/// Errors of [`compare`].
pub fn examine(
    study: &Study,
    refinement: &Refinement,
    logs: &Logs,
    progress: impl FnMut(&str),
) -> Result<Examination, CompareError> {
    // A refinement recalibrates its first model on the log to explain; that model is exported only after an effect is added.
    let added = refinement.last().filter(|last| last.added.is_some());
    let alone = study.axis_alone(&refinement.column).ok();
    let model: &UnitModel = added.map(|last| &last.model).or(alone.as_ref()).unwrap_or(&study.model);
    let report = study.axes.iter().find(|report| report.column == refinement.column);
    let lag_1: Vec<f64> = report.map(|report| report.lag_1).into_iter().collect();
    let trained_rows = 0..study.data.trained_rows;
    let rest = |log: &Recording| match study.data.is(log) {
        true => stillness::find_apart(log, trained_rows.end),
        false => stillness::find(log),
    };
    let field_stillness = rest(&logs.field);
    let quiet = logs.quiet.as_ref().filter(|quiet| study.data.is(quiet)).map(|quiet| (quiet, rest(quiet)));
    let own_field = study.data.is(&logs.field);
    let trained = match &quiet {
        Some((recording, stillness)) => Some(Trained { recording, stillness, rows: trained_rows }),
        None => own_field.then_some(Trained {
            recording: &logs.field,
            stillness: &field_stillness,
            rows: trained_rows,
        }),
    };
    let rows = if own_field { study.data.trained_rows } else { 0 }..logs.field.n_rows();
    let (comparison, trace) =
        compare(model, &lag_1, &logs.field, &field_stillness, rows, trained.as_ref(), progress)?;
    let judged_s = comparison.judged_s;
    // A refinement has one axis.
    let comparison = comparison.axes.into_iter().next().ok_or(CompareError::NothingLeft { trained: 0 })?;
    let curves = AxisCurves::of(&comparison, &trace, 0, &logs.field);
    Ok(Examination { judged_s, comparison, trace, curves })
}

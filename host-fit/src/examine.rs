//! One axis examined on the log where its model fails: the model as it is now against the measurements.

use serde::Serialize;

use crate::escaping::quoted;
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::stillness;
use fos_diagnose::compare::{AxisComparison, CompareError, compare};
use fos_diagnose::dependence::Trained;
use fos_diagnose::refine::Logs;
use fos_diagnose::study::Refinement;
use fos_diagnose::study::Study;
use fos_fit::evaluate::Trace;
use fos_fit::model::UnitModel;

/// An axis against the field log.
#[derive(Debug, Clone, Serialize)]
pub struct Examination {
    /// First and last time stamp of the judged rows, s.
    pub judged_s: (f64, f64),
    /// The axis.
    pub comparison: AxisComparison,
    /// What is left, row by row.
    #[serde(skip)]
    pub trace: Trace,
}

/// Judges the model of `growth`, as it is now, on the field log, on rows that the study was not fitted to.
///
/// # Errors
///
/// As for [`compare`].
pub fn examine(
    study: &Study,
    growth: &Refinement,
    logs: &Logs,
    progress: impl FnMut(&str),
) -> Result<Examination, CompareError> {
    let model: &UnitModel = growth.last().map_or(&study.model, |last| &last.model);
    let report = study.axes.iter().find(|report| report.column == growth.column);
    let lag_1: Vec<f64> = report.map(|report| report.lag_1).into_iter().collect();
    let field_rest = stillness::find(&logs.field);
    let quiet =
        logs.quiet.as_ref().filter(|quiet| study.data.is(quiet)).map(|quiet| (quiet, stillness::find(quiet)));
    let trained_rows = 0..study.data.trained_rows;
    let own_field = study.data.is(&logs.field);
    let trained = match &quiet {
        Some((recording, stillness)) => Some(Trained { recording, stillness, rows: trained_rows }),
        None => own_field.then_some(Trained {
            recording: &logs.field,
            stillness: &field_rest,
            rows: trained_rows,
        }),
    };
    let rows = if own_field { study.data.trained_rows } else { 0 }..logs.field.n_rows();
    let (comparison, trace) =
        compare(model, &lag_1, &logs.field, &field_rest, rows, trained.as_ref(), progress)?;
    let judged_s = comparison.judged_s;
    // a growth is of one axis
    let comparison = comparison.axes.into_iter().next().ok_or(CompareError::NothingLeft { trained: 0 })?;
    Ok(Examination { judged_s, comparison, trace })
}

/// The command lines that do the same as was done with these logs: fitted to `fitted`, looking at axes, each as it has grown.
pub fn command_lines<'a>(
    fitted: &[Source],
    logs: &Logs,
    axes: impl IntoIterator<Item = (&'a str, Option<&'a Refinement>)>,
) -> Vec<String> {
    let path = |log: &Recording| quoted(&log.paths());
    let LoadOptions { columns, rate_hz, strict: _ } = &logs.read;
    let maps: String = columns.specs().iter().map(|map| format!(" --map {}", quoted(map))).collect();
    let rate = rate_hz.map_or_else(String::new, |rate| format!(" --rate {rate}"));
    let read = format!("{maps}{rate}");
    let fitted: Vec<String> = fitted.iter().map(|source| quoted(&source.path)).collect();
    let field = path(&logs.field);
    let quiet = logs.quiet.as_ref().map_or_else(String::new, |log| format!(" --quiet {}", path(log)));
    let judge = logs.judged.as_ref().map_or_else(String::new, |log| format!(" --judge {}", path(log)));
    let mut lines = vec![
        format!("host-fit fit {} --axis all{read} -o unit.json", fitted.join(" ")),
        format!("host-fit compare unit.json {field}{read} --figures figures"),
    ];
    for (column, growth) in axes {
        let on = format!("--axis {} --from {field}{quiet}{judge}{read}", quoted(column));
        lines.push(format!("host-fit diagnose unit.json {on}"));
        for added in growth.into_iter().flat_map(Refinement::added) {
            lines.push(format!("host-fit add unit.json {} {on}", quoted(&added.effect.id)));
        }
    }
    let last = logs.judged.as_ref().map_or(field, path);
    lines.push("host-fit export unit.json --image unit.fosm --rust model.rs --c model.h".to_owned());
    lines.push(format!("host-fit replay unit.fosm {last}{read}"));
    lines
}

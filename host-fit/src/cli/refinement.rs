//! Functions shared by `add`, `undo`, `history` and `diagnose` of a study: choice of axis and logs, and the table of added effects.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use super::arguments::Reading;
use super::error_table::{error_table, error_unit};
use super::output::{Failure, percent, print_line, sparkline, table};
use super::units::{ErrorUnit, Printed, three};
use fos_data::recording::Source;
use fos_data::text::counted;
use fos_data::unit::MG_MPS2;
use fos_diagnose::refine::Logs;
use fos_diagnose::session::{NamedLogs, NoLog, Wanted};
use fos_diagnose::study::{Added, Refinement, RefinementStep, Study, StudyAxisError, load_again};
use fos_fit::calibration::UnitCalibration;
use fos_fit::evaluate::ModelErrors;

/// The logs that an axis is refined on.
#[derive(Debug, Clone, Args)]
pub(super) struct LogArguments {
    /// The log to explain; by default that of the previous step
    #[arg(long, value_name = "LOG")]
    pub(super) from: Option<PathBuf>,
    /// A log of the same device without the missing effect; by default the log that the study was fitted to
    #[arg(long = "reference", alias = "quiet", value_name = "LOG")]
    pub(super) reference: Option<PathBuf>,
    /// The evaluation log: a later log that nothing is fitted to; by default the last two fifths of the log to explain.
    /// If it begins where the log to explain ends, lags and hysteresis continue
    #[arg(long = "evaluate-on", alias = "judge", value_name = "LOG")]
    pub(super) evaluate_on: Option<PathBuf>,
}

/// Reads the logs in the arguments, or those of the refinement of `column`; `study` is in `file`.
pub(super) fn read_logs(
    logs: &LogArguments,
    reading: &Reading,
    study: &Study,
    file: &Path,
    column: &str,
) -> Result<Logs, Failure> {
    let read = reading.options_or(study.read_options(column))?;
    let LogArguments { from, reference, evaluate_on } = logs.clone();
    let named = NamedLogs { log: from, reference, evaluation: evaluate_on };
    let may_be = |path: &PathBuf, own: &Source| fs::metadata(path).is_ok_and(|file| file.len() == own.bytes);
    let load = |wanted: Wanted<'_, PathBuf>| match wanted {
        Wanted::Named(path) => reading.read_named(path, &read),
        Wanted::Stored(source) => Ok(load_again(source, file, &read)?),
    };
    let loaded: Result<Logs, Failure> = named.load(study, column, read.clone(), may_be, load);
    loaded.map_err(|error| match error.downcast_ref::<NoLog>() {
        Some(none) => format!("{none}\nhelp: give it with --from LOG").into(),
        None => error,
    })
}

/// Column of `--axis` in a study, or its only one.
pub(super) fn column_of(study: &Study, axis: Option<&str>) -> Result<String, Failure> {
    named(study.column(axis))
}

/// An error in the choice of an axis names the option.
pub(super) fn named(column: Result<String, StudyAxisError>) -> Result<String, Failure> {
    column.map_err(|error| format!("{error} with --axis").into())
}

/// Columns of `--axis` in a study, several with commas; all without one.
pub(super) fn columns_of(study: &Study, axes: Option<&str>) -> Result<Vec<String>, Failure> {
    match axes {
        None | Some("all") => Ok(study.columns()),
        Some(axes) => axes.split(',').map(|axis| column_of(study, Some(axis.trim()))).collect(),
    }
}

/// Describes the calibration of a study in a line.
pub(super) fn calibration_in_words(calibration: &UnitCalibration) -> String {
    let [before, after] = calibration.gravity_residual_mps2.map(|residual| three(residual / MG_MPS2));
    let logs: Vec<&str> = calibration.sources.iter().map(|source| source.path.as_str()).collect();
    let gyro = if calibration.gyro.is_some() { "accelerometer and gyro" } else { "accelerometer" };
    let at = calibration.temperature_c.map_or_else(String::new, |at| format!(" at {} °C", three(at)));
    format!(
        "calibration of {gyro} from {}{at} ({}): |a| − g {before} → {after} mg RMS",
        counted(calibration.rests, "rest"),
        logs.join(", ")
    )
}

/// Prints every added effect with the predicted and the measured reduction and its cost, then all errors after each.
pub(super) fn print_refinement(refinement: &Refinement, printed: Printed) {
    let slow: Vec<f64> = refinement.steps.iter().map(|step| step.left.slow.sqrt()).collect();
    let unit = ErrorUnit::of(&refinement.column, slow.iter().copied().fold(0.0, f64::max), printed.units);
    let logs = &refinement.logs;
    match &logs.evaluation {
        Some(evaluation) => {
            print_line!(
                "{}: estimated on {}, evaluated on {}",
                refinement.column,
                logs.log.path,
                evaluation.path
            )
        }
        None => print_line!(
            "{}: estimated on the first {} rows of {}, evaluated on the others",
            refinement.column,
            logs.fitted_rows,
            logs.log.path
        ),
    }
    let slow_error = format!("slow error, {}", unit.label);
    let mut header = vec!["  step", "size", "predicted RMS reduction (90 %)", "measured", &slow_error];
    if printed.details {
        header.extend(["broadband error", "bias error", "terms", "RAM, bytes", "instructions"]);
    }
    let mut rows = table(&header);
    for (index, step) in refinement.steps.iter().enumerate() {
        rows.add_row(row(index, step, unit, printed));
    }
    print_line!("{rows}");
    let is_outside = |step: &RefinementStep| step.added.as_ref().is_some_and(|added| !is_as_predicted(added));
    if refinement.steps.iter().any(is_outside) {
        print_line!("  (!): the measured reduction lies outside the interval of the predicted one");
    }
    print_line!(
        "  slow error: RMS of 1-s means, about the bias of the log to explain if the evaluation log continues it, otherwise about its own mean"
    );
    if let [first, .., last] = slow[..] {
        print_line!(
            "  slow error, step by step: {}  {} to {} {} RMS",
            sparkline(&slow),
            unit.show(first),
            unit.show(last),
            unit.label
        );
    }
    if !printed.details {
        return;
    }
    print_line!(
        "  residual of the physical part on the evaluated rows; slow error: RMS of 1-s means, about the bias of the log to explain if the evaluation log continues it, otherwise about its own mean; broadband error: RMS of samples about their mean; bias error: the mean there, where the log determines it"
    );
    print_line!("  instructions: per sample on a Cortex-M4F, about; terms and inputs of this axis");
    let errors: Vec<&ModelErrors> = refinement.steps.iter().map(|step| &step.errors).collect();
    let unit = error_unit(&refinement.column, &errors, printed.units);
    print_line!("{}", error_table(&errors, unit));
}

/// True if the measured reduction lies in the interval of the predicted one.
fn is_as_predicted(added: &Added) -> bool {
    let [low, high] = added.finding.predicted_reduction_interval;
    (low..=high).contains(&added.measured_reduction)
}

fn row(index: usize, step: &RefinementStep, unit: ErrorUnit, printed: Printed) -> Vec<String> {
    let (name, size, predicted, measured) = match &step.added {
        None => ("before".to_owned(), String::new(), String::new(), String::new()),
        Some(added) => {
            let finding = &added.finding;
            let sizes: Vec<String> = finding
                .params
                .iter()
                .map(|(name, value)| format!("{name} {}", three(*value)))
                .chain(finding.sizes.iter().map(|size| {
                    let (value, unit) = printed.coefficient(size.value, &size.unit);
                    format!("{value} {unit}")
                }))
                .collect();
            let [low, high] = finding.predicted_reduction_interval;
            let predicted =
                format!("{} ({} … {})", percent(finding.predicted_reduction), percent(low), percent(high));
            let mark = if is_as_predicted(added) { "" } else { " (!)" };
            let measured = format!("{}{mark}", percent(added.measured_reduction));
            (format!("+ {}", added.effect.id), sizes.join(", "), predicted, measured)
        }
    };
    let mut cells =
        vec![format!("  {index} {name}"), size, predicted, measured, unit.root(Some(step.left.slow))];
    if printed.details {
        cells.extend([
            unit.root(Some(step.left.wide)),
            step.left.bias.map_or_else(String::new, |bias| unit.show(bias)),
            step.cost.terms.to_string(),
            step.cost.ram_bytes.to_string(),
            step.cost.instructions.to_string(),
        ]);
    }
    cells
}

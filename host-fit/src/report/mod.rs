//! A report: what a study says of its axes, as plain data; [`html`] and [`markdown`] only render it.

mod axis_section;
mod axis_units;
mod evidence;
pub mod fleet;
mod log_summary;
mod markdown_text;
mod offer;
mod render;
mod template;

use serde::Serialize;

pub use axis_section::{AxisSection, ModelSummary, PhysicalTerm};
pub(crate) use axis_units::{AxisUnits, UnitChoice};
pub use log_summary::{ColumnSummary, LogSummary, Summaries};
pub use offer::{Card, Offer, offers};
pub(crate) use render::markdown_environment;
pub use render::{html, markdown};
pub use template::RenderError;
pub(crate) use template::{of_pages as page_environment, style};

use crate::command_lines::command_lines;
use crate::examine::examine;
use crate::figures::Figure;
use crate::plots::View;
use fos_diagnose::compare::CompareError;
use fos_diagnose::effects::Library;
use fos_diagnose::refine::{Logs, RefineError};
use fos_diagnose::study::{Study, Tool};

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The model cannot be compared with the log.
    #[error(transparent)]
    Compare(Box<CompareError>),
    /// What is missing cannot be said.
    #[error(transparent)]
    Refine(Box<RefineError>),
}

// boxed, as both carry names and paths: the way of a success is not to be as wide as that of an error
impl From<CompareError> for ReportError {
    fn from(error: CompareError) -> Self {
        Self::Compare(Box::new(error))
    }
}

impl From<RefineError> for ReportError {
    fn from(error: RefineError) -> Self {
        Self::Refine(Box::new(error))
    }
}

/// What a study says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// The program that wrote it.
    pub tool: Tool,
    /// Where the model comes from, a line each.
    pub provenance: Vec<String>,
    /// The log where the model fails.
    pub field: LogSummary,
    /// A log in which nothing is missing; absent where none was given.
    pub quiet: Option<LogSummary>,
    /// The log that errors are of.
    pub judged: Option<LogSummary>,
    /// One for each axis that was examined.
    pub axes: Vec<ReportAxis>,
    /// The command lines that do the same.
    pub commands: Vec<String>,
    /// The settings of the fit, as in the study.
    pub settings: serde_json::Value,
}

/// An axis with its figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReportAxis {
    /// What there is to say.
    pub section: AxisSection,
    /// Measured against predicted, and where it fails.
    pub figures: Vec<Figure>,
}

impl Report {
    /// Examines and diagnoses `columns` of a study. `progress` is told what is being done.
    ///
    /// # Errors
    ///
    /// A column is missing, a log is too short.
    pub fn of(
        study: &Study,
        columns: &[String],
        logs: &Logs,
        library: &Library,
        mut progress: impl FnMut(&str),
    ) -> Result<Self, ReportError> {
        let refiner = logs.refiner(library);
        let summaries = Summaries::of(logs);
        let mut axes = Vec::new();
        for column in columns {
            let refinement = match study.refinement_of(column) {
                Some(refinement) => refinement.clone(),
                None => refiner.begin(study, column, logs.named(refiner.fitted_rows()))?,
            };
            progress(&format!("{column}: comparing"));
            let examination = examine(study, &refinement, logs, |_| {})?;
            progress(&format!("{column}: testing effects"));
            let section = AxisSection::of(study, &refinement).examined(&examination);
            let section = section.diagnosed(&refinement, logs, library)?;
            let moved = &summaries.field.moved;
            let view = View { axis: &examination.comparison, curves: &examination.curves, moved };
            axes.push(ReportAxis { section, figures: view.all() });
        }
        Ok(Self::put_together(study, axes, logs, summaries))
    }

    /// A report of axes that were examined before.
    pub fn put_together(study: &Study, axes: Vec<ReportAxis>, logs: &Logs, summaries: Summaries) -> Self {
        let Summaries { field, quiet, judged } = summaries;
        let refined =
            axes.iter().map(|axis| (axis.section.column.as_str(), axis.section.refinement.as_ref()));
        let commands = command_lines(&study.data.sources, logs, refined);
        Self {
            tool: Tool::this(),
            provenance: study.provenance().lines().map(str::to_owned).collect(),
            field,
            quiet,
            judged,
            axes,
            commands,
            settings: serde_json::to_value(&study.settings).unwrap_or_default(),
        }
    }
}

#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// Names of fields speak for themselves; doc comments are written where they add a unit, a range or a reason.
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

mod axis_section;
mod axis_units;
pub mod certificate;
pub mod command_lines;
pub mod examine;
pub mod fleet;
mod log_summary;
mod markdown_text;
mod offer;
pub mod physical_terms;
mod render;
mod template;
pub mod unaided;

use serde::Serialize;

pub use axis_section::{AxisSection, ModelSummary};
pub use axis_units::{AxisUnits, UnitChoice};
pub use log_summary::{ColumnSummary, LogSummary, Summaries};
pub use offer::{Offer, offers};
pub use render::{html, markdown};
pub use template::RenderError;

use crate::command_lines::command_lines;
use crate::examine::examine;
use fos_diagnose::compare::{CompareError, strapdown};
use fos_diagnose::effects::Library;
use fos_diagnose::refine::{Logs, RefineError};
use fos_diagnose::study::{Study, Tool};
use fos_figures::Figure;
use fos_figures::compare::View;
use fos_fit::evaluate::UnaidedError;

/// Failure to build a report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The model cannot be compared with the log.
    #[error(transparent)]
    Compare(Box<CompareError>),
    /// The axis cannot be refined or diagnosed.
    #[error(transparent)]
    Refine(Box<RefineError>),
}

// boxed, as both carry names and paths, which would enlarge the result of a success too
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

/// Report on a study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Program that wrote the report.
    pub tool: Tool,
    /// Provenance of the model, a line each.
    pub provenance: Vec<String>,
    /// Log to explain.
    pub log: LogSummary,
    /// Reference log; none if not given.
    pub reference: Option<LogSummary>,
    /// Evaluation log; none if not given.
    pub evaluation: Option<LogSummary>,
    /// One entry for each examined axis.
    pub axes: Vec<ReportAxis>,
    /// Heading and position errors without aiding of all six axes together, before the model and with it, by length of
    /// the windows; empty if the study lacks one of them.
    pub strapdown: Vec<[UnaidedError; 2]>,
    /// Command lines that give the same results.
    pub commands: Vec<String>,
    /// Settings of the fit, as in the study.
    pub settings: serde_json::Value,
}

/// An axis with its figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReportAxis {
    /// Findings on the axis.
    pub section: AxisSection,
    /// Figures of measured against predicted values, and of the places where the model fails.
    pub figures: Vec<Figure>,
}

impl Report {
    /// Examines and diagnoses `columns` of a study. `progress` gets a description of each step.
    pub fn of(
        study: &Study,
        columns: &[String],
        logs: &Logs,
        library: &Library,
        progress: &mut dyn FnMut(&str),
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
            let examination = examine(study, &refinement, logs, &mut |_| {})?;
            progress(&format!("{column}: testing effects"));
            let section = AxisSection::of(study, &refinement).examined(&examination);
            let section = section.diagnosed(&refinement, &refiner, &logs.log)?;
            let moved = &summaries.log.moved;
            let view = View { axis: &examination.comparison, curves: &examination.curves, moved };
            axes.push(ReportAxis { section, figures: view.all() });
        }
        progress("integrating six axes without aiding");
        // the model of an axis outside the report may need a column that the log lacks
        let strapdown = strapdown(study, &logs.log, logs.reference.as_ref()).unwrap_or_default();
        Ok(Self::put_together(study, axes, strapdown, logs, summaries))
    }

    /// Builds a report from axes that were examined before, and the errors of their [`strapdown`].
    pub fn put_together(
        study: &Study,
        axes: Vec<ReportAxis>,
        strapdown: Vec<[UnaidedError; 2]>,
        logs: &Logs,
        summaries: Summaries,
    ) -> Self {
        let Summaries { log, reference, evaluation } = summaries;
        let refined =
            axes.iter().map(|axis| (axis.section.column.as_str(), axis.section.refinement.as_ref()));
        let commands = command_lines(&study.data.sources, &study.settings, logs, refined);
        Self {
            tool: Tool::this(),
            provenance: study.provenance().lines().map(str::to_owned).collect(),
            log,
            reference,
            evaluation,
            axes,
            strapdown,
            commands,
            settings: serde_json::to_value(&study.settings).unwrap_or_default(),
        }
    }
}

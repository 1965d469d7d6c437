//! What there is to say of one axis, in the order of thought: where the model fails, what is missing, how the error
//! falls.

use fos_data::column::Column;
use serde::Serialize;

use super::offer::{Offer, offers};
use crate::examine::Examination;
use crate::figures::Figure;
use crate::plots::staircase_of;
use fos_diagnose::compare::AxisComparison;
use fos_diagnose::detect::Diagnosis;
use fos_diagnose::effects::Library;
use fos_diagnose::refine::{Logs, RefineError};
use fos_diagnose::study::Refinement;
use fos_diagnose::study::Study;
use fos_fit::candidates::monomial_text_named;

/// One axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct AxisSection {
    /// As in the log format, as `gx_rads`.
    pub column: String,
    /// As in `gyro x`.
    pub label: String,
    /// Unit of the column, as `rad/s`.
    pub unit: String,
    /// Its model as it is now.
    pub model: Option<ModelSummary>,
    /// The model as it is now against the field log.
    pub comparison: Option<AxisComparison>,
    /// First and last time stamp that the comparison is of, s.
    pub judged_s: Option<(f64, f64)>,
    /// What is missing from the model as it is now.
    pub diagnosis: Option<Diagnosis>,
    /// One for each finding of the diagnosis.
    pub offers: Vec<Offer>,
    /// Every step of the model, with its errors.
    #[serde(rename = "growth")]
    pub refinement: Option<Refinement>,
    /// The same as a figure.
    pub staircase: Option<Figure>,
}

/// The model of an axis in words.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ModelSummary {
    /// Physical and stochastic together.
    pub terms: usize,
    /// Candidates that were searched.
    pub candidates: usize,
    /// By which method.
    pub method: String,
    /// Why the search stopped.
    pub stopped: String,
    /// Terms of the stochastic part, in the order of their selection.
    pub monomials: Vec<String>,
    /// Terms of the physical part.
    pub physical: Vec<PhysicalTerm>,
}

/// A term of the physical part.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PhysicalTerm {
    /// The product of inputs.
    pub term: String,
    /// Coefficient, unit of the axis per unit of the product.
    pub coefficient: f64,
}

impl AxisSection {
    /// An axis of which nothing is known yet.
    pub fn empty(column: &str) -> Self {
        Self {
            column: column.to_owned(),
            label: Column::named(column).label().to_owned(),
            unit: Column::named(column).unit().label().to_owned(),
            model: None,
            comparison: None,
            judged_s: None,
            diagnosis: None,
            offers: Vec::new(),
            refinement: None,
            staircase: None,
        }
    }

    /// The axis of a study as it is refined, without comparison and diagnosis.
    pub fn of(study: &Study, refinement: &Refinement) -> Self {
        Self {
            model: ModelSummary::of(study, refinement),
            staircase: Some(staircase_of(refinement)),
            refinement: Some(refinement.clone()),
            ..Self::empty(&refinement.column)
        }
    }

    /// With the model against the field log.
    pub fn examined(mut self, examination: &Examination) -> Self {
        self.comparison = Some(examination.comparison.clone());
        self.judged_s = Some(examination.judged_s);
        self
    }

    /// With what is missing from the model of `refinement`.
    ///
    /// # Errors
    ///
    /// A column is missing, or the log is too short.
    pub fn diagnosed(
        mut self,
        refinement: &Refinement,
        logs: &Logs,
        library: &Library,
    ) -> Result<Self, RefineError> {
        let refiner = logs.refiner(library);
        let diagnosis = refiner.diagnose(refinement)?;
        self.offers = offers(&refiner, refinement, &diagnosis, library, &logs.field)?;
        self.diagnosis = Some(diagnosis);
        Ok(self)
    }
}

impl ModelSummary {
    fn of(study: &Study, refinement: &Refinement) -> Option<Self> {
        let report = study.axes.iter().find(|report| report.column == refinement.column)?;
        let model = &refinement.last()?.model;
        let axis = model.axes.first()?;
        let names: Vec<&str> = model.inputs.iter().map(|named| named.name.as_str()).collect();
        let text = |factors: &[fos_core::Factor]| monomial_text_named(factors, "r", &names);
        let physical = axis.physical.iter().map(|term| PhysicalTerm {
            term: text(&term.factors),
            coefficient: term.coefficient * axis.parameters.scale,
        });
        Some(Self {
            terms: model.n_terms(),
            candidates: report.candidates,
            method: report.method.to_string(),
            stopped: report.stopped.clone(),
            monomials: axis.stochastic.iter().map(|term| text(&term.factors)).collect(),
            physical: physical.collect(),
        })
    }
}

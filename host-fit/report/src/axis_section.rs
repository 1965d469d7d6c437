//! Section of a report on one axis, in the order of reasoning: where the model fails, which effect is missing, how far
//! the error is reduced.

use fos_data::column::Column;
use fos_data::recording::Recording;
use serde::Serialize;

use super::offer::{Offer, offers};
use crate::examine::Examination;
use crate::physical_terms::physical_terms;
use fos_diagnose::compare::AxisComparison;
use fos_diagnose::detect::Diagnosis;
use fos_diagnose::refine::{RefineError, Refiner};
use fos_diagnose::study::Refinement;
use fos_diagnose::study::Study;
use fos_figures::Figure;
use fos_figures::staircase::staircase;
use fos_figures::units::Units;
use fos_fit::candidates::monomial_text_named;

/// Findings on one axis.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct AxisSection {
    /// Column of the log format, such as `gx_rads`.
    pub column: String,
    /// Name for people, such as `gyro x`.
    pub label: String,
    /// Unit of the column, such as `rad/s`.
    pub unit: String,
    /// Summary of the present model.
    pub model: Option<ModelSummary>,
    /// Comparison of the present model with the log to explain.
    pub comparison: Option<AxisComparison>,
    /// First and last timestamp of the compared rows, s.
    pub evaluated_s: Option<(f64, f64)>,
    /// Effects missing from the present model.
    pub diagnosis: Option<Diagnosis>,
    /// One offer for each finding of the diagnosis.
    pub offers: Vec<Offer>,
    /// Every step of the refinement, with the errors of its model.
    pub refinement: Option<Refinement>,
    /// Refinement as a figure.
    pub staircase: Option<Figure>,
}

/// Summary of the model of an axis, for people.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct ModelSummary {
    /// Number of terms, physical and stochastic together.
    pub terms: usize,
    /// Number of candidates that were searched.
    pub candidates: usize,
    /// Search method.
    pub method: String,
    /// Reason why the search stopped.
    pub stopped: String,
    /// Terms of the stochastic part, in the order of their selection.
    pub monomials: Vec<String>,
    /// Terms of the physical part, as in a data sheet: `0.0123 ± 0.0004 (°/s)/K of temp_c`.
    pub physical: Vec<String>,
}

impl AxisSection {
    /// Returns a section without results.
    pub fn empty(column: &str) -> Self {
        Self {
            column: column.to_owned(),
            label: Column::named(column).label().to_owned(),
            unit: Column::named(column).unit().label().to_owned(),
            ..Self::default()
        }
    }

    /// Returns the section of a refined axis of a study, without comparison and diagnosis.
    pub fn of(study: &Study, refinement: &Refinement) -> Self {
        Self {
            model: ModelSummary::of(study, refinement),
            staircase: Some(staircase(refinement)),
            refinement: Some(refinement.clone()),
            ..Self::empty(&refinement.column)
        }
    }

    /// Adds the comparison of the model with the log to explain.
    pub fn examined(mut self, examination: &Examination) -> Self {
        self.comparison = Some(examination.comparison.clone());
        self.evaluated_s = Some(examination.evaluated_s);
        self
    }

    /// Adds the effects missing from the model of `refinement`, and their offers. `log` is the log to explain.
    pub fn diagnosed(
        mut self,
        refinement: &Refinement,
        refiner: &Refiner<'_>,
        log: &Recording,
    ) -> Result<Self, RefineError> {
        let diagnosis = refiner.diagnose(refinement)?;
        self.offers = offers(refiner, refinement, &diagnosis, log)?;
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
        Some(Self {
            terms: model.n_terms(),
            candidates: report.candidates,
            method: report.method.to_string(),
            stopped: report.stopped.clone(),
            monomials: axis.stochastic.iter().map(|term| text(&term.factors)).collect(),
            physical: physical_terms(model, axis, Units::Field),
        })
    }
}

//! Consistency checks of a study beyond the types of its fields, which all later computations rely on.

use std::collections::HashSet;

use fos_core::{Channel, Factor, FittedOn, Source, Term};

use super::Study;
use super::refinement::{Added, Refinement};
use crate::detect::{Finding, step_time};
use crate::effects::Regressor;
use fos_data::column::Column;
use fos_data::recording::SensorProvenance;
use fos_fit::model::{FittedAxis, FittedTerm, NamedInput, UnitModel};

impl Study {
    /// Checks the study. The error is the inconsistency, which no study written by this program has.
    pub(super) fn check(&self) -> Result<(), String> {
        check_model(&self.model).map_err(|wrong| format!("model: {wrong}"))?;
        let columns: Vec<&str> = self.model.axes.iter().map(|axis| axis.column.as_str()).collect();
        let reports: Vec<&str> = self.axes.iter().map(|report| report.column.as_str()).collect();
        if columns != reports {
            return Err(format!("axes: they are {reports:?}, those of the model {columns:?}"));
        }
        if let Some(step) = self.steps.iter().find(|step| step.errors.len() != columns.len()) {
            let (errors, axes) = (step.errors.len(), columns.len());
            return Err(format!("steps: {:?} has the errors of {errors} axes, the model {axes}", step.name));
        }
        if let Some((column, by)) = self.corrected_axis().filter(|_| self.model.fitted_on == FittedOn::Raw) {
            return Err(format!("model: of raw values, and {column} of its log was corrected by {by}"));
        }
        if self.data.trained_rows > self.data.rows {
            return Err("data: fitted to more rows than there are".to_owned());
        }
        let mut grown = HashSet::new();
        for refinement in &self.refinements {
            let column = refinement.column.as_str();
            if !columns.contains(&column) || !grown.insert(column) {
                return Err(format!("refinement: {column:?} is no axis of the model, or stands there twice"));
            }
            check_refinement(refinement).map_err(|wrong| format!("refinement of {column}: {wrong}"))?;
        }
        Ok(())
    }

    /// Returns an axis of the model whose values were corrected before they were logged, and the corrector.
    fn corrected_axis(&self) -> Option<(&str, String)> {
        let find = |axis: &FittedAxis| {
            let (triad, _) = Column::named(&axis.column).place()?;
            SensorProvenance::of_sources(&self.data.sources, triad).corrected_by().map(str::to_owned)
        };
        self.model.axes.iter().find_map(|axis| Some((axis.column.as_str(), find(axis)?)))
    }
}

fn check_model(model: &UnitModel) -> Result<(), String> {
    let UnitModel { quantities, inputs, axes, .. } = model;
    if axes.is_empty() {
        return Err("there is no axis".to_owned());
    }
    // they are counted in a byte
    if [quantities.len(), inputs.len(), axes.len()].into_iter().any(|count| count > usize::from(u8::MAX)) {
        return Err("more quantities, inputs or axes than 255".to_owned());
    }
    for NamedInput { name, input } in inputs {
        let is_there = match input.source {
            Source::Clock => true,
            Source::Quantity(index) => usize::from(index) < quantities.len(),
            Source::Remainder(index) => usize::from(index) < axes.len(),
        };
        if !is_there {
            return Err(format!("{name}: what it is computed from is not there"));
        }
    }
    let mut columns = HashSet::new();
    for FittedAxis { column, physical, stochastic, .. } in axes {
        if !columns.insert(column) {
            return Err(format!("two axes of the column {column:?}"));
        }
        for FittedTerm { coefficient, factors, .. } in physical.iter().chain(stochastic) {
            if Term::try_new(*coefficient, factors).is_none() {
                return Err(format!("{column}: a term has 1 to 3 factors, and no output at lag 0"));
            }
            let is_there = |factor: &Factor| match factor.channel {
                Channel::Output => true,
                Channel::Input(index) => usize::from(index) < inputs.len(),
            };
            if !factors.iter().all(is_there) {
                return Err(format!("{column}: a term names an input that is not there"));
            }
        }
    }
    // each axis alone: together they may exceed a predictor, and effects can be removed one by one
    for (index, axis) in axes.iter().enumerate() {
        let alone = model.only(index).predictor::<f64>();
        alone.map_err(|error| format!("{}: {error}", axis.column))?;
    }
    // last, because it needs ranges that were checked
    match model.device_calibration() {
        Some(calibration) => calibration.convert::<f32>().check().map_err(|error| error.to_string()),
        None => Ok(()),
    }
}

fn check_refinement(refinement: &Refinement) -> Result<(), String> {
    if refinement.steps.is_empty() {
        return Err("there is no step".to_owned());
    }
    for (number, step) in refinement.steps.iter().enumerate() {
        let at = |wrong: String| format!("step {number}: {wrong}");
        check_model(&step.model).map_err(at)?;
        if step.model.axis().column != refinement.column {
            return Err(at(format!("the model is of {}, not of this axis", step.model.axis().column)));
        }
        match &step.added {
            Some(added) if number > 0 => check_added(added).map_err(at)?,
            None if number == 0 => {}
            _ => return Err(at("an effect is added by each step but the first".to_owned())),
        }
    }
    Ok(())
}

fn check_added(Added { effect, finding, .. }: &Added) -> Result<(), String> {
    effect.check()?;
    let Finding { effect: found, correction, limits, .. } = finding;
    if *found != effect.id {
        return Err(format!("the effect is {:?}, the finding is {found:?}", effect.id));
    }
    for term in correction {
        if step_time(&term.regressor).is_none() {
            Regressor::parse(&term.regressor)?;
        }
    }
    match limits.iter().find(|(_, [low, high])| low > high) {
        Some((input, _)) => Err(format!("the limits of {input} are the wrong way round")),
        None => Ok(()),
    }
}

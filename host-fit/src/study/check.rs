//! What a study must hold beyond the types of its fields: whatever is done with it relies on that.

use std::collections::HashSet;

use fos_core::Term;

use super::Study;
use crate::diagnose::{Finding, step_time};
use crate::effects::Regressor;
use crate::grow::{Added, Growth};
use crate::model::{FittedAxis, UnitModel};

impl Study {
    /// # Errors
    ///
    /// What no study holds that this program wrote, in words.
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
        if self.data.trained_rows > self.data.rows {
            return Err("data: fitted to more rows than there are".to_owned());
        }
        let mut grown = HashSet::new();
        for growth in &self.growth {
            let column = growth.column.as_str();
            if !columns.contains(&column) || !grown.insert(column) {
                return Err(format!("growth: {column:?} is no axis of the model, or stands there twice"));
            }
            check_growth(growth).map_err(|wrong| format!("growth of {column}: {wrong}"))?;
        }
        Ok(())
    }
}

fn check_model(model: &UnitModel) -> Result<(), String> {
    let mut columns = HashSet::new();
    for FittedAxis { column, physical, stochastic, .. } in &model.axes {
        if !columns.insert(column) {
            return Err(format!("two axes of the column {column:?}"));
        }
        let is_term = |factors: &[_]| Term::try_new(0.0, factors).is_some();
        if !physical.iter().chain(stochastic).all(|term| is_term(&term.factors)) {
            return Err(format!("{column}: a term has 1 to 3 factors, and no output at lag 0"));
        }
    }
    model.predictor::<f64>().map(drop).map_err(|error| error.to_string())
}

fn check_growth(growth: &Growth) -> Result<(), String> {
    if growth.stairs.is_empty() {
        return Err("there is no stair".to_owned());
    }
    for (number, stair) in growth.stairs.iter().enumerate() {
        let at = |wrong: String| format!("stair {number}: {wrong}");
        check_model(&stair.model).map_err(at)?;
        if !matches!(&stair.model.axes[..], [axis] if axis.column == growth.column) {
            return Err(at("the model is not of this axis alone".to_owned()));
        }
        match &stair.added {
            Some(added) if number > 0 => check_added(added).map_err(at)?,
            None if number == 0 => {}
            _ => return Err(at("an effect is added by each stair but the first".to_owned())),
        }
    }
    Ok(())
}

fn check_added(Added { effect, finding, .. }: &Added) -> Result<(), String> {
    effect.check()?;
    let Finding { effect: found, correction, limits, .. } = finding;
    if *found != effect.id {
        return Err(format!("the effect is {:?}, what was found is {found:?}", effect.id));
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

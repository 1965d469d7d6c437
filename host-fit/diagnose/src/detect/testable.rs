//! Slow effects that a log can test, the rows in which all their inputs are known, and the data that the log lacks for
//! the others.

use std::sync::Arc;

use super::answer::Untested;
use super::findings::listed;
use super::hypothesis::{Hypotheses, Hypothesis};
use super::open::least_motion;
use super::question::{DiagnoseError, Question};
use super::shape::TEMPERATURE;
use crate::effects::{Detector, Effect, Inputs, Regressor};
use fos_data::column::AXES;
use fos_data::recording::RecordingError;
use fos_fit::noise::dot;

/// Slow effects that a log can test.
#[derive(Debug)]
pub(super) struct Testable {
    /// Effects that can be tested.
    pub(super) effects: Vec<Arc<Effect>>,
    /// Effects that cannot, with the data that they need.
    pub(super) untested: Vec<Untested>,
    /// Rows in which every column of the testable effects is known; before its first value a column would have to be
    /// guessed.
    pub(super) known: Vec<bool>,
}

impl Testable {
    /// Selects the effects of a question's library, without those that are given.
    pub(super) fn of(
        question: &Question<'_>,
        inputs: &Inputs<'_>,
        target: &str,
    ) -> Result<Self, DiagnoseError> {
        let (mut effects, mut untested, mut columns) = (Vec::new(), Vec::new(), Vec::new());
        for effect in question.library.effects() {
            let is_slow = matches!(effect.search, Detector::Terms | Detector::Step);
            let is_given = question.given.iter().any(|given| given.effect == effect.id);
            match lacking(effect, inputs, target) {
                Some(needs) if !needs.is_empty() && !is_given => {
                    untested.push(Untested::of(effect, needs));
                }
                Some(needs) if needs.is_empty() && is_slow => {
                    columns.extend(followed(effect, inputs, target));
                    if !is_given {
                        effects.push(Arc::new(effect.clone()));
                    }
                }
                _ => {}
            }
        }
        columns.sort_unstable();
        columns.dedup();
        let known = inputs.known_rows(columns.iter().map(String::as_str))?;
        Ok(Self { effects, untested, known })
    }

    /// Returns the effects of attitude, which an axis at rest in one attitude cannot show: its slow changes are its own
    /// error.
    pub(super) fn attitude_effects(
        &self,
        hypotheses: &Hypotheses<'_>,
        target: &str,
    ) -> Result<Vec<Untested>, RecordingError> {
        let mut attitude_effects = Vec::new();
        for effect in self.effects.iter().filter(|effect| effect.parameter.is_none()) {
            let Hypothesis { regressors, columns, .. } = hypotheses.make(effect, None)?;
            let axes = regressors.iter().zip(columns.iter()).filter_map(|(regressor, means)| {
                let axis = AXES.into_iter().find(|axis| regressor.to_string() == *axis)?;
                Some(dot(means, means).sqrt() < least_motion(axis) * (means.len() as f64).sqrt())
            });
            let at_rest: Vec<bool> = axes.collect();
            if !at_rest.is_empty() && !at_rest.contains(&false) {
                attitude_effects.push(Self::needs_variation(effect, hypotheses.inputs(), target));
            }
        }
        Ok(attitude_effects)
    }

    /// Returns the entry of an effect whose inputs change too little.
    pub(super) fn needs_variation(effect: &Effect, inputs: &Inputs<'_>, target: &str) -> Untested {
        let mut columns = followed(effect, inputs, target);
        columns.sort_unstable();
        columns.dedup();
        let needs = match columns.is_empty() {
            true => "a longer log at rest".to_owned(),
            false => format!("more variation of {}", listed(columns.into_iter())),
        };
        Untested::of(effect, vec![needs])
    }

    /// Returns the entry of an effect whose columns are logged but whose regressors add nothing to the model.
    pub(super) fn adds_nothing(effect: &Effect, inputs: &Inputs<'_>, target: &str) -> Untested {
        let followed = followed(effect, inputs, target);
        let changes = |column: &&String| {
            let values = inputs.recording().channel(column).map(|channel| channel.values.as_slice());
            let mut known = values.unwrap_or(&[]).iter().filter(|value| !value.is_nan());
            known.next().is_some_and(|first| known.any(|value| value != first))
        };
        let constant: Vec<String> = followed
            .iter()
            .filter(|column| !changes(column))
            .map(|column| format!("{column} (never changes)"))
            .collect();
        let needs = match constant.is_empty() {
            true => vec!["a log in which it differs from the effects in the model".to_owned()],
            false => constant,
        };
        Untested::of(effect, needs)
    }
}

/// Returns the regressors of an effect on an axis, at the lowest value of its parameter.
fn regressors(effect: &Effect, target: &str) -> Option<Vec<Regressor>> {
    let low = effect.parameter.as_ref().map(|parameter| parameter.low);
    let regressors = effect.regressors(target, low).ok()?;
    Some(regressors.into_iter().map(|(_, regressor)| regressor).collect())
}

/// Returns the logged columns that an effect follows.
pub(super) fn followed(effect: &Effect, inputs: &Inputs<'_>, target: &str) -> Vec<String> {
    let regressors = regressors(effect, target).unwrap_or_default();
    let logged = regressors.iter().filter_map(|regressor| inputs.logged(regressor));
    logged.flat_map(|regressor| regressor.columns().map(str::to_owned).collect::<Vec<_>>()).collect()
}

/// Describes the columns that `effect` needs and the log lacks; `None` if the effect cannot act on the target at all.
///
/// Terms whose column is not logged are excluded as long as one that follows a logged quantity remains: a single
/// accelerometer axis already shows vibration.
pub(super) fn lacking(effect: &Effect, inputs: &Inputs<'_>, target: &str) -> Option<Vec<String>> {
    if !effect.strikes(target) {
        return None;
    }
    if effect.search == Detector::NoiseLevel {
        return Some(inputs.lacks(TEMPERATURE).into_iter().collect());
    }
    if effect.search != Detector::Terms {
        return Some(Vec::new());
    }
    let regressors = regressors(effect, target)?;
    if !followed(effect, inputs, target).is_empty() {
        return Some(Vec::new());
    }
    let columns = regressors.iter().flat_map(Regressor::columns);
    let mut missing: Vec<String> = columns.filter_map(|column| inputs.lacks(column)).collect();
    missing.sort_unstable();
    missing.dedup();
    Some(missing)
}

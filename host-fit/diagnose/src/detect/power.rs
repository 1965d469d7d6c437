//! Which tested effects a log would have shown: an effect that could be as large as is typical without standing out of the
//! noise was not tested, whatever its score.

use std::sync::Arc;

use super::answer::Untested;
use super::findings::listed;
use super::hypothesis::{Hypotheses, Hypothesis};
use super::prepared::Prepared;
use super::question::DiagnoseError;
use super::slow::SlowResult;
use super::testable::followed;
use crate::effects::{Effect, Inputs};
use fos_fit::noise::{Gls, dot};

/// Standard errors of a coefficient that its largest typical value must exceed: those of a 95 % interval.
const VISIBLE: f64 = 1.96;

/// A log with its noise, as far as the power of a test depends on them.
pub(super) struct Power<'a> {
    prepared: &'a Prepared,
    hypotheses: &'a Hypotheses<'a>,
    slow: &'a SlowResult,
    inputs: &'a Inputs<'a>,
}

impl<'a> Power<'a> {
    pub(super) fn of(
        prepared: &'a Prepared,
        hypotheses: &'a Hypotheses<'a>,
        slow: &'a SlowResult,
        inputs: &'a Inputs<'a>,
    ) -> Self {
        Self { prepared, hypotheses, slow, inputs }
    }

    /// Those of the effects that the log would not have shown, with the data that would show them. An effect whose typical
    /// size is unknown counts as those that follow the same columns.
    pub(super) fn powerless(&self, effects: &[&Arc<Effect>]) -> Result<Vec<Untested>, DiagnoseError> {
        let mut shown: Vec<(&Arc<Effect>, Option<bool>)> = Vec::new();
        for effect in effects {
            let is_found = self.slow.found.iter().any(|found| found.hypothesis.effect.id == effect.id);
            shown.push((effect, if is_found { Some(true) } else { self.is_visible(effect)? }));
        }
        let columns = |effect: &Effect| followed(effect, self.inputs, &self.prepared.column);
        let follows = |wanted: bool, column: &String| {
            shown.iter().any(|(effect, is)| *is == Some(wanted) && columns(effect).contains(column))
        };
        let is_powerless = |effect: &Effect, is_visible: Option<bool>| match is_visible {
            Some(is_visible) => !is_visible,
            None => columns(effect).iter().any(|column| follows(false, column) && !follows(true, column)),
        };
        let needs = |effect: &Effect| {
            let mut columns = columns(effect);
            columns.sort_unstable();
            columns.dedup();
            match columns.is_empty() {
                true => "a longer log at rest".to_owned(),
                false => format!("more variation of {}", listed(columns.into_iter())),
            }
        };
        let powerless = shown.iter().filter(|(effect, is_visible)| is_powerless(effect, *is_visible));
        let untested =
            powerless.map(|(effect, _)| Untested { effect: effect.id.clone(), needs: vec![needs(effect)] });
        Ok(untested.collect())
    }

    /// Whether one of its terms would stand out at its largest typical size; `None` if no typical size is known.
    fn is_visible(&self, effect: &Arc<Effect>) -> Result<Option<bool>, DiagnoseError> {
        let target = self.prepared.column.as_str();
        let typical = |term: usize| Some(effect.typical(term, target)? * effect.unit(term, target)?.si);
        if (0..effect.terms.len()).all(|term| typical(term).is_none()) {
            return Ok(None);
        }
        let grid = self.hypotheses.grid(effect);
        // the ends and the middle of a parameter bracket its power
        let mut places = vec![0, grid.len() / 2, grid.len().saturating_sub(1)];
        places.dedup();
        for value in places.into_iter().filter_map(|place| grid.get(place)) {
            let Hypothesis { columns, terms, .. } = self.hypotheses.make(effect, *value)?;
            let sizes = terms.iter().map(|term| typical(*term));
            let is_visible = |(column, size): (&Vec<f64>, Option<f64>)| {
                size.is_some_and(|size| size.abs() * self.information(column).sqrt() >= VISIBLE)
            };
            if columns.iter().zip(sizes).any(is_visible) {
                return Ok(Some(true));
            }
        }
        Ok(Some(false))
    }

    /// One over the variance of the coefficient of a regressor beside what the model has already.
    fn information(&self, column: &[f64]) -> f64 {
        let given: Vec<&[f64]> = self.prepared.given.iter().map(Vec::as_slice).collect();
        let gls = Gls::new(&self.prepared.reduced.blocks, &self.slow.fitted.levels, column, &given);
        dot(&gls.residual, &gls.residual)
    }
}

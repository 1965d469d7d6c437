//! Power of the tests. An effect that may have its typical size without standing out of the noise counts as not tested,
//! whatever its score.

use std::sync::Arc;

use super::answer::Untested;
use super::hypothesis::Hypothesis;
use super::prepared::Prepared;
use super::question::DiagnoseError;
use super::slow::{Estimate, SlowResult};
use super::testable::{Testable, followed};
use crate::effects::Effect;
use fos_data::statistics::centred;
use fos_fit::noise::{Gls, combination, dot};

/// Standard errors that the largest typical coefficient must exceed: those of a 95 % interval.
const VISIBLE: f64 = 1.96;

/// Multiple of the largest typical size from which on a finding is implausible if the log shows no typical size, unless
/// it explains this share of the variance of the block means: then the column may be in another unit, or the effect
/// new.
const IMPLAUSIBLE: f64 = 5.0;
const MOST_BY_CHANCE: f64 = 0.25;

/// Least share of the variance of an effect that the levels of the rests must leave.
const LEFT_BY_LEVELS: f64 = 0.02;

/// A log and its noise as inputs of a power computation.
pub(super) struct Power<'a> {
    pub(super) prepared: &'a Prepared<'a>,
    pub(super) slow: &'a SlowResult,
}

impl Power<'_> {
    /// Returns those of the effects that the log would not have shown, with the data that they need. An effect without
    /// a known typical size is treated as those that follow the same columns.
    pub(super) fn powerless(&self, effects: &[Arc<Effect>]) -> Result<Vec<Untested>, DiagnoseError> {
        let mut shown: Vec<(&Arc<Effect>, Option<bool>)> = Vec::new();
        for effect in effects {
            let is_found = self.slow.found.iter().any(|found| found.hypothesis.effect.id == effect.id);
            shown.push((effect, if is_found { Some(true) } else { self.shows(effect)? }));
        }
        let columns = |effect: &Effect| followed(effect, self.prepared.inputs(), &self.prepared.column);
        let follows = |wanted: bool, column: &String| {
            shown.iter().any(|(effect, is)| *is == Some(wanted) && columns(effect).contains(column))
        };
        let is_powerless = |effect: &Effect, is_visible: Option<bool>| match is_visible {
            Some(is_visible) => !is_visible,
            None => columns(effect).iter().any(|column| follows(false, column) && !follows(true, column)),
        };
        let powerless = shown.iter().filter(|(effect, is_visible)| is_powerless(effect, *is_visible));
        powerless.map(|(effect, _)| self.untested(effect)).collect()
    }

    fn untested(&self, effect: &Arc<Effect>) -> Result<Untested, DiagnoseError> {
        Ok(match self.is_hidden_by_levels(effect)? {
            true => Untested::of(effect, vec!["longer rests in one orientation".to_owned()]),
            false => Testable::needs_variation(effect, self.prepared.inputs(), &self.prepared.column),
        })
    }

    /// Returns the findings of implausible size that this log would not show at any typical size: their inputs hardly
    /// change, and they match another drift by chance.
    pub(super) fn implausible(&self) -> Result<Vec<Untested>, DiagnoseError> {
        let gls = &self.slow.fitted.gls;
        let mut implausible = Vec::new();
        for found in &self.slow.found {
            let effect = &found.hypothesis.effect;
            let estimate = Estimate::of(gls, found.place.clone());
            let is_beyond = found.hypothesis.terms.iter().enumerate().any(|(at, &term)| {
                let typical = typical(effect, term, &self.prepared.column);
                let half = VISIBLE * estimate.covariance[(at, at)].sqrt();
                typical.is_some_and(|typical| estimate.coefficients[at].abs() - half > IMPLAUSIBLE * typical)
            });
            if is_beyond
                && self.share(&found.hypothesis, &estimate) < MOST_BY_CHANCE
                && self.is_visible(effect)? == Some(false)
            {
                implausible.push(self.untested(effect)?);
            }
        }
        Ok(implausible)
    }

    /// Returns the share of the variance of the block means that an effect explains.
    fn share(&self, hypothesis: &Hypothesis, estimate: &Estimate) -> f64 {
        let reduced = &self.prepared.reduced;
        let effect = combination(&hypothesis.columns, estimate.coefficients.as_slice(), reduced.means.len());
        let variance = |values: &[f64]| reduced.variance_in(values, 0..values.len());
        variance(&effect) / variance(&reduced.means)
    }

    fn shows(&self, effect: &Arc<Effect>) -> Result<Option<bool>, DiagnoseError> {
        if self.is_hidden_by_levels(effect)? { Ok(Some(false)) } else { self.is_visible(effect) }
    }

    /// Returns true if the levels of an accelerometer, one for each rest, take the course of an effect: what changes
    /// from rest to rest is gravity.
    fn is_hidden_by_levels(&self, effect: &Arc<Effect>) -> Result<bool, DiagnoseError> {
        let blocks = &self.prepared.reduced.blocks;
        if blocks.restarts().is_empty() {
            return Ok(false);
        }
        let grid = self.prepared.hypotheses.grid(effect);
        for value in ends_and_middle(&grid) {
            let Hypothesis { columns, .. } = self.prepared.hypotheses.make(effect, *value)?;
            let is_left = |column: &Vec<f64>| {
                let left = blocks.about_levels(column, 0..column.len());
                let all = centred(column.clone());
                dot(&left, &left) > LEFT_BY_LEVELS * dot(&all, &all)
            };
            if columns.iter().any(is_left) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns whether a term would stand out at its largest typical size; `None` if no typical size is known.
    fn is_visible(&self, effect: &Arc<Effect>) -> Result<Option<bool>, DiagnoseError> {
        let typical = |term: usize| typical(effect, term, &self.prepared.column);
        if (0..effect.terms.len()).all(|term| typical(term).is_none()) {
            return Ok(None);
        }
        let grid = self.prepared.hypotheses.grid(effect);
        for value in ends_and_middle(&grid) {
            let Hypothesis { columns, terms, .. } = self.prepared.hypotheses.make(effect, *value)?;
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

    /// Returns the inverse variance of the coefficient of a regressor added to the model.
    fn information(&self, column: &[f64]) -> f64 {
        let given: Vec<&[f64]> = self.prepared.given.iter().map(Vec::as_slice).collect();
        let gls = Gls::new(&self.prepared.reduced.blocks, &self.slow.fitted.levels, column, &given);
        dot(&gls.residual, &gls.residual)
    }
}

/// Values that bracket the power of an effect over the range of its parameter.
fn ends_and_middle<T>(grid: &[T]) -> impl Iterator<Item = &T> {
    let mut places = vec![0, grid.len() / 2, grid.len().saturating_sub(1)];
    places.dedup();
    places.into_iter().filter_map(|place| grid.get(place))
}

/// Largest typical coefficient of a term, SI.
fn typical(effect: &Effect, term: usize, target: &str) -> Option<f64> {
    Some(effect.typical(term, target)? * effect.unit(term, target)?.si)
}

//! Description of the result of a search: the gain of each effect, the uncertainty of its parameter, and the effects
//! that are indistinguishable from it.

use super::candidates::Tried;
use super::model::{SlowSearch, State};
use super::result::{ExtraNoise, Found, SlowResult};
use crate::detect::hypothesis::Hypothesis;
use crate::effects::Detector;
use fos_data::recording::RecordingError;
use fos_fit::noise::NoiseLevels;
use fos_fit::noise::{Gls, dot};

/// Rivals within this difference in −2 ln L are indistinguishable from a finding: odds of 33 to 1.
pub(in crate::detect) const INSEPARABLE: f64 = 7.0;

/// Factor within which a value counts as at a limit of the search.
const GRID_EDGE: f64 = 1.3;

/// Factor from the limits of the search from which on a value counts as well inside.
pub(in crate::detect) const INSIDE: f64 = 3.0;

/// A finding of which less than this share lies outside a rival is contained in it.
const NESTED: f64 = 1e-3;

impl SlowSearch<'_> {
    /// Computes gains, parameter errors and rivals of the accepted effects.
    pub(super) fn describe(&self, state: State, tried: Tried) -> Result<SlowResult, RecordingError> {
        let mut found = Vec::new();
        for (place, current) in state.accepted.iter().enumerate() {
            let (without, _) = self.without(&state, place);
            let levels = state.fitted.levels;
            let gain = without.fitted.deviance - state.fitted.deviance;
            let k = state.fitted.gls.kept.len().saturating_sub(without.fitted.gls.kept.len()).max(1);
            let mut rivals = Vec::new();
            for candidate in self.candidates(&without)? {
                if candidate.hypothesis.is_same_effect(current) {
                    continue;
                }
                let (mut rival, mut behind) = (candidate.hypothesis, gain - candidate.gain);
                if behind < INSEPARABLE && self.is_nested(current, &rival) {
                    match self.inside(&without, levels, &rival)? {
                        Some((inner, further)) => (rival, behind) = (inner, behind + further),
                        None => continue,
                    }
                }
                if behind < INSEPARABLE {
                    rivals.push((rival, behind));
                }
            }
            let score = gain - self.price(k, current, &without.accepted);
            let scored: Vec<(&Hypothesis, f64)> = rivals
                .iter()
                .filter(|(rival, _)| rival.effect.search == Detector::Terms)
                .map(|(rival, behind)| {
                    let price = self.price(rival.columns.len(), rival, &without.accepted);
                    (rival, score - (gain - behind - price))
                })
                .collect();
            let log_error = self.log_error(&without, levels, current)?;
            found.push(Found {
                hypothesis: current.clone(),
                alternatives: self.alternatives((&without, levels), current, log_error, &scored)?,
                place: self.place_after(&state.accepted[..place], current),
                log_error,
                gain,
                score,
                rivals,
            });
        }
        let (mut noise_gain, mut noise_score) = (0.0, 0.0);
        if state.noise != ExtraNoise::None {
            let base = NoiseLevels::from_logs(&self.prior.mean);
            let without = self.fit(&state.accepted, ExtraNoise::None, base);
            noise_gain = without.deviance - state.fitted.deviance;
            let price = if matches!(state.noise, ExtraNoise::Walk) { 1.0 } else { 2.0 };
            noise_score = noise_gain - price * (self.blocks.len() as f64).ln() - self.price_of_axes();
        }
        let noise = match (state.noise, state.fitted.levels.gauss_markov) {
            (ExtraNoise::GaussMarkov(_), Some(process)) => ExtraNoise::GaussMarkov(process),
            (noise, _) => noise,
        };
        let prior = self.prior_of(noise);
        Ok(SlowResult {
            found,
            noise,
            noise_gain,
            noise_score,
            fitted: state.fitted,
            prior,
            reference_prior: self.prior,
            tried: tried.scores,
            beside: Vec::new(),
            silent: tried.silent,
        })
    }

    /// Returns true if a rival contains the finding and thus explains at least as much: a cubic contains any line, and
    /// a lag at the shortest time constant contains any prompt response.
    fn is_nested(&self, finding: &Hypothesis, rival: &Hypothesis) -> bool {
        let levels = NoiseLevels::from_logs(&self.prior.mean);
        let constant = &self.given[0];
        let freedom =
            |hypothesis: &Hypothesis| hypothesis.effect.terms.len() + usize::from(hypothesis.value.is_some());
        if freedom(rival) <= freedom(finding) {
            return false;
        }
        let at_limit = match (&rival.effect.parameter, rival.value) {
            (Some(parameter), Some(value)) => {
                value < parameter.low * GRID_EDGE || value > parameter.high / GRID_EDGE
            }
            _ => true,
        };
        if !at_limit {
            return false;
        }
        // the rival must span every column of the finding
        finding.columns().iter().all(|column| {
            let mut spanning: Vec<&[f64]> = vec![constant];
            spanning.extend(rival.columns());
            let alone = Gls::new(self.blocks, &levels, column, &[constant]);
            let spanned = Gls::new(self.blocks, &levels, column, &spanning);
            let (before, after) =
                (dot(&alone.residual, &alone.residual), dot(&spanned.residual, &spanned.residual));
            after < NESTED * before
        })
    }

    /// Moves a rival from the limit of its parameter to the best value well inside; also returns the increase of −2 ln
    /// L. A lag of a minute that explains a log as well as no lag is indistinguishable from none.
    fn inside(
        &self,
        rest: &State,
        levels: NoiseLevels,
        rival: &Hypothesis,
    ) -> Result<Option<(Hypothesis, f64)>, RecordingError> {
        let (Some(parameter), Some(_)) = (&rival.effect.parameter, rival.value) else { return Ok(None) };
        let at = |hypothesis: &Hypothesis| self.deviance_with(rest, hypothesis, levels);
        let limit = at(rival);
        let mut best: Option<(f64, Hypothesis)> = None;
        for value in self.hypotheses.grid(&rival.effect) {
            if value.is_some_and(|value| value > INSIDE * parameter.low && value < parameter.high / INSIDE) {
                let hypothesis = self.hypotheses.make(&rival.effect, value)?.with_terms_of(rival);
                let deviance = at(&hypothesis);
                if best.as_ref().is_none_or(|(other, _)| deviance < *other) {
                    best = Some((deviance, hypothesis));
                }
            }
        }
        Ok(best.map(|(deviance, hypothesis)| (hypothesis, deviance - limit)))
    }

    /// Returns the standard error of the logarithm of a parameter, from the curvature of the deviance.
    fn log_error(
        &self,
        rest: &State,
        levels: NoiseLevels,
        current: &Hypothesis,
    ) -> Result<Option<f64>, RecordingError> {
        let Some(value) = current.value.filter(|_| current.effect.search == Detector::Terms) else {
            return Ok(None);
        };
        let at = |log: f64| -> Result<f64, RecordingError> {
            let hypothesis = self.hypotheses.make(&current.effect, Some(log.exp()))?.with_terms_of(current);
            Ok(self.deviance_with(rest, &hypothesis, levels))
        };
        let step = 0.1;
        let curvature =
            (at(value.ln() + step)? - 2.0 * at(value.ln())? + at(value.ln() - step)?) / (step * step);
        Ok((curvature > 0.0).then(|| (2.0 / curvature).sqrt()))
    }
}

//! Candidates: every effect added to a model, in a first pass with given noise levels, then the best with fitted
//! levels.

use std::collections::HashSet;
use std::sync::Arc;

use super::model::{ACCEPT, SlowSearch, State};
use super::result::ExtraNoise;
use crate::detect::hypothesis::Hypothesis;
use crate::effects::{Detector, Effect};
use fos_data::interrupt::in_parallel;
use fos_data::recording::RecordingError;
use fos_fit::noise::{Fitted, NoiseLevels};

/// Least number of hypotheses whose noise levels are fitted: the best of the first pass.
const FITTED: usize = 9;

/// A hypothesis added to a state.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub(super) hypothesis: Hypothesis,
    pub(super) fitted: Fitted,
    pub(super) gain: f64,
    pub(super) score: f64,
}

/// Scores of the effects that were tried alone, and the effects that add nothing.
#[derive(Debug, Clone, Default)]
pub(super) struct Tried {
    pub(super) scores: Vec<(String, f64)>,
    pub(super) silent: Vec<Arc<Effect>>,
}

/// Number of hypotheses of a first pass whose noise levels are fitted: all acceptable ones, since under the levels of
/// the first pass a drift that noise explains as well passes for an effect.
fn fitted_of(first_pass: &[(f64, Hypothesis)]) -> usize {
    let acceptable = first_pass.iter().take_while(|(score, _)| *score >= ACCEPT).count();
    acceptable.max(FITTED).min(first_pass.len())
}

impl SlowSearch<'_> {
    /// Returns every effect at the best value of its parameter on top of `state`, with the noise levels fitted for the
    /// best of them; highest score first.
    pub(super) fn candidates(&self, state: &State) -> Result<Vec<Candidate>, RecordingError> {
        self.fitted(state, &self.first_pass(state)?)
    }

    /// Refines the parameters of the best of a first pass and fits the noise levels under each; highest score first.
    pub(super) fn fitted(
        &self,
        state: &State,
        first_pass: &[(f64, Hypothesis)],
    ) -> Result<Vec<Candidate>, RecordingError> {
        let best = &first_pass[..fitted_of(first_pass)];
        let fit = |(_, hypothesis): &(f64, Hypothesis)| self.candidate(state, hypothesis.clone());
        let mut candidates = in_parallel(best, fit).into_iter().collect::<Result<Vec<_>, _>>()?;
        candidates.sort_by(|a, b| b.score.total_cmp(&a.score));
        self.remove_thermal_steps(state, &mut candidates);
        let mut seen = HashSet::new();
        candidates.retain(|candidate| seen.insert(candidate.hypothesis.effect.id.clone()));
        Ok(candidates)
    }

    /// Returns the score of every effect that was tried alone: from the fit if it was fitted, else from the first pass.
    pub(super) fn tried(&self, first_pass: &[(f64, Hypothesis)], candidates: &[Candidate]) -> Tried {
        let id = |hypothesis: &Hypothesis| hypothesis.effect.id.clone();
        let fitted = candidates.iter().map(|candidate| (id(&candidate.hypothesis), candidate.score));
        let behind =
            first_pass.iter().skip(fitted_of(first_pass)).map(|(score, hypothesis)| (id(hypothesis), *score));
        let mut scores: Vec<(String, f64)> = fitted.chain(behind).collect();
        let mut seen = HashSet::new();
        scores.retain(|(id, _)| seen.insert(id.clone()));
        let is_silent = |effect: &&Arc<Effect>| scores.iter().all(|(id, _)| *id != effect.id);
        Tried { silent: self.effects.iter().filter(is_silent).cloned().collect(), scores }
    }

    /// Returns every effect at the best value of its parameter on top of `state`, under the noise levels of the prior, and
    /// at the best value under the fitted levels where that is another; highest score first. Effects whose regressors
    /// add nothing are excluded.
    ///
    /// The fitted levels are inflated by a missing effect, so that it hardly shows under them. Under those of the prior
    /// a large slow residual outweighs a sharp change: the step that explains most of it is not where the bias jumps.
    pub(super) fn first_pass(&self, state: &State) -> Result<Vec<(f64, Hypothesis)>, RecordingError> {
        let at = |levels: NoiseLevels| self.at(&state.accepted, state.noise, levels);
        let mut nulls = vec![at(state.fitted.levels)];
        if state.noise == ExtraNoise::None {
            nulls.insert(0, at(NoiseLevels::from_logs(&self.prior.mean)));
        }
        let best = |effect: &Arc<Effect>| -> Result<Vec<(f64, Hypothesis)>, RecordingError> {
            if state.accepted.iter().any(|hypothesis| hypothesis.effect.id == effect.id)
                && effect.search != Detector::Step
            {
                return Ok(Vec::new());
            }
            let grid = self.hypotheses.grid(effect);
            let mut best: Vec<(f64, Hypothesis)> = Vec::new();
            for null in if grid.len() > 1 { &nulls[..] } else { &nulls[..1] } {
                let mut here: Option<(f64, Hypothesis)> = None;
                for value in &grid {
                    let hypothesis = self.hypotheses.make(effect, *value)?;
                    let (gain, k) = null.gls.gain(&hypothesis.columns());
                    if k == 0 {
                        continue;
                    }
                    let score = gain - self.price(k, &hypothesis, &state.accepted);
                    if here.as_ref().is_none_or(|(other, _)| score > *other) {
                        here = Some((score, hypothesis));
                    }
                }
                best.extend(here.filter(|(_, here)| best.iter().all(|(_, other)| other.value != here.value)));
            }
            Ok(best)
        };
        let best: Result<Vec<_>, _> = in_parallel(self.effects, best).into_iter().collect();
        let mut first_pass: Vec<(f64, Hypothesis)> = best?.into_iter().flatten().collect();
        first_pass.sort_by(|a, b| b.0.total_cmp(&a.0));
        Ok(first_pass)
    }

    /// Fits a hypothesis on top of `state`: refines its parameter and fits the noise levels.
    pub(super) fn candidate(
        &self,
        state: &State,
        hypothesis: Hypothesis,
    ) -> Result<Candidate, RecordingError> {
        let with = |hypothesis: &Hypothesis, start| {
            self.fit(state.accepted.iter().chain([hypothesis]), state.noise, start)
        };
        let first = with(&hypothesis, state.fitted.levels);
        let refined = self.significant_terms(state, first.levels, hypothesis)?;
        let fitted = with(&refined, first.levels);
        let k = fitted.gls.kept.len().saturating_sub(state.fitted.gls.kept.len());
        let gain = state.fitted.deviance - fitted.deviance;
        let score = gain - self.price(k.max(1), &refined, &state.accepted);
        Ok(Candidate { hypothesis: refined, fitted, gain, score })
    }
}

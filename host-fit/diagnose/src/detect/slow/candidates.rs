//! Every effect on top of a model: a first pass under given noise levels, then the best of it with the levels fitted.

use std::sync::Arc;

use super::model::{ACCEPT, SlowSearch, State};
use super::result::ExtraNoise;
use crate::detect::hypothesis::Hypothesis;
use crate::effects::{Detector, Effect};
use fos_data::interrupt::in_parallel;
use fos_data::recording::RecordingError;
use fos_fit::noise::{Fitted, NoiseLevels};

/// Hypotheses whose noise levels are fitted at least: the best of the first pass.
const FITTED: usize = 9;

/// A hypothesis on top of a state.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub(super) hypothesis: Hypothesis,
    pub(super) fitted: Fitted,
    pub(super) gain: f64,
    pub(super) score: f64,
}

/// What became of the effects that were tried alone.
#[derive(Debug, Clone, Default)]
pub(super) struct Tried {
    pub(super) scores: Vec<(String, f64)>,
    pub(super) silent: Vec<Arc<Effect>>,
}

/// Hypotheses of a first pass whose noise levels are fitted: all that it would accept, since under its levels a drift that
/// the noise explains as well passes for an effect.
fn fitted_of(first_pass: &[(f64, Hypothesis)]) -> usize {
    let acceptable = first_pass.iter().take_while(|(score, _)| *score >= ACCEPT).count();
    acceptable.max(FITTED).min(first_pass.len())
}

impl SlowSearch<'_> {
    /// Every effect at the best value of its parameter on top of `state`, those of them fitted that explain most; best
    /// score first.
    pub(super) fn candidates(&self, state: &State) -> Result<Vec<Candidate>, RecordingError> {
        self.fitted(state, &self.first_pass(state)?)
    }

    /// The best of a first pass, their parameters refined and the levels fitted under each; best score first.
    pub(super) fn fitted(
        &self,
        state: &State,
        first_pass: &[(f64, Hypothesis)],
    ) -> Result<Vec<Candidate>, RecordingError> {
        let accepted: Vec<&Hypothesis> = state.accepted.iter().collect();
        let best = &first_pass[..fitted_of(first_pass)];
        let fit = |(_, hypothesis): &(f64, Hypothesis)| self.candidate(&accepted, state, hypothesis.clone());
        let mut candidates = in_parallel(best, fit).into_iter().collect::<Result<Vec<_>, _>>()?;
        candidates.sort_by(|a, b| b.score.total_cmp(&a.score));
        self.without_thermal_steps(state, &mut candidates);
        Ok(candidates)
    }

    /// What became of every effect that was tried alone: those fitted with the score of the fit, the others with that
    /// of the first pass, which left them behind.
    pub(super) fn tried(&self, first_pass: &[(f64, Hypothesis)], candidates: &[Candidate]) -> Tried {
        let id = |hypothesis: &Hypothesis| hypothesis.effect.id.clone();
        let fitted = candidates.iter().map(|candidate| (id(&candidate.hypothesis), candidate.score));
        let behind =
            first_pass.iter().skip(fitted_of(first_pass)).map(|(score, hypothesis)| (id(hypothesis), *score));
        let scores: Vec<(String, f64)> = fitted.chain(behind).collect();
        let is_silent = |effect: &&Arc<Effect>| scores.iter().all(|(id, _)| *id != effect.id);
        Tried { silent: self.effects.iter().filter(is_silent).cloned().collect(), scores }
    }

    /// Every effect at the best value of its parameter on top of `state`, under given levels; best score first. Effects
    /// of which no regressor adds anything are left out.
    pub(super) fn first_pass(&self, state: &State) -> Result<Vec<(f64, Hypothesis)>, RecordingError> {
        // at the prior's levels: those of the null have swollen to hold what is missing
        let mut levels = NoiseLevels::from_logs(&self.prior.mean);
        if state.noise != ExtraNoise::None {
            levels = state.fitted.levels;
        }
        let accepted: Vec<&Hypothesis> = state.accepted.iter().collect();
        let null = self.at(&accepted, state.noise, levels);
        let best = |effect: &Arc<Effect>| -> Result<Option<(f64, Hypothesis)>, RecordingError> {
            if state.accepted.iter().any(|hypothesis| hypothesis.effect.id == effect.id)
                && effect.search != Detector::Step
            {
                return Ok(None);
            }
            let mut best: Option<(f64, Hypothesis)> = None;
            for value in self.hypotheses.grid(effect) {
                let hypothesis = self.hypotheses.make(effect, value)?;
                let (gain, k) = null.gls.gain(&hypothesis.columns());
                if k == 0 {
                    continue;
                }
                let score = gain - self.price(k, &hypothesis, &accepted);
                if best.as_ref().is_none_or(|(other, _)| score > *other) {
                    best = Some((score, hypothesis));
                }
            }
            Ok(best)
        };
        let best: Result<Vec<_>, _> = in_parallel(self.effects, best).into_iter().collect();
        let mut first_pass: Vec<(f64, Hypothesis)> = best?.into_iter().flatten().collect();
        first_pass.sort_by(|a, b| b.0.total_cmp(&a.0));
        Ok(first_pass)
    }

    /// A hypothesis on top of `accepted`, its parameter refined and the levels fitted.
    pub(super) fn candidate(
        &self,
        accepted: &[&Hypothesis],
        state: &State,
        hypothesis: Hypothesis,
    ) -> Result<Candidate, RecordingError> {
        let with = |hypothesis: &Hypothesis, start| {
            let all: Vec<&Hypothesis> = accepted.iter().copied().chain([hypothesis]).collect();
            self.fit(&all, state.noise, start)
        };
        let first = with(&hypothesis, state.fitted.levels);
        let refined = self.worth_their_price(accepted, state.noise, &first, hypothesis)?;
        let fitted = with(&refined, first.levels);
        let k = fitted.gls.kept.len().saturating_sub(state.fitted.gls.kept.len());
        let gain = state.fitted.deviance - fitted.deviance;
        let score = gain - self.price(k.max(1), &refined, accepted);
        Ok(Candidate { hypothesis: refined, fitted, gain, score })
    }
}

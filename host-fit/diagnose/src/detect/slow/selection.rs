//! Forward selection among hypotheses, and joint estimation of given effects.

use std::sync::Arc;

use super::candidates::Tried;
use super::model::{ACCEPT, SlowSearch, State};
use super::result::SlowResult;
use crate::effects::Effect;
use fos_data::recording::RecordingError;

/// Largest number of findings of one search.
pub(crate) const MAX_FOUND: usize = 4;

/// Number of times that each of several given effects is estimated again beside the others.
const PASSES: usize = 2;

impl SlowSearch<'_> {
    /// Runs the search.
    pub(crate) fn run(&self) -> Result<SlowResult, RecordingError> {
        let mut state = self.null();
        let (mut tried, mut beside) = (Tried::default(), Vec::new());
        // terminates after MAX_FOUND rounds; a gain need not be monotonic, because `exchange` and `drop_unneeded_noise`
        // refit
        for round in 0..MAX_FOUND {
            fos_data::interrupt::check();
            let first_pass = self.first_pass(&state)?;
            let candidates = self.fitted(&state, &first_pass)?;
            let round_results = self.tried(&first_pass, &candidates);
            match round {
                0 => tried = round_results,
                _ => beside = round_results.scores,
            }
            let noise = self.best_noise(&state);
            let best = self.best_reported(candidates);
            let best_score = best.as_ref().map_or(f64::NEG_INFINITY, |candidate| candidate.score);
            match (best, noise) {
                (_, Some((noise, fitted, score))) if score >= ACCEPT && score > best_score => {
                    state = State { noise, fitted, ..state };
                }
                (Some(best), _) if best.score >= ACCEPT => {
                    state.accepted.push(best.hypothesis);
                    state.fitted = best.fitted;
                    self.drop_unneeded_noise(&mut state);
                    self.exchange(&mut state)?;
                }
                _ => break,
            }
        }
        self.drop_unsupported(&mut state);
        Ok(SlowResult { beside, ..self.describe(state, tried)? })
    }

    /// Estimates these effects together, whether or not they are missing.
    pub(crate) fn estimate(&self, wanted: &[Arc<Effect>]) -> Result<SlowResult, RecordingError> {
        let mut state = self.null();
        for effect in wanted {
            let alone = SlowSearch { effects: std::slice::from_ref(effect), ..*self };
            if let Some(best) = alone.candidates(&state)?.into_iter().next() {
                state.accepted.push(best.hypothesis);
                state.fitted = best.fitted;
            }
        }
        // the first effects were estimated without the later ones: a parameter may be far off
        let again = if wanted.len() > 1 { state.accepted.len() } else { 0 };
        for place in (0..PASSES).flat_map(|_| 0..again) {
            let (without, current) = self.without(&state, place);
            let effect = Arc::clone(&current.effect);
            let alone = SlowSearch { effects: std::slice::from_ref(&effect), ..*self };
            let own = self.candidate(&without, current)?;
            let again = alone.candidates(&without)?.into_iter().next();
            let again = again.filter(|again| again.score > own.score).unwrap_or(own);
            state.accepted[place] = again.hypothesis;
            state.fitted = self.fit(&state.accepted, state.noise, again.fitted.levels);
        }
        self.describe(state, Tried::default())
    }

    /// Replaces each effect by another that explains more in its place: the first was found before the others were
    /// known.
    fn exchange(&self, state: &mut State) -> Result<(), RecordingError> {
        if state.accepted.len() < 2 {
            return Ok(());
        }
        for place in 0..state.accepted.len() {
            let (without, current) = self.without(state, place);
            let own = self.candidate(&without, current.clone())?;
            let better = self.best_reported(self.candidates(&without)?);
            let winner = match better {
                Some(better) if better.score > own.score + 0.5 => better,
                _ => own,
            };
            state.accepted[place] = winner.hypothesis;
            state.fitted = winner.fitted;
        }
        Ok(())
    }

    /// Removes effects that are no longer significant beside later ones.
    fn drop_unsupported(&self, state: &mut State) {
        let mut place = 0;
        // terminates: each iteration passes one effect or removes one
        while place < state.accepted.len() {
            let (without, current) = self.without(state, place);
            let k = state.fitted.gls.kept.len().saturating_sub(without.fitted.gls.kept.len()).max(1);
            let price = self.price(k, &current, &without.accepted);
            if without.fitted.deviance - state.fitted.deviance - price < ACCEPT {
                *state = without;
            } else {
                place += 1;
            }
        }
    }
}

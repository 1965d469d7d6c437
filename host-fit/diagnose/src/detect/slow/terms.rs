//! Selection of an effect's regressors by penalised likelihood.

use super::model::{SlowSearch, State};
use crate::detect::hypothesis::Hypothesis;
use fos_data::recording::RecordingError;
use fos_fit::noise::{Fitted, NoiseLevels};

/// Largest number of terms for which every subset is tried.
const MAX_TERMS: usize = 6;

/// Subsets within this difference of the best, in −2 ln L plus penalty, count as equally good: odds of 4 to 1.
const AS_GOOD: f64 = 3.0;

/// The first sum alone is chosen if it explains this share of what all terms explain.
const NEARLY_ALL: f64 = 0.9;

impl SlowSearch<'_> {
    /// Returns the regressors of an effect that are worth their penalty on top of `state`, under given noise levels,
    /// with the best parameter value for them: coefficients that the log does not determine would be wrong in the next
    /// one. Among equally good subsets the smallest is chosen, then the first listed. If the terms share a parameter, the
    /// first one sets its scale and is in every subset.
    pub(super) fn significant_terms(
        &self,
        state: &State,
        levels: NoiseLevels,
        hypothesis: Hypothesis,
    ) -> Result<Hypothesis, RecordingError> {
        let n = hypothesis.columns.len();
        if !hypothesis.effect.any_terms || !(2..=MAX_TERMS).contains(&n) {
            return self.refine(state, levels, hypothesis);
        }
        let price = (self.blocks.len() as f64).ln();
        // part of a sum is added only on top of the sum: any axis shows vibration in one direction, but for a change of
        // direction the sum is needed
        let is_sum = |term: usize| {
            hypothesis.regressors.get(term).is_some_and(|regressor| regressor.products.len() > 1)
        };
        let has_sums = (0..n).any(is_sum);
        let has_scale = hypothesis.value.is_some();
        let with = |hypothesis: &Hypothesis| self.deviance_with(state, hypothesis, levels);
        let none = self.at(&state.accepted, state.noise, levels);
        if has_sums {
            let (all, first) = (with(&hypothesis), hypothesis.with_terms(&[0]));
            if none.deviance - with(&first) > NEARLY_ALL * (none.deviance - all) {
                return Ok(first);
            }
        }
        let mut choices: Vec<(f64, Hypothesis)> = (1_u32..1 << n)
            .map(|choice| (0..n).filter(|term| choice >> term & 1 == 1).collect::<Vec<usize>>())
            .filter(|terms| (!has_sums || is_sum(terms[0])) && (!has_scale || terms[0] == 0))
            .map(|terms| {
                let chosen = self.best_on_grid(&none, hypothesis.with_terms(&terms))?;
                let chosen = self.refine(state, levels, chosen)?;
                Ok((with(&chosen) + price * terms.len() as f64, chosen))
            })
            .collect::<Result<_, RecordingError>>()?;
        let best = choices.iter().map(|(deviance, _)| *deviance).fold(f64::INFINITY, f64::min);
        choices.retain(|(deviance, _)| *deviance < best + AS_GOOD);
        choices.sort_by(|a, b| a.1.terms.len().cmp(&b.1.terms.len()).then_with(|| a.1.terms.cmp(&b.1.terms)));
        // beyond the range of f64 no deviance is finite, and no subset is better than all terms
        Ok(if choices.is_empty() { hypothesis } else { choices.swap_remove(0).1 })
    }

    /// Returns the same terms at the grid value of the parameter that explains most on top of `none`.
    fn best_on_grid(&self, none: &Fitted, chosen: Hypothesis) -> Result<Hypothesis, RecordingError> {
        if chosen.value.is_none() {
            return Ok(chosen);
        }
        let mut best = (f64::NEG_INFINITY, chosen);
        for value in self.hypotheses.grid(&best.1.effect) {
            let there = self.hypotheses.make(&best.1.effect, value)?.with_terms_of(&best.1);
            let (gain, _) = none.gls.gain(&there.columns());
            if gain > best.0 {
                best = (gain, there);
            }
        }
        Ok(best.1)
    }
}

//! Which regressors of an effect are worth their price.

use super::model::SlowSearch;
use super::result::ExtraNoise;
use crate::detect::hypothesis::Hypothesis;
use fos_data::recording::RecordingError;
use fos_fit::noise::Fitted;

/// Terms of which every choice is tried.
const MOST_TERMS: usize = 6;

/// Choices of terms within this much of the best, in −2 ln L after their price, are as good: odds of 4 to 1.
const AS_GOOD: f64 = 3.0;

/// The first sum stands for the effect if it explains this share of what all terms explain.
const NEARLY_ALL: f64 = 0.9;

impl SlowSearch<'_> {
    /// The regressors of an effect that are worth their price, under given levels, with the best value of its parameter
    /// for them: coefficients that the log does not determine would go wrong in the next one. Of choices as good, the
    /// one listed first. Where the terms are multiples of one parameter the first of them sets its scale, and is in every
    /// choice.
    ///
    /// # Errors
    ///
    /// A column is missing.
    pub(super) fn worth_their_price(
        &self,
        accepted: &[&Hypothesis],
        noise: ExtraNoise,
        fitted: &Fitted,
        hypothesis: Hypothesis,
    ) -> Result<Hypothesis, RecordingError> {
        let n = hypothesis.columns.len();
        if !hypothesis.effect.any_terms || !(2..=MOST_TERMS).contains(&n) {
            return self.refine(accepted, noise, fitted, hypothesis);
        }
        let price = (self.blocks.len() as f64).ln();
        // a part of a sum comes on top of it: of shaking in one direction any axis tells, of the next direction the sum
        // does
        let is_sum = |term: usize| {
            hypothesis.regressors.get(term).is_some_and(|regressor| regressor.products.len() > 1)
        };
        let has_sums = (0..n).any(is_sum);
        let has_scale = hypothesis.value.is_some();
        let with = |hypothesis: &Hypothesis| self.deviance_with(accepted, hypothesis, noise, fitted.levels);
        let none = self.at(accepted, noise, fitted.levels);
        if has_sums {
            let (all, first) = (with(&hypothesis), hypothesis.of_terms(&[0]));
            if none.deviance - with(&first) > NEARLY_ALL * (none.deviance - all) {
                return Ok(first);
            }
        }
        let mut choices: Vec<(f64, Hypothesis)> = (1_u32..1 << n)
            .map(|choice| (0..n).filter(|term| choice >> term & 1 == 1).collect::<Vec<usize>>())
            .filter(|terms| (!has_sums || is_sum(terms[0])) && (!has_scale || terms[0] == 0))
            .map(|terms| {
                let chosen = self.best_on_grid(&none, hypothesis.of_terms(&terms))?;
                let chosen = self.refine(accepted, noise, fitted, chosen)?;
                Ok((with(&chosen) + price * terms.len() as f64, chosen))
            })
            .collect::<Result<_, RecordingError>>()?;
        let best = choices.iter().map(|(deviance, _)| *deviance).fold(f64::INFINITY, f64::min);
        choices.retain(|(deviance, _)| *deviance < best + AS_GOOD);
        choices.sort_by(|a, b| a.1.terms.len().cmp(&b.1.terms.len()).then_with(|| a.1.terms.cmp(&b.1.terms)));
        // of numbers beyond the range of f64 no deviance is finite, and no choice is better than all terms
        Ok(if choices.is_empty() { hypothesis } else { choices.swap_remove(0).1 })
    }

    /// The same terms at the value of the parameter's grid that explains most on top of `none`.
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

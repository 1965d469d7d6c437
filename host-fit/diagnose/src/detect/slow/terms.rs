//! Which regressors of an effect are worth their price.

use super::model::SlowSearch;
use super::result::ExtraNoise;
use crate::detect::hypothesis::Hypothesis;
use fos_fit::noise::Fitted;

/// Terms of which every choice is tried.
const MOST_TERMS: usize = 6;

/// Choices of terms within this much of the best, in −2 ln L after their price, are as good: odds of 4 to 1.
const AS_GOOD: f64 = 3.0;

/// The first sum stands for the effect if it explains this share of what all terms explain.
const NEARLY_ALL: f64 = 0.9;

impl SlowSearch<'_> {
    /// The regressors of an effect that are worth their price, under given levels: coefficients that the log cannot
    /// tell apart would go wrong in the next one. Of choices as good, the one listed first.
    pub(super) fn worth_their_price(
        &self,
        accepted: &[&Hypothesis],
        noise: ExtraNoise,
        fitted: &Fitted,
        hypothesis: Hypothesis,
    ) -> Hypothesis {
        let n = hypothesis.columns.len();
        if !hypothesis.effect.any_terms || !(2..=MOST_TERMS).contains(&n) {
            return hypothesis;
        }
        let price = (self.blocks.len() as f64).ln();
        // a part of a sum comes on top of it: of shaking in one direction any axis tells, of the next direction the sum
        // does
        let is_sum = |term: usize| {
            hypothesis.regressors.get(term).is_some_and(|regressor| regressor.products.len() > 1)
        };
        let has_sums = (0..n).any(is_sum);
        let with = |hypothesis: &Hypothesis| self.deviance_with(accepted, hypothesis, noise, fitted.levels);
        if has_sums {
            let none = self.at(accepted, noise, fitted.levels).deviance;
            let (all, first) = (with(&hypothesis), hypothesis.of_terms(&[0]));
            if none - with(&first) > NEARLY_ALL * (none - all) {
                return first;
            }
        }
        let mut choices: Vec<(f64, Hypothesis)> = (1_u32..1 << n)
            .map(|choice| (0..n).filter(|term| choice >> term & 1 == 1).collect::<Vec<usize>>())
            .filter(|terms| !has_sums || is_sum(terms[0]))
            .map(|terms| {
                let chosen = hypothesis.of_terms(&terms);
                (with(&chosen) + price * terms.len() as f64, chosen)
            })
            .collect();
        let best = choices.iter().map(|(deviance, _)| *deviance).fold(f64::INFINITY, f64::min);
        choices.retain(|(deviance, _)| *deviance < best + AS_GOOD);
        choices.sort_by(|a, b| a.1.terms.len().cmp(&b.1.terms.len()).then_with(|| a.1.terms.cmp(&b.1.terms)));
        // of numbers beyond the range of f64 no deviance is finite, and no choice is better than all terms
        if choices.is_empty() { hypothesis } else { choices.swap_remove(0).1 }
    }
}

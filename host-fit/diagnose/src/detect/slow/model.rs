//! A model of the slow error under construction: effects and further noise, fitted, and what each of its parameters
//! costs.

use std::ops::Range;
use std::sync::Arc;

use super::result::ExtraNoise;
use crate::detect::hypothesis::{Hypotheses, Hypothesis, span};
use crate::detect::shape::TEMPERATURE;
use crate::effects::Effect;
use fos_fit::noise::{Blocks, Fitted, LevelPrior, NoiseLevels, Regression};

/// Least score of what is accepted. On simulated logs with nothing missing the best score of all passes 9 less often
/// than once in a hundred (docs/calibration.md).
pub(in crate::detect) const ACCEPT: f64 = 9.0;

/// Price of a parameter that is searched for, beside that of its grid.
const PARAMETER_PRICE: f64 = 1.5;

/// Price of an effect that follows nothing but the clock: odds of 7 to 1 that what also follows a logged quantity is no
/// coincidence.
const CLOCK_PRICE: f64 = 4.0;

/// Span of temperature over which a part is as likely to drift visibly as not, K. Of 32 parts calibrated by drone builders
/// the slopes have a median of 2.0 mm/s²/K and 0.0080 (°/s)/K, and one below a tenth of it is as rare as 6 in 100: over
/// this span the median drift is what means over 20 s show beside the noise of usual parts.
const VISIBLE_SPAN: f64 = 0.5;

#[derive(Debug)]
pub(crate) struct SlowSearch<'a> {
    /// Equally long stretches of the log; those with too little data are left out.
    pub(crate) blocks: &'a Blocks,
    /// Block means of the target's error.
    pub(crate) y: &'a [f64],
    /// Regressors that are in every model: the constant, what the model already has.
    pub(crate) given: &'a [Vec<f64>],
    /// Makes the hypotheses.
    pub(crate) hypotheses: &'a Hypotheses<'a>,
    /// Axes of the log, of which the target is one: each of them is asked for noise beyond the baseline's, and a log is
    /// judged by all.
    pub(crate) axes: usize,
    pub(crate) effects: &'a [Arc<Effect>],
    /// What is known of the noise levels.
    pub(crate) prior: LevelPrior,
    /// The same where a random walk larger than the baseline's is tried.
    pub(crate) free_walk_prior: LevelPrior,
}

/// A model under construction.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) accepted: Vec<Hypothesis>,
    pub(super) noise: ExtraNoise,
    pub(super) fitted: Fitted,
}

impl SlowSearch<'_> {
    /// Nothing but what is given, and the noise of the baseline.
    pub(super) fn null(&self) -> State {
        let base = NoiseLevels::from_logs(&self.prior.mean);
        State { accepted: Vec::new(), noise: ExtraNoise::None, fitted: self.fit(&[], ExtraNoise::None, base) }
    }

    /// What is known of the noise levels with this further noise.
    pub(super) fn prior_of(&self, noise: ExtraNoise) -> LevelPrior {
        match noise {
            ExtraNoise::Walk => self.free_walk_prior,
            _ => self.prior,
        }
    }

    /// What is given, and the regressors of these hypotheses.
    fn regressors<'h>(&'h self, accepted: &[&'h Hypothesis]) -> Vec<&'h [f64]> {
        let given = self.given.iter().map(Vec::as_slice);
        given.chain(accepted.iter().flat_map(|hypothesis| hypothesis.columns())).collect()
    }

    /// Where the regressors of a hypothesis stand among all, behind what is given and those of the ones before it.
    pub(super) fn place_after<'h>(
        &self,
        before: impl IntoIterator<Item = &'h Hypothesis>,
        hypothesis: &Hypothesis,
    ) -> Range<usize> {
        let others: usize = before.into_iter().map(|other| other.columns.len()).sum();
        let start = self.given.len() + others;
        start..start + hypothesis.columns.len()
    }

    /// Fits coefficients and noise levels with these hypotheses.
    pub(super) fn fit(&self, accepted: &[&Hypothesis], noise: ExtraNoise, start: NoiseLevels) -> Fitted {
        let regressors = self.regressors(accepted);
        let prior = self.prior_of(noise);
        let regression =
            Regression { blocks: self.blocks, y: self.y, regressors: &regressors, prior: &prior };
        match noise {
            ExtraNoise::GaussMarkov(process) => {
                regression.fit_gauss_markov(NoiseLevels { gauss_markov: None, ..start }, process)
            }
            _ => regression.fit(NoiseLevels { gauss_markov: None, ..start }),
        }
    }

    /// Coefficients only, under given levels.
    pub(super) fn at(&self, accepted: &[&Hypothesis], noise: ExtraNoise, levels: NoiseLevels) -> Fitted {
        let regressors = self.regressors(accepted);
        let prior = self.prior_of(noise);
        Regression { blocks: self.blocks, y: self.y, regressors: &regressors, prior: &prior }.at(levels)
    }

    /// −2 ln L with a hypothesis on top of `accepted`, under given levels.
    pub(super) fn deviance_with(
        &self,
        accepted: &[&Hypothesis],
        hypothesis: &Hypothesis,
        noise: ExtraNoise,
        levels: NoiseLevels,
    ) -> f64 {
        let all: Vec<&Hypothesis> = accepted.iter().copied().chain([hypothesis]).collect();
        self.at(&all, noise, levels).deviance
    }

    /// Price of `k` coefficients and of the search for a parameter on top of the effects of `accepted`.
    pub(in crate::detect) fn price(
        &self,
        k: usize,
        hypothesis: &Hypothesis,
        accepted: &[&Hypothesis],
    ) -> f64 {
        let grid = self.hypotheses.grid(&hypothesis.effect).len() as f64;
        let parameter = if hypothesis.value.is_some() { PARAMETER_PRICE } else { 0.0 };
        let clock = if hypothesis.effect.follows_clock_alone() { CLOCK_PRICE } else { 0.0 };
        let n = self.blocks.len() as f64;
        k as f64 * n.ln() + 2.0 * grid.ln() + parameter + clock - self.rebate(hypothesis, accepted)
    }

    /// Rebate of the first effect of temperature: the odds that the part drifts visibly, which rise as the span of the
    /// temperature does. A random walk that is estimated from the same log explains a monotonic drift nearly as well.
    fn rebate(&self, hypothesis: &Hypothesis, accepted: &[&Hypothesis]) -> f64 {
        let follows = |hypothesis: &Hypothesis| hypothesis.effect.follows(TEMPERATURE);
        if !follows(hypothesis) || accepted.iter().any(|other| follows(other)) {
            return 0.0;
        }
        let means = self.hypotheses.logged_means(TEMPERATURE);
        means.map_or(0.0, |means| 2.0 * (span(&means) / VISIBLE_SPAN).max(1.0).ln())
    }

    /// The state without the effect at `place`, and that effect.
    pub(super) fn without(&self, state: &State, place: usize) -> (State, Hypothesis) {
        let mut accepted = state.accepted.clone();
        let removed = accepted.remove(place);
        let rest: Vec<&Hypothesis> = accepted.iter().collect();
        let fitted = self.fit(&rest, state.noise, state.fitted.levels);
        (State { accepted, noise: state.noise, fitted }, removed)
    }
}

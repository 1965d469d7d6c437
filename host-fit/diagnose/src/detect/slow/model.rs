//! A model of the slow error under construction: effects and excess noise, fitted, and the penalty of each parameter.

use std::ops::Range;
use std::sync::Arc;

use super::result::ExtraNoise;
use crate::detect::hypothesis::{Hypotheses, Hypothesis, span};
use crate::detect::shape::TEMPERATURE;
use crate::effects::Effect;
use fos_fit::noise::{Blocks, Fitted, LevelPrior, NoiseLevels, Regression};

/// Least score of an accepted effect. In simulated logs without a missing effect the best score exceeds 9 less often
/// than once in a hundred (docs/calibration.md).
pub(in crate::detect) const ACCEPT: f64 = 9.0;

/// Penalty of a parameter that is searched for, in addition to that of its grid.
const PARAMETER_PRICE: f64 = 1.5;

/// Penalty of an effect that follows only the clock: odds of 7 to 1 that a match with a logged quantity is not a
/// coincidence.
const CLOCK_PRICE: f64 = 4.0;

/// Span of temperature over which a part is as likely to drift visibly as not, K. The slopes of 32 parts calibrated by
/// drone builders have a median of 2.0 mm/s²/K and 0.0080 (°/s)/K, and 6 in 100 lie below a tenth of it. Over this
/// span, means over 20 s show the median drift above the noise of usual parts.
const VISIBLE_SPAN: f64 = 0.5;

#[derive(Debug)]
pub(crate) struct SlowSearch<'a> {
    /// Blocks of equal length; those with too few data are excluded.
    pub(crate) blocks: &'a Blocks,
    /// Block means of the target's error.
    pub(crate) y: &'a [f64],
    /// Regressors of every model: the constant and the effects that the model already has.
    pub(crate) given: &'a [Vec<f64>],
    /// Source of the hypotheses.
    pub(crate) hypotheses: &'a Hypotheses<'a>,
    /// Number of inertial axes of the log, the target included. Each is tested for excess noise, so the penalty counts
    /// them all.
    pub(crate) axes: usize,
    pub(crate) effects: &'a [Arc<Effect>],
    /// Prior of the noise levels.
    pub(crate) prior: LevelPrior,
    /// Prior for trying a random walk larger than that of the reference log.
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
    /// Returns the null model: the given regressors, and the noise of the reference log.
    pub(super) fn null(&self) -> State {
        let base = NoiseLevels::from_logs(&self.prior.mean);
        State { accepted: Vec::new(), noise: ExtraNoise::None, fitted: self.fit(&[], ExtraNoise::None, base) }
    }

    /// Returns the prior of the noise levels with this excess noise.
    pub(super) fn prior_of(&self, noise: ExtraNoise) -> LevelPrior {
        match noise {
            ExtraNoise::Walk => self.free_walk_prior,
            _ => self.prior,
        }
    }

    /// Returns the given regressors and those of these hypotheses.
    pub(super) fn regressors<'h>(
        &'h self,
        accepted: impl IntoIterator<Item = &'h Hypothesis>,
    ) -> Vec<&'h [f64]> {
        let given = self.given.iter().map(Vec::as_slice);
        given.chain(accepted.into_iter().flat_map(Hypothesis::columns)).collect()
    }

    /// Returns the positions of a hypothesis's regressors, after the given ones and those of `before`.
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
    pub(super) fn fit<'h>(
        &'h self,
        accepted: impl IntoIterator<Item = &'h Hypothesis>,
        noise: ExtraNoise,
        start: NoiseLevels,
    ) -> Fitted {
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

    /// Fits the coefficients under given noise levels.
    pub(super) fn at<'h>(
        &'h self,
        accepted: impl IntoIterator<Item = &'h Hypothesis>,
        noise: ExtraNoise,
        levels: NoiseLevels,
    ) -> Fitted {
        let regressors = self.regressors(accepted);
        let prior = self.prior_of(noise);
        Regression { blocks: self.blocks, y: self.y, regressors: &regressors, prior: &prior }.at(levels)
    }

    /// Returns −2 ln L with a hypothesis on top of `state`, under given noise levels.
    pub(super) fn deviance_with(&self, state: &State, hypothesis: &Hypothesis, levels: NoiseLevels) -> f64 {
        self.at(state.accepted.iter().chain([hypothesis]), state.noise, levels).deviance
    }

    /// Returns the penalty of `k` coefficients and of the parameter search, on top of the effects of `accepted`. A term
    /// that the log cannot separate from the others counts, unless the effect is any subset of its terms: where the
    /// temperature does not vary, a drift of the scale factor explains what a scale factor error explains.
    pub(in crate::detect) fn price(&self, k: usize, hypothesis: &Hypothesis, accepted: &[Hypothesis]) -> f64 {
        let grid = self.hypotheses.grid(&hypothesis.effect).len() as f64;
        let parameter = if hypothesis.value.is_some() { PARAMETER_PRICE } else { 0.0 };
        let clock = if hypothesis.effect.follows_clock_alone() { CLOCK_PRICE } else { 0.0 };
        let n = self.blocks.len() as f64;
        let k = if hypothesis.effect.any_terms { k } else { k.max(hypothesis.columns.len()) };
        k as f64 * n.ln() + 2.0 * grid.ln() + parameter + clock - self.rebate(hypothesis, accepted)
    }

    /// Reduction of the penalty for the first drift of the bias with temperature: the odds that the part drifts
    /// visibly, which grow with the span of the temperature. A random walk estimated from the same log explains a
    /// monotonic drift nearly as well.
    fn rebate(&self, hypothesis: &Hypothesis, accepted: &[Hypothesis]) -> f64 {
        let drifts = |hypothesis: &Hypothesis| hypothesis.effect.follows_alone(TEMPERATURE);
        if !drifts(hypothesis) || accepted.iter().any(drifts) {
            return 0.0;
        }
        let means = self.hypotheses.logged_means(TEMPERATURE);
        means.map_or(0.0, |means| 2.0 * (span(&means) / VISIBLE_SPAN).max(1.0).ln())
    }

    /// Returns the state without the effect at `place`, and that effect.
    pub(super) fn without(&self, state: &State, place: usize) -> (State, Hypothesis) {
        let mut accepted = state.accepted.clone();
        let removed = accepted.remove(place);
        let fitted = self.fit(&accepted, state.noise, state.fitted.levels);
        (State { accepted, noise: state.noise, fitted }, removed)
    }
}

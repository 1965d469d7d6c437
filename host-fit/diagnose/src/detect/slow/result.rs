//! What was found in the slow band.

use std::ops::Range;
use std::sync::Arc;

use super::estimate::Estimate;
use crate::detect::hypothesis::Hypothesis;
use crate::effects::Effect;
use fos_fit::noise::{Fitted, GaussMarkov, LevelPrior};

/// A slow effect that was found.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    /// The effect and the value of its parameter.
    pub(crate) hypothesis: Hypothesis,
    /// Where its regressors stand among those of the fit.
    pub(crate) place: Range<usize>,
    /// Standard error of the logarithm of the parameter.
    pub(crate) log_error: Option<f64>,
    /// By how much −2 ln L falls with it, given everything else.
    pub(crate) gain: f64,
    /// The gain after the price of its coefficients, its parameter, and its grid.
    pub(crate) score: f64,
    /// Hypotheses that could stand in its place, with how much worse they are in −2 ln L.
    pub(crate) rivals: Vec<(Hypothesis, f64)>,
    /// What may be true instead.
    pub(crate) alternatives: Vec<Alternative>,
}

impl Found {
    /// True if the effect follows something that is logged.
    pub(crate) fn is_backed(&self) -> bool {
        !self.hypothesis.effect.follows_clock_alone()
    }
}

/// What may be true instead of a finding.
#[derive(Debug, Clone)]
pub(crate) struct Alternative {
    pub(crate) hypothesis: Hypothesis,
    /// Its coefficients with everything else that was found, under the same noise levels.
    pub(crate) estimate: Estimate,
    /// Its odds against the finding as it is.
    pub(crate) odds: f64,
}

/// Noise beyond the baseline's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ExtraNoise {
    None,
    /// A further Gauss-Markov process.
    GaussMarkov(GaussMarkov),
    /// A random walk larger than the baseline allows.
    Walk,
}

/// What was found in the slow band.
#[derive(Debug, Clone)]
pub(crate) struct SlowResult {
    /// The effects, in the order of the regressors of the fit.
    pub(crate) found: Vec<Found>,
    /// Noise beyond the baseline's, its gain and its score.
    pub(crate) noise: ExtraNoise,
    /// By how much −2 ln L falls with it.
    pub(crate) noise_gain: f64,
    /// The gain after its price.
    pub(crate) noise_score: f64,
    /// The regression with all that was found.
    pub(crate) fitted: Fitted,
    /// What was known of the levels, without further noise.
    pub(crate) quiet_prior: LevelPrior,
    /// The prior of the levels it was fitted with.
    pub(crate) prior: LevelPrior,
    /// Every effect that was tried alone: its best score; first those that explain most.
    pub(crate) tried: Vec<(String, f64)>,
    /// The same beside what had been found before the last round of the search.
    pub(crate) beside: Vec<(String, f64)>,
    /// Effects of which no regressor adds anything to what is given.
    pub(crate) silent: Vec<Arc<Effect>>,
}

impl SlowResult {
    /// Score of all effects that follow nothing logged.
    pub(crate) fn unbacked(&self) -> f64 {
        self.found.iter().filter(|found| !found.is_backed()).map(|found| found.score).sum()
    }
}

//! Result of the search for slow effects.

use std::ops::Range;
use std::sync::Arc;

use super::estimate::Estimate;
use crate::detect::hypothesis::Hypothesis;
use crate::effects::Effect;
use fos_fit::noise::{Fitted, GaussMarkov, LevelPrior};

/// A slow finding.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    /// Effect and value of its parameter.
    pub(crate) hypothesis: Hypothesis,
    /// Positions of its regressors in the fit.
    pub(crate) place: Range<usize>,
    /// Standard error of the logarithm of the parameter.
    pub(crate) log_error: Option<f64>,
    /// Decrease of −2 ln L, given everything else.
    pub(crate) gain: f64,
    /// Gain minus the penalty for its coefficients, its parameter and its grid.
    pub(crate) score: f64,
    /// Hypotheses that could replace it, with the increase of −2 ln L.
    pub(crate) rivals: Vec<(Hypothesis, f64)>,
    /// Alternatives with their odds.
    pub(crate) alternatives: Vec<Alternative>,
}

impl Found {
    /// Returns true if the effect follows a logged quantity.
    pub(crate) fn is_backed(&self) -> bool {
        !self.hypothesis.effect.follows_clock_alone()
    }
}

/// An alternative to a finding.
#[derive(Debug, Clone)]
pub(crate) struct Alternative {
    pub(crate) hypothesis: Hypothesis,
    /// Coefficients together with all other findings, under the same noise levels.
    pub(crate) estimate: Estimate,
    /// Odds relative to the finding.
    pub(crate) odds: f64,
}

/// Noise in excess of the reference log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ExtraNoise {
    None,
    /// A further Gauss-Markov process.
    GaussMarkov(GaussMarkov),
    /// A random walk larger than the reference log allows.
    Walk,
}

/// Result of the search for slow effects.
#[derive(Debug, Clone)]
pub(crate) struct SlowResult {
    /// Effects, in the order of the regressors of the fit.
    pub(crate) found: Vec<Found>,
    /// Excess noise.
    pub(crate) noise: ExtraNoise,
    /// Decrease of −2 ln L with the excess noise.
    pub(crate) noise_gain: f64,
    /// Gain of the excess noise minus its penalty.
    pub(crate) noise_score: f64,
    /// Regression with all findings.
    pub(crate) fitted: Fitted,
    /// Prior of the noise levels without excess noise.
    pub(crate) reference_prior: LevelPrior,
    /// Prior of the noise levels in `fitted`.
    pub(crate) prior: LevelPrior,
    /// Best score of every effect that was tried alone, highest first.
    pub(crate) tried: Vec<(String, f64)>,
    /// Scores in addition to the findings before the last round of the search.
    pub(crate) beside: Vec<(String, f64)>,
    /// Effects whose regressors add nothing to the given ones.
    pub(crate) silent: Vec<Arc<Effect>>,
}

impl SlowResult {
    /// Returns the total score of the effects that follow nothing logged.
    pub(crate) fn unbacked(&self) -> f64 {
        self.found.iter().filter(|found| !found.is_backed()).map(|found| found.score).sum()
    }
}

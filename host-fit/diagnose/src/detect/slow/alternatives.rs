//! Alternatives to a finding with their odds: its effect with another parameter value, or a rival. They are nearly
//! indistinguishable in this log but may differ in another one, so a predicted reduction must hold for all of them.

use super::estimate::Estimate;
use super::model::{SlowSearch, State};
use super::result::Alternative;
use crate::detect::hypothesis::Hypothesis;
use fos_data::recording::RecordingError;
use fos_fit::noise::NoiseLevels;

/// Parameter values tried, in standard errors of the logarithm from the best.
const AROUND: [f64; 4] = [-2.0, -1.0, 1.0, 2.0];

impl SlowSearch<'_> {
    /// Returns the alternatives to `current`, which is found together with `rest`, under `levels`. `log_error` is the
    /// standard error of the logarithm of its parameter; `rivals` come with the amounts by which their scores are lower.
    pub(super) fn alternatives(
        &self,
        (rest, levels): (&State, NoiseLevels),
        current: &Hypothesis,
        log_error: Option<f64>,
        rivals: &[(&Hypothesis, f64)],
    ) -> Result<Vec<Alternative>, RecordingError> {
        let mut alternatives = Vec::new();
        if let (Some(error), Some(value), Some(parameter)) =
            (log_error, current.value, &current.effect.parameter)
        {
            for deviation in AROUND {
                let other = (value * (deviation * error).exp()).clamp(parameter.low, parameter.high);
                let other = self.hypotheses.make(&current.effect, Some(other))?.with_terms_of(current);
                let odds = (-0.5 * deviation * deviation).exp();
                alternatives.push(self.alternative((rest, levels), other, odds));
            }
        }
        let of_finding = 1.0 + alternatives.iter().map(|alternative| alternative.odds).sum::<f64>();
        for (rival, behind) in rivals {
            let odds = of_finding * (-0.5 * behind.max(0.0)).exp();
            alternatives.push(self.alternative((rest, levels), (*rival).clone(), odds));
        }
        Ok(alternatives)
    }

    fn alternative(
        &self,
        (rest, levels): (&State, NoiseLevels),
        hypothesis: Hypothesis,
        odds: f64,
    ) -> Alternative {
        let fitted = self.at(rest.accepted.iter().chain([&hypothesis]), rest.noise, levels);
        let estimate = Estimate::of(&fitted.gls, self.place_after(&rest.accepted, &hypothesis));
        Alternative { hypothesis, estimate, odds }
    }
}

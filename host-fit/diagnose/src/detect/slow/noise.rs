//! Noise in excess of the reference log: a larger random walk, or a further Gauss-Markov process.

use super::model::{ACCEPT, SlowSearch, State};
use super::result::ExtraNoise;
use crate::detect::MIN_BLOCKS;
use fos_fit::noise::{Fitted, GaussMarkov, NoiseLevels};

/// Initial correlation times of a further Gauss-Markov process, s.
const GAUSS_MARKOV_STARTS_S: [f64; 4] = [5.0, 20.0, 80.0, 250.0];

impl SlowSearch<'_> {
    /// Returns the better of the two kinds of excess noise on top of `state`, with its score.
    pub(super) fn best_noise(&self, state: &State) -> Option<(ExtraNoise, Fitted, f64)> {
        if state.noise != ExtraNoise::None || self.blocks.len() < MIN_BLOCKS {
            return None;
        }
        let accepted = &state.accepted;
        let (price, of_axes) = ((self.blocks.len() as f64).ln(), self.price_of_axes());
        let start = state.fitted.levels;
        let walk = self.fit(accepted, ExtraNoise::Walk, NoiseLevels { walk: 3.0 * start.walk, ..start });
        let walk_score = state.fitted.deviance - walk.deviance - price - of_axes;
        // a slow process leaves little in the whitened residual, and effects that are still missing leave more in the other
        let whitened = fos_fit::signal::variance(&[&state.fitted.gls.residual]).sqrt();
        let deviations = [whitened.max(1.0) * start.flicker, self.residual_deviation(state)];
        let longest = self.blocks.len() as f64 * self.blocks.length_s / 5.0;
        let processes = GAUSS_MARKOV_STARTS_S
            .into_iter()
            .filter(|tau_s| (2.0 * self.blocks.length_s..longest).contains(tau_s))
            .map(|tau_s| {
                let base = NoiseLevels::from_logs(&self.prior.mean);
                let deviance = |process: GaussMarkov| {
                    let levels = NoiseLevels { gauss_markov: Some(process), ..base };
                    self.at(accepted, ExtraNoise::GaussMarkov(process), levels).deviance
                };
                let [one, other] = deviations.map(|deviation| GaussMarkov { deviation, tau_s });
                let process = if deviance(one) <= deviance(other) { one } else { other };
                self.fit(accepted, ExtraNoise::GaussMarkov(process), base)
            });
        // a shorter process is white noise in block means, which already has a level
        let is_slow = |process: &GaussMarkov| (self.blocks.length_s..longest).contains(&process.tau_s);
        let processes = processes.filter_map(|fitted| {
            let process = fitted.levels.gauss_markov.filter(is_slow)?;
            let score = state.fitted.deviance - fitted.deviance - 2.0 * price - of_axes;
            Some((ExtraNoise::GaussMarkov(process), fitted, score))
        });
        let process = processes.max_by(|a, b| a.2.total_cmp(&b.2));
        let walk = (ExtraNoise::Walk, walk, walk_score);
        match process {
            Some(process) if process.2 > walk.2 => Some(process),
            _ => Some(walk),
        }
    }

    /// Returns the standard deviation of the block means without the accepted effects.
    fn residual_deviation(&self, state: &State) -> f64 {
        let residual = state.fitted.gls.unexplained(self.y, &self.regressors(&state.accepted));
        fos_fit::signal::variance(&[&self.blocks.about_levels(&residual, 0..residual.len())]).sqrt()
    }

    /// Penalty for testing every axis of the log.
    pub(super) fn price_of_axes(&self) -> f64 {
        2.0 * (self.axes.max(1) as f64).ln()
    }

    /// Removes excess noise that an effect has made unnecessary.
    pub(super) fn drop_unneeded_noise(&self, state: &mut State) {
        if state.noise == ExtraNoise::None {
            return;
        }
        let base = NoiseLevels::from_logs(&self.prior.mean);
        let without = self.fit(&state.accepted, ExtraNoise::None, base);
        let price = (self.blocks.len() as f64).ln();
        if without.deviance - state.fitted.deviance < price + self.price_of_axes() + ACCEPT {
            *state = State { noise: ExtraNoise::None, fitted: without, accepted: state.accepted.clone() };
        }
    }
}

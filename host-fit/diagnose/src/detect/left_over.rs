//! What the library leaves unexplained: leads, and the shape of what is left.

use fos_fit::noise::{Fitted, LevelPrior, NoiseLevels, Regression};

use super::error_in_blocks::ErrorInBlocks;
use super::open::{self, Lead};
use super::question::Question;
use super::shape::{self, Misshape};
use super::slow::{ExtraNoise, Found, SlowResult};

/// Leads that explain less than this share of what the findings explain do not make the answer *unexplained*: a strong
/// effect is never reproduced to the last digit by a thermometer that lags.
const LEAD_SHARE: f64 = 0.03;

/// What the library leaves.
#[derive(Default)]
pub(super) struct LeftOver {
    pub(super) leads: Vec<Lead>,
    pub(super) misshapes: Vec<Misshape>,
    /// The leads explain more than findings that follow nothing logged, and than further noise.
    pub(super) instead: bool,
}

/// A lead must be this much better than what it stands for: odds of 150 to 1.
pub(super) const INSTEAD: f64 = 10.0;

pub(super) fn left_over(
    question: &Question<'_>,
    column: &str,
    reduced: &ErrorInBlocks,
    given: &[Vec<f64>],
    slow: &SlowResult,
    (sound, shaken): (bool, bool),
) -> LeftOver {
    let regressors = |keep: &dyn Fn(&Found) -> bool| -> Vec<&[f64]> {
        let mut regressors: Vec<&[f64]> = given.iter().map(Vec::as_slice).collect();
        for found in slow.found.iter().filter(|found| keep(found)) {
            regressors.extend(found.hypothesis.columns());
        }
        regressors
    };
    let left = |regressors: &[&[f64]], fitted: &Fitted, prior: &LevelPrior| {
        open::Left {
            recording: question.field,
            blocks: &reduced.blocks,
            target: column,
            y: &reduced.means,
            regressors,
            fitted,
            prior,
            shaken,
        }
        .leads()
    };
    let explained: f64 = slow.found.iter().map(|found| found.gain).sum();
    let mut leads = left(&regressors(&|_| true), &slow.fitted, &slow.prior);
    leads.retain(|lead| lead.gain > LEAD_SHARE * explained);
    let mut misshapes = Vec::new();
    // the noise of an accelerometer that is shaken is the shaking
    if !shaken {
        let quiet = away_from_effects(reduced, slow);
        misshapes.extend(shape::jumps(&quiet, LEAD_SHARE * explained, slow.noise != ExtraNoise::None));
    }
    if sound && !shaken {
        misshapes.extend(shape::level(question.field, &reduced.blocks, column, !slow.found.is_empty()));
    }
    // what follows nothing that is logged may stand for something that does
    let replaced = slow.unbacked() + slow.noise_score;
    if replaced > 0.0 {
        let backed = regressors(&Found::is_backed);
        let regression = Regression {
            blocks: &reduced.blocks,
            y: &reduced.means,
            regressors: &backed,
            prior: &slow.quiet_prior,
        };
        let fitted = regression.fit(NoiseLevels::from_logs(&slow.quiet_prior.mean));
        let instead = left(&backed, &fitted, &slow.quiet_prior);
        if instead.first().is_some_and(|lead| lead.score > replaced + INSTEAD) {
            return LeftOver { leads: instead, misshapes, instead: true };
        }
    }
    LeftOver { leads, misshapes, instead: false }
}

/// The whitened residual but for the blocks that only determine a level, where it is 0, and the tenth of the blocks in
/// which the effects that were found change most: there they leave what they do not reproduce to the last digit, a delay
/// of a few samples or a thermometer's, and that is no jump.
fn away_from_effects(reduced: &ErrorInBlocks, slow: &SlowResult) -> Vec<f64> {
    let residual = &slow.fitted.gls.residual;
    let restarts = reduced.blocks.restarts();
    let mut blocks: Vec<usize> =
        (0..residual.len()).filter(|block| restarts.binary_search(block).is_err()).collect();
    if slow.found.is_empty() {
        return blocks.into_iter().map(|block| residual[block]).collect();
    }
    let coefficients = slow.fitted.gls.coefficients();
    let mut effect = vec![0.0; residual.len()];
    for found in &slow.found {
        for (place, column) in found.place.clone().zip(found.hypothesis.columns()) {
            effect.iter_mut().zip(column).for_each(|(sum, value)| *sum += coefficients[place] * value);
        }
    }
    let whitened = slow.fitted.levels.whiten(&reduced.blocks, &[&effect]);
    blocks.sort_by(|a, b| whitened.columns[0][*a].abs().total_cmp(&whitened.columns[0][*b].abs()));
    blocks.truncate(blocks.len() * 9 / 10);
    blocks.into_iter().map(|block| residual[block]).collect()
}

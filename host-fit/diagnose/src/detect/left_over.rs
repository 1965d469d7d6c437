//! Residual after the library: leads, jumps and changes of the noise level.

use fos_fit::noise::{Fitted, LevelPrior, NoiseLevels, Regression};

use super::error_in_blocks::ErrorInBlocks;
use super::open::{self, Lead};
use super::prepared::Prepared;
use super::shape::{self, Level};
use super::slow::{ExtraNoise, Found, SlowResult};

/// Leads that explain less than this share of what the findings explain do not change the verdict to *unexplained*: a
/// lagging thermometer never reproduces a strong effect exactly.
const LEAD_SHARE: f64 = 0.03;

/// Results of the search in the residual.
#[derive(Default)]
pub(super) struct LeftOver {
    pub(super) leads: Vec<Lead>,
    pub(super) jumps: Option<Lead>,
    pub(super) level: Option<Level>,
    /// True if the leads explain more than the findings that follow nothing logged, and than the excess noise.
    pub(super) instead: bool,
}

/// Score by which a lead must exceed what it replaces: odds of 150 to 1.
pub(super) const INSTEAD: f64 = 10.0;

/// Searches in the residual after the regressors `given` and the slow effects.
pub(super) fn left_over(prepared: &Prepared<'_>, given: &[Vec<f64>], slow: &SlowResult) -> LeftOver {
    let (log, column, reduced, shaken) =
        (prepared.log(), &prepared.column, &prepared.reduced, prepared.shaken);
    let regressors = |keep: &dyn Fn(&Found) -> bool| -> Vec<&[f64]> {
        let mut regressors: Vec<&[f64]> = given.iter().map(Vec::as_slice).collect();
        for found in slow.found.iter().filter(|found| keep(found)) {
            regressors.extend(found.hypothesis.columns());
        }
        regressors
    };
    let left = |regressors: &[&[f64]], fitted: &Fitted, prior: &LevelPrior| {
        open::Residual {
            recording: log,
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
    let (mut jumps, mut level) = (None, None);
    // the noise of a shaken accelerometer is the shaking
    if !shaken {
        let reference = away_from_effects(reduced, slow);
        jumps = shape::jumps(&reference, LEAD_SHARE * explained, slow.noise != ExtraNoise::None);
    }
    if prepared.faults.is_empty() && !shaken {
        level = shape::level(log, &reduced.blocks, column, !slow.found.is_empty());
    }
    // findings that follow nothing logged may be stand-ins for a logged cause
    let replaced = slow.unbacked() + slow.noise_score;
    if replaced > 0.0 {
        let backed = regressors(&Found::is_backed);
        let regression = Regression {
            blocks: &reduced.blocks,
            y: &reduced.means,
            regressors: &backed,
            prior: &slow.reference_prior,
        };
        let fitted = regression.fit(NoiseLevels::from_logs(&slow.reference_prior.mean));
        let instead = left(&backed, &fitted, &slow.reference_prior);
        if instead.first().is_some_and(|lead| lead.score > replaced + INSTEAD) {
            return LeftOver { leads: instead, jumps, level, instead: true };
        }
    }
    LeftOver { leads, jumps, level, instead: false }
}

/// Returns the whitened residual without the blocks that only determine a level, where it is 0, and without the tenth
/// of the blocks in which the detected effects change most. There a small delay, of a few samples or of the
/// thermometer, leaves residuals that are not jumps.
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

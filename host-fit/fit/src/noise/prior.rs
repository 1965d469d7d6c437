//! Prior of an axis' noise: the data sheet, and a reference log of the same device.

use fos_data::case::DataSheet;
use fos_data::statistics::median_of;

use super::blocks::{Block, Blocks};
use super::levels::{LevelPrior, Regression, UnknownLevels};
use super::model::NoiseLevels;

/// Standard deviations of the logarithms of white, flicker and walk about a data sheet: devices of a part scatter by a
/// third, flicker by half, and data sheets do not state the random walk.
const ABOUT_DATA_SHEET: [f64; 3] = [0.3, 0.45, 0.8];

/// Standard deviations of the logarithms if only the log itself is available.
const ABOUT_GUESS: [f64; 3] = [0.5, 1.0, 1.3];

/// Random walk whose Allan deviation meets that of the flicker noise after 20 minutes: K·√(t/3) = 0.664·B.
const WALK_PER_FLICKER: f64 = 0.664 / 20.0;

/// Flicker per white noise without a data sheet: the Allan deviation of phone-class parts reaches its floor after about
/// 20 s (the data sheets of `simulate::part` give 8 to 60 s).
const FLICKER_PER_WHITE: f64 = 0.35;

/// Variances of the logarithms between logs of one device.
const NEXT_LOG: [f64; 3] = [0.01, 0.02, 0.06];

impl LevelPrior {
    pub fn of_data_sheet(sheet: &DataSheet) -> Self {
        // one-sided density D: the mean over t seconds has variance D²/2t
        let white = sheet.noise_density / 2.0_f64.sqrt();
        let flicker = sheet.bias_instability;
        let walk = WALK_PER_FLICKER * flicker;
        Self::independent([white.ln(), flicker.ln(), walk.ln()], ABOUT_DATA_SHEET)
    }

    /// Returns a wide prior from the scatter of neighbouring blocks of a log.
    pub fn of_log(blocks: &Blocks, y: &[f64]) -> Self {
        // blocks of one level
        let is_one_level = |first: usize, last: usize| {
            let after_first = blocks.restarts().partition_point(|start| *start <= first);
            blocks.restarts().get(after_first).is_none_or(|start| *start > last)
        };
        let pairs = blocks.blocks.windows(2).zip(y.windows(2));
        let pairs = pairs.enumerate().filter(|(at, _)| is_one_level(*at, at + 1)).map(|(_, pair)| pair);
        let seconds = |block: &Block| block.count as f64 * blocks.period_s;
        let mut squares: Vec<f64> = pairs
            .filter(|(pair, _)| pair[1].index == pair[0].index + 1)
            .map(|(pair, values)| {
                let seconds = 0.5 * (seconds(&pair[0]) + seconds(&pair[1]));
                (values[1] - values[0]).powi(2) * seconds / 2.0
            })
            .collect();
        if squares.is_empty() {
            // for bursts far apart: the deviation from the line between the neighbours, because slow errors change in
            // between
            let threes = blocks.blocks.windows(3).zip(y.windows(3)).enumerate();
            let threes = threes.filter(|(at, _)| is_one_level(*at, at + 2)).map(|(_, three)| three);
            squares.extend(threes.map(|(three, values)| {
                let share =
                    (three[1].index - three[0].index) as f64 / (three[2].index - three[0].index) as f64;
                let weights = [share - 1.0, 1.0, -share];
                let off: f64 = weights.iter().zip(values).map(|(weight, value)| weight * value).sum();
                off * off / weights.iter().zip(three).map(|(w, block)| w * w / seconds(block)).sum::<f64>()
            }));
        }
        // the median of a squared normal variable is 0.4549 of its mean; unlike the mean it is robust to steps
        let white = (median_of(squares).unwrap_or(1.0) / 0.4549).sqrt().max(f64::MIN_POSITIVE);
        let flicker = FLICKER_PER_WHITE * white;
        Self::independent([white.ln(), flicker.ln(), (WALK_PER_FLICKER * flicker).ln()], ABOUT_GUESS)
    }

    /// Updates the prior with a reference log, for use with the next log of the device. `given` are regressors that the
    /// model already has.
    pub fn learnt(&self, blocks: &Blocks, y: &[f64], given: &[Vec<f64>]) -> Result<Self, UnknownLevels> {
        let regressors: Vec<&[f64]> = given.iter().map(Vec::as_slice).collect();
        let regression = Regression { blocks, y, regressors: &regressors, prior: self };
        let fitted = regression.fit(NoiseLevels::from_logs(&self.mean));
        let random_walk_likelihood = Some(regression.random_walk_likelihood(&fitted));
        Ok(Self { random_walk_likelihood, ..regression.posterior(&fitted).widened(NEXT_LOG)? })
    }
}

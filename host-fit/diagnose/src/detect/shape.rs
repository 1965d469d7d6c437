//! Tests of the residual against noise: its distribution in block means, and its level in the samples.

use super::open::{Lead, LeadKind};
use crate::effects::Band;
use fos_data::column::AXES;
use fos_data::recording::Recording;
use fos_fit::noise::Blocks;
use fos_fit::noise::dot;

/// Least excess kurtosis of whitened block means, in standard errors (√(24/n)); occasional jumps make a few of them
/// huge. Of 600 normal values it exceeds 5.9 once in 10,000 logs and 4.2 once in 1000; the second holds if excess noise
/// was found, which is assumed to be normal.
const KURTOSIS_ERRORS: f64 = 5.9;
const KURTOSIS_ERRORS_OF_NOISE: f64 = 4.2;

/// Block means beyond this many standard deviations are part of a jump.
const FAR_OUT: f64 = 3.0;

/// Share of the variance of normal noise beyond [`FAR_OUT`] standard deviations: 2·(3·φ(3) + Q(3)).
const FAR_OUT_SHARE: f64 = 0.0293;

/// Least score of a change of the noise level.
const LEVEL_ACCEPT: f64 = 15.0;

/// Least relative change of the noise level; the second if effects were found.
const LEVEL_SHARE: f64 = 0.01;
const LEVEL_SHARE_BESIDE: f64 = 0.03;

/// Column of the thermometer.
pub(super) const TEMPERATURE: &str = "temp_c";

/// Least relative change of an unexplained noise level that affects the verdict.
const NOTICED_LEVEL: f64 = 0.05;

/// Least share of the variance of the residual in jumps that affects the verdict: 13 % of the RMS. Sensors at rest have
/// block means beyond three standard deviations more often than normal noise.
const NOTICED_JUMPS: f64 = 0.25;

/// A change of the noise level of the samples.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Level {
    /// Quantity that it follows best, if any.
    follows: Option<Followed>,
    /// Standard deviation of the explained part of the logarithm of the level.
    spread: f64,
    pub(super) score: f64,
}

impl Level {
    /// Returns the change of the logarithm of the noise level per kelvin and its standard error, if the level follows
    /// the temperature.
    pub(super) fn temperature_slope(&self) -> Option<[f64; 2]> {
        let follows = self.follows.as_ref().filter(|follows| follows.column == TEMPERATURE)?;
        Some(follows.slope)
    }

    pub(super) fn lead(&self) -> Lead {
        let change = 100.0 * self.spread;
        let follows = match &self.follows {
            Some(Followed { column, .. }) => {
                format!("a noise level that changes by {change:.0} % with {column}")
            }
            None => format!("a noise level that changes by {change:.0} % over the log"),
        };
        let decides = self.follows.is_some() || self.spread >= NOTICED_LEVEL;
        let lead = Lead::new(LeadKind::Level, follows, Band::Wide, self.score);
        Lead { share: self.spread, decides, ..lead }
    }
}

/// A quantity that a noise level follows.
#[derive(Debug, Clone, PartialEq)]
struct Followed {
    column: String,
    /// Change of the logarithm of the level per unit of the quantity, and its standard error.
    slope: [f64; 2],
}

/// Finds jumps in the whitened residual of a fit: more extreme block means than their number explains, if they
/// contribute more than `least` to −2 ln L.
pub(super) fn jumps(whitened: &[f64], least: f64, is_noise: bool) -> Option<Lead> {
    let errors = if is_noise { KURTOSIS_ERRORS_OF_NOISE } else { KURTOSIS_ERRORS };
    let n = whitened.len() as f64;
    let mean = whitened.iter().sum::<f64>() / n;
    let moment = |power: i32| whitened.iter().map(|u| (u - mean).powi(power)).sum::<f64>() / n;
    let kurtosis = moment(4) / (moment(2) * moment(2)) - 3.0;
    let squares = whitened.iter().map(|u| (u - mean).powi(2) / moment(2));
    let gain: f64 = squares.filter(|square| *square > FAR_OUT * FAR_OUT).sum();
    // beyond that of normal noise
    let share = (gain / n - FAR_OUT_SHARE).max(0.0);
    (gain > least && kurtosis > errors * (24.0 / n).sqrt()).then(|| {
        let follows = format!("jumps at irregular times (excess kurtosis {kurtosis:.1} of the residual)");
        let lead = Lead::new(LeadKind::Jumps, follows, Band::Slow, kurtosis);
        Lead { gain, share, decides: share >= NOTICED_JUMPS, ..lead }
    })
}

/// Finds a change of the noise level of `target` that the other axes do not have; vibration shows in all of them.
pub(super) fn level(recording: &Recording, blocks: &Blocks, target: &str, beside: bool) -> Option<Level> {
    let least = if beside { LEVEL_SHARE_BESIDE } else { LEVEL_SHARE };
    let own = log_level(recording, blocks, target)?;
    let mut others: Vec<Vec<f64>> = AXES
        .into_iter()
        .filter(|axis| *axis != target)
        .filter_map(|axis| log_level(recording, blocks, axis))
        .collect();
    let known = |levels: &Vec<f64>| levels.iter().filter(|level| !level.is_nan()).count();
    others.retain(|levels| 2 * known(levels) > known(&own));
    let is_known =
        |block: &usize| !own[*block].is_nan() && others.iter().all(|levels| !levels[*block].is_nan());
    let usable: Vec<usize> = (0..own.len()).filter(is_known).collect();
    let in_usable = |values: &[f64]| -> Vec<f64> { usable.iter().map(|block| values[*block]).collect() };
    let own = in_usable(&own);
    let mut basis = Basis::default();
    basis.add(&vec![1.0; own.len()]);
    for other in &others {
        basis.add(&in_usable(other));
    }
    let left = basis.without(&own);
    let n = left.len() as f64;
    let before = dot(&left, &left);
    let mut best: Option<(f64, f64, Option<Followed>)> = None;
    let mut consider = |columns: &[Vec<f64>], follows: Option<&str>, basis: &Basis| {
        let mut wider = basis.clone();
        let k = columns.iter().filter(|column| wider.add(column)).count() as f64;
        let rest = wider.without(&own);
        let after = dot(&rest, &rest);
        let score = n * (before / after).ln() - k * n.ln();
        if best.as_ref().is_none_or(|(other, ..)| score > *other) {
            let follows = follows.map(|column| Followed {
                column: column.to_owned(),
                slope: basis.slope(&own, &columns[0], after / n),
            });
            best = Some((score, ((before - after) / n).max(0.0).sqrt(), follows));
        }
    };
    let middle = |i: usize| i as f64 / n;
    let slow: Vec<Vec<f64>> = (1..=6)
        .map(|k| (0..left.len()).map(|i| (std::f64::consts::PI * f64::from(k) * middle(i)).cos()).collect())
        .collect();
    consider(&slow, None, &basis);
    for channel in recording.channels() {
        if AXES.contains(&channel.name.as_str()) || channel.column().is_of_model() {
            continue;
        }
        let held = recording.held_from_first(channel);
        let means = in_usable(&blocks.means(&held));
        let mean = means.iter().sum::<f64>() / n;
        let square = means.iter().map(|v| (v - mean).powi(2)).collect();
        consider(&[means, square], Some(&channel.name), &basis);
    }
    let (score, spread, follows) = best?;
    (score >= LEVEL_ACCEPT && spread > least).then_some(Level { follows, spread, score })
}

/// Returns the logarithm of the RMS of first differences in each block: NaN for a block with less than half the
/// differences of the fullest, such as the last one of a log.
fn log_level(recording: &Recording, blocks: &Blocks, column: &str) -> Option<Vec<f64>> {
    // in the error, since motion that a reference covers is not noise
    let values = &recording.error_series(column).ok()?.values;
    let squares = |block: &fos_fit::noise::Block| {
        let rows = block.rows.clone();
        let known = &blocks.known()[rows.clone()];
        let values = &values[rows];
        let pairs = values.windows(2).zip(known.windows(2)).filter(|(_, known)| known[0] && known[1]);
        let squares = pairs.map(|(v, _)| (v[1] - v[0]).powi(2)).filter(|square| square.is_finite());
        squares.fold((0.0, 0), |(sum, count), square| (sum + square, count + 1))
    };
    let squares: Vec<(f64, u32)> = blocks.blocks.iter().map(squares).collect();
    let fullest = squares.iter().map(|(_, count)| *count).max().filter(|count| *count > 0)?;
    let level = |(sum, count): &(f64, u32)| match 2 * count >= fullest {
        true => 0.5 * (sum / f64::from(*count)).ln(),
        false => f64::NAN,
    };
    let levels: Vec<f64> = squares.iter().map(level).collect();
    // a block of one repeated value
    levels.iter().all(|level| !level.is_infinite()).then_some(levels)
}

#[derive(Debug, Clone, Default)]
struct Basis {
    columns: Vec<Vec<f64>>,
}

impl Basis {
    /// Adds the new direction in `column`; returns false if there is none.
    fn add(&mut self, column: &[f64]) -> bool {
        let left = self.without(&self.without(column));
        let norm = dot(&left, &left).sqrt();
        let is_new = norm > 1e-6 * dot(column, column).sqrt();
        if is_new {
            self.columns.push(left.iter().map(|value| value / norm).collect());
        }
        is_new
    }

    /// Returns the coefficient of `column` in `values` beside the basis, and its standard error in noise of `variance`.
    fn slope(&self, values: &[f64], column: &[f64], variance: f64) -> [f64; 2] {
        let new = self.without(&self.without(column));
        let square = dot(&new, &new);
        [dot(&new, values) / square, (variance / square).sqrt()]
    }

    fn without(&self, column: &[f64]) -> Vec<f64> {
        let mut left = column.to_vec();
        for direction in &self.columns {
            let along = dot(direction, &left);
            left.iter_mut().zip(direction).for_each(|(value, part)| *value -= along * part);
        }
        left
    }
}

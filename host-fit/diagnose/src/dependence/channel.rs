//! Residual against one channel: its mean in bins of the channel, and a test whether a curve of the channel explains
//! it.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::likelihood::{BlockResidual, Test};
use fos_fit::noise::Fitted;
use fos_fit::noise::{Gls, NoiseLevels};

const BINS: usize = 12;

/// Least number of blocks in a bin: where a temperature reverses, single rising blocks lie among falling ones.
const MIN_BIN_BLOCKS: usize = 3;

/// Share of the log over which the slope of a channel is taken: much longer than a step of a thermometer, much shorter
/// than its course.
const SLOPE_SHARE: f64 = 1.0 / 40.0;

/// Knots of the curve, as shares of the blocks (Harrell 2015, table 2.3).
const KNOTS: [f64; 5] = [0.05, 0.275, 0.5, 0.725, 0.95];

/// Residual in one bin of a channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Bin {
    /// Mean of the channel in the bin.
    pub channel: f64,
    pub blocks: usize,
    /// Plain mean of the residual, in the axis' unit.
    pub mean: f64,
    /// Mean of the residual by generalised least squares, which weights the blocks by their correlated noise, relative
    /// to the mean over all bins.
    pub level: f64,
    /// Half of the 95 % interval of `level` under coloured noise.
    pub half_width: f64,
}

/// Residual by bins of a channel.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Bins {
    /// All blocks, by ascending value of the channel.
    pub all: Vec<Bin>,
    /// Blocks in which the channel rises; for temperatures only.
    pub rising: Vec<Bin>,
    /// Blocks in which the channel falls; for temperatures only.
    pub falling: Vec<Bin>,
}

/// Tests a curve with the noise levels fitted; also returns the fit.
pub(super) fn curve(residual: &BlockResidual<'_>, null: &Fitted, values: &[f64]) -> Option<(Test, Fitted)> {
    residual.test(null, &natural_curve(values))
}

/// Noise estimated by a test.
#[derive(Debug, Clone, Copy)]
pub(super) struct Noise<'a> {
    pub(super) levels: &'a NoiseLevels,
    /// Number of independent samples behind the estimate.
    pub(super) effective_samples: f64,
    /// Number of fitted coefficients, including the constant.
    pub(super) coefficients: usize,
}

impl<'a> Noise<'a> {
    pub(super) fn of(test: &Test, fitted: &'a Fitted) -> Self {
        let Test { effective_samples, terms, .. } = *test;
        Self { levels: &fitted.levels, effective_samples, coefficients: terms + 1 }
    }

    /// Returns half of a 95 % interval in standard errors. With n samples and k coefficients the maximum likelihood
    /// estimate of the noise is too small by √((n − k)/n), and Student's distribution has n − k degrees of freedom.
    fn half_width(&self) -> f64 {
        let freedom = (self.effective_samples - self.coefficients as f64).max(1.0);
        let quantile = StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |t| t.inverse_cdf(0.975));
        quantile * (self.effective_samples / freedom).sqrt()
    }
}

/// Computes the residual in bins of `values`, one per block; also by the sign of the slope if `split`.
pub(super) fn bins(residual: &BlockResidual<'_>, noise: Noise<'_>, values: &[f64], split: bool) -> Bins {
    let place = equal_counts(values);
    let all = levels_in(residual, noise, values, &place).into_iter().flatten().collect();
    if !split {
        return Bins { all, ..Bins::default() };
    }
    let rises = rising(residual, values);
    let by_slope: Vec<usize> =
        place.iter().zip(&rises).map(|(bin, rises)| 2 * bin + usize::from(*rises)).collect();
    let split = levels_in(residual, noise, values, &by_slope);
    let half = |odd: usize| split.iter().skip(odd).step_by(2).flatten().cloned().collect();
    Bins { all, rising: half(1), falling: half(0) }
}

/// Returns the bin of every value: bins of equal count, but equal values share one.
fn equal_counts(values: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_unstable_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut place = vec![0; values.len()];
    let mut before: Option<(f64, usize)> = None;
    for (rank, index) in order.into_iter().enumerate() {
        let bin = match before {
            Some((value, bin)) if value == values[index] => bin,
            _ => rank * BINS / values.len(),
        };
        before = Some((values[index], bin));
        place[index] = bin;
    }
    place
}

/// Computes the bins given by `place`; those with too few blocks are omitted from the result but not from the
/// regression.
fn levels_in(
    residual: &BlockResidual<'_>,
    noise: Noise<'_>,
    values: &[f64],
    place: &[usize],
) -> Vec<Option<Bin>> {
    let n = values.len();
    let count = place.iter().max().map_or(0, |most| most + 1);
    let indicators: Vec<Vec<f64>> = (0..count)
        .map(|bin| place.iter().map(|place| f64::from(u8::from(*place == bin))).collect())
        .collect();
    let regressors: Vec<&[f64]> = indicators.iter().map(Vec::as_slice).collect();
    let gls = Gls::new(residual.blocks, noise.levels, residual.means, &regressors);
    let (coefficients, covariance) = (gls.coefficients(), gls.covariance());
    let share: Vec<f64> = indicators.iter().map(|column| column.iter().sum::<f64>() / n as f64).collect();
    let overall: f64 = coefficients.iter().zip(&share).map(|(level, share)| level * share).sum();
    let wide = noise.half_width();
    let mut bins = vec![None; count];
    for (at, &bin) in gls.kept.iter().enumerate() {
        let own = |series: &[f64]| {
            let inside = series.iter().zip(place).filter(|(_, place)| **place == bin);
            inside.map(|(value, _)| *value).sum::<f64>() / (share[bin] * n as f64)
        };
        // the level is a contrast: the bin's coefficient minus the mean of all
        let contrast: Vec<f64> = gls
            .kept
            .iter()
            .enumerate()
            .map(|(other, &index)| f64::from(u8::from(other == at)) - share[index])
            .collect();
        let variance: f64 = (0..contrast.len())
            .flat_map(|i| (0..contrast.len()).map(move |j| (i, j)))
            .map(|(i, j)| contrast[i] * covariance[(i, j)] * contrast[j])
            .sum();
        let blocks = (share[bin] * n as f64).round() as usize;
        if blocks >= MIN_BIN_BLOCKS {
            bins[bin] = Some(Bin {
                channel: own(values),
                blocks,
                mean: own(residual.means),
                level: coefficients[bin] - overall,
                half_width: wide * variance.sqrt(),
            });
        }
    }
    bins
}

/// Returns for each block whether the channel rises: the sign of its least-squares slope around the block.
fn rising(residual: &BlockResidual<'_>, values: &[f64]) -> Vec<bool> {
    let blocks = &residual.blocks.blocks;
    let span = blocks.last().map_or(0, |last| last.index) - blocks.first().map_or(0, |first| first.index);
    let reach = ((span as f64 * SLOPE_SHARE / 2.0) as u64).max(1);
    let (mut begin, mut end) = (0, 0);
    blocks
        .iter()
        .map(|block| {
            while blocks[begin].index + reach < block.index {
                begin += 1;
            }
            while end < blocks.len() && blocks[end].index <= block.index + reach {
                end += 1;
            }
            let near = begin..end;
            let time = |at: usize| blocks[at].index as f64 - block.index as f64;
            let middle = near.clone().map(time).sum::<f64>() / near.len() as f64;
            near.map(|at| (time(at) - middle) * values[at]).sum::<f64>() > 0.0
        })
        .collect()
}

/// Natural cubic spline of a channel (linear beyond the outer knots) without its constant: four columns, fewer if the
/// channel has few distinct values. Knot i of k gives d_i(x) − d_(k−1)(x) with
/// d_i = ((x − t_i)₊³ − (x − t_k)₊³)/(t_k − t_i) (Hastie, Tibshirani and Friedman 2009, eq. 5.4–5.5).
pub(super) fn natural_curve(values: &[f64]) -> Vec<Vec<f64>> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share).round() as usize];
    let (low, width) = (at(0.0), (at(1.0) - at(0.0)).max(f64::MIN_POSITIVE));
    let scaled = |value: f64| (value - low) / width;
    let mut knots: Vec<f64> = KNOTS.map(|share| scaled(at(share))).to_vec();
    knots.dedup();
    let x: Vec<f64> = values.iter().map(|value| scaled(*value)).collect();
    let mut columns = vec![x.clone()];
    if let [inner @ .., second, last] = knots.as_slice() {
        let cube = |x: f64, knot: f64| (x - knot).max(0.0).powi(3);
        let ratio = |x: f64, knot: f64| (cube(x, knot) - cube(x, *last)) / (last - knot);
        for knot in inner {
            columns.push(x.iter().map(|x| ratio(*x, *knot) - ratio(*x, *second)).collect());
        }
    }
    columns
}

//! Dependence of the residual of an axis on all logged columns: on each channel, each delay of it, each time and
//! frequency.
//!
//! The residual is the measured error minus offset and physical part. The stochastic part is excluded, since its
//! feedback would hide slow effects. Sensor noise is not white, so the null hypothesis of every test is sensor noise
//! (white, flicker, random walk: [`NoiseLevels`]), with a prior from the rows that the model was fitted to and levels
//! fitted with and without the tested regressors.

mod bands;
mod channel;
mod lag;
mod likelihood;

#[cfg(test)]
mod tests;

use fos_data::column::Column;
use fos_data::interrupt::in_parallel;
use fos_data::unit::Unit;
use std::ops::Range;

use fos_core::Predictor;
use serde::{Deserialize, Serialize};

pub use bands::{Cell, PowerMap};
pub use channel::{Bin, Bins};
pub use lag::{Delay, LagProfile};
pub use likelihood::Test;

use crate::detect::MIN_BLOCKS;
use crate::physical::PhysicalError;
use channel::Noise;
use fos_data::recording::{Channel, Recording};
use fos_data::stillness::Stillness;
use fos_fit::model::{AXES, INPUTS, SmallPredictor, UnitModel};
use fos_fit::noise::{Blocks, LevelPrior, NoiseLevels};
use fos_fit::playback::Playback;
use lag::Delays;
use likelihood::BlockResidual;

/// Approximate number of blocks of the evaluation rows, and shortest block, s; as for a diagnosis.
const BLOCKS: f64 = 600.0;
const SHORTEST_S: f64 = 0.5;

/// Least relative variation of a channel.
const CHANGES: f64 = 1e-9;

/// Largest p, over all channels, at which a channel is reported.
const REPORTED_P: f64 = 0.05;

/// Dependence of the residual of an axis on all logged columns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Dependence {
    /// Length of the blocks, s.
    pub block_s: f64,
    /// Number of blocks with enough data.
    pub blocks: usize,
    /// Noise levels without any channel.
    pub noise: NoiseLevels,
    /// True if the noise prior is from the rows that the model was fitted to; else it is from the evaluation rows,
    /// which is less certain.
    pub learnt: bool,
    /// Every channel that varies, lowest p first.
    pub channels: Vec<ChannelDependence>,
    /// Power by time and frequency.
    pub power: PowerMap,
}

/// Dependence of the residual of an axis on one channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct ChannelDependence {
    /// Column of the channel, as `temp_c`.
    pub channel: String,
    /// Unit of the channel.
    pub unit: String,
    /// Test of a curve of the channel against a constant.
    pub curve: Test,
    /// p of the curve, corrected for the number of channels (Bonferroni).
    pub p_of_all: f64,
    /// Residual by value of the channel.
    pub bins: Bins,
    /// Residual by delay of the channel.
    pub lag: LagProfile,
}

impl ChannelDependence {
    /// Returns true if the dependence is significant, corrected for the number of channels.
    pub fn is_clear(&self) -> bool {
        self.p_of_all < REPORTED_P
    }
}

/// Rows that a model was fitted to, from which the noise prior is estimated.
#[derive(Debug, Clone)]
pub struct Trained<'a> {
    /// Log that was fitted.
    pub recording: &'a Recording,
    pub stillness: &'a Stillness,
    pub rows: Range<usize>,
}

/// Computes the dependence of the residual of every axis of `model` in `rows`; `None` if the data are too few to
/// separate a dependence from drifting noise.
pub fn dependence(
    model: &UnitModel,
    recording: &Recording,
    stillness: &Stillness,
    rows: Range<usize>,
    trained: Option<&Trained<'_>>,
) -> Result<Vec<Option<Dependence>>, PhysicalError> {
    let left = residuals(model, recording, stillness)?;
    let is_same = |trained: &&Trained<'_>| {
        std::ptr::eq(trained.recording, recording) && std::ptr::eq(trained.stillness, stillness)
    };
    // usually the fitted rows are of the same log; its residual, as large as its axes, is then computed once
    let other_residuals = trained.filter(|trained| !is_same(trained));
    let other_residuals =
        other_residuals.map(|trained| residuals(model, trained.recording, trained.stillness)).transpose()?;
    let length_s = (rows.len() as f64 * recording.rate.period_s / BLOCKS).max(SHORTEST_S);
    let n_axes = model.axes.len();
    let evaluated: Vec<EvaluatedRows> = in_parallel(0..n_axes, |axis| {
        let (blocks, means) = in_blocks(recording, &rows, &left[axis], length_s);
        EvaluatedRows { blocks, means, length_s }
    });
    // usually the axes are known in the same rows; their channels are then averaged once
    let first_alike = |axis: usize| {
        let known = evaluated[axis].blocks.known();
        (0..axis).find(|other| evaluated[*other].blocks.known() == known).unwrap_or(axis)
    };
    let first_alike: Vec<usize> = in_parallel(0..n_axes, first_alike);
    let channels: Vec<&Channel> =
        recording.channels().iter().filter(|channel| !channel.column().is_of_model()).collect();
    let delays = Delays::new(recording);
    let wanted = (0..n_axes).filter(|axis| first_alike[*axis] == *axis && evaluated[*axis].is_enough());
    let pairs: Vec<(usize, &Channel)> =
        wanted.flat_map(|axis| channels.iter().map(move |channel| (axis, *channel))).collect();
    let in_blocks: Vec<Option<ChannelInBlocks>> = in_parallel(&pairs, |(axis, channel)| {
        ChannelInBlocks::of(recording, channel, &rows, &evaluated[*axis].blocks, &delays)
    });
    Ok(in_parallel(0..n_axes, |axis| {
        let learnt_from = trained.map(|trained| {
            let left = other_residuals.as_ref().unwrap_or(&left);
            (trained.recording, trained.rows.clone(), left[axis].as_slice())
        });
        let column = &model.axes[axis].column;
        let alike = pairs
            .iter()
            .zip(&in_blocks)
            .filter(|((first, channel), _)| *first == first_alike[axis] && channel.name != *column);
        let channels = alike.filter_map(|((_, channel), in_blocks)| Some((*channel, in_blocks.as_ref()?)));
        let power = || bands::power_map(recording, rows.clone(), &left[axis]);
        axis_dependence(&evaluated[axis], channels.collect(), learnt_from, power)
    }))
}

/// Evaluation rows of an axis.
struct EvaluatedRows {
    blocks: Blocks,
    means: Vec<f64>,
    /// Requested length of a block, s.
    length_s: f64,
}

impl EvaluatedRows {
    /// Returns true if there are enough blocks to separate a dependence from drifting noise.
    fn is_enough(&self) -> bool {
        self.blocks.len() >= MIN_BLOCKS
    }
}

/// Block means of a varying channel, by delay.
struct ChannelInBlocks([Vec<f64>; lag::N_DELAYS]);

impl ChannelInBlocks {
    fn of(
        recording: &Recording,
        channel: &Channel,
        rows: &Range<usize>,
        blocks: &Blocks,
        delays: &Delays,
    ) -> Option<Self> {
        let held = recording.held_from_first(channel);
        let delayed = delays.means(blocks, &held);
        let size = held[rows.clone()].iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let spread = fos_fit::signal::variance(&[&delayed[0]]).sqrt();
        // NaN if nothing was logged
        (spread > CHANGES * size).then_some(Self(delayed))
    }

    fn means(&self) -> &[f64] {
        &self.0[0]
    }
}

/// Returns the measured error minus offset and physical part, one value per row of the recording for each axis; NaN in
/// motion and if the value is unknown.
fn residuals(
    model: &UnitModel,
    recording: &Recording,
    stillness: &Stillness,
) -> Result<Vec<Vec<f64>>, PhysicalError> {
    let mut physical = model.clone();
    for axis in &mut physical.axes {
        axis.stochastic.clear();
        axis.parameters.constant = 0.0;
    }
    physical.drop_unused();
    let playback = Playback::new(recording, &physical, &stillness.still)?;
    match physical.with(SmallPredictor::new) {
        Ok(small) => Ok(innovations(small, &playback)),
        Err(_) => Ok(innovations(physical.predictor::<f64>()?, &playback)),
    }
}

/// Returns the innovation of each axis in every row, which without a stochastic part is the residual.
fn innovations<const TERMS: usize, const HISTORY: usize>(
    mut predictor: Predictor<f64, AXES, INPUTS, TERMS, HISTORY>,
    playback: &Playback<'_>,
) -> Vec<Vec<f64>> {
    let mut left = vec![Vec::with_capacity(playback.n_rows()); predictor.n_axes()];
    let mut feed = playback.feed();
    for row in 0..playback.n_rows() {
        for (left, correction) in left.iter_mut().zip(feed.step(&mut predictor, row)) {
            left.push(correction.innovation.unwrap_or(f64::NAN));
        }
    }
    left
}

/// Returns the blocks of the rows in which `left` is known, and its means.
fn in_blocks(recording: &Recording, rows: &Range<usize>, left: &[f64], length_s: f64) -> (Blocks, Vec<f64>) {
    let known = (0..left.len()).map(|row| rows.contains(&row) && left[row].is_finite()).collect();
    let blocks = Blocks::new(recording, length_s, known);
    let means = blocks.means(left);
    (blocks, means)
}

fn axis_dependence(
    EvaluatedRows { blocks, means, length_s }: &EvaluatedRows,
    channels: Vec<(&Channel, &ChannelInBlocks)>,
    learnt_from: Option<(&Recording, Range<usize>, &[f64])>,
    power: impl FnOnce() -> PowerMap,
) -> Option<Dependence> {
    if blocks.len() < MIN_BLOCKS {
        return None;
    }
    let learnt = learnt_from.and_then(|(recording, rows, left)| {
        let (blocks, means) = in_blocks(recording, &rows, left, *length_s);
        let ones = vec![1.0; blocks.len()];
        // a log that does not determine its levels is ignored: the wide prior below holds
        let prior = LevelPrior::of_log(&blocks, &means);
        (blocks.len() >= MIN_BLOCKS).then(|| prior.learnt(&blocks, &means, &[ones]).ok())?
    });
    let prior = learnt.unwrap_or_else(|| LevelPrior::of_log(blocks, means));
    let remainder = BlockResidual { blocks, means, prior: &prior };
    let null = remainder.constant();
    let channel_dependence =
        |(channel, in_blocks): (&Channel, &ChannelInBlocks)| -> Option<ChannelDependence> {
            let values = in_blocks.means();
            let (curve, fitted) = channel::curve(&remainder, &null, values)?;
            let noise = Noise::of(&curve, &fitted);
            Some(ChannelDependence {
                channel: channel.name.clone(),
                unit: Column::named(&channel.name).unit().label().to_owned(),
                p_of_all: curve.p,
                bins: channel::bins(&remainder, noise, values, channel.unit == Unit::Celsius),
                lag: lag::profile(&remainder, (&null, &fitted.levels), &in_blocks.0)?,
                curve,
            })
        };
    let mut channels: Vec<ChannelDependence> =
        in_parallel(channels, channel_dependence).into_iter().flatten().collect();
    let tried = channels.len() as f64;
    channels.iter_mut().for_each(|channel| channel.p_of_all = (channel.curve.p * tried).min(1.0));
    channels.sort_by(|a, b| a.curve.p.total_cmp(&b.curve.p).then(b.curve.score.total_cmp(&a.curve.score)));
    Some(Dependence {
        block_s: blocks.length_s,
        blocks: blocks.len(),
        noise: null.levels,
        learnt: learnt.is_some(),
        channels,
        power: power(),
    })
}

//! What is left of an axis against everything that is logged: each channel, each delay of it, each hour and frequency.
//!
//! What is looked at is the slow remainder: measured error less offset and physical part. The stochastic part is left
//! out, since what it feeds back would hide slow effects. Sensor noise is not white, so every test has the noise of the
//! sensor as its null hypothesis (white, flicker, random walk: [`NoiseLevels`]), with levels as they were learnt from
//! the rows that the model was fitted to, and fitted anew with and without what is tested.

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
use channel::Noise;
use fos_data::recording::{Channel, Recording, RecordingError};
use fos_data::stillness::Stillness;
use fos_fit::model::{AXES, INPUTS, SmallPredictor, UnitModel};
use fos_fit::noise::{Blocks, LevelPrior, NoiseLevels};
use fos_fit::playback::Playback;
use lag::Delays;
use likelihood::Remainder;

/// Blocks that the judged rows are cut into, about, and the shortest block, s: as for a diagnosis.
const BLOCKS: f64 = 600.0;
const SHORTEST_S: f64 = 0.5;

/// A channel that varies by less than this share of its size does not change.
const CHANGES: f64 = 1e-9;

/// A channel is named if less likely than this among all channels.
const NAMED: f64 = 0.05;

/// What is left of an axis, against everything that is logged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Dependence {
    /// Length of the blocks that means were taken over, s.
    pub block_s: f64,
    /// Blocks with enough data.
    pub blocks: usize,
    /// The noise, with no channel taken into account.
    pub noise: NoiseLevels,
    /// The noise was learnt from the rows that the model was fitted to; else from the judged rows themselves, which is
    /// less sure.
    pub learnt: bool,
    /// Every channel that changes, least likely first.
    pub channels: Vec<ChannelDependence>,
    /// Power by time and frequency.
    pub power: PowerMap,
}

/// What is left of an axis, against one channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct ChannelDependence {
    /// Its column, as `temp_c`.
    pub channel: String,
    /// Unit that the channel's values are in.
    pub unit: String,
    /// A curve of the channel against a constant.
    pub curve: Test,
    /// p of the curve after allowing for all channels (Bonferroni).
    pub p_of_all: f64,
    /// What is left by value of the channel.
    pub bins: Bins,
    /// What is left by delay of the channel.
    pub lag: LagProfile,
}

impl ChannelDependence {
    /// Whether it is more than chance explains, all channels considered.
    pub fn is_clear(&self) -> bool {
        self.p_of_all < NAMED
    }
}

/// The rows that a model was fitted to: what its noise is learnt from.
#[derive(Debug, Clone)]
pub struct Trained<'a> {
    /// The log that was fitted.
    pub recording: &'a Recording,
    pub stillness: &'a Stillness,
    /// The rows.
    pub rows: Range<usize>,
}

/// What is left of every axis of `model` in `rows`, against everything that is logged; `None` where that is too little
/// to tell a dependence from drifting noise.
///
/// # Errors
///
/// A column is missing.
pub fn dependence(
    model: &UnitModel,
    recording: &Recording,
    stillness: &Stillness,
    rows: Range<usize>,
    trained: Option<&Trained<'_>>,
) -> Result<Vec<Option<Dependence>>, DependenceError> {
    let left = remainders(model, recording, stillness)?;
    let is_same = |trained: &&Trained<'_>| {
        std::ptr::eq(trained.recording, recording) && std::ptr::eq(trained.stillness, stillness)
    };
    // most often the rows that were fitted are of the same log, and one is as large as its axes
    let of_another = trained.filter(|trained| !is_same(trained));
    let of_another =
        of_another.map(|trained| remainders(model, trained.recording, trained.stillness)).transpose()?;
    let length_s = (rows.len() as f64 * recording.rate.period_s / BLOCKS).max(SHORTEST_S);
    let n_axes = model.axes.len();
    let judged: Vec<Judged> = in_parallel(0..n_axes, |axis| {
        let (blocks, means) = in_blocks(recording, &rows, &left[axis], length_s);
        Judged { blocks, means, length_s }
    });
    // most often the axes are known in the same rows, and what a channel comes to in their blocks is computed once
    let first_alike = |axis: usize| {
        let known = judged[axis].blocks.known();
        (0..axis).find(|other| judged[*other].blocks.known() == known).unwrap_or(axis)
    };
    let first_alike: Vec<usize> = in_parallel(0..n_axes, first_alike);
    let channels: Vec<&Channel> =
        recording.channels().iter().filter(|channel| !channel.column().is_of_model()).collect();
    let delays = Delays::new(recording);
    let wanted = (0..n_axes).filter(|axis| first_alike[*axis] == *axis && judged[*axis].is_enough());
    let pairs: Vec<(usize, &Channel)> =
        wanted.flat_map(|axis| channels.iter().map(move |channel| (axis, *channel))).collect();
    let in_blocks: Vec<Option<ChannelInBlocks>> = in_parallel(&pairs, |(axis, channel)| {
        ChannelInBlocks::of(recording, channel, &rows, &judged[*axis].blocks, &delays)
    });
    Ok(in_parallel(0..n_axes, |axis| {
        let learnt_from = trained.map(|trained| {
            let left = of_another.as_ref().unwrap_or(&left);
            (trained.recording, trained.rows.clone(), left[axis].as_slice())
        });
        let column = &model.axes[axis].column;
        let alike = pairs
            .iter()
            .zip(&in_blocks)
            .filter(|((first, channel), _)| *first == first_alike[axis] && channel.name != *column);
        let channels = alike.filter_map(|((_, channel), in_blocks)| Some((*channel, in_blocks.as_ref()?)));
        let power = || bands::power_map(recording, rows.clone(), &left[axis]);
        of_axis(&judged[axis], channels.collect(), learnt_from, power)
    }))
}

/// The judged rows of an axis.
struct Judged {
    blocks: Blocks,
    means: Vec<f64>,
    /// Of a block as it was asked for, s.
    length_s: f64,
}

impl Judged {
    /// To tell a dependence from drifting noise.
    fn is_enough(&self) -> bool {
        self.blocks.len() >= MIN_BLOCKS
    }
}

/// A channel that changes, in the blocks of an axis: its means, by delay.
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
        // not a number where nothing was ever logged
        (spread > CHANGES * size).then_some(Self(delayed))
    }

    fn means(&self) -> &[f64] {
        &self.0[0]
    }
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum DependenceError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// fos-core refuses the model.
    #[error("the model cannot be run: {0}")]
    Model(#[from] fos_core::ModelError),
}

/// Measured error less offset and physical part, one value per row of the recording for each axis; NaN where it moves
/// or the value is not known.
fn remainders(
    model: &UnitModel,
    recording: &Recording,
    stillness: &Stillness,
) -> Result<Vec<Vec<f64>>, DependenceError> {
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

/// Of each axis the innovation in every row; without a stochastic part it is the remainder.
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

/// Blocks of the rows in which `left` is known, and its means.
fn in_blocks(recording: &Recording, rows: &Range<usize>, left: &[f64], length_s: f64) -> (Blocks, Vec<f64>) {
    let known = (0..left.len()).map(|row| rows.contains(&row) && left[row].is_finite()).collect();
    let blocks = Blocks::new(recording, length_s, known);
    let means = blocks.means(left);
    (blocks, means)
}

fn of_axis(
    Judged { blocks, means, length_s }: &Judged,
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
        // a log that does not tell its levels is as none: the wide prior below stands
        let prior = LevelPrior::of_log(&blocks, &means);
        (blocks.len() >= MIN_BLOCKS).then(|| prior.learnt(&blocks, &means, &[ones]).ok())?
    });
    let prior = learnt.unwrap_or_else(|| LevelPrior::of_log(blocks, means));
    let remainder = Remainder { blocks, means, prior: &prior };
    let null = remainder.constant();
    let of_channel = |(channel, in_blocks): (&Channel, &ChannelInBlocks)| -> Option<ChannelDependence> {
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
        in_parallel(channels, of_channel).into_iter().flatten().collect();
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

//! Drift with temperature, estimated together with the noise levels: otherwise a sensor that warms up seems to have a
//! large random walk.

use serde::Serialize;

use super::blocks::Blocks;
use super::gls::Gls;
use super::model::NoiseLevels;
use crate::signal::centred;
use fos_data::recording::Recording;

/// Least span of a temperature that counts as varying, K: below, the drift of a usual part is below its noise.
const LEAST_SPAN: f64 = 0.5;

/// Spans from which on the drift is quadratic, and cubic, K.
const CURVED_SPAN: f64 = 5.0;
const CUBIC_SPAN: f64 = 20.0;

/// Time constant of the second temperature, s, for a sensor that lags the thermometer. To first order the difference of
/// the two covers any lag that is short compared with the changes.
const LAG_S: f64 = 60.0;

/// Drift with temperature that was removed before the noise was estimated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ThermalDrift {
    /// Range of the block means of the temperature, °C.
    pub range_c: [f64; 2],
    /// RMS of the drift about its mean, unit of the axis.
    pub rms: f64,
}

/// Temperature of a log as regressors of a drift.
pub(super) struct Temperature {
    range_c: [f64; 2],
    /// Powers of the temperature and the lagged temperature, one value per block each.
    regressors: Vec<Vec<f64>>,
}

impl Temperature {
    /// Returns `None` if the temperature is not logged, or constant. Empty cells hold the value before; between two
    /// steps of a coarse thermometer the temperature follows a smooth curve.
    pub(super) fn of(recording: &Recording, blocks: &Blocks) -> Option<Self> {
        let channel = recording.channel("temp_c").ok()?;
        let held = recording.held_from_first(channel);
        let means = match recording.coarse_step(channel) {
            Some(step) => blocks.means(&recording.between_steps(&held, step)),
            None => blocks.means(&held),
        };
        let (low, high) = means.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(*value), high.max(*value))
        });
        let span = high - low;
        if !(span >= LEAST_SPAN && means.iter().all(|value| value.is_finite())) {
            return None;
        }
        let scaled: Vec<f64> =
            means.iter().map(|value| (value - 0.5 * (low + high)) / (0.5 * span)).collect();
        let power = |power: i32| centred(scaled.iter().map(|value| value.powi(power)).collect());
        let mut regressors = vec![power(1), centred(lagged(&scaled, blocks))];
        if span >= CURVED_SPAN {
            regressors.push(power(2));
        }
        if span >= CUBIC_SPAN {
            regressors.push(power(3));
        }
        Some(Self { range_c: [low, high], regressors })
    }

    /// Returns the constant, then the regressors of the drift.
    pub(super) fn beside<'r>(&'r self, constant: &'r [f64]) -> Vec<&'r [f64]> {
        std::iter::once(constant).chain(self.regressors.iter().map(Vec::as_slice)).collect()
    }

    /// Returns the drift in `y`, block means, under noise levels, in each row of the log; interpolated between blocks,
    /// because the thermometer's own noise is not part of the sensor's.
    pub(super) fn drift(
        &self,
        blocks: &Blocks,
        y: &[f64],
        levels: &NoiseLevels,
        rows: usize,
    ) -> (Vec<f64>, ThermalDrift) {
        let constant = vec![1.0; blocks.len()];
        let coefficients = Gls::new(blocks, levels, y, &self.beside(&constant)).coefficients();
        let in_blocks = super::combination(&self.regressors, &coefficients[1..], blocks.len());
        let rms = (super::dot(&in_blocks, &in_blocks) / in_blocks.len() as f64).sqrt();
        let middles: Vec<f64> =
            blocks.blocks.iter().map(|block| 0.5 * (block.rows.start + block.rows.end) as f64).collect();
        let drift_at = |row: usize| {
            let (row, after) = (row as f64, middles.partition_point(|middle| *middle <= row as f64));
            match after {
                0 => in_blocks[0],
                after if after == middles.len() => in_blocks[after - 1],
                after => {
                    let share = (row - middles[after - 1]) / (middles[after] - middles[after - 1]);
                    in_blocks[after - 1] + share * (in_blocks[after] - in_blocks[after - 1])
                }
            }
        };
        ((0..rows).map(drift_at).collect(), ThermalDrift { range_c: self.range_c, rms })
    }
}

/// First-order low-pass from block to block.
fn lagged(values: &[f64], blocks: &Blocks) -> Vec<f64> {
    let mut state = values[0];
    let mut index = blocks.blocks[0].index;
    let step = |(value, block): (&f64, &super::Block)| {
        let elapsed_s = (block.index - index) as f64 * blocks.length_s;
        index = block.index;
        state += (1.0 - (-elapsed_s / LAG_S).exp()) * (value - state);
        state
    };
    values.iter().zip(&blocks.blocks).map(step).collect()
}

//! Noise of an axis of a log at rest: its Allan deviation, and N, B and K with their intervals.

use std::borrow::Cow;
use std::ops::Range;

use fos_data::observed::ObservedAxis;
use fos_data::recording::{Recording, RecordingError};
use fos_data::stillness::Stillness;
use serde::Serialize;

use super::blocks::{Blocks, length_for};
use super::estimate::{FEWEST_BLOCKS, NoiseEstimate, estimate};
use super::filter::FilterNoise;
use super::levels::UnknownLevels;
use super::model::NoiseLevels;
use super::step::Rounded;
use super::thermal_drift::{Temperature, ThermalDrift};
use crate::signal::allan::{AllanPoint, TAUS_PER_DECADE, allan_deviation, averaging_times};
use crate::signal::quantisation::{Quantisation, quantisation};

/// Ratio of the block length for slow effects to the one used here: white noise shows in short blocks.
const FINER: f64 = 10.0;

/// Shortest block, s; faster noise is part of the white noise.
const SHORTEST_S: f64 = 0.5;

/// Noise of one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxisNoise {
    /// Name in the log format, as `gx_rads`.
    pub column: String,
    pub unit: String,
    /// Time at rest, s.
    pub seconds: f64,
    /// Time from the first to the last sample at rest, s.
    pub span_s: f64,
    /// Number of excluded outliers.
    pub left_out: usize,
    /// N, B and K.
    #[serde(flatten)]
    pub levels: NoiseEstimate,
    /// Noise of a Kalman filter that is updated with every sample.
    pub filter: FilterNoise,
    /// Drift with temperature, which is part of neither the levels nor the Allan deviation; none if the temperature is
    /// constant or not logged.
    pub thermal_drift: Option<ThermalDrift>,
    /// Step of the converter, unit of the column, if it hides the noise: N, B and K are then limits.
    pub step: Option<f64>,
    /// Length of a log that would show more about an undetected random walk, s.
    pub walk_needs_s: Option<f64>,
    /// Overlapping Allan deviation; no difference spans a gap or a motion.
    pub allan: Vec<AllanPoint>,
}

#[derive(Debug, thiserror::Error)]
pub enum AxisNoiseError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error(
        "{column}: {seconds:.1} s at rest in stretches long enough for means over {block_s:.1} s; its noise needs at least {needed:.0} s\nhelp: record a longer log of the device lying still, without interruptions; three hours show the random walk of most parts"
    )]
    TooShort {
        column: String,
        /// Time at rest in blocks with enough samples, s.
        seconds: f64,
        block_s: f64,
        needed: f64,
    },
    /// The axis does not change, or is stuck for at least half of the time.
    #[error(
        "{column} repeats one value, {value}, at rest: stuck or not connected\nhelp: leave the axis out with `axis`"
    )]
    Constant { column: String, value: f64 },
}

/// Estimates the noise of an axis (`gx`, or a column) in the rows that `stillness` marks as at rest.
///
/// An accelerometer has a separate constant in each orientation, because of gravity. A drift with the logged
/// temperature is estimated together with the levels (restricted likelihood) and removed. Any other drift counts as
/// noise, mostly as random walk.
pub fn axis_noise(
    recording: &Recording,
    stillness: &Stillness,
    axis: &str,
) -> Result<AxisNoise, AxisNoiseError> {
    let column = recording.axis(axis)?.name.clone();
    let rows = 0..recording.n_rows();
    stillness.check_rest(recording, &rows)?;
    if let Some((value, _)) = recording.stuck_axis(&column, &stillness.still) {
        return Err(AxisNoiseError::Constant { column, value });
    }
    let (cleaned, left_out) = recording.without_outliers(&column, rows, &stillness.still);
    let observed = ObservedAxis::at_rest(&cleaned, stillness, &column)?;
    let series = &observed.error;

    let length_s = (length_for(recording) / FINER).max(SHORTEST_S);
    let blocks = Blocks::with_levels(recording, length_s, observed.known.clone(), &observed.turns);
    let period_s = recording.rate.period_s;
    let seconds = blocks.known().iter().filter(|known| **known).count() as f64 * period_s;
    if blocks.beyond_levels() < FEWEST_BLOCKS {
        let block_s = blocks.length_s;
        let (seconds, needed) = (blocks.beyond_levels() as f64 * block_s, FEWEST_BLOCKS as f64 * block_s);
        return Err(AxisNoiseError::TooShort { column, seconds, block_s, needed });
    }
    let y = blocks.means(&series.values);
    let constant = vec![1.0; blocks.len()];
    // a large offset would cost digits of the noise
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    let centred: Vec<f64> = y.iter().map(|value| value - mean).collect();
    let span_s = blocks.middle_s(blocks.len() - 1) - blocks.middle_s(0) + blocks.length_s;
    let temperature = Temperature::of(recording, &blocks);
    let regressors =
        temperature.as_ref().map_or_else(|| vec![constant.as_slice()], |of| of.beside(&constant));
    let estimated = estimate(&blocks, &centred, &regressors);
    let removed = temperature.as_ref().zip(estimated.as_ref().ok()).map(|(temperature, levels)| {
        let [white, flicker, walk] = [levels.white, levels.flicker, levels.walk].map(|level| level.at_most());
        let levels = NoiseLevels { white, flicker, walk, gauss_markov: None };
        temperature.drift(&blocks, &centred, &levels, recording.n_rows())
    });
    let (drift, thermal_drift) = removed.unzip();
    let values: Cow<'_, [f64]> = match drift {
        Some(drift) => series.values.iter().zip(&drift).map(|(value, drift)| value - drift).collect(),
        None => Cow::Borrowed(&series.values),
    };
    let stretches: Vec<Range<usize>> = recording
        .stretches_where(|row| blocks.known()[row])
        .into_iter()
        .flat_map(|stretch| observed.levels(stretch))
        .collect();
    let measured = parts(&series.values, &stretches);
    let (levels, step) = match estimated {
        Ok(found) => match quantisation(&measured) {
            Some(Quantisation { step, .. }) => {
                let rounded = Rounded::of(&measured, step, period_s, span_s);
                let (levels, is_hidden) = rounded.before_rounding(found);
                (levels, is_hidden.then_some(step))
            }
            None => (found, None),
        },
        Err(UnknownLevels) => match recording.hidden_step(&column, &stillness.still) {
            Some(step) => {
                let samples = measured.iter().map(|stretch| stretch.len()).sum();
                (Rounded::limits_of_constant(step, samples, period_s, span_s), Some(step))
            }
            None => return Err(AxisNoiseError::Constant { column, value: mean }),
        },
    };
    let without_drift = parts(&values, &stretches);
    let taus = averaging_times(&without_drift, period_s, TAUS_PER_DECADE);
    Ok(AxisNoise {
        unit: series.unit.label().to_owned(),
        seconds,
        span_s,
        left_out,
        levels,
        filter: FilterNoise::of(&levels, period_s),
        // a longer log does not reveal what a step hides
        walk_needs_s: if step.is_some() { None } else { levels.seconds_for_walk(span_s) },
        step,
        thermal_drift,
        allan: allan_deviation(&without_drift, period_s, &taus),
        column,
    })
}

fn parts<'v>(values: &'v [f64], ranges: &[Range<usize>]) -> Vec<&'v [f64]> {
    ranges.iter().map(|range| &values[range.clone()]).collect()
}

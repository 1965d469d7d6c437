//! The noise of an axis of a log at rest: its Allan deviation, and N, B and K with their intervals.

use std::ops::Range;

use fos_data::pose;
use fos_data::recording::{Recording, RecordingError};
use fos_data::stillness::Stillness;
use serde::Serialize;

use super::blocks::{Blocks, length_for};
use super::estimate::{FEWEST_BLOCKS, NoiseEstimate, estimate};
use crate::signal::allan::{AllanPoint, TAUS_PER_DECADE, allan_deviation, averaging_times};

/// Blocks are so many times shorter than those that slow effects are looked for in: white noise shows in the short ones.
const FINER: f64 = 10.0;

/// Shortest block, s: what is faster is part of the white noise.
const SHORTEST_S: f64 = 0.5;

/// The noise of one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxisNoise {
    /// As in the log format, as `gx_rads`.
    pub column: String,
    /// Unit of the column.
    pub unit: String,
    /// Time at rest that it is of, s.
    pub seconds: f64,
    /// Time from the first to the last sample at rest, s.
    pub span_s: f64,
    /// Samples that are no measurements, left out.
    pub left_out: usize,
    /// N, B, K.
    #[serde(flatten)]
    pub levels: NoiseEstimate,
    /// How long a log would have to be to tell more of a random walk that was not seen, s.
    pub walk_needs_s: Option<f64>,
    /// Overlapping Allan deviation; none of its differences reaches over a gap or a motion.
    pub allan: Vec<AllanPoint>,
}

/// Why the noise of an axis cannot be told.
#[derive(Debug, thiserror::Error)]
pub enum AxisNoiseError {
    /// A column is not there.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Too little at rest.
    #[error(
        "{column}: {seconds:.1} s at rest in stretches long enough for means over {block_s:.1} s; its noise needs at least {needed:.0} s\nhelp: record a longer log of the device lying still, without interruptions; three hours show the random walk of most parts"
    )]
    TooShort {
        /// The column.
        column: String,
        /// Time at rest in blocks with enough samples, s.
        seconds: f64,
        /// Length of a block, s.
        block_s: f64,
        /// Time needed, s.
        needed: f64,
    },
    /// It does not change.
    #[error(
        "{column}: it has one value, {value}, throughout: no noise can be told from it\nhelp: a finer range, or a column that is measured"
    )]
    Constant {
        /// The column.
        column: String,
        /// The value.
        value: f64,
    },
}

/// Most poses that a constant is estimated for, the longest: the time that the estimate takes grows with their square, and
/// a calibration in more orientations is rare.
const MOST_POSES: usize = 32;

/// Counts no rows but those of the longest poses.
fn keep_longest_poses(known: &mut [bool], turns: &[usize]) {
    let mut poses = pose::levels_between(turns, 0..known.len());
    let rows = |pose: &Range<usize>| known[pose.clone()].iter().filter(|known| **known).count();
    poses.sort_by_cached_key(|pose| std::cmp::Reverse(rows(pose)));
    for pose in poses.split_off(MOST_POSES.min(poses.len())) {
        known[pose].fill(false);
    }
}

/// The noise of an axis (`gx`, or a column) where `stillness` says that the unit lies still.
///
/// An accelerometer has a constant of its own in each pose, as gravity is in each. What the axis measures besides, such
/// as a temperature that changes, counts as noise: mostly as random walk.
///
/// # Errors
///
/// The column is missing, too short or constant.
pub fn axis_noise(
    recording: &Recording,
    stillness: &Stillness,
    axis: &str,
) -> Result<AxisNoise, AxisNoiseError> {
    let column = recording.axis(axis)?.name.clone();
    let rows = 0..recording.n_rows();
    let (cleaned, left_out) = recording.only_measurements(&column, rows.clone(), &stillness.still);
    let series = cleaned.error_series(&column)?;
    let mut known: Vec<bool> =
        rows.map(|row| stillness.still[row] && series.values[row].is_finite()).collect();
    let in_poses = pose::has_unknown_level(&column, &series.reference);
    let turns = if in_poses { &stillness.turns[..] } else { &[] };
    keep_longest_poses(&mut known, turns);

    let length_s = (length_for(recording) / FINER).max(SHORTEST_S);
    let blocks = Blocks::new(recording, length_s, known);
    let period_s = recording.rate.period_s;
    let seconds = blocks.known().iter().filter(|known| **known).count() as f64 * period_s;
    if blocks.len() < FEWEST_BLOCKS {
        let block_s = blocks.length_s;
        let (seconds, needed) = (blocks.len() as f64 * block_s, FEWEST_BLOCKS as f64 * block_s);
        return Err(AxisNoiseError::TooShort { column, seconds, block_s, needed });
    }
    let y = blocks.means(&series.values);
    let constants = blocks.levels(turns);
    let has_blocks = |constant: &&Vec<f64>| constant.iter().any(|value| *value != 0.0);
    let constants: Vec<&[f64]> = constants.iter().filter(has_blocks).map(Vec::as_slice).collect();
    // what is far from zero would leave fewer digits to the noise
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    let centred: Vec<f64> = y.iter().map(|value| value - mean).collect();
    let levels_found = estimate(&blocks, &centred, &constants)
        .map_err(|_| AxisNoiseError::Constant { column: column.clone(), value: mean })?;
    let stretches = recording.stretches_where(|row| blocks.known()[row]);
    let stretches: Vec<&[f64]> = stretches
        .iter()
        .flat_map(|stretch| pose::levels_between(turns, stretch.clone()))
        .map(|stretch| &series.values[stretch])
        .collect();
    let taus = averaging_times(&stretches, period_s, TAUS_PER_DECADE);
    let span_s = blocks.middle_s(blocks.len() - 1) - blocks.middle_s(0) + blocks.length_s;
    Ok(AxisNoise {
        unit: series.unit.label().to_owned(),
        seconds,
        span_s,
        left_out,
        levels: levels_found,
        walk_needs_s: levels_found.seconds_for_walk(span_s),
        allan: allan_deviation(&stretches, period_s, &taus),
        column,
    })
}

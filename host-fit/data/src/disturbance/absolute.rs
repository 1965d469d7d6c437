//! Motion by absolute size: scatter beyond that of any MEMS sensor at rest, however usual it is in a log. A vehicle
//! moves all along, and nothing in its log stands out.

use std::ops::Range;

use super::scale::stretches;
use crate::column::Column;
use crate::recording::Recording;
use crate::statistics::{MAD_TO_SD, finite_median};
use crate::unit::Unit;

/// Averaging time of the compared means, s: vibration averages out, and a bias has hardly moved from one to the next.
const BLOCK_S: f64 = 1.0;

/// Blocks of a window. The median of its second differences does not follow one or two steps of a bias.
const WINDOW_BLOCKS: usize = 10;

/// Upper limit of the scatter of 1-s means of a gyro at rest, as the square root of a Hadamard variance, rad/s: 0.57
/// °/s. The bias instability of the worst consumer parts is some 0.05 °/s, their white noise over 1 s too, and the
/// noisiest of the recorded logs at rest has 0.1 °/s (docs/decisions/motion.md); a driving car has several °/s.
const GYRO_RADS: f64 = 0.01;

/// The same for accelerometers, m/s²: 10 mg. Data sheets state up to 0.3 mg/√Hz and instabilities below 1 mg; the
/// noisiest log at rest has 3 mg, all of it white.
const ACCELEROMETER_MPS2: f64 = 0.1;

/// Minimum ratio of the variance of the means to that expected from the sample-to-sample scatter if it were white: a
/// machine that shakes the device, or a wrong unit, makes both large.
const SLOW_OVER_WHITE: f64 = 4.0;

/// Minimum duration of a rest between motions, s.
pub(super) const SHORTEST_REST_S: f64 = 30.0;

/// Scatter above which an axis is in motion, in its unit; `None` for other columns.
pub(super) fn limit(column: &str) -> Option<f64> {
    match Column::named(column).unit() {
        Unit::RadianPerSecond => Some(GYRO_RADS),
        Unit::MetrePerSecondSquared => Some(ACCELEROMETER_MPS2),
        _ => None,
    }
}

/// Stretches in which at least two axes scatter more than any sensor at rest, in order. `axes` are the columns and their
/// values, NaN in rows that are not examined.
pub(super) fn find(recording: &Recording, axes: &[(&str, Vec<f64>)]) -> Vec<Range<usize>> {
    let Some(windows) = Windows::of(recording) else { return Vec::new() };
    let limits: Vec<f64> = axes.iter().map(|(column, _)| limit(column).unwrap_or(f64::INFINITY)).collect();
    let scatters: Vec<Vec<f64>> =
        axes.iter().zip(&limits).map(|((_, values), limit)| windows.scatters(values, *limit)).collect();
    let mut moves = vec![false; recording.n_rows()];
    for (window, rows) in windows.rows.iter().enumerate() {
        let above = scatters.iter().zip(&limits).filter(|(scatter, limit)| scatter[window] > **limit);
        if above.count() >= 2 {
            moves[rows.clone()].fill(true);
        }
    }
    stretches(&moves, (SHORTEST_REST_S / recording.rate.period_s) as usize)
}

/// Median scatter of the means of an axis within these rows, in its unit; 0 if it does not exceed white noise.
pub(super) fn scatter(recording: &Recording, values: &[f64], within: &Range<usize>) -> f64 {
    let Some(windows) = Windows::of(recording) else { return 0.0 };
    let scatters = windows.scatters(values, 0.0);
    let inside = windows
        .rows
        .iter()
        .zip(&scatters)
        .filter(|(rows, _)| rows.start < within.end && within.start < rows.end);
    finite_median(&inside.map(|(_, scatter)| *scatter).collect::<Vec<f64>>()).unwrap_or(0.0)
}

/// Windows that overlap by half. A few lost samples do not hide a motion; a change across a longer gap was not recorded
/// and does not count, as of a device put down differently between two bursts.
struct Windows<'a> {
    time_s: &'a [f64],
    rows: Vec<Range<usize>>,
    block: usize,
}

impl<'a> Windows<'a> {
    /// `None` for a log with fewer than three blocks.
    fn of(recording: &'a Recording) -> Option<Self> {
        let n = recording.n_rows();
        let block = (BLOCK_S / recording.rate.period_s).round() as usize;
        let length = WINDOW_BLOCKS * block;
        let starts = (0..n).step_by((length / 2).max(1));
        let rows: Vec<Range<usize>> =
            starts.map(|start| start..start + length).filter(|rows| rows.end <= n).collect();
        (block > 1 && rows.len() >= 3).then_some(Self { time_s: &recording.time_s, rows, block })
    }

    /// Scatter of the means of an axis, window by window; 0 if at most `least`, that of white noise, or unknown.
    fn scatters(&self, values: &[f64], least: f64) -> Vec<f64> {
        let of = |rows: &Range<usize>| {
            let mean = |start: usize| {
                if self.time_s[start + self.block - 1] - self.time_s[start] > 1.5 * BLOCK_S {
                    return f64::NAN;
                }
                let known = values[start..start + self.block].iter().filter(|value| value.is_finite());
                let (sum, count) = known.fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
                if 2 * count >= self.block { sum / count as f64 } else { f64::NAN }
            };
            let lasts = |start: usize, blocks: usize| {
                self.time_s[start + blocks * self.block - 1] - self.time_s[start]
            };
            let is_gap = |start: usize| start > rows.start && lasts(start - self.block, 2) > 2.5 * BLOCK_S;
            let mut means: Vec<f64> = Vec::with_capacity(WINDOW_BLOCKS);
            for start in rows.clone().step_by(self.block) {
                // second differences across a gap are unknown
                if is_gap(start) {
                    means.push(f64::NAN);
                }
                means.push(mean(start));
            }
            let Some(slow) = deviation(&means).filter(|slow| *slow > least) else { return 0.0 };
            let Some(fast) = deviation(&values[rows.clone()]) else { return 0.0 };
            let white = fast.powi(2) / self.block as f64;
            if slow.powi(2) > SLOW_OVER_WHITE * white { slow } else { 0.0 }
        };
        self.rows.iter().map(of).collect()
    }
}

/// Standard deviation of noise from its second differences, which are invariant to level and drift; `None` if fewer than
/// half are known.
fn deviation(values: &[f64]) -> Option<f64> {
    let seconds = values.windows(3).map(|of| (of[2] - 2.0 * of[1] + of[0]).abs());
    let known: Vec<f64> = seconds.filter(|second| second.is_finite()).collect();
    if 2 * known.len() < values.len() {
        return None;
    }
    // the second difference of white noise of variance 1 has variance 6
    finite_median(&known).map(|median| MAD_TO_SD * median / 6.0_f64.sqrt())
}

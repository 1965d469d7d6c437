//! Dwells of a hand-turned log: stretches at rest, one orientation each.

use std::ops::Range;

use fos_data::statistics::{median, median_of};
use serde::Serialize;

use crate::imu::{Axes, Imu, Scale};
use crate::quiet::{Windows, quiet, step};
use crate::vector::{angle_deg, distance, unit};

/// Shortest rest between the margins, s.
pub(crate) const SHORTEST_S: f64 = 0.5;

/// Shortest rest including its margins of half a window on either side, s: for messages.
pub(crate) const SHORTEST_WITH_MARGINS_S: f64 = 1.0;

/// Length of a batch, s. Means of batches show noise that is correlated over shorter times than this.
const BATCH_S: f64 = 0.25;

/// Rests one after the other in directions nearer than this are one rest with a knock in it, °.
const SAME_REST_DEG: f64 = 0.5;

/// Length of the pieces into which longer rests are divided, s, so that a change of temperature within a rest is resolved.
const LONGEST_S: f64 = 60.0;

/// Pieces of one rest whose temperatures differ by more than this, K, count as two.
const SAME_TEMPERATURE_K: f64 = 2.0;

/// A rest moves if the means of its halves differ by more standard errors than this, and by more than this share of gravity:
/// 3 mg, a tilt of 0.2°.
const MOVES_ERRORS: f64 = 6.0;
const MOVES_SHARE: f64 = 3e-3;

/// A rest clips where more than this share of its samples lies at the end of the range of an axis.
const CLIPPED_SHARE: f64 = 0.05;

/// Samples in a row at the end of the range of an axis that make a turn clip.
const CLIPPED_IN_A_ROW: usize = 3;

/// Reason to exclude a rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "reason")]
pub enum Exclusion {
    /// The means of its halves differ by this share of gravity.
    Moves { share: f64 },
    /// An axis of the accelerometer, 0 … 2, stays at the end of its range.
    Clips { axis: usize },
    /// |a| differs from gravity by this many standard deviations of the other rests.
    Outlier { deviations: f64 },
}

/// One rest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rest {
    /// Rows without the margins; of a rest with a knock in it, from the first to the last.
    #[serde(skip)]
    pub rows: Range<usize>,
    /// Stretches of these rows that are quiet.
    #[serde(skip)]
    pub(crate) parts: Vec<Range<usize>>,
    /// Start, s, by the time of the log.
    pub start_s: f64,
    /// Seconds at rest.
    pub duration_s: f64,
    /// Mean of the accelerometer, in the unit of the log.
    pub accelerometer: [f64; 3],
    /// Mean of the gyro, in the unit of the log.
    pub gyro: Option<[f64; 3]>,
    /// Mean temperature, °C.
    pub temperature_c: Option<f64>,
    pub excluded: Option<Exclusion>,
}

/// The rests of a log, and the noise of their means.
#[derive(Debug, Clone)]
pub(crate) struct Rests {
    pub(crate) rests: Vec<Rest>,
    /// Variance of the mean of one batch, of each accelerometer axis and each gyro axis.
    accelerometer_batch: [f64; 3],
    gyro_batch: [f64; 3],
    batch_s: f64,
}

impl Rests {
    /// Variance of the accelerometer mean of a rest of the given length, s, by axis, in the unit of the log squared.
    pub(crate) fn accelerometer_variance(&self, seconds: f64) -> [f64; 3] {
        self.accelerometer_batch.map(|batch| batch * self.batch_s / seconds)
    }

    /// The same of the gyro.
    pub(crate) fn gyro_variance(&self, seconds: f64) -> [f64; 3] {
        self.gyro_batch.map(|batch| batch * self.batch_s / seconds)
    }
}

/// Finds the rests where the variance of all axes is below `ratio` times that of the noise, and excludes those that move or
/// clip.
pub(crate) fn find(imu: &Imu, accelerometer: &Axes, windows: &[Windows], ratio: f64) -> Rests {
    let shortest = imu.rows_in(SHORTEST_S, 4);
    let longest = imu.rows_in(LONGEST_S, 8);
    let stretches = quiet(imu, windows, ratio).into_iter().filter(|rows| rows.len() >= shortest);
    let stretches: Vec<Range<usize>> = stretches
        .flat_map(|rows| {
            let pieces = rows.len().div_ceil(longest);
            let cut = move |piece: usize| rows.start + piece * rows.len() / pieces;
            (0..pieces).map(move |piece| cut(piece)..cut(piece + 1))
        })
        .collect();
    let batch = imu.rows_in(BATCH_S, 2);
    let batch_s = batch as f64 * imu.period_s;
    let noise = |axes: &Axes| axes.values.each_ref().map(|values| batch_variance(values, &stretches, batch));
    let accelerometer_batch = noise(accelerometer);
    let gyro_batch = imu.gyro.as_ref().map_or([0.0; 3], noise);
    let means: Vec<[f64; 3]> =
        stretches.iter().map(|rows| mean(accelerometer, std::slice::from_ref(rows))).collect();
    // gravity in the unit of the log: half the range of the means is enough to tell directions apart
    let centre = centre(&means);
    let direction = |raw: &[f64; 3]| unit([0, 1, 2].map(|i| raw[i] - centre[i]));
    let temperatures: Vec<Option<f64>> =
        stretches.iter().map(|rows| temperature(imu, std::slice::from_ref(rows))).collect();
    let segment_of = |row: usize| imu.segments.partition_point(|segment| segment.end <= row);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for index in 0..stretches.len() {
        let same = groups.last().is_some_and(|group| {
            let (first, last) = (group[0], group[group.len() - 1]);
            let kelvin = temperatures[first].zip(temperatures[index]).map_or(0.0, |(a, b)| (a - b).abs());
            angle_deg(&direction(&means[last]), &direction(&means[index])) < SAME_REST_DEG
                && kelvin < SAME_TEMPERATURE_K
                && segment_of(stretches[last].start) == segment_of(stretches[index].start)
        });
        match groups.last_mut() {
            Some(group) if same => group.push(index),
            _ => groups.push(vec![index]),
        }
    }
    let ends = accelerometer.values.each_ref().map(|values| range(values));
    // the accelerometer's windows come first
    let is_coarse = [0, 1, 2].map(|axis| {
        let step = step(&accelerometer.values[axis]);
        windows.get(axis).is_some_and(|windows| windows.noise < step * step)
    });
    let size = median_of(means.iter().map(|mean| distance(*mean, centre)));
    let size = size.unwrap_or(0.0).max(f64::MIN_POSITIVE);
    let rests = groups.into_iter().map(|group| {
        let parts: Vec<Range<usize>> = group.iter().map(|&index| stretches[index].clone()).collect();
        let rows = parts[0].start..parts[parts.len() - 1].end;
        let count: usize = parts.iter().map(Range::len).sum();
        // The bias drifts during a long rest, which is not motion.
        let is_long = count as f64 * imu.period_s > LONGEST_S;
        let moves = if is_long { 0.0 } else { moves(accelerometer, &parts, &accelerometer_batch, batch) };
        let excluded = match (clips(accelerometer, &parts, &ends, &is_coarse), moves / size) {
            (Some(axis), _) => Some(Exclusion::Clips { axis }),
            (None, share) if share.is_finite() && share > MOVES_SHARE => Some(Exclusion::Moves { share }),
            _ => None,
        };
        Rest {
            start_s: imu.time_s[rows.start],
            duration_s: count as f64 * imu.period_s,
            accelerometer: mean(accelerometer, &parts),
            gyro: imu.gyro.as_ref().map(|gyro| mean(gyro, &parts)),
            temperature_c: temperature(imu, &parts),
            excluded,
            rows,
            parts,
        }
    });
    Rests { rests: rests.collect(), accelerometer_batch, gyro_batch, batch_s }
}

/// Median temperature of these rows, °C.
fn temperature(imu: &Imu, parts: &[Range<usize>]) -> Option<f64> {
    let values = imu.temperature_c.as_ref()?;
    let inside = parts.iter().flat_map(|rows| values[rows.clone()].iter().copied());
    median_of(inside.filter(|value| value.is_finite()))
}

/// Mean of each axis over these rows.
pub(crate) fn mean(axes: &Axes, parts: &[Range<usize>]) -> [f64; 3] {
    axes.values.each_ref().map(|values| {
        let inside = || parts.iter().flat_map(|rows| values[rows.clone()].iter()).filter(|v| v.is_finite());
        let count = inside().count().max(1) as f64;
        // about the first value: counts are large
        let origin = inside().next().copied().unwrap_or(0.0);
        origin + inside().map(|value| value - origin).sum::<f64>() / count
    })
}

/// Centre of the values of each axis. For counts on one side of 0 the midrange, which does not depend on the number of rests per
/// orientation; otherwise 0.
fn centre(means: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        let (low, high) = means.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mean| {
            (low.min(mean[axis]), high.max(mean[axis]))
        });
        // an axis that is seen on one side of 0 only has its zero outside the middle; SI values near 0 keep it
        if low.is_finite() && low * high > 0.0 && low.abs().max(high.abs()) > 100.0 {
            0.5 * (low + high)
        } else {
            0.0
        }
    })
}

/// Median variance of batch means about the mean of their stretch, over stretches of at least four batches; of shorter ones
/// where there are no others.
fn batch_variance(values: &[f64], stretches: &[Range<usize>], batch: usize) -> f64 {
    let variance_of = |rows: &Range<usize>| {
        let means: Vec<f64> = rows
            .clone()
            .step_by(batch)
            .filter(|start| start + batch <= rows.end)
            .map(|start| mean_of(&values[start..start + batch]))
            .filter(|mean| mean.is_finite())
            .collect();
        // successive differences: a slow drift within the rest is not noise of its mean
        let squares: Vec<f64> = means.windows(2).map(|pair| 0.5 * (pair[1] - pair[0]).powi(2)).collect();
        (!squares.is_empty()).then(|| squares.iter().sum::<f64>() / squares.len() as f64)
    };
    let mut found: Vec<f64> = stretches.iter().filter_map(variance_of).collect();
    median(&mut found)
}

fn mean_of(values: &[f64]) -> f64 {
    let (sum, count) =
        values.iter().filter(|v| v.is_finite()).fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    sum / count
}

/// Distance between the means of the two halves of a rest; 0 where it is within the noise.
fn moves(axes: &Axes, parts: &[Range<usize>], batch_variance: &[f64; 3], batch: usize) -> f64 {
    let count: usize = parts.iter().map(Range::len).sum();
    let (mut first, mut second, mut taken) = (Vec::new(), Vec::new(), 0);
    for rows in parts {
        let cut = (count / 2).saturating_sub(taken).min(rows.len());
        first.push(rows.start..rows.start + cut);
        second.push(rows.start + cut..rows.end);
        taken += rows.len();
    }
    let (before, after) = (mean(axes, &first), mean(axes, &second));
    let batches = (count as f64 / 2.0 / batch as f64).max(0.5);
    let error: f64 = batch_variance.iter().map(|variance| 2.0 * variance / batches).sum();
    let moved = distance(after, before);
    if moved > MOVES_ERRORS * error.sqrt() { moved } else { 0.0 }
}

/// The smallest and the largest value.
pub(crate) fn range(values: &[f64]) -> [f64; 2] {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

/// A rest does not exceed this on an axis in m/s², 1.5 g: a larger value at the end of the range is a rail.
const SURELY_RAIL_MPS2: f64 = 14.7;

/// The axis that lies at the end of its range: many samples on the extreme, and more than on the value next to it. An axis whose
/// noise is below one step rests on few codes, and one of them is the extreme without clipping.
fn clips(axes: &Axes, parts: &[Range<usize>], ends: &[[f64; 2]; 3], is_coarse: &[bool; 3]) -> Option<usize> {
    (0..3).find(|&axis| {
        let inside = || parts.iter().flat_map(|rows| axes.values[axis][rows.clone()].iter().copied());
        let total = inside().count() as f64;
        let piles_up = |end: f64| {
            let count = |code: f64| inside().filter(|value| *value == code).count();
            let at_end = count(end);
            let distance = |value: &f64| (value - end).abs();
            let others = inside().filter(|value| value.is_finite() && *value != end);
            let next = others.min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let is_rail = axes.scale == Scale::Si && end.abs() > SURELY_RAIL_MPS2;
            at_end as f64 > CLIPPED_SHARE * total
                && (is_rail || (!is_coarse[axis] && next.is_none_or(|code| at_end > count(code))))
        };
        ends[axis][1] > ends[axis][0] && ends[axis].into_iter().any(piles_up)
    })
}

/// True where an axis stays at the end of its range for some samples in these rows. Of a sensor whose values are held for
/// several rows, for as many times longer.
pub(crate) fn has_clipped(axes: &Axes, ends: &[[f64; 2]; 3], rows: &Range<usize>) -> bool {
    axes.values.iter().zip(ends).any(|(values, &[low, high])| {
        let at_end = |value: f64| value == low || value == high;
        let longest = fos_data::recording::runs(rows.clone(), |row| at_end(values[row]))
            .iter()
            .map(Range::len)
            .max()
            .unwrap_or(0);
        let changes = values[rows.clone()].windows(2).filter(|pair| pair[0] != pair[1] && !at_end(pair[0]));
        let held = (rows.len() - longest) / (changes.count() + 1);
        high > low && longest >= CLIPPED_IN_A_ROW * held.max(1)
    })
}

//! True sampling rate, from timestamps with jitter, bursts, pauses and missing samples.

use std::ops::{Range, RangeInclusive};

use super::grid::{Boundary, Grid};
pub(super) use crate::statistics::{MAD_TO_SD, median};

/// Largest share of early timestamps (less than half a period after the previous one) in a log that was stamped sample
/// by sample. Normal jitter with sd 0.3 T gives 12 %, bursts of two samples 50 %.
const EARLY_SHARE: f64 = 0.2;

/// Scatter below which timestamps count as regular, sample periods. Rounding to a tenth of a period gives 0.03.
const REGULAR_SCATTER: f64 = 0.02;

/// Rows per block in which the scatter of timestamps is computed, short enough that no clock wanders in it.
const SCATTER_BLOCK: usize = 64;

/// Longest distance in rows of the first estimate of the period.
const FIRST_REACH: usize = 4096;

/// Minimum interval that may be a pause: longer than a host lets a sensor's buffer fill, s, and a multiple of the usual
/// interval.
const PAUSE_S: f64 = 1.0;
const PAUSE_WAITS: f64 = 10.0;

/// Minimum duration of the rows between two pauses, s. A host reads a full buffer faster: 128 samples over a bus of
/// 400 kHz take 50 ms.
const BETWEEN_PAUSES_S: f64 = 0.2;

/// Minimum ratio of the mean period to that between pauses; below it pauses have no influence.
const PAUSED: f64 = 1.5;

/// Largest relative deviation from the median of a slope within a burst; beyond it timestamps are wrong.
const USUAL_SLOPE: f64 = 0.1;

/// Plausible sampling rates of a sensor, Hz: beyond them the timestamps are in another unit.
pub const RATES_HZ: RangeInclusive<f64> = 0.01..=1e6;

/// Sampling rate of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Rate {
    /// Rate stated by the user or a case's `meta.json`, Hz.
    pub nominal_hz: Option<f64>,
    /// Measured rate, 1/`period_s`, Hz.
    pub true_hz: f64,
    /// Slope of timestamp against sample count, missing samples included: median over pairs of rows half the longest
    /// unbroken stretch apart (after Theil 1950, Sen 1968), s. Of a duty-cycled log the mean of the slopes within a
    /// tenth of it.
    pub period_s: f64,
    /// Scatter of the timestamps about the regular grid: 1.4826 × the median absolute deviation within blocks of 64
    /// rows, s.
    pub jitter_s: f64,
    /// Arrangement of the timestamps on the grid.
    pub stamps: Stamps,
}

/// Arrangement of timestamps on the regular sample grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stamps {
    /// Scatter below 2 % of the period.
    Regular,
    /// Stamped sample by sample, with jitter.
    Jittered,
    /// Stamped in bursts, as by a host that polls or by a clock with coarse ticks: late, never early.
    Bursts,
    /// No timestamps: times are the row number over the stated rate.
    Absent,
}

/// First estimates from timestamps, sufficient to look for gaps.
#[derive(Clone, Debug)]
pub(super) struct FirstLook {
    /// Sample period, s.
    pub(super) period_s: f64,
    /// `Regular` or `Bursts`, or `Jittered`.
    pub(super) stamps: Stamps,
    /// Scatter of single timestamps, sample periods.
    pub(super) scatter: f64,
    /// Mean number of rows from one long interval to the next.
    pub(super) burst_rows: f64,
    /// First rows after the pauses of a duty-cycled log.
    pub(super) after_pauses: Vec<usize>,
}

/// Estimates the period before the gaps are known; `None` if time does not run forward.
///
/// Long intervals between short ones come from a host that polls, or from pauses of a duty-cycled log (5 s of every
/// 300 s): the rate is the mean of all rows, or that between the pauses. The rows between two pauses last some time;
/// those that a host reads at once do not. A stated rate equal to the mean shows that the host polls.
pub(super) fn first_look(time_s: &[f64], nominal_hz: Option<f64>) -> Option<FirstLook> {
    let whole = look_over(time_s, std::slice::from_ref(&(0..time_s.len())), nominal_hz)?;
    if whole.stamps != Stamps::Bursts || is_nominal(whole.period_s, nominal_hz) {
        return Some(whole);
    }
    let after_pauses = after_pauses(time_s);
    let between = stretches(time_s.len(), &after_pauses);
    let lasts = |rows: &&Range<usize>| time_s[rows.end - 1] - time_s[rows.start] >= BETWEEN_PAUSES_S;
    let lasting: usize = between.iter().filter(lasts).map(|rows| rows.len()).sum();
    let paused = match 2 * lasting > time_s.len() {
        true => look_over(time_s, &between, nominal_hz),
        false => None,
    };
    match paused.filter(|look| whole.period_s > PAUSED * look.period_s) {
        Some(look) => Some(FirstLook { after_pauses, ..look }),
        None => Some(whole),
    }
}

/// Rows before which the log may have paused.
fn after_pauses(time_s: &[f64]) -> Vec<usize> {
    let wait = |row: usize| time_s[row] - time_s[row - 1];
    let usual = median(&mut (1..time_s.len()).map(wait).collect::<Vec<_>>());
    let least = PAUSE_S.max(PAUSE_WAITS * usual);
    (1..time_s.len()).filter(|row| wait(*row) >= least).collect()
}

/// Splits `n` rows before each of `cuts`.
fn stretches(n: usize, cuts: &[usize]) -> Vec<Range<usize>> {
    let begins = std::iter::once(0).chain(cuts.iter().copied());
    let ends = cuts.iter().copied().chain([n]);
    begins.zip(ends).map(|(begin, end)| begin..end).collect()
}

/// Length of a stretch such that half of all rows lie in shorter ones.
fn usual_length(stretches: &[Range<usize>]) -> usize {
    let mut lengths: Vec<usize> = stretches.iter().map(|rows| rows.len()).collect();
    lengths.sort_unstable();
    let half = lengths.iter().sum::<usize>() / 2;
    let mut shorter = 0;
    let reaches_half = |length: &&usize| {
        shorter += **length;
        shorter >= half
    };
    lengths.iter().find(reaches_half).copied().unwrap_or(0)
}

fn is_nominal(period_s: f64, nominal_hz: Option<f64>) -> bool {
    nominal_hz.is_some_and(|hz| (period_s * hz - 1.0).abs() < 0.2)
}

/// First estimates from stretches of rows, without comparing rows of different stretches.
fn look_over(time_s: &[f64], stretches: &[Range<usize>], nominal_hz: Option<f64>) -> Option<FirstLook> {
    let rows = usual_length(stretches);
    let waits: Vec<f64> = stretches
        .iter()
        .flat_map(|rows| time_s[rows.clone()].windows(2).map(|pair| pair[1] - pair[0]))
        .collect();
    let typical_wait = median(&mut waits.clone());

    // over many rows bursts and coarse timestamps average out; missing samples lengthen it
    let reach = (rows / 4).clamp(1, FIRST_REACH);
    let mut slopes: Vec<f64> = stretches
        .iter()
        .flat_map(|rows| rows.start + reach..rows.end)
        .map(|i| (time_s[i] - time_s[i - reach]) / reach as f64)
        .collect();
    let far = median(&mut slopes);
    if !(far > 0.0 && far.is_finite()) {
        return None;
    }
    let share = |count: usize| count as f64 / waits.len() as f64;
    let early = share(waits.iter().filter(|&&wait| wait < 0.5 * far).count());

    // the mean of the usual intervals, not their median: timestamps in whole milliseconds
    let usual: Vec<f64> = waits
        .iter()
        .copied()
        .filter(|wait| (wait - typical_wait).abs() <= 0.5 * typical_wait.abs())
        .collect();
    let near = usual.iter().sum::<f64>() / usual.len().max(1) as f64;
    let near = if near.is_finite() { near } else { 0.0 };

    let after_pauses = Vec::new();
    // alternating intervals of one and two ticks may be loss or a coarse clock: only the stated rate distinguishes them
    let coarse = is_nominal(far, nominal_hz) && !is_nominal(near, nominal_hz);
    if early > EARLY_SHARE || near <= 0.0 || coarse {
        let long = share(waits.iter().filter(|&&wait| wait > 1.5 * far).count());
        let burst_rows = 1.0 / long.max(1e-9);
        let stamps = Stamps::Bursts;
        return Some(FirstLook { period_s: far, stamps, scatter: 0.0, burst_rows, after_pauses });
    }
    let mut deviations: Vec<f64> = waits.iter().map(|wait| (wait - typical_wait).abs()).collect();
    // the interval between two timestamps scatters by √2 as much as a timestamp
    let scatter = MAD_TO_SD * median(&mut deviations) / near / std::f64::consts::SQRT_2;
    Some(FirstLook { period_s: near, stamps: Stamps::Jittered, scatter, burst_rows: 1.0, after_pauses })
}

/// Slope of time against ticks of the grid; `None` if no two rows can be compared.
pub(super) fn slope(time_s: &[f64], grid: &Grid) -> Option<f64> {
    let stretches = grid.unbroken();
    let longest = stretches.iter().map(|rows| rows.len()).max()?;
    let reach = (longest / 2).max(1);
    let ticks = grid.ticks();
    let mut slopes: Vec<f64> = stretches
        .into_iter()
        .flat_map(|rows| rows.start + reach..rows.end.max(rows.start + reach))
        .map(|i| (time_s[i] - time_s[i - reach]) / (ticks[i] - ticks[i - reach]) as f64)
        .collect();
    if slopes.is_empty() {
        return None;
    }
    let mut slope = median(&mut slopes);
    if grid.segments.iter().any(|segment| segment.boundary == Boundary::Pause) {
        // in a burst, timestamps in ticks or from polls give only a few distinct slopes: take their mean, not the most
        // usual
        slopes.retain(|other| (other / slope - 1.0).abs() < USUAL_SLOPE);
        slope = slopes.iter().sum::<f64>() / slopes.len() as f64;
    }
    Some(slope).filter(|slope| *slope > 0.0 && slope.is_finite())
}

/// Scatter of the timestamps about the grid, s.
pub(super) fn jitter(time_s: &[f64], grid: &Grid, period_s: f64) -> f64 {
    let ticks = grid.ticks();
    let mut deviations = Vec::with_capacity(time_s.len());
    for rows in grid.unbroken() {
        // from the stretch's own start, so that large numbers cancel before they are scaled
        let start = rows.start;
        let late = |i: usize| (time_s[i] - time_s[start]) - period_s * (ticks[i] - ticks[start]) as f64;
        for block in rows.clone().step_by(SCATTER_BLOCK) {
            let end = (block + SCATTER_BLOCK).min(rows.end);
            let mut block: Vec<f64> = (block..end).map(late).collect();
            let level = median(&mut block);
            deviations.extend(block.iter().map(|late| (late - level).abs()));
        }
    }
    MAD_TO_SD * median(&mut deviations)
}

/// Classifies jittered timestamps as regular by their scatter.
pub(super) fn classify_timestamps(first: Stamps, jitter_s: f64, period_s: f64) -> Stamps {
    match first {
        Stamps::Jittered if jitter_s < REGULAR_SCATTER * period_s => Stamps::Regular,
        other => other,
    }
}

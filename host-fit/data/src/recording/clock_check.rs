//! Detects timestamps that cannot be the time at which their rows were sampled.

use std::fmt;

use super::channel::Channel;
use super::grid::Segment;
use crate::statistics::median_of;
use crate::unit::Unit;

/// Fastest change of a thermometer in or next to a MEMS sensor, K/s. A package of 3 × 3 × 1 mm holds 0.02 J/K: 5 K/s
/// take 0.1 W, ten times the power of an inertial sensor, and a board or a chamber is far slower.
const FASTEST_K_PER_S: f64 = 5.0;

/// Shortest duration of a change, s, and minimum number of rows: failed reads and noise are shorter.
const BLOCK_S: f64 = 0.25;
const BLOCK_ROWS: usize = 8;

/// Number of consecutive blocks with such a fast change in one direction, and their minimum total, K.
const BLOCKS: usize = 3;
const MIN_K: f64 = 10.0;

/// Share of repeated timestamps from which the clock ticks slower than the sensor samples.
const REPEATED: f64 = 0.1;

/// Smallest timestamp, in the unit of its column, with more digits than a spreadsheet keeps.
const MANY_DIGITS: f64 = 1e15;

/// Rounding of timestamps that matters, as a share of the sampling period.
const ROUNDING_MATTERS: f64 = 1e-3;

/// Reason why the timestamps of a log are not the time of its samples.
#[derive(Clone, Debug, PartialEq)]
pub enum ClockProblem {
    /// A stated rate replaces the timestamps.
    Overridden {
        column: String,
        /// Rate by the timestamps, Hz; `None` if they determine none.
        stamped_hz: Option<f64>,
        rate_hz: f64,
    },
    /// A thermometer changes faster than any part can warm or cool.
    TooFast {
        column: String,
        /// Column of the thermometer, such as `temp_c`.
        thermometer: String,
        /// Its fastest change, K.
        kelvin: f64,
        /// Duration of the change by the timestamps, s.
        seconds: f64,
    },
    /// All timestamps end in zeros, as after rounding by a spreadsheet.
    Rounded {
        column: String,
        /// Common divisor of the timestamps, s.
        step_s: f64,
    },
    /// Many rows repeat the timestamp before them.
    Repeated {
        column: String,
        /// Share of the rows.
        share: f64,
    },
}

impl ClockProblem {
    /// Returns true if a stated rate replaces such timestamps even if the two agree.
    pub(super) fn discredits_stamps(&self) -> bool {
        matches!(self, Self::TooFast { .. } | Self::Rounded { .. })
    }
}

impl fmt::Display for ClockProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Overridden { column, stamped_hz, rate_hz } => {
                let stamped = stamped_hz.map_or_else(|| "no rate".to_owned(), |hz| format!("{hz:.4} Hz"));
                write!(
                    f,
                    "the stated rate of {rate_hz} Hz replaces the timestamps (column \"{column}\"), which show {stamped}: rows count in their order, and gaps between the timestamps still end segments. If the timestamps are right, omit `rate_hz`; if they are in another unit, name it in the column map, as in t_s={column}:ms"
                )
            }
            Self::TooFast { column, thermometer, kelvin, seconds } => write!(
                f,
                "{thermometer} moves by {kelvin:.1} K within {seconds:.2} s, {:.0} K/s: a sensor warms by less than {FASTEST_K_PER_S} K/s, so that the timestamps (column \"{column}\") are not time. State the true rate of the rows as `rate_hz`; rows then count in their order",
                kelvin.abs() / seconds
            ),
            Self::Rounded { column, step_s } => write!(
                f,
                "the timestamps (column \"{column}\") are multiples of {} µs: a spreadsheet rounded them, as 1.40364E+18. Read the file that it was made of, or state the rate of the rows as `rate_hz`",
                1e6 * step_s
            ),
            Self::Repeated { column, share } => write!(
                f,
                "{:.0} % of the rows repeat the time stamp before them (column \"{column}\"): the clock ticks slower than the sensor samples. The rate is that of all rows together; record with a finer clock",
                100.0 * share
            ),
        }
    }
}

/// Reasons against the timestamps of a log. `column` is their column, `rounded_to_s` the result of [`rounded`], s.
pub(super) fn problems(
    column: &str,
    time_s: &[f64],
    rounded_to_s: Option<f64>,
    segments: &[Segment],
    period_s: f64,
    channels: &[Channel],
) -> Vec<ClockProblem> {
    let column = || column.to_owned();
    let thermometers = channels.iter().filter(|channel| channel.unit == Unit::Celsius);
    let fastest = |channel: &Channel| {
        let of_segment = |segment: &Segment| {
            let rows = segment.rows.clone();
            fastest(&time_s[rows.clone()], &channel.values[rows], period_s)
        };
        let (kelvin, seconds) = segments
            .iter()
            .filter_map(of_segment)
            .max_by(|one, other| one.0.abs().total_cmp(&other.0.abs()))?;
        let thermometer = channel.name.clone();
        Some(ClockProblem::TooFast { column: column(), thermometer, kelvin, seconds })
    };
    let mut found: Vec<ClockProblem> = thermometers.filter_map(fastest).take(1).collect();
    if let Some(step_s) = rounded_to_s.filter(|step_s| *step_s >= ROUNDING_MATTERS * period_s) {
        found.push(ClockProblem::Rounded { column: column(), step_s });
    }
    let repeated = time_s.windows(2).filter(|pair| pair[0] == pair[1]).count();
    let share = repeated as f64 / time_s.len().max(1) as f64;
    if share > REPEATED {
        found.push(ClockProblem::Repeated { column: column(), share });
    }
    found
}

/// Largest change of a thermometer that is too fast, K, and its duration, s.
fn fastest(time_s: &[f64], celsius: &[f64], period_s: f64) -> Option<(f64, f64)> {
    if !(period_s > 0.0 && period_s.is_finite()) {
        return None;
    }
    let rows = ((BLOCK_S / period_s).ceil() as usize).max(BLOCK_ROWS);
    let blocks = time_s.chunks(rows).zip(celsius.chunks(rows)).filter(|(times, _)| times.len() == rows);
    let blocks: Vec<(f64, f64)> = blocks
        .filter_map(|(times, celsius)| {
            let celsius = median_of(celsius.iter().copied().filter(|value| value.is_finite()))?;
            Some((times[0], celsius))
        })
        .collect();
    let too_fast = |pair: &[(f64, f64)]| -> f64 {
        let (kelvin, seconds) = (pair[1].1 - pair[0].1, pair[1].0 - pair[0].0);
        if seconds > 0.0 && kelvin.abs() > FASTEST_K_PER_S * seconds { kelvin.signum() } else { 0.0 }
    };
    let ways: Vec<f64> = blocks.windows(2).map(too_fast).collect();
    let mut most: Option<(f64, f64)> = None;
    let mut from = 0;
    while from < ways.len() {
        let run = ways[from..].iter().take_while(|way| **way == ways[from]).count();
        let (first, last) = (blocks[from], blocks[from + run]);
        let moved = (last.1 - first.1, last.0 - first.0);
        if ways[from] != 0.0
            && run >= BLOCKS
            && moved.0.abs() >= MIN_K
            && most.is_none_or(|most| moved.0.abs() > most.0.abs())
        {
            most = Some(moved);
        }
        from += run;
    }
    most
}

/// Power of ten that divides all timestamps, if they had more digits than a spreadsheet keeps. `None` for evenly spaced
/// timestamps that are whole numbers of a coarser unit, such as the milliseconds of a clock.
pub(super) fn rounded(stamps: &[f64]) -> Option<f64> {
    let finite = stamps.iter().copied().filter(|stamp| stamp.is_finite());
    // a remark below the timestamps is not one of them
    let (many, few): (Vec<f64>, Vec<f64>) = finite.partition(|stamp| stamp.abs() >= MANY_DIGITS);
    if few.len() * 100 > many.len() {
        return None;
    }
    let smallest = many.iter().map(|stamp| stamp.abs()).reduce(f64::min)?;
    let is_multiple = |stamp: f64, step: f64| {
        let nearest = (stamp / step).round() * step;
        (stamp - nearest).abs() <= 2.0 * f64::EPSILON * stamp.abs()
    };
    // 15 digits are kept
    let least = 10_f64.powi(smallest.log10().floor() as i32 - 14);
    if !many.iter().all(|stamp| is_multiple(*stamp, least)) {
        return None;
    }
    let steps: Vec<f64> = many.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = median_of(steps.iter().copied().filter(|step| step.is_finite()))?;
    let resolution = 2.0 * f64::EPSILON * smallest;
    let is_even = steps.iter().all(|step| (step - usual).abs() <= resolution);
    // evenly spaced whole milliseconds are a clock's own; an even grid that is rounded to 10 µs has other digits
    let is_coarser = many.iter().all(|stamp| is_multiple(*stamp, 100.0 * least));
    (!(is_even && is_coarser)).then_some(least).filter(|step| *step > 4.0 * resolution)
}

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, LogWarning, Recording, Source};
    use super::*;

    fn recording(time_s: Vec<f64>, celsius: Vec<f64>, rate_hz: Option<f64>) -> Recording {
        let rates = (0..time_s.len()).map(|row| 1e-3 * (row % 7) as f64).collect();
        let columns =
            [("t_s", time_s), ("gx_rads", rates), ("temp_c", celsius)].map(|(name, v)| (name.to_owned(), v));
        let options = LoadOptions { rate_hz, ..LoadOptions::default() };
        Recording::from_columns(Source::made_by("test"), columns.into(), &options).unwrap()
    }

    fn clock_warnings(log: &Recording) -> Vec<String> {
        let odd = log.warnings(&vec![true; log.n_rows()]).into_iter();
        odd.filter(|odd| matches!(odd, LogWarning::Clock(_))).map(|odd| odd.to_string()).collect()
    }

    #[test]
    fn warns_of_impossibly_fast_temperature_changes() {
        let stamps = |period: f64| (0..8000).map(|row| f64::from(row) * period).collect::<Vec<_>>();
        let chamber = || (0..8000).map(|row| 50.0 - f64::from(row) * 0.01).collect::<Vec<_>>();
        let warnings = clock_warnings(&recording(stamps(5e-4), chamber(), None));
        assert!(
            warnings.len() == 1
                && warnings[0].contains("temp_c moves by -")
                && warnings[0].contains("`rate_hz`"),
            "{warnings:?}"
        );
        // the same at its true rate
        assert!(clock_warnings(&recording(stamps(0.5), chamber(), None)).is_empty());
        // self-heating, noise, a step of another thermometer, and a failed read of many rows
        let heating = (0..8000).map(|row| 25.0 + 8.0 * (1.0 - (-f64::from(row) / 4000.0).exp())).collect();
        let noisy = (0..8000).map(|row| 25.0 + f64::from(row * 7919 % 101) * 0.1).collect();
        let steps = (0..8000).map(|row| if row / 1000 % 2 == 0 { 25.0 } else { 60.0 }).collect();
        for celsius in [heating, noisy, steps] {
            assert!(clock_warnings(&recording(stamps(5e-3), celsius, None)).is_empty());
        }
    }

    #[test]
    fn stated_rate_replaces_contradicting_timestamps_with_a_warning() {
        let stamps: Vec<f64> = (0..2000).map(|row| f64::from(row) * 5e-4).collect();
        let warm = vec![25.5; 2000];
        let log = recording(stamps.clone(), warm.clone(), Some(2.0));
        assert_eq!((log.rate.true_hz, log.time_s[10], log.n_rows()), (2.0, 5.0, 2000));
        let warnings = clock_warnings(&log);
        assert!(
            warnings[0].contains("2 Hz replaces") && warnings[0].contains("2000.0000 Hz"),
            "{warnings:?}"
        );
        // if the timestamps agree it is the nominal rate, as before
        let log = recording(stamps, warm.clone(), Some(1990.0));
        assert!((log.rate.true_hz - 2000.0).abs() < 1e-6 && clock_warnings(&log).is_empty());
        // and without a rate in the timestamps it is the only one
        let log = recording(vec![1.0; 2000], warm, Some(100.0));
        assert_eq!(log.rate.true_hz, 100.0);
        assert!(clock_warnings(&log)[0].contains("which show no rate"));
    }

    #[test]
    fn finds_the_rounding_of_a_spreadsheet() {
        let sampled: Vec<f64> =
            (0..500).map(|row| 1_403_636_579_758_555_392.0 + f64::from(row) * 5_000_192.0).collect();
        assert_eq!(rounded(&sampled), None);
        let mangled: Vec<f64> = sampled.iter().map(|ns| (ns / 1e4).round() * 1e4).collect();
        assert_eq!(rounded(&mangled), Some(1e4));
        // with a remark of the spreadsheet below
        assert_eq!(rounded(&[mangled, vec![200.0]].concat()), Some(1e4));
        // an even grid, rounded
        let even: Vec<f64> = (0..500).map(|row| 1_403_636_579_758_560_000.0 + f64::from(row) * 5e6).collect();
        assert_eq!(rounded(&even), Some(1e4));
        // an even grid of milliseconds, and a clock in s
        assert_eq!(rounded(&(0..500).map(|row| 1.4e18 + f64::from(row) * 5e6).collect::<Vec<_>>()), None);
        assert_eq!(rounded(&(0..500).map(|row| f64::from(row) * 0.01).collect::<Vec<_>>()), None);
        assert_eq!(rounded(&[]), None);
    }
}

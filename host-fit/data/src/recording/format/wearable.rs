//! Common parts of the loggers of wearable devices: blocks of samples, each with one time and one temperature.

use std::path::Path;

use super::super::error::RecordingError;
use super::super::load_options::LoadOptions;
use super::super::provenance::Provenance;
use super::super::stream::Stream;
use super::opened::Opened;
use super::{Format, ReadAs, choice};
use crate::column::{ACCELEROMETERS, GYROS, Triad};

/// A block whose successor begins later than this, as a multiple of its own duration, is followed by a gap.
const GAP: f64 = 1.1;

/// Sampling rates of such loggers, Hz.
const RATES_HZ: std::ops::RangeInclusive<f64> = 0.1..=10_000.0;

/// Samples of a log as they are read, block by block.
#[derive(Default)]
pub(super) struct Blocks {
    /// Start and sampling period of each block, ns; its number of samples; its temperature, °C (NaN: none).
    blocks: Vec<(i64, f64, usize, f64)>,
    /// Acceleration, m/s².
    acceleration: [Vec<f64>; 3],
    /// Angular rate, rad/s; empty in a log without gyro.
    rate: [Vec<f64>; 3],
    /// Number of blocks that cannot be read.
    pub(super) damaged: u64,
}

impl Blocks {
    /// Appends one sample of the block that is being read.
    pub(super) fn push(&mut self, acceleration: Option<[f64; 3]>, rate: Option<[f64; 3]>) {
        for (columns, values) in [(&mut self.acceleration, acceleration), (&mut self.rate, rate)] {
            let Some(values) = values else { continue };
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
    }

    /// Presence of a gyro in the blocks so far; `None` before the first.
    pub(super) fn has_gyro(&self) -> Option<bool> {
        (!self.blocks.is_empty()).then(|| !self.rate[0].is_empty())
    }

    /// Ends a block of `samples` samples that begins at `start_ns`.
    pub(super) fn end(&mut self, start_ns: i64, rate_hz: f64, samples: usize, celsius: f64) {
        self.blocks.push((start_ns, 1e9 / rate_hz, samples, celsius));
    }

    /// Converts the log to streams. `assumed` describes the conversion of the values.
    pub(super) fn opened(
        self,
        path: &Path,
        format: Format,
        options: &LoadOptions,
        assumed: &str,
        mut provenance: Provenance,
    ) -> Result<Opened, RecordingError> {
        let Self { blocks, acceleration, rate, damaged } = self;
        let problem = (damaged > 0).then(|| format!("{damaged} blocks cannot be read"));
        choice::refuse_damage(path, format, options.strict, problem.as_deref(), 0)?;
        let stamps_ns = stamps(&blocks);
        if stamps_ns.len() < 2 {
            return Err(choice::no_sensors(
                path,
                format,
                format!(
                    "there are {} samples in it, and {damaged} blocks that cannot be read",
                    stamps_ns.len()
                ),
                "copy the file from the device again, or record again",
            ));
        }
        let has = |columns: &[Vec<f64>; 3]| columns[0].len() == stamps_ns.len();
        let triads = [(ACCELEROMETERS, acceleration), (GYROS, rate)];
        let columns = triads.into_iter().filter(|(_, columns)| has(columns));
        let columns = columns.flat_map(|(names, columns)| names.map(str::to_owned).into_iter().zip(columns));
        let columns: Vec<(String, Vec<f64>)> = columns.collect();
        let has_gyro = columns.iter().any(|(name, _)| name == GYROS[0]);
        let name = if has_gyro { "accelerometer and gyro" } else { "accelerometer" };
        let mut streams = vec![Stream { name: name.to_owned(), stamps_ns, columns }];
        let warm = blocks.iter().filter(|(.., celsius)| celsius.is_finite());
        let (at, celsius): (Vec<i64>, Vec<f64>) =
            warm.map(|(start, _, _, celsius)| (*start, *celsius)).unzip();
        if at.len() > 1 {
            let columns = vec![("temp_c".to_owned(), celsius)];
            streams.push(Stream { name: "temperature of each block".to_owned(), stamps_ns: at, columns });
        }
        if !has_gyro {
            provenance.forget(Triad::Gyros);
        }
        let gyro = if has_gyro { "" } else { "; it has no gyro" };
        let lost = if damaged > 0 { format!("; {damaged} blocks cannot be read") } else { String::new() };
        let assumed = format!("{assumed}{gyro}; one temperature for each block, held until the next{lost}");
        Ok(Opened::Streams(streams, ReadAs { format, assumed, provenance: Some(provenance) }))
    }
}

/// Returns true for a plausible sampling rate of a logger.
pub(super) fn is_rate(rate_hz: f64) -> bool {
    RATES_HZ.contains(&rate_hz)
}

/// Timestamps of all samples: evenly from the start of a block to that of the next, at the nominal rate before a gap.
fn stamps(blocks: &[(i64, f64, usize, f64)]) -> Vec<i64> {
    let mut stamps = Vec::new();
    for (at, (start, period, samples, _)) in blocks.iter().enumerate() {
        let to_next = blocks.get(at + 1).map(|(next, ..)| next.saturating_sub(*start) as f64);
        let nominal = period * *samples as f64;
        let step = match to_next {
            Some(to_next) if to_next > 0.0 && to_next <= GAP * nominal => to_next / *samples as f64,
            _ => *period,
        };
        stamps
            .extend((0..*samples).map(|sample| start.saturating_add((step * sample as f64).round() as i64)));
    }
    stamps
}

/// Nanoseconds since 1970 of a date and a time of day by the logger's own clock; `None` for an impossible one.
pub(super) fn ns_since_1970([year, month, day]: [i64; 3], [hour, minute, second]: [i64; 3]) -> Option<i64> {
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let days = match month {
        2 => 28 + i64::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    };
    let is_date = (1970..2200).contains(&year) && (1..=12).contains(&month) && (1..=days).contains(&day);
    let is_time = (0..24).contains(&hour) && (0..60).contains(&minute) && (0..=60).contains(&second);
    if !(is_date && is_time) {
        return None;
    }
    // years that begin in March have their leap day at the end
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let days = 365 * year + year / 4 - year / 100 + year / 400 + (153 * month + 2) / 5 + day - 1 - 719_468;
    (((days * 24 + hour) * 60 + minute) * 60 + second).checked_mul(1_000_000_000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_the_seconds_of_the_calendar() {
        assert_eq!(ns_since_1970([1970, 1, 1], [0, 0, 0]), Some(0));
        // `date -u -d '2000-03-01 00:00:00' +%s`, and one past a leap day in 2024
        assert_eq!(ns_since_1970([2000, 3, 1], [0, 0, 0]), Some(951_868_800 * 1_000_000_000));
        assert_eq!(ns_since_1970([2024, 2, 29], [23, 59, 59]), Some(1_709_251_199 * 1_000_000_000));
        for wrong in [
            [2024, 13, 1],
            [2024, 0, 1],
            [0, 1, 1],
            [2024, 1, 0],
            [2023, 2, 29],
            [2100, 2, 29],
            [2024, 4, 31],
        ] {
            assert_eq!(ns_since_1970(wrong, [0, 0, 0]), None);
        }
        assert_eq!(ns_since_1970([2024, 1, 1], [24, 0, 0]), None);
    }

    #[test]
    fn spreads_samples_to_the_start_of_the_next_block_and_leaves_gaps() {
        let block = |start| (start, 10.0, 4, f64::NAN);
        // a clock that runs 5 % fast, then a pause, then a clock that was set back
        let found = stamps(&[block(0), block(42), block(1000), block(500)]);
        assert_eq!(found[..5], [0, 11, 21, 32, 42]);
        assert_eq!(found[5..8], [52, 62, 72]);
        assert_eq!(found[8..], [1000, 1010, 1020, 1030, 500, 510, 520, 530]);
    }
}

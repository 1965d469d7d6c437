//! Failed reads of a thermometer: placeholder values that a driver logs in their place.

use super::channel::Channel;
use crate::unit::Unit;

/// Placeholders logged for a failed read, °C: a register of zeros, the power-on value of a DS18B20, the value that its
/// libraries return when it does not answer, absolute zero as converted or rounded.
const PLACEHOLDERS_C: [f64; 5] = [0.0, 85.0, -127.0, -273.0, -273.15];

/// Tolerance for a match with a placeholder, °C: a conversion from kelvin or °F rounds.
const TOLERANCE_C: f64 = 1e-9;

/// Minimum jump from one reading to the next and back, K: no thermometer read more than once a second changes so fast.
const JUMP_K: f64 = 5.0;

/// Minimum number of rows for discarding a thermometer that shows placeholders throughout.
const MIN_ROWS: usize = 20;

/// Failed reads of a thermometer, treated as empty cells.
#[derive(Clone, Debug, PartialEq)]
pub struct FailedReads {
    /// Column in the log format, such as `temp_c`.
    pub column: String,
    /// Number of rows with a failed read.
    pub rows: u64,
    /// Share of the rows with a value that are failed reads.
    pub share: f64,
    /// Placeholder values found, °C, in ascending order.
    pub said: Vec<f64>,
}

impl FailedReads {
    /// Returns true if every reading of this column failed, so that the column is excluded.
    pub(super) fn covers_column(&self, column: &str) -> bool {
        self.column == column && self.share >= 1.0
    }
}

/// Empties the cells of a thermometer that hold a placeholder of a failed read, if the readings before and after are far
/// from it, on the same side: a log that passes through 0 °C, or stays there, keeps its values.
pub(super) fn take_out(channel: &mut Channel) -> Option<FailedReads> {
    if channel.unit != Unit::Celsius {
        return None;
    }
    let values = channel.values.clone();
    let placeholder_at =
        |row: usize| PLACEHOLDERS_C.into_iter().find(|said| (values[row] - said).abs() < TOLERANCE_C);
    let known: Vec<usize> = (0..values.len()).filter(|row| !values[*row].is_nan()).collect();
    // a working thermometer shows its own noise, and never a placeholder in every row
    if known.len() >= MIN_ROWS && known.iter().all(|row| placeholder_at(*row).is_some()) {
        let mut said: Vec<f64> = known.iter().filter_map(|row| placeholder_at(*row)).collect();
        said.sort_unstable_by(f64::total_cmp);
        said.dedup();
        channel.values = vec![f64::NAN; values.len()].into();
        return Some(FailedReads {
            column: channel.name.clone(),
            rows: known.len() as u64,
            share: 1.0,
            said,
        });
    }
    let mut failed: Vec<usize> = Vec::new();
    let mut said = Vec::new();
    let mut last_good = None;
    let mut at = 0;
    while at < known.len() {
        let Some(value) = placeholder_at(known[at]) else {
            last_good = Some(values[known[at]]);
            at += 1;
            continue;
        };
        let run = known[at..].iter().take_while(|row| placeholder_at(**row).is_some()).count();
        let next_good = known.get(at + run).map(|row| values[*row]);
        let runs = known[at..at + run].iter().map(|row| values[*row]);
        let is_failed = match (last_good, next_good) {
            (None, None) => false,
            (Some(beside), None) | (None, Some(beside)) => runs.clone().all(|v| (beside - v).abs() > JUMP_K),
            (Some(before), Some(after)) => runs.clone().all(|v| {
                let (before, after) = (before - v, after - v);
                before * after > 0.0 && before.abs().min(after.abs()) > JUMP_K
            }),
        };
        if is_failed {
            failed.extend(&known[at..at + run]);
            said.extend(runs);
        } else {
            last_good = Some(value);
        }
        at += run;
    }
    if failed.is_empty() || 2 * failed.len() > known.len() {
        return None;
    }
    let mut emptied = values.to_vec();
    failed.iter().for_each(|row| emptied[*row] = f64::NAN);
    channel.values = emptied.into();
    said.sort_unstable_by(f64::total_cmp);
    said.dedup();
    let (rows, share) = (failed.len() as u64, failed.len() as f64 / known.len() as f64);
    Some(FailedReads { column: channel.name.clone(), rows, share, said })
}

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, LogWarning, Recording, Source};

    fn recording(column: &str, values: Vec<f64>) -> Recording {
        let columns = vec![(column.to_owned(), values)];
        let options = LoadOptions { rate_hz: Some(100.0), ..LoadOptions::default() };
        Recording::from_columns(Source::made_by("test"), columns, &options).unwrap()
    }

    /// Ramp of 1 K/s at 100 Hz, starting at `from` °C.
    fn warming(from: f64) -> Vec<f64> {
        (0..2000).map(|row| from + 0.01 * f64::from(row)).collect()
    }

    #[test]
    fn failed_reads_become_empty_cells_with_one_warning() {
        let mut values = warming(20.0);
        values[0] = 85.0;
        values[700] = 0.0;
        values[900..950].fill(-273.15);
        values[950] = 0.0;
        values[1999] = -127.0;
        let log = recording("temp_c", values);
        let channel = log.channel("temp_c").unwrap();
        assert_eq!(channel.n_missing(), 54);
        assert!([0, 700, 920, 950, 1999].iter().all(|row| channel.values[*row].is_nan()));
        let held = log.held_from_first(channel);
        assert!(held.iter().enumerate().all(|(row, t)| (t - 20.0 - 0.01 * row as f64).abs() < 0.6));
        let warnings = log.warnings(&[true; 2000]);
        let [LogWarning::FailedReads(failed)] = &warnings[..] else { panic!("{warnings:?}") };
        assert_eq!((failed.rows, &failed.said[..]), (54, &[-273.15, -127.0, 0.0, 85.0][..]));
        let text = warnings[0].to_string();
        assert!(text.contains("temp_c") && text.contains("54") && text.contains("-273.15"), "{text}");
    }

    #[test]
    fn excludes_a_thermometer_that_shows_only_zeros() {
        let log = recording("temp_c", vec![0.0; 2000]);
        assert!(log.channel("temp_c").is_err());
        let text = log.warnings(&[true; 2000])[0].to_string();
        assert!(text.contains("temp_c is exactly 0 °C in every row") && text.contains("excluded"), "{text}");
    }

    #[test]
    fn keeps_true_readings_equal_to_placeholders() {
        // through zero, at zero, through 85 °C, coarse about zero, and a step to 85 °C that stays
        let coarse = (0..2000).map(|row| (3.0 * (0.01 * f64::from(row)).sin()).round()).collect();
        let step = (0..2000).map(|row| if row < 500 { 25.0 } else { 85.0 }).collect();
        for values in [warming(-10.0), warming(75.0), coarse, step] {
            let log = recording("temp_c", values.clone());
            assert_eq!(log.channel("temp_c").unwrap().values[..], values[..]);
            assert!(log.quality.failed_reads.is_empty());
        }
        // not a thermometer
        let mut volts = vec![12.0; 2000];
        volts[700] = 0.0;
        assert_eq!(recording("supply_v", volts.clone()).channel("supply_v").unwrap().values[..], volts[..]);
    }
}

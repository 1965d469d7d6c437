//! Bias of every axis as a cubic of the temperature, the only correction that some stacks support; and the remaining
//! error.
//!
//! b(T) = Σ Xₖ·(clip(T) − T_ref)ᵏ, k = 0 … 3, with T clipped to its fitted range. It is fitted by generalised least
//! squares on block means, whitened by the axis' own noise, so that a slow change of temperature does not count for
//! more than a quick one only because it has more samples.

use std::ops::Range;
use std::sync::Arc;

use fos_data::column::AXES;
use fos_data::observed::ObservedAxis;
use fos_data::recording::{Recording, RecordingError};
use fos_data::stillness::Stillness;
use serde::Serialize;

use crate::evaluate::SLOW_BLOCK_S;
use crate::noise::{Blocks, LevelPrior, NoiseLevels, Regression, length_for};
use crate::signal;

/// Column of the thermometer, °C.
pub const TEMPERATURE: &str = "temp_c";

/// Least range of temperatures for a cubic, K: ArduPilot requires as much (`TEMP_RANGE_MIN`,
/// AP_InertialSensor_tempcal.cpp), and PX4 accepts no less (`SYS_CAL_TDEL`).
pub const NARROWEST_K: f64 = 10.0;

/// Least number of blocks for a cubic under noise.
const FEWEST_BLOCKS: usize = 40;

/// Bias of the axes of a device by temperature.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ThermalTable {
    /// Lowest valid temperature, °C, to a hundredth.
    pub low_c: f64,
    /// Highest valid temperature, °C, to a hundredth.
    pub high_c: f64,
    /// Cubics, one for every axis of the log.
    pub axes: Vec<ThermalCubic>,
}

/// Bias of one axis by temperature.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ThermalCubic {
    /// Name in the log format, as `gx_rads`.
    pub column: String,
    /// Coefficients X₀ … X₃ about the middle of the table's range, unit/Kᵏ. X₀ is 0 if the true value is unknown, as
    /// for an accelerometer.
    pub coefficients: [f64; 4],
}

#[derive(Debug, thiserror::Error)]
pub enum ThermalError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error(
        "{log}: it has no temperature, temp_c: a table by temperature needs one\nhelp: log the temperature of the sensor's die beside the axes, or map another column to temp_c"
    )]
    NoThermometer { log: String },
    #[error(
        "{log}: {blocks} blocks at rest with a temperature are too few for a cubic of it; {FEWEST_BLOCKS} are needed\nhelp: let the unit lie still from cold to warm, for half an hour or more"
    )]
    TooShort { log: String, blocks: usize },
    #[error(
        "{log}: on the rows that are fitted the temperature goes from {low_c:.2} to {high_c:.2} °C, less than the {NARROWEST_K} K that a cubic of it needs\nhelp: cool the unit for half an hour, then log it lying still while it warms up as far as it will in use; a larger `train` takes more of this log"
    )]
    TooNarrow { log: String, low_c: f64, high_c: f64 },
}

impl ThermalTable {
    /// Fits every axis on those of `rows` in which the device is at rest.
    pub fn fit(
        recording: &Recording,
        stillness: &Stillness,
        rows: Range<usize>,
    ) -> Result<Self, ThermalError> {
        stillness.check_rest(recording, &rows)?;
        let log = recording.paths();
        let temperature = temperature_of(recording)?;
        let length_s = length_for(recording);
        let is_known =
            |row: usize| rows.contains(&row) && stillness.still[row] && temperature[row].is_finite();
        let known: Vec<bool> = (0..recording.n_rows()).map(is_known).collect();
        let blocks = Blocks::new(recording, length_s, known.clone());
        if blocks.len() < FEWEST_BLOCKS {
            return Err(ThermalError::TooShort { log, blocks: blocks.len() });
        }
        // means: a single invalid value does not widen the range
        let means = blocks.means(&temperature);
        let low = means.iter().copied().fold(f64::INFINITY, f64::min);
        let high = means.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // rounded as printed, so that the computed and the written values agree
        let (low_c, high_c) = ((100.0 * low).ceil() / 100.0, (100.0 * high).floor() / 100.0);
        if high_c - low_c < NARROWEST_K {
            return Err(ThermalError::TooNarrow { log, low_c: low, high_c: high });
        }
        let mut table = Self { low_c, high_c, axes: Vec::new() };
        for column in AXES.into_iter().filter(|column| recording.channel(column).is_ok()) {
            let coefficients =
                table.fit_axis(recording, stillness, column, &temperature, length_s, &known)?;
            table.axes.push(ThermalCubic { column: column.to_owned(), coefficients });
        }
        Ok(table)
    }

    fn fit_axis(
        &self,
        recording: &Recording,
        stillness: &Stillness,
        column: &str,
        temperature: &[f64],
        length_s: f64,
        known: &[bool],
    ) -> Result<[f64; 4], ThermalError> {
        let (cleaned, _) = recording.without_outliers(column, 0..recording.n_rows(), known);
        let observed = ObservedAxis::at_rest(&cleaned, stillness, column)?;
        let known = known.iter().zip(&observed.known).map(|(known, observed)| *known && *observed);
        let blocks = Blocks::with_levels(recording, length_s, known.collect(), &observed.turns);
        if blocks.beyond_levels() < FEWEST_BLOCKS {
            return Err(ThermalError::TooShort { log: recording.paths(), blocks: blocks.beyond_levels() });
        }
        let y = blocks.means(&observed.error.values);
        let mean = y.iter().sum::<f64>() / y.len() as f64;
        let y: Vec<f64> = y.iter().map(|value| value - mean).collect();
        let half = 0.5 * (self.high_c - self.low_c);
        let power = |k: i32| -> Vec<f64> {
            let powers: Vec<f64> =
                temperature.iter().map(|t| ((t - self.reference_c()) / half).powi(k)).collect();
            blocks.means(&powers)
        };
        let mut columns = vec![vec![1.0; blocks.len()]];
        columns.extend((1..=3).map(power));
        let regressors: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let prior = LevelPrior::of_log(&blocks, &y);
        let regression = Regression { blocks: &blocks, y: &y, regressors: &regressors, prior: &prior };
        let fitted = regression.fit(NoiseLevels::from_logs(&prior.mean)).gls.coefficients();
        let constant = if observed.error.is_bias_known() { mean + fitted[0] } else { 0.0 };
        Ok([constant, fitted[1] / half, fitted[2] / (half * half), fitted[3] / half.powi(3)])
    }

    /// Returns the middle of the temperature range, °C.
    pub fn reference_c(&self) -> f64 {
        0.5 * (self.low_c + self.high_c)
    }
}

/// Converts the coefficients of a cubic about zero to those about `reference`: Σ cₖ·uᵏ = Σ dₖ·(u − reference)ᵏ.
pub fn about(coefficients: [f64; 4], reference: f64) -> [f64; 4] {
    let [c0, c1, c2, c3] = coefficients;
    let r = reference;
    [c0 + r * (c1 + r * (c2 + r * c3)), c1 + r * (2.0 * c2 + 3.0 * r * c3), c2 + 3.0 * r * c3, c3]
}

/// Returns the temperature of every row, °C, held between the values of a slower thermometer.
pub fn temperature_of(recording: &Recording) -> Result<Arc<Vec<f64>>, ThermalError> {
    match recording.channel(TEMPERATURE) {
        Ok(channel) => Ok(recording.held_from_first(channel)),
        Err(_) => Err(ThermalError::NoThermometer { log: recording.paths() }),
    }
}

/// Returns the RMS of the 1-s means of an axis minus `correction`, one value per row, over the rows at rest among
/// `rows`; about their mean, as every stack determines the constant itself, and for an accelerometer about the mean in
/// each orientation. In the axis' unit; none if fewer than two such means are known.
pub fn left_by(
    recording: &Recording,
    stillness: &Stillness,
    rows: &Range<usize>,
    column: &str,
    correction: impl Fn(usize) -> f64,
) -> Result<Option<f64>, RecordingError> {
    let (cleaned, _) = recording.without_outliers(column, rows.clone(), &stillness.still);
    let observed = ObservedAxis::at_rest(&cleaned, stillness, column)?.within(rows);
    let left: Vec<f64> = rows.clone().map(|row| observed.error.values[row] - correction(row)).collect();
    let is_known = |row: usize| observed.known[row] && left[row - rows.start].is_finite();
    let stretches = recording.stretches_where(is_known);
    let per_block = ((SLOW_BLOCK_S / recording.rate.period_s).round() as usize).max(1);
    let (mut squares, mut count) = (0.0, 0);
    for level in observed.levels(rows.clone()) {
        let within = stretches.iter().map(|s| s.start.max(level.start)..s.end.min(level.end));
        let within: Vec<&[f64]> = within
            .filter(|stretch| !stretch.is_empty())
            .map(|stretch| &left[stretch.start - rows.start..stretch.end - rows.start])
            .collect();
        let means = signal::blocks::block_means(&within, per_block);
        squares += signal::centred(means.clone()).iter().map(|value| value * value).sum::<f64>();
        count += means.len();
    }
    Ok((count >= 2).then(|| (squares / count as f64).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_data::recording::{LoadOptions, Source};
    use fos_data::stillness;
    use fos_testkit::noise::white_noise;

    /// A log of 120 blocks, of which 119 determine the levels of as many orientations, was refused because "120 blocks
    /// are too few; 40 are needed".
    #[test]
    fn refusal_counts_the_blocks_beyond_levels() {
        let n = 1200;
        let noise = white_noise(1, n);
        let columns = [
            ("t_s", (0..n).map(|row| 0.05 * row as f64).collect()),
            ("ax_mps2", noise.iter().map(|noise| 9.8 + 0.01 * noise).collect()),
            ("temp_c", (0..n).map(|row| 10.0 + 0.025 * row as f64).collect()),
        ];
        let columns = columns.map(|(name, values): (&str, Vec<f64>)| (name.to_owned(), values)).into();
        let log = Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default());
        let log = log.expect("a log");
        let turns = (10..n).step_by(10).collect();
        let stillness = Stillness { still: vec![true; n], turns, ..stillness::find(&log) };
        match ThermalTable::fit(&log, &stillness, 0..n) {
            Err(ThermalError::TooShort { blocks, .. }) => assert!(blocks < FEWEST_BLOCKS, "{blocks}"),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn shifting_the_reference_preserves_the_cubic() {
        let coefficients = [0.3, -0.02, 4e-4, -7e-6];
        let value = |c: [f64; 4], u: f64| c[0] + u * (c[1] + u * (c[2] + u * c[3]));
        for reference in [0.0, -12.5, 7.25] {
            let moved = about(coefficients, reference);
            for u in [-30.0, 0.0, 3.0, 41.0] {
                let off = value(moved, u - reference) - value(coefficients, u);
                assert!(off.abs() < 1e-14, "{reference} {u}: {off:e}"); // rounding of numbers up to 1
            }
        }
    }
}

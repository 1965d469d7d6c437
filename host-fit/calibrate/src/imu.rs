//! The six axes of a log as the calibration reads them: SI units, or raw counts of unknown scale.

use std::ops::Range;

use fos_data::column::{ACCELEROMETERS, GYROS};
use fos_data::recording::Recording;
use serde::Serialize;

use crate::error::CalibrateError;

/// Last parts of the names of columns that hold counts of a converter.
const COUNTS: [&str; 4] = ["cnt", "counts", "raw", "lsb"];

/// Scale of the logged values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Scale {
    /// m/s² or rad/s, to within the error of the sensor.
    Si,
    /// Counts; the calibration finds their scale.
    Counts,
}

/// Three axes of one sensor, a value per row. NaN where a value is missing.
#[derive(Debug, Clone)]
pub struct Axes {
    pub values: [Vec<f64>; 3],
    /// Names of the columns, x, y, z.
    pub columns: [String; 3],
    pub scale: Scale,
}

impl Axes {
    /// The first axis whose values are all equal: its column and the value. The noise of a connected sensor changes some.
    pub(crate) fn stuck(&self) -> Option<(&str, f64)> {
        self.values.iter().zip(&self.columns).find_map(|(values, column)| {
            let mut finite = values.iter().copied().filter(|value| value.is_finite());
            let first = finite.next()?;
            finite.all(|value| value == first).then_some((column.as_str(), first))
        })
    }

    /// The three values of a row.
    pub fn at(&self, row: usize) -> [f64; 3] {
        [self.values[0][row], self.values[1][row], self.values[2][row]]
    }
}

/// A log of one IMU.
#[derive(Debug, Clone)]
pub struct Imu {
    /// Sample period, s.
    pub period_s: f64,
    /// Time of every row, s.
    pub time_s: Vec<f64>,
    /// Rows without gaps.
    pub segments: Vec<Range<usize>>,
    pub accelerometer: Option<Axes>,
    pub gyro: Option<Axes>,
    /// °C, a value per row.
    pub temperature_c: Option<Vec<f64>>,
}

impl Imu {
    /// The axes of a recording: `ax_mps2` … `gz_rads`, or columns in counts (`ax_cnt`, `gx_raw`, …).
    pub fn of(recording: &Recording) -> Result<Self, CalibrateError> {
        let accelerometer = axes(recording, ACCELEROMETERS, 'a');
        let gyro = axes(recording, GYROS, 'g');
        if accelerometer.is_none() && gyro.is_none() {
            let columns = recording.channels().iter().map(|channel| channel.name.clone()).collect();
            return Err(CalibrateError::NoTriad { path: recording.paths(), columns });
        }
        let temperature = recording.channel("temp_c").ok().map(|channel| channel.values.to_vec());
        Ok(Self {
            period_s: recording.rate.period_s,
            time_s: recording.time_s.clone(),
            segments: recording.segments.iter().map(|segment| segment.rows.clone()).collect(),
            accelerometer,
            gyro,
            temperature_c: temperature.filter(|values| values.iter().any(|value| value.is_finite())),
        })
    }

    /// Number of samples in the given time, s, at least `fewest`.
    pub(crate) fn rows_in(&self, seconds: f64, fewest: usize) -> usize {
        ((seconds / self.period_s).round() as usize).max(fewest)
    }
}

fn axes(recording: &Recording, si: [&str; 3], letter: char) -> Option<Axes> {
    let find = |columns: [String; 3], scale| {
        let values = columns.each_ref().map(|name| recording.channel(name).ok().map(|c| c.values.to_vec()));
        let [Some(x), Some(y), Some(z)] = values else { return None };
        let values = [x, y, z];
        let has_numbers = values.iter().all(|axis| axis.iter().any(|value| value.is_finite()));
        has_numbers.then_some(Axes { values, columns, scale })
    };
    find(si.map(str::to_owned), Scale::Si).or_else(|| {
        COUNTS.iter().find_map(|unit| {
            find(['x', 'y', 'z'].map(|axis| format!("{letter}{axis}_{unit}")), Scale::Counts)
        })
    })
}

//! Error left by a correction by temperature alone, compared with that of the study's model.

use std::ops::Range;

use fos_data::recording::Recording;
use fos_data::stillness::Stillness;
use fos_fit::model::UnitModel;
use fos_fit::thermal::{ThermalError, left_by, temperature_of};
use serde::Serialize;

use crate::physical::{PhysicalError, physical};

/// Slow error of one axis on the evaluation rows: RMS of its 1-s means at rest about their mean, in the unit of the
/// axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftByTemperature {
    /// Name in the log format, as `gx_rads`.
    pub column: String,
    pub unit: String,
    /// Error without a correction.
    pub nothing: f64,
    /// Error with each of the corrections by temperature, in their order.
    pub corrected: Vec<f64>,
    /// Error with the physical part of the study's model, which is valid in motion, as a correction by temperature is;
    /// `None` if the study does not contain the axis.
    pub study: Option<f64>,
}

/// Error of the computation.
#[derive(Debug, thiserror::Error)]
pub enum LeftError {
    #[error(transparent)]
    Thermal(#[from] ThermalError),
    #[error(transparent)]
    Physical(#[from] PhysicalError),
    #[error(
        "{log}: no row at rest remains for the evaluation\nhelp: use a smaller `train`, or another evaluation log"
    )]
    NothingLeft { log: String },
}

/// Correction by temperature: maps a column and a temperature in °C to a value in the column's unit.
pub type Correction<'a> = &'a dyn Fn(&str, f64) -> f64;

/// Computes the slow error of `columns` with each of `corrections` and with the physical part of `model`, on those of
/// `rows` in which the device is at rest.
pub fn left_by_temperature(
    model: &UnitModel,
    recording: &Recording,
    stillness: &Stillness,
    rows: &Range<usize>,
    columns: &[&str],
    corrections: &[Correction<'_>],
) -> Result<Vec<LeftByTemperature>, LeftError> {
    let temperature = temperature_of(recording)?;
    let explained = physical(model, recording)?;
    let left = |column: &str, correction: &dyn Fn(usize) -> f64| -> Result<f64, LeftError> {
        let left = left_by(recording, stillness, rows, column, correction).map_err(ThermalError::from)?;
        left.ok_or_else(|| LeftError::NothingLeft { log: recording.paths() })
    };
    columns
        .iter()
        .map(|column| {
            let corrected = corrections.iter().map(|of| left(column, &|row| of(column, temperature[row])));
            let place = model.axes.iter().position(|axis| axis.column == *column);
            Ok(LeftByTemperature {
                column: (*column).to_owned(),
                unit: recording.channel(column).map_err(ThermalError::from)?.unit.label().to_owned(),
                nothing: left(column, &|_| 0.0)?,
                corrected: corrected.collect::<Result<_, _>>()?,
                study: place.map(|place| left(column, &|row| explained[place][row])).transpose()?,
            })
        })
        .collect()
}

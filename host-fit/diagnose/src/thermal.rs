//! What a correction by temperature alone costs: the error that it leaves beside that of the study's model.

use std::ops::Range;

use fos_data::recording::Recording;
use fos_data::stillness::Stillness;
use fos_fit::model::UnitModel;
use fos_fit::thermal::{ThermalError, left_by, temperature_of};
use serde::Serialize;

use crate::physical::{PhysicalError, physical};

/// What is left of an axis on the judged rows: root mean square of its 1-s means at rest, less their mean, in its unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftByTemperature {
    /// As in the log format.
    pub column: String,
    pub unit: String,
    /// With nothing corrected.
    pub nothing: f64,
    /// With each of the corrections by temperature, in their order.
    pub corrected: Vec<f64>,
    /// With the physical part of the study's model, which holds in motion as a correction by temperature does; none where
    /// the study does not have the axis.
    pub study: Option<f64>,
}

/// Why the errors cannot be computed.
#[derive(Debug, thiserror::Error)]
pub enum LeftError {
    #[error(transparent)]
    Thermal(#[from] ThermalError),
    #[error(transparent)]
    Physical(#[from] PhysicalError),
    /// Nothing is left to judge on.
    #[error(
        "{log}: no row at rest remains for the evaluation\nhelp: use a smaller `train`, or another evaluation log (`judge`)"
    )]
    NothingLeft { log: String },
}

/// A correction by temperature: of a column at a temperature, in the column's unit.
pub type Correction<'a> = &'a dyn Fn(&str, f64) -> f64;

/// What each of `corrections`, and the physical part of `model`, leave of `columns` on those of `rows` in which the unit
/// lies still.
///
/// # Errors
///
/// A column is missing, the model cannot be run, or no row is left.
pub fn left_by_temperature(
    model: &UnitModel,
    recording: &Recording,
    stillness: &Stillness,
    rows: &Range<usize>,
    columns: &[&str],
    corrections: &[Correction<'_>],
) -> Result<Vec<LeftByTemperature>, LeftError> {
    let temperature = temperature_of(recording)?;
    let explained = physical(model, recording, &stillness.still)?;
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

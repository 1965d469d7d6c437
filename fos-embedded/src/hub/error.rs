//! Reasons why a hub rejects a model.

use core::fmt;

use fos_core::{FittedOn, ImageError};

/// Reason why a hub rejects a model. Indices count from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum HubError {
    /// The image or its model is invalid.
    Image(ImageError),
    /// The model was fitted on raw values and the sensor gives corrected ones, or the reverse: a correction would be
    /// applied twice, or not at all.
    FittedOn {
        /// Values that the model was fitted on.
        model: FittedOn,
        /// Values that the sensor gives.
        sensor: FittedOn,
    },
    /// The model was fitted at another sample period.
    Period {
        /// Sample period of the model, s.
        model_s: f32,
        /// Sample period that the sensor is set to, s.
        sensor_s: f32,
    },
    /// The model has a calibration, but fos-embedded was built without the feature `calibration`.
    CalibrationNotBuilt,
    /// An axis of the model, by index, is not one of the six, or occurs twice.
    Axis(usize),
    /// A logged quantity of the model, by index, is measured by an axis that is not one of the six, or exceeds the capacity.
    Quantity(usize),
}

impl fmt::Display for HubError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Image(error) => write!(f, "{error}"),
            Self::FittedOn { model, sensor } => {
                write!(f, "the model was fitted on {model:?} values, the sensor gives {sensor:?} ones")
            }
            Self::Period { model_s, sensor_s } => {
                write!(f, "the model was fitted every {model_s} s, the sensor is set to {sensor_s} s")
            }
            Self::CalibrationNotBuilt => {
                write!(f, "the model has a calibration: build fos-embedded with its feature `calibration`")
            }
            Self::Axis(axis) => {
                write!(f, "axis {axis} of the model is none of the sensor's, or is there twice")
            }
            Self::Quantity(index) => write!(f, "quantity {index} of the model cannot be measured here"),
        }
    }
}

impl core::error::Error for HubError {}

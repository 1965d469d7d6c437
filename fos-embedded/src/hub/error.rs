//! Why a hub does not take a model.

use core::fmt;

use fos_core::{FittedOn, ImageError};

/// Why a hub does not take a model. Indices count from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum HubError {
    /// The image, or the model in it.
    Image(ImageError),
    /// The model was fitted on other values than the sensor gives: a correction would be applied twice, or not at all.
    FittedOn {
        /// What the model was fitted on.
        model: FittedOn,
        /// What the sensor gives.
        sensor: FittedOn,
    },
    /// The model was fitted at another sample period.
    Period {
        /// Of the model, s.
        model_s: f32,
        /// That the sensor is set to, s.
        sensor_s: f32,
    },
    /// An axis of the model is none of the sensor's six, or is there twice.
    Axis(usize),
    /// A logged quantity of the model is measured by an axis that is none of the six, or there is no room for it.
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
            Self::Axis(axis) => {
                write!(f, "axis {axis} of the model is none of the sensor's, or is there twice")
            }
            Self::Quantity(index) => write!(f, "quantity {index} of the model cannot be measured here"),
        }
    }
}

impl core::error::Error for HubError {}

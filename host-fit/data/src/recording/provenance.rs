//! Provenance of inertial values: the sensor that measured them, the corrections they contain, and their frame.
//!
//! A reader states it ([`ReadAs`](super::ReadAs)), a recording carries it, a study stores it, and an image or a
//! temperature table is written from it. The log format states none: its values are those that the user declares.

use std::borrow::Cow;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::column::Triad;

/// Provenance of the inertial values of a log.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Provenance {
    /// Provenance of the accelerometers.
    pub accelerometers: SensorProvenance,
    pub gyros: SensorProvenance,
}

/// Provenance of the three axes of a sensor. Fields that a log does not state are absent or `Unstated`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct SensorProvenance {
    /// Number of the sensor as the autopilot counts it, from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instance: Option<u8>,
    /// The autopilot's `device_id` of the sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device_id: Option<u32>,
    /// Corrections that the values contain.
    pub values: Values,
    /// Axes in which the values are given.
    pub frame: Frame,
}

/// Corrections that logged values contain.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum Values {
    /// Not stated by the log.
    #[default]
    Unstated,
    /// Delivered by the sensor or its driver.
    Raw,
    /// Corrected before logging, by the named software or parameters.
    Corrected(Cow<'static, str>),
}

/// Axes in which values are given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// Not stated by the log.
    #[default]
    Unstated,
    /// Axes of the sensor's die.
    Sensor,
    /// Axes of the autopilot's board, in which autopilots correct by temperature.
    Board,
    /// Axes of the vehicle.
    Vehicle,
    Phone,
}

impl Provenance {
    /// The same provenance for accelerometers and gyros.
    pub(super) fn of_both(values: Values, frame: Frame) -> Self {
        let sensor = SensorProvenance { values, frame, ..SensorProvenance::default() };
        Self { accelerometers: sensor.clone(), gyros: sensor }
    }

    pub fn of(&self, triad: Triad) -> &SensorProvenance {
        match triad {
            Triad::Accelerometers => &self.accelerometers,
            Triad::Gyros => &self.gyros,
        }
    }

    /// Discards the statement about a triad: the user maps its columns.
    pub(super) fn forget(&mut self, triad: Triad) {
        let sensor = match triad {
            Triad::Accelerometers => &mut self.accelerometers,
            Triad::Gyros => &mut self.gyros,
        };
        *sensor = SensorProvenance::default();
    }
}

impl SensorProvenance {
    /// Corrections contained in the values; `None` if they are raw or the log does not state any.
    pub fn corrected_by(&self) -> Option<&str> {
        match &self.values {
            Values::Corrected(by) => Some(by),
            Values::Raw | Values::Unstated => None,
        }
    }

    /// First contradiction between two provenances, in words: the statement of this one, then of the other. `None` if
    /// one of them states nothing.
    pub fn contradiction(&self, other: &Self) -> Option<[String; 2]> {
        let differ =
            |one: &dyn fmt::Display, other: &dyn fmt::Display| Some([one.to_string(), other.to_string()]);
        if let (Some(one), Some(two)) = (self.device_id, other.device_id) {
            if one != two {
                return differ(&format!("device_id {one}"), &format!("device_id {two}"));
            }
        } else if let (Some(one), Some(two)) = (self.instance, other.instance)
            && one != two
        {
            // without a device id the instance number must do
            return differ(&format!("IMU {one}"), &format!("IMU {two}"));
        }
        let is_stated = |values: &Values| *values != Values::Unstated;
        if self.values != other.values && is_stated(&self.values) && is_stated(&other.values) {
            return differ(&self.values, &other.values);
        }
        let is_stated = |frame: Frame| frame != Frame::Unstated;
        if self.frame != other.frame && is_stated(self.frame) && is_stated(other.frame) {
            return differ(&self.frame, &other.frame);
        }
        None
    }

    /// Common part of both: a statement made by only one is dropped, but a correction of one counts for both.
    pub(super) fn common(&self, other: &Self) -> Self {
        let values = match (&self.values, &other.values) {
            (corrected @ Values::Corrected(_), _) | (_, corrected @ Values::Corrected(_)) => {
                corrected.clone()
            }
            (Values::Raw, Values::Raw) => Values::Raw,
            _ => Values::Unstated,
        };
        Self {
            instance: self.instance.filter(|_| self.instance == other.instance),
            device_id: self.device_id.filter(|_| self.device_id == other.device_id),
            values,
            frame: if self.frame == other.frame { self.frame } else { Frame::Unstated },
        }
    }
}

impl fmt::Display for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unstated => f.write_str("raw or corrected: not stated"),
            Self::Raw => f.write_str("raw"),
            Self::Corrected(by) => write!(f, "corrected by {by}"),
        }
    }
}

impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unstated => "axes not stated",
            Self::Sensor => "axes of the sensor",
            Self::Board => "axes of the board",
            Self::Vehicle => "axes of the vehicle",
            Self::Phone => "axes of the phone",
        })
    }
}

impl fmt::Display for SensorProvenance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(instance) = self.instance {
            write!(f, "IMU {instance}, ")?;
        }
        if let Some(device_id) = self.device_id {
            write!(f, "device_id {device_id}, ")?;
        }
        write!(f, "{}, {}", self.values, self.frame)
    }
}

impl fmt::Display for Provenance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.accelerometers == self.gyros {
            return write!(f, "accelerometers and gyros {}", self.gyros);
        }
        write!(f, "accelerometers {}; gyros {}", self.accelerometers, self.gyros)
    }
}

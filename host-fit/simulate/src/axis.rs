//! The six axes of a device.

use serde::{Deserialize, Serialize};

/// An axis of the accelerometer or gyro.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Axis {
    #[serde(rename = "ax_mps2")]
    Ax,
    #[serde(rename = "ay_mps2")]
    Ay,
    #[serde(rename = "az_mps2")]
    Az,
    #[serde(rename = "gx_rads")]
    Gx,
    #[serde(rename = "gy_rads")]
    Gy,
    #[serde(rename = "gz_rads")]
    Gz,
}

impl Axis {
    /// All six, in the order of a log.
    pub const ALL: [Self; 6] = [Self::Ax, Self::Ay, Self::Az, Self::Gx, Self::Gy, Self::Gz];

    pub fn column(self) -> &'static str {
        fos_data::column::AXES[self as usize]
    }

    /// Axis of this column, or of its first two letters.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|axis| axis.column() == name || &axis.column()[..2] == name)
    }

    /// Returns true for a gyro, false for an accelerometer.
    pub fn is_gyro(self) -> bool {
        self as usize >= 3
    }

    /// Index of the direction: 0, 1, 2 for x, y, z.
    pub fn direction(self) -> usize {
        self as usize % 3
    }
}

//! Calibration of a device's triads as a log of turned orientations gave it.

use fos_core::TriadCalibration;
use fos_data::recording;
use serde::{Deserialize, Serialize};

/// Bias, sensitivity and cross-axis of a device as a log of turned orientations gave them. The log does not know the
/// error that the model predicts, so each bias contains it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnitCalibration {
    /// Logs that it was made from.
    pub sources: Vec<recording::Source>,
    /// Number of rests.
    pub rests: usize,
    /// RMS of |a| − g at these rests, m/s², before and after.
    pub gravity_residual_mps2: [f64; 2],
    /// Temperature at which it was made, °C; none if the logs have no thermometer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    pub accel: TriadCalibration<f64>,
    /// None if the logs determine no gyro.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro: Option<TriadCalibration<f64>>,
}

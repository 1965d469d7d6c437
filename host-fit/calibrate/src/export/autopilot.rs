//! The part of a calibration that PX4 and ArduPilot can apply: an offset and a scale for each axis.

use crate::Calibration;
use crate::imu::Scale;

/// Reason why an autopilot cannot apply a calibration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotForAutopilot {
    /// Autopilots scale counts themselves.
    #[error(
        "the log is in counts, and an autopilot corrects m/s² and rad/s\nhelp: record the log with the autopilot, or convert the counts by the nominal scale in the column map"
    )]
    Counts,
    #[error(
        "{parameter} would be {value:.3}, beyond the range {low} … {high} that the autopilot accepts\nhelp: check the unit of the log; a part with such an error is faulty"
    )]
    Range { parameter: String, value: f64, low: f64, high: f64 },
}

/// Offsets and scales, in single precision as they are stored.
#[derive(Debug, Clone, PartialEq)]
pub struct Autopilot {
    /// m/s².
    pub accelerometer_offset: [f32; 3],
    pub accelerometer_scale: [f32; 3],
    /// rad/s; `None` for a log without a gyro.
    pub gyro_offset: Option<[f32; 3]>,
    /// Largest error at 1 g because the cross-axis terms are not applied, m/s².
    pub neglected_mps2: f64,
}

impl Autopilot {
    /// The offsets and scales of a calibration at its reference temperature.
    pub fn of(calibration: &Calibration) -> Result<Self, NotForAutopilot> {
        let accelerometer = &calibration.accelerometer;
        if accelerometer.scale == Scale::Counts {
            return Err(NotForAutopilot::Counts);
        }
        // a gyro with a stuck axis has no parameters
        let gyro = calibration.gyro.as_ref().filter(|gyro| !gyro.parameters.is_empty());
        if gyro.is_some_and(|gyro| gyro.scale == Scale::Counts) {
            return Err(NotForAutopilot::Counts);
        }
        let model = &accelerometer.model;
        let (matrix, _) = model.correction(model.reference_c);
        // With only the diagonal of M, the error of an axis is the contribution of the other two.
        let beside = |i: usize| (0..3).filter(|j| *j != i).map(|j| matrix[i][j].powi(2)).sum::<f64>().sqrt();
        let neglected = (0..3).map(beside).fold(0.0, f64::max) * accelerometer.gravity.mps2;
        Ok(Self {
            accelerometer_offset: model.bias.map(|x| x as f32),
            accelerometer_scale: [0, 1, 2].map(|i| matrix[i][i] as f32),
            gyro_offset: gyro.map(|gyro| gyro.bias.map(|x| x as f32)),
            neglected_mps2: neglected,
        })
    }

    pub(super) fn check(&self, scale: [f64; 2], offset: f64) -> Result<(), NotForAutopilot> {
        let axes = ["x", "y", "z"];
        for (axis, name) in axes.iter().enumerate() {
            for (parameter, value, low, high) in [
                ("scale", f64::from(self.accelerometer_scale[axis]), scale[0], scale[1]),
                ("offset", f64::from(self.accelerometer_offset[axis]), -offset, offset),
            ] {
                if !(low..=high).contains(&value) {
                    let parameter = format!("the accelerometer {parameter} of {name}");
                    return Err(NotForAutopilot::Range { parameter, value, low, high });
                }
            }
        }
        Ok(())
    }
}

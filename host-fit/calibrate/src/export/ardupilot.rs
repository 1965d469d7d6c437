//! ArduPilot: parameters `INS_ACCOFFS_*`, `INS_ACCSCAL_*`, `INS_GYROFFS_*` of the first IMU, `INS_ACC2OFFS_*` of the second, ….
//!
//! ArduPilot computes (accel − offset) ∘ scale and gyro − offset in the frame of the sensor
//! (libraries/AP_InertialSensor/AP_InertialSensor_Backend.cpp, `_rotate_and_correct_accel`).

use std::fmt::Write as _;

use super::autopilot::{Autopilot, NotForAutopilot};
use super::in_comment;
use crate::Calibration;
use fos_data::unit::MG_MPS2;

/// Ranges of the parameters (AP_InertialSensor.cpp, `@Range` of ACCSCAL and ACCOFFS).
const SCALE: [f64; 2] = [0.8, 1.2];
const OFFSET_MPS2: f64 = 3.5;

/// Parameters for ArduPilot.
#[derive(Debug, Clone, PartialEq)]
pub struct ArduPilot {
    pub parameters: Autopilot,
    /// Mean temperature of the calibration, °C.
    pub temperature_c: Option<f32>,
}

impl ArduPilot {
    pub fn of(calibration: &Calibration) -> Result<Self, NotForAutopilot> {
        let parameters = Autopilot::of(calibration)?;
        parameters.check(SCALE, OFFSET_MPS2)?;
        let accelerometer = &calibration.accelerometer;
        let temperature_c = accelerometer.temperature_c.map(|_| accelerometer.model.reference_c as f32);
        Ok(Self { parameters, temperature_c })
    }

    /// The file, for the IMU of this number, counted from 0.
    pub fn file(&self, log: &str, instance: u8) -> String {
        // The fourth and fifth IMU have their own groups (AP_InertialSensor_Params.cpp).
        let name = |triad: &str, what: &str| match instance {
            0 => format!("INS_{triad}{what}"),
            1 | 2 => format!("INS_{triad}{}{what}", instance + 1),
            _ => format!("INS{}_{triad}{what}", u16::from(instance) + 1),
        };
        let one = &self.parameters;
        let mut text = format!(
            "# Accelerometer and gyro {instance} (counted from 0), from {}, by fos\n\
             # Axes are those of the sensor, before AHRS_ORIENTATION. ArduPilot has no cross-axis terms: without them up to\n\
             # {:.1} mg remain at 1 g. It has no gyro scale.\n",
            in_comment(log),
            one.neglected_mps2 / MG_MPS2
        );
        for (axis, letter) in ["X", "Y", "Z"].iter().enumerate() {
            // writing to a string does not fail
            let _ = writeln!(text, "{}_{letter} {}", name("ACC", "OFFS"), one.accelerometer_offset[axis]);
            let _ = writeln!(text, "{}_{letter} {}", name("ACC", "SCAL"), one.accelerometer_scale[axis]);
            if let Some(offset) = one.gyro_offset {
                let _ = writeln!(text, "{}_{letter} {}", name("GYR", "OFFS"), offset[axis]);
            }
        }
        if let Some(celsius) = self.temperature_c {
            let number = u16::from(instance) + 1;
            let group = if number <= 3 { format!("INS_ACC{number}") } else { format!("INS{number}_ACC") };
            let _ = writeln!(text, "{group}_CALTEMP {celsius}");
        }
        text
    }
}

//! PX4: parameters `CAL_ACCn_*` and `CAL_GYROn_*` as QGroundControl loads them.
//!
//! PX4 computes (data − thermal offset − offset) ∘ scale for an accelerometer and data − thermal offset − offset for a gyro
//! (src/lib/sensor_calibration/Accelerometer.hpp and Gyroscope.hpp, `Correct`), then rotates to the body. It has neither
//! cross-axis terms nor a gyro scale. A line is tab-separated: vehicle 1, component 1, name, value, type (6 whole, 9 real).

use std::fmt::Write as _;

use super::autopilot::{Autopilot, NotForAutopilot};
use super::in_comment;
use crate::Calibration;
use fos_data::unit::MG_MPS2;

/// Range of PX4's scales (src/lib/sensor_calibration/Accelerometer.cpp, `set_scale`, refuses 0 and below); offsets have none, and
/// half of gravity is a fault.
const SCALE: [f64; 2] = [0.1, 10.0];
const OFFSET_MPS2: f64 = 4.9;

/// Parameters for PX4.
#[derive(Debug, Clone, PartialEq)]
pub struct Px4(pub Autopilot);

impl Px4 {
    pub fn of(calibration: &Calibration) -> Result<Self, NotForAutopilot> {
        let parameters = Autopilot::of(calibration)?;
        parameters.check(SCALE, OFFSET_MPS2)?;
        Ok(Self(parameters))
    }

    /// The file, for the sensors of this number, counted from 0. `ids` are the `device_id` of accelerometer and gyro, without
    /// which PX4 does not apply the values; 0 is written where they are not known.
    pub fn file(&self, log: &str, instance: u8, ids: [u32; 2]) -> String {
        let one = &self.0;
        let mut text = format!(
            "# Accelerometer and gyro {instance} (counted from 0), from {}, by fos\n\
             # Load with QGroundControl and restart. CAL_ACC{instance}_ID and CAL_GYRO{instance}_ID must be the device_id of the sensors\n\
             # (as in sensor_accel, sensor_gyro); 0 means that fos does not know it: enter it by hand.\n\
             # PX4 has no cross-axis terms: without them up to {:.1} mg remain at 1 g. It has no gyro scale.\n\
             # Vehicle-Id\tComponent-Id\tName\tValue\tType\n",
            in_comment(log),
            one.neglected_mps2 / MG_MPS2
        );
        let mut line = |name: &str, value: String, kind: u8| {
            // writing to a string does not fail
            let _ = writeln!(text, "1\t1\tCAL_{name}\t{value}\t{kind}");
        };
        line(&format!("ACC{instance}_ID"), ids[0].to_string(), 6);
        for (axis, name) in ["X", "Y", "Z"].iter().enumerate() {
            line(&format!("ACC{instance}_{name}OFF"), one.accelerometer_offset[axis].to_string(), 9);
            line(&format!("ACC{instance}_{name}SCALE"), one.accelerometer_scale[axis].to_string(), 9);
        }
        if let Some(offset) = one.gyro_offset {
            line(&format!("GYRO{instance}_ID"), ids[1].to_string(), 6);
            for (axis, name) in ["X", "Y", "Z"].iter().enumerate() {
                line(&format!("GYRO{instance}_{name}OFF"), offset[axis].to_string(), 9);
            }
        }
        text
    }
}

//! Temperature tables for ArduPilot: parameters `INS_TCAL1_*` of the first IMU, `INS_TCAL2_*` of the second, ….
//!
//! ArduPilot subtracts P(clip(T) − 35) and adds P(clip(T_cal) − 35), with P(d) = 10⁻⁶·(c₁d + c₂d² + c₃d³) and the temperature T_cal of the
//! calibration of the offsets, both clipped to TMIN … TMAX (libraries/AP_InertialSensor/AP_InertialSensor_tempcal.cpp, `correct_sensor`).
//! It does so in the frame of the sensor, before AHRS_ORIENTATION.

use std::fmt::Write as _;

use fos_data::column::{ACCELEROMETERS, GYROS};
use fos_fit::export::in_ascii;
use fos_fit::thermal::{ThermalTable, about};

/// ArduPilot's reference temperature, °C, and the scale of its coefficients.
const REFERENCE_C: f64 = 35.0;
const SCALE: f64 = 1e6;

/// Parameters of a sensor in single precision, as ArduPilot stores them.
#[derive(Debug, Clone, PartialEq)]
pub struct ArduPilot {
    /// TMIN, TMAX, °C.
    range: [f32; 2],
    /// Coefficients of first, second and third order of each column.
    columns: Vec<(String, [f32; 3])>,
}

impl ArduPilot {
    /// Converts a table to 35 °C, without its constant, and rounds it.
    pub fn of(table: &ThermalTable) -> Self {
        let moved = |x| {
            let [_, first, second, third] = about(x, REFERENCE_C - table.reference_c());
            [first, second, third].map(|x| (SCALE * x) as f32)
        };
        let columns = table.axes.iter().map(|axis| (axis.column.clone(), moved(axis.coefficients)));
        Self { range: [table.low_c, table.high_c].map(|celsius| celsius as f32), columns: columns.collect() }
    }

    /// Correction that ArduPilot subtracts from a column at a temperature, up to a constant, in the column's unit; 0 for a column
    /// without parameters.
    pub fn offset(&self, column: &str, temperature_c: f64) -> f64 {
        let Some((_, c)) = self.columns.iter().find(|(name, _)| name == column) else { return 0.0 };
        let delta = (temperature_c as f32).clamp(self.range[0], self.range[1]) - REFERENCE_C as f32;
        f64::from((c[0] + (c[1] + c[2] * delta) * delta) * delta * 1e-6)
    }

    /// Content of the file for IMU `instance`, counted from 0.
    pub fn file(&self, log: &str, instance: u8) -> String {
        let number = u16::from(instance) + 1;
        // The fourth and fifth IMU have their own groups (AP_InertialSensor_Params.cpp).
        let group = if number <= 3 { format!("INS_TCAL{number}") } else { format!("INS{number}_TCAL") };
        let mut text = format!(
            "# Temperature table of IMU {instance} (counted from 0), from {}, by fos export\n\
             # Axes are those of the board, before AHRS_ORIENTATION. Calibrate the accelerometer once they are loaded:\n\
             # ArduPilot takes them from the temperature of that calibration on.\n\
             {group}_ENABLE 1\n{group}_TMIN {}\n{group}_TMAX {}\n",
            in_ascii(log),
            self.range[0],
            self.range[1]
        );
        for (name, columns) in [("ACC", ACCELEROMETERS), ("GYR", GYROS)] {
            for order in 0..3 {
                for (axis, column) in ["X", "Y", "Z"].iter().zip(columns) {
                    let found = self.columns.iter().find(|(name, _)| name == column);
                    let value = found.map_or(0.0, |(_, c)| c[order]);
                    // Writing to a string cannot fail.
                    let _ = writeln!(text, "{group}_{name}{}_{axis} {value}", order + 1);
                }
            }
        }
        text
    }
}

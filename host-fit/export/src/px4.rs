//! Temperature tables for PX4: parameters `TC_*` as QGroundControl loads them.
//!
//! PX4 subtracts Σ Xₖ·(clip(T) − TREF)ᵏ from the sensor output, with T clipped to TMIN … TMAX
//! (src/modules/temperature_compensation/TemperatureCompensation.cpp, `calc_thermal_offsets_3D`), for the sensor with the `device_id` of
//! the table. A line of the file is tab-separated: vehicle 1, component 1, name, value, type, which is 6 for integers and 9 for floats
//! (QGroundControl, ParameterManager.cc, `readParametersFromStream`).

use std::fmt::Write as _;

use fos_data::column::{ACCELEROMETERS, GYROS};
use fos_fit::export::in_ascii;
use fos_fit::thermal::ThermalTable;

/// Parameters of one accelerometer and one gyro in single precision, as PX4 stores them.
#[derive(Debug, Clone, PartialEq)]
pub struct Px4 {
    /// TMIN, TMAX, TREF, °C.
    range: [f32; 3],
    /// X₀ … X₃ of each column.
    columns: Vec<(String, [f32; 4])>,
}

impl Px4 {
    /// Rounds a table.
    pub fn of(table: &ThermalTable) -> Self {
        let columns =
            table.axes.iter().map(|axis| (axis.column.clone(), axis.coefficients.map(|x| x as f32)));
        Self {
            range: [table.low_c, table.high_c, table.reference_c()].map(|celsius| celsius as f32),
            columns: columns.collect(),
        }
    }

    /// Correction that PX4 subtracts from a column at a temperature, in the column's unit; 0 for a column without parameters.
    pub fn offset(&self, column: &str, temperature_c: f64) -> f64 {
        let Some((_, x)) = self.columns.iter().find(|(name, _)| name == column) else { return 0.0 };
        let [low, high, reference] = self.range;
        // As PX4's comparisons, which do not clip NaN.
        let delta = (temperature_c as f32).clamp(low, high) - reference;
        f64::from(x[0] + x[1] * delta + x[2] * (delta * delta) + x[3] * (delta * delta * delta))
    }

    /// Content of the file for accelerometer and gyro `instance`, counted from 0. `ids` are their `device_id`.
    pub fn file(&self, log: &str, instance: u8, ids: [u32; 2]) -> String {
        let mut text = format!(
            "# Temperature tables of accelerometer and gyro {instance} (counted from 0), from {}, by fos export\n\
             # Load with QGroundControl, restart, then calibrate accelerometer and gyro as usual: what was calibrated\n\
             # without these tables does not hold with them.\n\
             # TC_A{instance}_ID, TC_G{instance}_ID: device_id of the sensors (as in sensor_accel, sensor_gyro). PX4 leaves a sensor as it\n\
             # is whose device_id none of these is.\n\
             # Vehicle-Id\tComponent-Id\tName\tValue\tType\n",
            in_ascii(log)
        );
        for (letter, columns, id) in [('A', ACCELEROMETERS, ids[0]), ('G', GYROS, ids[1])] {
            let has = |column: &str| self.columns.iter().any(|(name, _)| name == column);
            if !columns.iter().any(|column| has(column)) {
                continue;
            }
            // Writing to a string cannot fail.
            let _ = writeln!(text, "1\t1\tTC_{letter}_ENABLE\t1\t6\n1\t1\tTC_{letter}{instance}_ID\t{id}\t6");
            for (name, value) in ["TMIN", "TMAX", "TREF"].iter().zip(self.range) {
                let _ = writeln!(text, "1\t1\tTC_{letter}{instance}_{name}\t{value}\t9");
            }
            for power in 0..4 {
                for (axis, column) in columns.iter().enumerate() {
                    let found = self.columns.iter().find(|(name, _)| name == column);
                    let value = found.map_or(0.0, |(_, x)| x[power]);
                    let _ = writeln!(text, "1\t1\tTC_{letter}{instance}_X{power}_{axis}\t{value}\t9");
                }
            }
        }
        text
    }
}

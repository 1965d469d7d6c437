//! What ArduPilot does to a sample before it logs it, taken back by the parameters that stand in the log.
//!
//! It takes off a polynomial of the temperature (INS_TCALn), an offset, multiplies by a scale, and turns into the
//! vehicle's frame, in this order (`AP_InertialSensor_Backend.cpp`, `AP_InertialSensor_tempcal.cpp`).

use std::collections::HashMap;
use std::fmt;

use super::rotation;
use crate::column::Triad;

/// Parameters by name, as PARM messages have them.
pub(super) type Parameters = HashMap<String, f64>;

/// Temperature that the polynomials count from, °C.
const REFERENCE_C: f64 = 35.0;

/// Coefficients are stored so many times larger.
const STORED: f64 = 1e6;

/// Corrections of one sensor, accelerometers and gyros.
pub(super) struct Correction {
    /// None of a mounting that is not in the table.
    turned: Option<[[f64; 3]; 3]>,
    orientation: f64,
    sensors: [Sensor; 2],
}

#[derive(Default)]
struct Sensor {
    offset: [f64; 3],
    scale: [f64; 3],
    polynomial: Option<Polynomial>,
}

/// Coefficients of T, T², T³ for each axis, and where it is clipped.
struct Polynomial {
    coefficients: [[f64; 3]; 3],
    range_c: [f64; 2],
    /// Temperature at which the offsets were found.
    calibrated_c: f64,
}

impl Polynomial {
    fn at(&self, axis: usize, celsius: f64) -> f64 {
        let t = celsius.clamp(self.range_c[0], self.range_c[1]) - REFERENCE_C;
        let [first, second, third] = self.coefficients[axis];
        (first + (second + third * t) * t) * t
    }

    /// What is taken off at a temperature.
    fn taken_off(&self, axis: usize, celsius: f64) -> f64 {
        self.at(axis, celsius) - self.at(axis, self.calibrated_c)
    }
}

impl Correction {
    pub(super) fn of(parameters: &Parameters, instance: u8) -> Self {
        let get = |name: String| parameters.get(&name).copied().filter(|value| value.is_finite());
        let number = instance + 1;
        // the first has no number, the fourth and fifth are in a group of their own
        let group = |sensor: &str, what: &str, axis: &str| match number {
            1 => format!("INS_{sensor}{what}_{axis}"),
            2 | 3 => format!("INS_{sensor}{number}{what}_{axis}"),
            _ => format!("INS{number}_{sensor}{what}_{axis}"),
        };
        let sensor = |sensor: &str| {
            let long = if number == 1 && sensor == "GYR" { "GYR" } else { sensor };
            let triad = |what: &str, default: f64| {
                ["X", "Y", "Z"].map(|axis| get(group(long, what, axis)).unwrap_or(default))
            };
            let scale = if sensor == "ACC" { triad("SCAL", 1.0) } else { [1.0; 3] };
            Sensor {
                offset: triad("OFFS", 0.0),
                // a scale of 0 means that none was found
                scale: scale.map(|scale| if scale == 0.0 { 1.0 } else { scale }),
                polynomial: polynomial(parameters, sensor, number),
            }
        };
        let orientation = get("AHRS_ORIENTATION".to_owned()).unwrap_or(0.0);
        Self { turned: rotation::matrix(orientation), orientation, sensors: [sensor("ACC"), sensor("GYR")] }
    }

    /// Takes back what was done to the three axes of a sensor. `warmth` are stamps and temperatures, °C.
    pub(super) fn take_back(
        &self,
        triad: Triad,
        stamps_ns: &[i64],
        axes: &mut [Vec<f64>; 3],
        warmth: Option<(&[i64], &[f64])>,
    ) {
        let [accelerometers, gyros] = &self.sensors;
        let sensor = match triad {
            Triad::Accelerometers => accelerometers,
            Triad::Gyros => gyros,
        };
        let [x, y, z] = axes;
        if let Some(matrix) = self.turned.as_ref().filter(|_| self.orientation != 0.0) {
            for ((x, y), z) in x.iter_mut().zip(y.iter_mut()).zip(z.iter_mut()) {
                let turned = [*x, *y, *z];
                let back = |axis: usize| (0..3).map(|row| matrix[row][axis] * turned[row]).sum::<f64>();
                (*x, *y, *z) = (back(0), back(1), back(2));
            }
        }
        for (axis, values) in [x, y, z].into_iter().enumerate() {
            let (offset, scale) = (sensor.offset[axis], sensor.scale[axis]);
            if (offset, scale) != (0.0, 1.0) {
                values.iter_mut().for_each(|value| *value = *value / scale + offset);
            }
            let (Some(polynomial), Some((at_ns, celsius))) = (&sensor.polynomial, warmth) else { continue };
            let mut held = 0;
            for (value, stamp) in values.iter_mut().zip(stamps_ns) {
                while held + 1 < at_ns.len() && at_ns[held + 1] <= *stamp {
                    held += 1;
                }
                if let Some(celsius) = celsius.get(held).filter(|celsius| celsius.is_finite()) {
                    *value += polynomial.taken_off(axis, *celsius);
                }
            }
        }
    }
}

fn polynomial(parameters: &Parameters, sensor: &str, number: u8) -> Option<Polynomial> {
    let get = |name: &str| parameters.get(&format!("INS_TCAL{number}_{name}")).copied();
    // 2 means that it is being learned
    if get("ENABLE")? != 1.0 {
        return None;
    }
    let coefficients = ["X", "Y", "Z"]
        .map(|axis| [1, 2, 3].map(|power| get(&format!("{sensor}{power}_{axis}")).unwrap_or(0.0) / STORED));
    let range_c = [get("TMIN")?, get("TMAX")?];
    let calibrated_c = parameters.get(&format!("INS_{sensor}{number}_CALTEMP")).copied()?;
    let is_usable = range_c[0] <= range_c[1] && calibrated_c.is_finite();
    is_usable.then_some(Polynomial { coefficients, range_c, calibrated_c })
}

impl fmt::Display for Correction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut taken_back = Vec::new();
        if self.sensors.iter().any(|sensor| sensor.polynomial.is_some()) {
            taken_back.push("INS_TCAL");
        }
        if self.sensors.iter().any(|sensor| sensor.offset != [0.0; 3]) {
            taken_back.push("offsets");
        }
        if self.sensors[0].scale != [1.0; 3] {
            taken_back.push("scales");
        }
        let orientation = format!("AHRS_ORIENTATION {}", self.orientation);
        if self.turned.is_some() && self.orientation != 0.0 {
            taken_back.push(&orientation);
        }
        if taken_back.is_empty() {
            f.write_str("the parameters in it say of no correction")?;
        } else {
            write!(f, "ArduPilot's corrections taken back: {}", taken_back.join(", "))?;
        }
        if self.turned.is_none() {
            write!(f, "; still turned by {orientation}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_done_to_a_sample_is_taken_back() {
        let parameters = [
            ("AHRS_ORIENTATION", 2.0),
            ("INS_ACCOFFS_X", 0.25),
            ("INS_ACCSCAL_X", 1.5),
            ("INS_ACCSCAL_Y", 1.0),
            ("INS_ACCSCAL_Z", 1.0),
            ("INS_TCAL1_ENABLE", 1.0),
            ("INS_TCAL1_TMIN", 10.0),
            ("INS_TCAL1_TMAX", 60.0),
            ("INS_TCAL1_ACC1_X", 2000.0),
            ("INS_TCAL1_ACC2_X", -30.0),
            ("INS_ACC1_CALTEMP", 30.0),
        ];
        let parameters: Parameters = parameters.map(|(name, value)| (name.to_owned(), value)).into();
        // forwards, by the formulas
        let polynomial = |celsius: f64| {
            let t = celsius.clamp(10.0, 60.0) - 35.0;
            2000e-6 * t - 30e-6 * t * t
        };
        let stamps_ns: Vec<i64> = (0..5).map(|n| n * 1_000_000).collect();
        let celsius = [5.0, 20.0, 35.0, 50.0, 80.0];
        let raw: Vec<[f64; 3]> = (0..5).map(|n| [1.0 + f64::from(n), -2.0, 9.8]).collect();
        let mut axes = [const { Vec::new() }; 3];
        for (sample, celsius) in raw.iter().zip(celsius) {
            let x = (sample[0] - polynomial(celsius) + polynomial(30.0) - 0.25) * 1.5;
            // turned by 90 degrees about z: the board's x is the vehicle's y
            for (axis, value) in axes.iter_mut().zip([-sample[1], x, sample[2]]) {
                axis.push(value);
            }
        }
        let correction = Correction::of(&parameters, 0);
        correction.take_back(Triad::Accelerometers, &stamps_ns, &mut axes, Some((&stamps_ns, &celsius)));
        for (row, sample) in raw.iter().enumerate() {
            for axis in 0..3 {
                assert!((axes[axis][row] - sample[axis]).abs() < 1e-14, "{row} {axis}");
            }
        }
        let said = correction.to_string();
        assert!(said.contains("INS_TCAL, offsets, scales, AHRS_ORIENTATION 2"), "{said}");
    }
}

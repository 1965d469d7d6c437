//! Corrections that ArduPilot applies to a sample before logging, undone by the parameters in the log.
//!
//! It subtracts a polynomial of the temperature (INS_TCALn), then an offset, multiplies by a scale, and rotates the
//! result into the vehicle's frame (`AP_InertialSensor_Backend.cpp`, `AP_InertialSensor_tempcal.cpp`). They are undone
//! in reverse order up to the first step whose parameters the log lacks: earlier steps remain in the values.

use std::collections::HashMap;

use super::super::rotation::{self, Matrix};
use crate::column::Triad;

/// Parameters by name, as PARM messages have them.
pub(super) type Parameters = HashMap<String, f64>;

/// Reference temperature of the polynomials, °C.
const REFERENCE_C: f64 = 35.0;

/// Scale factor of stored coefficients.
const STORED: f64 = 1e6;

/// Corrections of one sensor, accelerometers and gyros.
pub(super) struct Correction {
    /// Prefix of the instance's temperature correction, such as `INS_TCAL2_`.
    tcal: String,
    mounting: Mounting,
    sensors: [Sensor; 2],
}

/// Rotation from the board to the vehicle.
enum Mounting {
    None,
    /// Rotation matrix, and the parameters that define it.
    Known(Matrix, String),
    /// Parameters whose values are not in the log.
    Unknown(String),
}

#[derive(Default)]
struct Sensor {
    offset: [f64; 3],
    scale: [f64; 3],
    polynomial: Polynomial,
}

#[derive(Default)]
enum Polynomial {
    /// Disabled, or all zero.
    #[default]
    None,
    Known(Cubic),
    /// Enabled, without all of its parameters in the log.
    Incomplete,
}

/// Coefficients of T, T², T³ for each axis, and the clipping range of T.
struct Cubic {
    coefficients: [[f64; 3]; 3],
    range_c: [f64; 2],
    /// Temperature at which the offsets were calibrated.
    calibrated_c: f64,
}

/// Corrections of a triad that were undone or not, each by the name of its parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Undone {
    /// Corrections no longer in the values.
    pub(super) undone: Vec<String>,
    /// Corrections still in the values, and why.
    pub(super) left: Vec<String>,
    /// True if the values are in the frame of the vehicle, as logged.
    pub(super) in_vehicle: bool,
}

impl Cubic {
    fn at(&self, axis: usize, celsius: f64) -> f64 {
        let t = celsius.clamp(self.range_c[0], self.range_c[1]) - REFERENCE_C;
        let [first, second, third] = self.coefficients[axis];
        (first + (second + third * t) * t) * t
    }

    /// Correction subtracted at a temperature.
    fn subtracted(&self, axis: usize, celsius: f64) -> f64 {
        self.at(axis, celsius) - self.at(axis, self.calibrated_c)
    }
}

/// Name of a parameter of a sensor: the first has no number, the fourth and fifth are in a separate group.
fn name_of(number: u8, sensor: &str, what: &str) -> String {
    match number {
        1 => format!("INS_{sensor}{what}"),
        2 | 3 => format!("INS_{sensor}{number}{what}"),
        _ => format!("INS{number}_{sensor}{what}"),
    }
}

/// The `device_id` of the accelerometers and gyros of an instance.
pub(super) fn device_ids(parameters: &Parameters, instance: u8) -> [Option<u32>; 2] {
    ["ACC", "GYR"].map(|sensor| {
        let id = parameters.get(&name_of(instance + 1, sensor, "_ID")).copied()?;
        (id > 0.0 && id <= f64::from(u32::MAX)).then_some(id as u32)
    })
}

impl Correction {
    pub(super) fn of(parameters: &Parameters, instance: u8) -> Self {
        let get = |name: String| parameters.get(&name).copied().filter(|value| value.is_finite());
        let number = instance + 1;
        let tcal = if number <= 3 { format!("INS_TCAL{number}_") } else { format!("INS{number}_TCAL_") };
        let sensor = |sensor: &str| {
            let triad = |what: &str, default: f64| {
                ["X", "Y", "Z"]
                    .map(|axis| get(name_of(number, sensor, &format!("{what}_{axis}"))).unwrap_or(default))
            };
            let scale = if sensor == "ACC" { triad("SCAL", 1.0) } else { [1.0; 3] };
            Sensor {
                offset: triad("OFFS", 0.0),
                // a scale of 0 means that there is none
                scale: scale.map(|scale| if scale == 0.0 { 1.0 } else { scale }),
                polynomial: Polynomial::of(parameters, &tcal, sensor, number),
            }
        };
        let sensors = [sensor("ACC"), sensor("GYR")];
        Self { mounting: Mounting::of(parameters), sensors, tcal }
    }

    /// Undoes the corrections of the three axes of a sensor, as far as the log has the parameters. `warmth` holds
    /// timestamps and temperatures, °C.
    pub(super) fn undo(
        &self,
        triad: Triad,
        stamps_ns: &[i64],
        axes: &mut [Vec<f64>; 3],
        warmth: Option<(&[i64], &[f64])>,
    ) -> Undone {
        let [accelerometers, gyros] = &self.sensors;
        let sensor = match triad {
            Triad::Accelerometers => accelerometers,
            Triad::Gyros => gyros,
        };
        let mut outcome = Undone::default();
        let has_scale = sensor.scale != [1.0; 3];
        let has_offset = sensor.offset != [0.0; 3];
        match &self.mounting {
            Mounting::None => {}
            Mounting::Known(matrix, name) => {
                let [x, y, z] = &mut *axes;
                for ((x, y), z) in x.iter_mut().zip(y.iter_mut()).zip(z.iter_mut()) {
                    [*x, *y, *z] = rotation::turned_back(matrix, [*x, *y, *z]);
                }
                outcome.undone.push(name.clone());
            }
            Mounting::Unknown(missing) => {
                // the others are in the axes of the board, which differ from those of the values
                outcome.left.push(missing.clone());
                outcome.in_vehicle = true;
                outcome.left.extend(has_scale.then(|| "scales".to_owned()));
                outcome.left.extend(has_offset.then(|| "offsets".to_owned()));
                if !matches!(sensor.polynomial, Polynomial::None) {
                    outcome.left.push(self.tcal_name());
                }
                return outcome;
            }
        }
        for (axis, values) in axes.iter_mut().enumerate() {
            let (offset, scale) = (sensor.offset[axis], sensor.scale[axis]);
            if (offset, scale) != (0.0, 1.0) {
                values.iter_mut().for_each(|value| *value = *value / scale + offset);
            }
        }
        outcome.undone.extend(has_scale.then(|| "scales".to_owned()));
        outcome.undone.extend(has_offset.then(|| "offsets".to_owned()));
        match (&sensor.polynomial, warmth.map(only_measured)) {
            (Polynomial::None, _) => {}
            (Polynomial::Known(cubic), Some((at_ns, celsius))) if !at_ns.is_empty() => {
                for (axis, values) in axes.iter_mut().enumerate() {
                    let mut held = 0;
                    for (value, stamp) in values.iter_mut().zip(stamps_ns) {
                        while held + 1 < at_ns.len() && at_ns[held + 1] <= *stamp {
                            held += 1;
                        }
                        *value += cubic.subtracted(axis, celsius[held]);
                    }
                }
                outcome.undone.push(self.tcal_name());
            }
            (Polynomial::Known(_), _) => {
                let why = "the log has no temperature of this IMU: record IMU messages too";
                outcome.left.push(format!("{} ({why})", self.tcal_name()));
            }
            (Polynomial::Incomplete, _) => {
                let why = "not all of its parameters are in the log";
                outcome.left.push(format!("{} ({why})", self.tcal_name()));
            }
        }
        // in the order of application
        outcome.undone.reverse();
        outcome
    }

    fn tcal_name(&self) -> String {
        self.tcal.trim_end_matches('_').to_owned()
    }
}

/// Finite temperatures with their timestamps.
fn only_measured((at_ns, celsius): (&[i64], &[f64])) -> (Vec<i64>, Vec<f64>) {
    let measured = at_ns.iter().zip(celsius).filter(|(_, celsius)| celsius.is_finite());
    measured.map(|(stamp, celsius)| (*stamp, *celsius)).unzip()
}

impl Mounting {
    fn of(parameters: &Parameters) -> Self {
        let get = |name: &str| parameters.get(name).copied().filter(|value| value.is_finite());
        let orientation = get("AHRS_ORIENTATION").unwrap_or(0.0);
        let name = format!("AHRS_ORIENTATION {orientation}");
        // yaw after pitch after roll, degrees; 100 is that of versions before 4.2
        let custom = match orientation {
            0.0 => return Self::None,
            100.0 => ["AHRS_CUSTOM_ROLL", "AHRS_CUSTOM_PIT", "AHRS_CUSTOM_YAW"],
            101.0 => ["CUST_ROT1_ROLL", "CUST_ROT1_PITCH", "CUST_ROT1_YAW"],
            102.0 => ["CUST_ROT2_ROLL", "CUST_ROT2_PITCH", "CUST_ROT2_YAW"],
            _ => {
                return match rotation::of_ardupilot(orientation) {
                    Some(matrix) => Self::Known(matrix, name),
                    None => Self::Unknown(format!("{name} (not a mounting that is known)")),
                };
            }
        };
        match custom.map(get) {
            [Some(roll), Some(pitch), Some(yaw)] => {
                let name = format!("{name} (roll {roll}°, pitch {pitch}°, yaw {yaw}°)");
                Self::Known(rotation::of_angles([roll, pitch, yaw]), name)
            }
            _ => Self::Unknown(format!("{name} (its angles {} are not in the log)", custom.join(", "))),
        }
    }
}

impl Polynomial {
    fn of(parameters: &Parameters, tcal: &str, sensor: &str, number: u8) -> Self {
        let finite = |name: &str| parameters.get(name).copied().filter(|value| value.is_finite());
        let get = |name: &str| finite(&format!("{tcal}{name}"));
        // 2 means that it is being learned
        if get("ENABLE") != Some(1.0) {
            return Self::None;
        }
        let coefficients = ["X", "Y", "Z"].map(|axis| {
            [1, 2, 3].map(|power| get(&format!("{sensor}{power}_{axis}")).unwrap_or(0.0) / STORED)
        });
        if coefficients == [[0.0; 3]; 3] {
            return Self::None;
        }
        // the first three have their number here, which no other parameter of the first has
        let calibrated = match number {
            1..=3 => format!("INS_{sensor}{number}_CALTEMP"),
            _ => name_of(number, sensor, "_CALTEMP"),
        };
        match (get("TMIN"), get("TMAX"), finite(&calibrated)) {
            (Some(low), Some(high), Some(calibrated_c)) if low <= high => {
                Self::Known(Cubic { coefficients, range_c: [low, high], calibrated_c })
            }
            _ => Self::Incomplete,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELSIUS: [f64; 5] = [5.0, 20.0, 35.0, 50.0, 80.0];

    fn stamps() -> Vec<i64> {
        (0..5).map(|n| n * 1_000_000).collect()
    }

    fn raw(row: usize) -> [f64; 3] {
        [1.0 + row as f64, -2.0, 9.8]
    }

    /// Parameters of an instance by ArduPilot's names: an offset of 0.25 and a scale of 1.5 on x, a polynomial on x.
    fn parameters(instance: u8, mounting: &[(&str, f64)]) -> Parameters {
        let [offset, scale, tcal, calibrated] = match instance {
            0 => ["INS_ACCOFFS", "INS_ACCSCAL", "INS_TCAL1", "INS_ACC1_CALTEMP"],
            1 => ["INS_ACC2OFFS", "INS_ACC2SCAL", "INS_TCAL2", "INS_ACC2_CALTEMP"],
            2 => ["INS_ACC3OFFS", "INS_ACC3SCAL", "INS_TCAL3", "INS_ACC3_CALTEMP"],
            3 => ["INS4_ACCOFFS", "INS4_ACCSCAL", "INS4_TCAL", "INS4_ACC_CALTEMP"],
            _ => ["INS5_ACCOFFS", "INS5_ACCSCAL", "INS5_TCAL", "INS5_ACC_CALTEMP"],
        };
        let of_sensor = [
            (format!("{offset}_X"), 0.25),
            (format!("{scale}_X"), 1.5),
            (format!("{tcal}_ENABLE"), 1.0),
            (format!("{tcal}_TMIN"), 10.0),
            (format!("{tcal}_TMAX"), 60.0),
            (format!("{tcal}_ACC1_X"), 2000.0),
            (format!("{tcal}_ACC2_X"), -30.0),
            (calibrated.to_owned(), 30.0),
        ];
        of_sensor
            .into_iter()
            .chain(mounting.iter().map(|(name, value)| ((*name).to_owned(), *value)))
            .collect()
    }

    /// Samples as logged by ArduPilot, by its formulas; `turn` is the mounting.
    fn logged(turn: impl Fn([f64; 3]) -> [f64; 3]) -> [Vec<f64>; 3] {
        let polynomial = |celsius: f64| {
            let t = celsius.clamp(10.0, 60.0) - 35.0;
            2000e-6 * t - 30e-6 * t * t
        };
        let mut axes = [const { Vec::new() }; 3];
        for (row, celsius) in CELSIUS.into_iter().enumerate() {
            let [x, y, z] = raw(row);
            let x = (x - polynomial(celsius) + polynomial(30.0) - 0.25) * 1.5;
            axes.iter_mut().zip(turn([x, y, z])).for_each(|(axis, value)| axis.push(value));
        }
        axes
    }

    fn furthest(axes: &[Vec<f64>; 3]) -> f64 {
        let off = |row: usize, axis: usize| (axes[axis][row] - raw(row)[axis]).abs();
        (0..5).flat_map(|row| (0..3).map(move |axis| off(row, axis))).fold(0.0, f64::max)
    }

    /// Rotates about z after y: independent of the matrices under test.
    fn yaw_after_pitch([x, y, z]: [f64; 3], pitch: f64, yaw: f64) -> [f64; 3] {
        let (sp, cp) = pitch.to_radians().sin_cos();
        let (sy, cy) = yaw.to_radians().sin_cos();
        let (x, z) = (cp * x + sp * z, cp * z - sp * x);
        [cy * x - sy * y, sy * x + cy * y, z]
    }

    #[test]
    fn undoes_the_corrections_of_every_instance_and_mounting() {
        let quarter = |[x, y, z]: [f64; 3]| [-y, x, z];
        for instance in 0..5 {
            let correction = Correction::of(&parameters(instance, &[("AHRS_ORIENTATION", 2.0)]), instance);
            let mut axes = logged(quarter);
            let done =
                correction.undo(Triad::Accelerometers, &stamps(), &mut axes, Some((&stamps(), &CELSIUS)));
            assert!(furthest(&axes) < 1e-14, "{instance}: {axes:?}");
            let tcal = if instance < 3 {
                format!("INS_TCAL{}", instance + 1)
            } else {
                format!("INS{}_TCAL", instance + 1)
            };
            assert_eq!(done.undone, [&tcal, "offsets", "scales", "AHRS_ORIENTATION 2"]);
            assert!(done.left.is_empty() && !done.in_vehicle);
            // another instance was corrected by its own parameters
            let other = Correction::of(&parameters(instance, &[]), (instance + 1) % 5);
            let mut untouched = logged(|vector| vector);
            let done = other.undo(Triad::Accelerometers, &stamps(), &mut untouched, None);
            assert_eq!((done, untouched), (Undone::default(), logged(|vector| vector)));
        }
        for (orientation, names) in [
            (100.0, ["AHRS_CUSTOM_ROLL", "AHRS_CUSTOM_PIT", "AHRS_CUSTOM_YAW"]),
            (101.0, ["CUST_ROT1_ROLL", "CUST_ROT1_PITCH", "CUST_ROT1_YAW"]),
            (102.0, ["CUST_ROT2_ROLL", "CUST_ROT2_PITCH", "CUST_ROT2_YAW"]),
        ] {
            let mounting =
                [("AHRS_ORIENTATION", orientation), (names[0], 0.0), (names[1], 12.5), (names[2], -90.5)];
            let mut axes = logged(|vector| yaw_after_pitch(vector, 12.5, -90.5));
            let correction = Correction::of(&parameters(0, &mounting), 0);
            let done =
                correction.undo(Triad::Accelerometers, &stamps(), &mut axes, Some((&stamps(), &CELSIUS)));
            assert!(furthest(&axes) < 1e-14, "{orientation}");
            assert!(done.left.is_empty(), "{done:?}");
            // without one of its angles nothing is changed
            let mut axes = logged(|vector| yaw_after_pitch(vector, 12.5, -90.5));
            let correction = Correction::of(&parameters(0, &mounting[..3]), 0);
            let done =
                correction.undo(Triad::Accelerometers, &stamps(), &mut axes, Some((&stamps(), &CELSIUS)));
            assert_eq!(axes, logged(|vector| yaw_after_pitch(vector, 12.5, -90.5)));
            assert!(done.undone.is_empty() && done.in_vehicle && done.left.len() == 4, "{done:?}");
        }
        let mut in_the_wrong_order = logged(|vector| vector);
        in_the_wrong_order[0].iter_mut().for_each(|value| *value = (*value + 0.25) / 1.5);
        println!(
            "attack: corrections undone | offsets, scale factors, temperature tables and mountings of 5 instances, applied by independent formulas: each reported reversal restores the raw values to rounding error, and nothing else changes | negative control: reversing scale and offset in the wrong order leaves {:.2} m/s²",
            furthest(&in_the_wrong_order),
        );
    }

    #[test]
    fn names_only_corrections_that_were_undone() {
        let undo = |parameters: &Parameters, warmth| {
            let mut axes = logged(|vector| vector);
            let done =
                Correction::of(parameters, 0).undo(Triad::Accelerometers, &stamps(), &mut axes, warmth);
            (done, furthest(&axes))
        };
        let all = parameters(0, &[]);
        let times = stamps();
        let known = undo(&all, Some((&times[..], &CELSIUS[..])));
        assert_eq!((known.0.undone.len(), known.0.left.len()), (3, 0));
        assert!(known.1 < 1e-14);
        let mut incomplete = all.clone();
        incomplete.remove("INS_ACC1_CALTEMP");
        let no_temperature: [f64; 5] = [f64::NAN; 5];
        for (done, off) in [
            undo(&all, None),
            undo(&all, Some((&times[..], &no_temperature[..]))),
            undo(&incomplete, Some((&times[..], &CELSIUS[..]))),
        ] {
            assert_eq!(done.undone, ["offsets", "scales"]);
            assert!(done.left.len() == 1 && done.left[0].starts_with("INS_TCAL1 ("), "{done:?}");
            // the polynomial is still in the values
            assert!(off > 0.01, "{off}");
        }
        // disabled, or being learned
        for enable in [0.0, 2.0] {
            let mut off = all.clone();
            off.insert("INS_TCAL1_ENABLE".to_owned(), enable);
            assert_eq!(undo(&off, None).0.left, Vec::<String>::new());
        }
    }

    #[test]
    fn detects_a_correction_step_in_the_wrong_order() {
        // the offset subtracted after the scale instead of before it
        let mut axes = logged(|vector| vector);
        for values in &mut axes[..1] {
            values.iter_mut().for_each(|value| *value = (*value + 0.25) / 1.5);
        }
        assert!(furthest(&axes) > 0.05);
    }
}

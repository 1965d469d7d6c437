//! Sensor of the autopilot to which a temperature table applies, from the provenance of the fitted log.
//!
//! A table for the wrong sensor, from values that the autopilot has already corrected, or in other axes is worse than none, and the
//! autopilot accepts it silently. A table is therefore written only if the log or the user states the sensor.

use fos_data::column::Triad;
use fos_data::recording::{Format, Frame, Recording, SensorProvenance, Values};

/// An autopilot with temperature correction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Autopilot {
    /// PX4: `TC_A0_*`, `TC_G0_*` to `TC_A3_*`, `TC_G3_*` (`TemperatureCompensation.h`, `SENSOR_COUNT_MAX`).
    Px4,
    /// ArduPilot: `INS_TCAL1_*` to `INS_TCAL3_*`, `INS4_TCAL_*`, `INS5_TCAL_*` (`AP_InertialSensor_Params.cpp`).
    ArduPilot,
}

/// Statements of the user about the sensor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StatedSensor {
    /// Number of the sensor on the autopilot, from 0.
    pub instance: Option<u8>,
    /// `device_id` of accelerometers and gyros.
    pub device_ids: [Option<u32>; 2],
}

/// Sensor to which a table applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableSensor {
    /// Number of the sensor on the autopilot, from 0.
    pub instance: u8,
    /// `device_id` of accelerometers and gyros, if known.
    pub device_ids: [Option<u32>; 2],
    /// The `device_id` of a sensor in the log is unknown.
    pub lacks_device_id: bool,
}

/// Reason why a table is not written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TableRefusal {
    /// The values are not those that the autopilot corrects, or the sensor of the log is unknown.
    #[error("{log}: no table for {}: {why}\nhelp: {help}", autopilot.name())]
    NoTable { log: String, autopilot: Autopilot, why: String, help: &'static str },
    #[error(
        "no table for IMU {instance} of {}: it has tables for 0 to {last} only\nhelp: choose one of these with --topic when the log is fitted",
        autopilot.name()
    )]
    NoSuchInstance { autopilot: Autopilot, instance: u8, last: u8 },
    #[error(
        "{log}: it is of {found}, but {stated} was stated\nhelp: remove {option}, or fit the log of that sensor (--topic)"
    )]
    OtherSensor { log: String, found: String, stated: String, option: &'static str },
}

impl Autopilot {
    /// Name for messages, format of the autopilot's own logs, highest number of a sensor with a table, and advice on what to record.
    fn about(self) -> (&'static str, Format, u8, &'static str) {
        match self {
            Self::Px4 => (
                "PX4",
                Format::Ulog,
                3,
                "record sensor_accel and sensor_gyro at their full rate (SDLOG_PROFILE 769: their FIFOs), and fit that log",
            ),
            Self::ArduPilot => (
                "ArduPilot",
                Format::Dataflash,
                4,
                "record IMU messages beside ACC and GYR (the IMU and IMU_RAW bits of LOG_BITMASK) with all parameters, and fit that log",
            ),
        }
    }

    pub fn name(self) -> &'static str {
        self.about().0
    }

    /// Highest number of a sensor with a table.
    pub fn last_instance(self) -> u8 {
        self.about().2
    }
}

impl TableSensor {
    /// Determines the sensor to which a table fitted to `log` applies.
    pub fn of(log: &Recording, autopilot: Autopilot, stated: StatedSensor) -> Result<Self, TableRefusal> {
        let path = log.paths();
        let mut instance = None;
        let mut device_ids = stated.device_ids;
        let mut lacks_device_id = false;
        // Sensor numbers in logs of another autopilot do not apply to this one.
        let format =
            |source: &fos_data::recording::Source| source.read_as.as_ref().map(|read_as| read_as.format);
        let (_, own_format, last, _) = autopilot.about();
        let is_own = log.sources.iter().all(|source| format(source) == Some(own_format));
        for (at, triad) in [Triad::Accelerometers, Triad::Gyros].into_iter().enumerate() {
            if triad.columns().into_iter().all(|column| log.channel(column).is_err()) {
                continue;
            }
            let found = log.provenance(triad);
            refuse_values(&path, autopilot, triad, &found)?;
            if !is_own {
                lacks_device_id |= device_ids[at].is_none();
                continue;
            }
            let same_number = [instance, stated.instance].into_iter().flatten();
            for other in same_number {
                if let Some(number) = found.instance.filter(|number| *number != other) {
                    return Err(TableRefusal::OtherSensor {
                        log: path,
                        found: format!("IMU {number}"),
                        stated: format!("IMU {other}"),
                        option: "--instance",
                    });
                }
            }
            instance = found.instance.or(instance);
            if let (Some(id), Some(other)) = (found.device_id, device_ids[at])
                && id != other
                && autopilot == Autopilot::Px4
            {
                return Err(TableRefusal::OtherSensor {
                    log: path,
                    found: format!("device_id {id}"),
                    stated: format!("device_id {other}"),
                    option: "--device-id",
                });
            }
            device_ids[at] = found.device_id.or(device_ids[at]);
            lacks_device_id |= device_ids[at].is_none();
        }
        let Some(instance) = instance.or(stated.instance) else {
            return Err(TableRefusal::NoTable {
                log: path,
                autopilot,
                why: "the log does not identify the IMU".to_owned(),
                help: "state it with --instance, counted from 0 as in the autopilot's logs: --instance 0 for the first",
            });
        };
        if instance > last {
            return Err(TableRefusal::NoSuchInstance { autopilot, instance, last });
        }
        Ok(Self { instance, device_ids, lacks_device_id })
    }
}

/// Refuses values on which the autopilot's correction would be wrong.
fn refuse_values(
    log: &str,
    autopilot: Autopilot,
    triad: Triad,
    found: &SensorProvenance,
) -> Result<(), TableRefusal> {
    let sensor = name_of(triad);
    let why = match (&found.values, found.frame) {
        (Values::Corrected(by), _) => format!(
            "its {sensor} were corrected before they were logged, by {by}; a table of them would correct a second time"
        ),
        (_, Frame::Board | Frame::Unstated) => return Ok(()),
        (_, frame) => format!("its {sensor} are in the {frame}, and a table is in the axes of the board"),
    };
    let (.., help) = autopilot.about();
    Err(TableRefusal::NoTable { log: log.to_owned(), autopilot, why, help })
}

fn name_of(triad: Triad) -> &'static str {
    match triad {
        Triad::Accelerometers => "accelerometers",
        Triad::Gyros => "gyros",
    }
}

#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// Names of fields speak for themselves; doc comments are written where they add a unit, a range or a reason.
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

mod accelerometer;
mod cautions;
mod error;
pub mod export;
mod gravity;
mod gyro;
mod gyro_start;
mod imu;
mod least_squares;
mod length_fit;
mod orientation;
mod parameter;
mod quiet;
mod rests;
mod shown;
mod triad;
mod turn;
mod turntable;
mod vector;

pub use accelerometer::{Accelerometer, Next, Options, RestResidual};
pub use error::CalibrateError;
pub use gravity::{Gravity, GravitySource};
pub use gyro::{Gyro, Turn, TurnExclusion};
pub use imu::{Axes, Imu, Scale};
pub use orientation::Orientation;
pub use parameter::{Determined, LEVEL, Parameter};
pub use rests::{Exclusion, Rest};
pub use shown::{Shown, shown};
pub use triad::{PAIRS, TriadModel};
pub use turntable::{Plateau, Turntable, calibrate_on_turntable};

/// Calibration of an IMU from a log of rests in many orientations.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Calibration {
    pub accelerometer: Accelerometer,
    /// `None` in a log without a gyro.
    pub gyro: Option<Gyro>,
}

/// Calibrates.
pub fn calibrate(imu: &Imu, options: &Options) -> Result<Calibration, CalibrateError> {
    if let Some((column, value)) = imu.accelerometer.as_ref().and_then(Axes::stuck) {
        return Err(CalibrateError::StuckAxis { column: column.to_owned(), value });
    }
    let windows = quiet::windows(imu);
    let found = accelerometer::calibrate(imu, &windows, options)?;
    let gyro = imu.gyro.as_ref().map(|axes| gyro::calibrate(imu, axes, &found.accelerometer, &found.rests));
    Ok(Calibration { accelerometer: found.accelerometer, gyro })
}

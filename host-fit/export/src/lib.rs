#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// Names of fields speak for themselves; doc comments are written where they add a unit, a range or a reason.
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

mod ardupilot;
mod c_source;
mod error;
mod px4;
mod refusal;
mod rust_source;
mod target;
mod test_vector;

pub use ardupilot::ArduPilot;
pub use c_source::c_source;
pub use error::ExportError;
pub use fos_fit::export::{
    NoiseModel, NoiseModelError, NoiseUnits, SHARE, UnusableImage, allan_csv, description, image, imu_yaml,
    orb_slam3, vins,
};
pub use px4::Px4;
pub use refusal::Refusal;
pub use rust_source::rust_source;
pub use target::{Autopilot, StatedSensor, TableRefusal, TableSensor};
pub use test_vector::{OwnedTestVector, Room, Unnoticed, test_vector};

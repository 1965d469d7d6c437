//! Exports for other software: a model as source code for a device, with a test vector that proves identical results, and the bias by
//! temperature. The image and the noise files are written by `fos_fit::export`.
//!
//! | file | writes |
//! |---|---|
//! | `rust_source`, `c_source`, `test_vector` | a model for a device |
//! | `px4`, `ardupilot` | bias by temperature, as corrected by these autopilots |
//! | `target` | the sensor that such a table is for; refuses values that are already corrected |

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

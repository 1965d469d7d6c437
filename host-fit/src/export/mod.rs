//! What others take: a model as source code for a device, with the test vector that proves it runs there as here; the
//! noise of a log as tables and as the files of other stacks.
//!
//! | file | writes |
//! |---|---|
//! | `rust_source`, `c_source`, `test_vector` | a model for a device |
//! | `allan_csv` | the noise of a log as a table |
//! | `noise_model` | one number of noise for three axes, for the files below |
//! | `imu_yaml` | the noise for Kalibr and OpenVINS |
//! | `slam` | the noise for ORB-SLAM3 and VINS |
//! | `px4`, `ardupilot` | the bias by temperature, as these autopilots correct it |

mod allan_csv;
mod ardupilot;
mod c_source;
mod comment;
mod error;
mod imu_yaml;
mod noise_model;
mod noise_unit;
mod px4;
mod refusal;
mod rust_source;
mod slam;
mod test_vector;

pub use allan_csv::{SHARE, allan_csv};
pub use ardupilot::ArduPilot;
pub use c_source::c_source;
pub use error::ExportError;
pub use fos_fit::export::{UnusableImage, current, description, image, version};
pub use imu_yaml::imu_yaml;
pub use noise_model::{NoiseModel, NoiseModelError};
pub use noise_unit::NoiseUnits;
pub use px4::Px4;
pub use refusal::Refusal;
pub use rust_source::rust_source;
pub use slam::{orb_slam3, vins};
pub use test_vector::{OwnedTestVector, Room, Unnoticed, test_vector};

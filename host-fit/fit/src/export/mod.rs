//! Exports: the image of a model, its description, and the model in it; the noise of a log as a table and as files of
//! other stacks.
//!
//! | file | writes |
//! |---|---|
//! | `image` | the image that a device reads |
//! | `description`, `model_of` | an image in words, and as a model again |
//! | `allan_csv` | the noise of a log as a table |
//! | `noise_model` | one number of noise for three axes, for the files below |
//! | `filter_comment` | discrete noise of a Kalman filter, for the comments of `imu_yaml` |
//! | `imu_yaml` | the noise for Kalibr and OpenVINS |
//! | `slam` | the noise for ORB-SLAM3 and VINS |

mod allan_csv;
mod comment;
mod description;
mod filter_comment;
mod image;
mod imu_yaml;
mod model_of;
mod noise_model;
mod noise_unit;
mod real;
mod slam;

pub use allan_csv::{SHARE, allan_csv};
pub use comment::in_ascii;
pub use description::description;
pub use image::{UnusableImage, image};
pub use imu_yaml::imu_yaml;
pub use model_of::{NoColumn, model_of};
pub use noise_model::{NoiseModel, NoiseModelError};
pub use noise_unit::NoiseUnits;
pub use slam::{orb_slam3, vins};

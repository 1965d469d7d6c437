#![doc = include_str!("../README.md")]
//!
//! # Contents
//!
//! - [`Model`]: inputs, terms, scaling of up to six axes; immutable. [`Image`] is its stored form.
//! - [`Predictor`]: one step per sample. It [tracks](Predictor::track) while the device is known to be still and
//!   [coasts](Predictor::coast) while it moves; [`StillnessDetector`] decides which.
//! - [`PoseGate`]: is the true value of this axis at rest known, that is, is the orientation that of the fit?
//! - [`Correction`]: predicted error and corrected value of one axis, with a [`Validity`].
//! - [`Calibration`]: bias, sensitivity and cross-axis of three axes, for corrected values.
//! - [`Monitor`]: does the model still fit?
//! - [`align`]: resamples streams with separate timestamps to a common time base, before any of these.
//!
//! Measured error of one axis: y(n) = (measured(n) − reference(n) − offset)/scale. Model: ŷ(n) = p(n) + r̂(n), the
//! physical part p over inputs, the stochastic part r̂ over the lagged remainder r = y − p and inputs
//! (docs/MATHS.md).
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod align;
mod arithmetic;
mod axis;
mod calibration;
mod check;
mod convert;
mod error;
mod evaluator;
mod exponential;
mod fixed;
mod history;
pub mod image;
mod input;
mod model;
mod monitor;
mod pose;
mod predictor;
mod program;
mod range;
mod real;
mod root;
#[cfg_attr(not(feature = "transforms"), path = "running_identity.rs")]
mod running;
mod stillness;
mod term;
mod transform;
mod transformer;
#[cfg(feature = "transforms")]
mod turn;
mod validity;

pub use axis::Correction;
pub use calibration::{Calibration, TriadCalibration};
pub use check::CheckedModel;
pub use error::ModelError;
#[cfg(feature = "coasts")]
pub use evaluator::Coasts;
pub use evaluator::{Evaluator, Sample};
pub use fixed::Fixed;
pub use image::{Image, ImageError, Info};
pub use input::{Input, Source};
pub use model::{Axis, AxisModel, AxisParameters, FittedOn, InnovationStatistics, Model, Quantity};
pub use monitor::{Drift, Monitor};
pub use pose::{GRAVITY_MPS2, OTHER_POSE, PoseGate};
pub use predictor::Predictor;
pub use range::Range;
pub use real::{Real, Scalar};
pub use stillness::{StillnessDetector, StillnessLimits};
pub use term::{Channel, Factor, MAX_DEGREE, Term, u, y};
pub use transform::Transform;
#[cfg(feature = "transforms")]
pub use transformer::Transformer;
pub use validity::Validity;

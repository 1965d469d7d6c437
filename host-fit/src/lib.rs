//! Fits models of inertial sensor error offline, compares them with the measurements, and exports them.

pub mod recording;
pub mod signal;

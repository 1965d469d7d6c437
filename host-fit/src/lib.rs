//! Fits models of inertial sensor error with Fast Orthogonal Search, compares and exports them.
#![forbid(unsafe_code)]

pub mod bench;
pub mod candidates;
pub mod fit;
pub mod moments;
pub mod recording;
pub mod signal;

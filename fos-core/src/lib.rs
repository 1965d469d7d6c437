//! Evaluates fitted models of inertial sensor error, sample by sample.
#![no_std]
#![forbid(unsafe_code)]

mod term;

pub use term::{Channel, Factor, u, y};

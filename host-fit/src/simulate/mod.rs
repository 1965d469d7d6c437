//! Logs with known truth: a six-axis unit with a thermometer, at rest and in motion, and a band-limited nonlinear hour;
//! every number from a seed.

pub mod band_limited;
mod noise;
mod unit;

pub use unit::{SimulatedLog, Simulation, simulate};

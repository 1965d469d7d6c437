//! Logs with known truth: a six-axis unit with a thermometer, at rest and in motion, every number from a seed.

mod noise;
mod unit;

pub use unit::{SimulatedLog, Simulation, simulate};

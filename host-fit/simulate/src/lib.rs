#![doc = include_str!("../README.md")]
//!
//! Logs with known truth: a six-axis unit with a thermometer, at rest and in motion; a band-limited nonlinear hour;
//! cases for the diagnosis with a planted effect; every number from a seed.
//!
//! | file | of a case |
//! |---|---|
//! | `part`, `coloured` | data sheets; the noise of a drawn unit |
//! | `setup`, `thermal`, `motion`, `world` | how it is used; what is then true |
//! | `effect`, `regressors`, `course` | what can be planted; its formula |
//! | `disturbance` | what the world does beside: knocks, hands, motors, wild samples, the part's filter |
//! | `plant`, `planting`, `strength`, `rivals` | what is planted; how large it is in the noise |
//! | `plan`, `recorder`, `case`, `case_meta`, `case_folder` | what to simulate; what is logged; a whole case |
//! | `streams` | the same log as sensors with clocks of their own would have given it |
//! | `suite` | many cases, to measure rates |

#![forbid(unsafe_code)]
// a doc comment says more than the name, or is not written
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod band_limited;

mod axis;
mod case;
mod case_folder;
mod case_meta;
mod coloured;
mod course;
mod disturbance;
mod draft;
mod effect;
mod motion;
mod noise;
mod part;
mod plan;
mod plant;
mod planting;
mod random;
mod recorder;
mod regressors;
mod rivals;
mod setup;
mod shape;
mod story;
mod streams;
mod strength;
mod suite;
mod thermal;
mod unit;
mod world;

#[cfg(test)]
mod case_tests;

pub use axis::Axis;
pub use case::{LogTruth, SimulatedCase, Truth, simulate_case};
pub use case_folder::CaseFolderError;
pub use coloured::{AxisNoise, Colour, GaussMarkov};
pub use disturbance::{Disturbance, Disturbed};
pub use effect::{Band, Description, Effect, Outside};
pub use part::{PARTS, Part};
pub use plan::{CasePlan, Durations, Kind, Level, NOMINAL_RATE_HZ, PlanError};
pub use plant::Plant;
pub use planting::{Planted, assess};
pub use setup::{Path, Setup};
pub use story::{HIDDEN_IN, StoryError, hidden_effects};
pub use suite::{suite, suite_in};
pub use unit::{SimulatedLog, Simulation, simulate};

#![doc = include_str!("../README.md")]
//!
//! Logs with known truth: a six-axis device with a thermometer, at rest and in motion; a band-limited nonlinear hour;
//! cases for the diagnosis with a planted effect; every number from a seed.
//!
//! | file | subject of a case |
//! |---|---|
//! | `part`, `coloured` | data sheets; the noise of a drawn device |
//! | `setup`, `thermal`, `motion`, `world` | its use; the resulting true quantities |
//! | `effect`, `regressors`, `course` | available effects; their formulas |
//! | `disturbance` | other influences: knocks, hands, motors, outliers, the part's filter |
//! | `plant`, `planting`, `strength`, `rivals` | planted effects; their size relative to the noise |
//! | `plan`, `recorder`, `case`, `case_meta`, `case_folder` | the plan; the recorded logs; a whole case |
//! | `streams` | the same log as sensors with separate clocks |
//! | `suite` | many cases, to measure rates |

#![forbid(unsafe_code)]
// doc comments that only repeat the name are omitted
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod band_limited;

mod axis;
mod case;
mod case_folder;
mod case_meta;
mod coloured;
mod course;
mod demo_case;
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
pub use demo_case::{DemoCaseError, HIDDEN_IN, hidden_effects};
pub use disturbance::{Disturbance, Disturbed};
pub use effect::{Band, Description, Effect, Outside};
pub use part::{PARTS, Part};
pub use plan::{CasePlan, Durations, Kind, Level, NOMINAL_RATE_HZ, PlanError};
pub use plant::Plant;
pub use planting::{Planted, assess};
pub use setup::{Path, Setup};
pub use suite::{suite, suite_in};
pub use unit::{SimulatedLog, Simulation, simulate};

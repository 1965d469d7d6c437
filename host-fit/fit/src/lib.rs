#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// doc comments that would only repeat a name are omitted
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod calibration;
pub mod candidates;
pub mod cost;
pub mod evaluate;
pub mod export;
pub mod fit;
pub mod model;
pub mod moments;
pub mod noise;
mod parameters;
pub mod playback;
pub mod series;
pub mod signal;
pub mod single_axis;
pub mod thermal;
mod unit_calibration;

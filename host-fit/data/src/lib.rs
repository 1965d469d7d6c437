#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// doc comments that only repeat the name are omitted
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod case;
pub mod catch_panic;
pub mod closest;
pub mod column;
pub mod disturbance;
pub mod escaping;
pub mod file;
pub mod interrupt;
pub mod observed;
pub mod pose;
pub mod recording;
pub mod schema;
pub mod spikes;
pub mod statistics;
pub mod stillness;
pub mod stuck;
pub mod text;
pub mod unit;
pub mod visible;

//! Common parts of the tests of several crates, and tests of the public interfaces of the workspace (`tests/`).

pub mod flash;
pub mod foreign;
pub mod models;
pub mod noise;
pub mod outside;
pub mod page;
pub mod reference;
pub mod series;
pub mod turned;

use std::env;

/// Returns true if `FOS_THOROUGH` is set: tests then run every combination and enough random cases for narrow
/// statistical bounds. Otherwise they run a selection.
pub fn is_thorough() -> bool {
    env::var_os("FOS_THOROUGH").is_some()
}

/// Compiles the device example of README.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;

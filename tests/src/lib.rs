//! What tests of several crates share, and tests over the public interfaces of the workspace (`tests/`).

pub mod flash;
pub mod foreign;
pub mod models;
pub mod noise;
pub mod outside;
pub mod page;
pub mod reference;
pub mod series;

/// README's device example compiles.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;

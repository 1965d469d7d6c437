#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// doc comments that would only repeat a name are omitted
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod batch;
pub mod case;
pub mod cautions;
pub mod compare;
#[cfg(test)]
mod compare_tests;
pub mod dependence;
pub mod detect;
pub mod effects;
mod memo;
pub mod physical;
pub mod refine;
mod rms;
pub mod session;
pub mod study;
pub mod thermal;

//! Finds the physical effect that a model of inertial sensor error lacks, adds it, and shows what that gains.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod batch;
pub mod case;
pub mod compare;
pub mod dependence;
pub mod detect;
pub mod effects;
pub mod refine;
pub mod study;

//! The program `fos`: the command line over the libraries of this workspace, and the development commands: rates of the diagnosis,
//! benchmarks, the tables of the paper.
#![forbid(unsafe_code)]
#![allow(
    clippy::result_large_err,
    reason = "an error carries places and help, and is made once, where a command ends"
)]
// All output goes through cli/output.rs, which escapes characters that act on a terminal.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

#[cfg(feature = "development")]
pub mod bench;
#[cfg(feature = "development")]
pub mod calibration;
pub mod cli;
#[cfg(feature = "development")]
pub mod paper;
mod program;
#[cfg(feature = "development")]
mod timing;

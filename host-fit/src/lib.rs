//! The program `fos`: the command line over the libraries beside it, and the development commands that calibrate, benchmark and repeat the
//! paper.
#![forbid(unsafe_code)]
#![allow(
    clippy::result_large_err,
    reason = "an error carries places and help, and is made once, where a command ends"
)]
// All output goes through cli/output.rs, which escapes characters that act on a terminal.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod bench;
pub mod calibration;
pub mod cli;
pub mod paper;
mod program;
mod timing;

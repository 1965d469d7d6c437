//! The program `fos`: command line, workbench in the browser, reports and figures over the libraries fos-data, fos-fit, fos-diagnose and
//! fos-simulate; and the connection to the device: recording its telemetry, replaying a model as it runs there.
#![forbid(unsafe_code)]
#![allow(
    clippy::result_large_err,
    reason = "an error carries places and help, and is made once, where a command ends"
)]
// All output goes through cli/output.rs, which escapes characters that act on a terminal.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod bench;
pub mod calibration;
pub mod certificate;
pub mod cli;
mod command_lines;
pub mod curves;
mod escaping;
pub mod examine;
pub mod export;
pub mod figures;
pub mod hub_log;
pub mod paper;
mod physical_terms;
pub mod plots;
mod program;
pub mod record;
pub mod replay;
pub mod report;
mod timing;
mod unaided;
mod units;
#[cfg(feature = "workbench")]
pub mod workbench;

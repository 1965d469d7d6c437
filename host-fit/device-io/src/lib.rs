#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// Names of fields speak for themselves; doc comments are written where they add a unit, a range or a reason.
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]
#![allow(
    clippy::result_large_err,
    reason = "an error carries places and help, and is made once, where a command ends"
)]

pub mod hub_log;
pub mod record;
pub mod replay;

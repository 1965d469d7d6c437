#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// Names of fields speak for themselves; doc comments are written where they add a unit, a range or a reason.
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod hub_log;
pub mod record;
pub mod replay;

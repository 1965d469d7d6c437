#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// Names of fields speak for themselves; doc comments are written where they add a unit, a range or a reason.
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

mod api;
mod assets;
mod folders;
mod guard;
mod job;
mod known;
mod populations;
mod queue;
mod series;
mod server;
mod standing;
mod state;
mod study;
mod task;
mod tasks;
mod view;
mod workspace;

#[cfg(test)]
mod page_types_tests;
#[cfg(test)]
mod tests;

pub use folders::Folders;
pub use server::{ServeError, Server};

//! The workbench: a local web page on the same engine as the command line.
//!
//! | file | is |
//! |---|---|
//! | `server` | which request goes where |
//! | `guard` | who may ask: this page, from this machine |
//! | `api` | what is asked and answered |
//! | `assets` | the page, in the binary |
//! | `desk` | all studies that are open |
//! | `study` | one study: its logs, its axes, and the one job that runs |
//! | `queue` | what a study is to do, and what it is doing |
//! | `tasks` | what a job does |
//! | `job` | progress of a job, and its end before time |
//! | `series` | a time series for display, true to its peaks |
//! | `folders` | which files may be opened |
//! | `example` | the built-in example |

mod api;
mod assets;
mod desk;
mod example;
mod folders;
mod guard;
mod job;
mod queue;
mod series;
mod server;
mod study;
mod tasks;

#[cfg(test)]
mod tests;

pub use folders::Folders;
pub use server::{ServeError, Server};

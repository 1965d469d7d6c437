//! The workbench: a local web page on the same engine as the command line.
//!
//! | file | is |
//! |---|---|
//! | `server` | which request goes where |
//! | `guard` | who may ask: this page, from this machine |
//! | `api` | what is asked and answered |
//! | `populations` | the same of populations |
//! | `assets` | the page, in the binary |
//! | `desk` | all studies that are open |
//! | `study` | one study and its thread |
//! | `state` | what changes under its lock |
//! | `known` | what is known of it; what a task sees, and what it changes |
//! | `standing` | the outcome for an axis and for a study |
//! | `told` | what a page is told of it |
//! | `queue` | what a study is to do, and what it is doing |
//! | `task` | a piece of work that waits |
//! | `tasks` | what is done for it |
//! | `job` | progress of the work, and its end before time |
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
mod told;

#[cfg(test)]
mod page_types_tests;
#[cfg(test)]
mod tests;

pub use folders::Folders;
pub use server::{ServeError, Server};

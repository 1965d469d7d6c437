//! The workbench: a local web page on the same engine as the command line.
//!
//! | file | is |
//! |---|---|
//! | `server` | routes and connections |
//! | `guard` | access control: this page, from this machine |
//! | `api` | requests and answers |
//! | `populations` | requests and answers on populations |
//! | `assets` | the page, in the binary |
//! | `desk` | open studies |
//! | `study` | one study and its thread |
//! | `state` | its state, which changes under a lock |
//! | `known` | its results; input and output of a task |
//! | `standing` | the outcome for an axis and for a study |
//! | `told` | data of a study for the page |
//! | `queue` | waiting tasks of a study, and the running one |
//! | `task` | pieces of work on a study |
//! | `tasks` | execution of tasks |
//! | `job` | description and progress of a job |
//! | `series` | a time series for display, true to its peaks |
//! | `folders` | files that may be opened |
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

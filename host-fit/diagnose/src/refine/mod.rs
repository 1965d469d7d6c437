//! Refinement of a model by physical effects: estimates them together on a log where the model fails, adds them to the
//! physical part, and evaluates every step on rows that were not fitted.

mod check;
mod error;
mod evidence;
mod identifiable;
mod logs;
mod observed_log;
mod refiner;
mod terms;
#[cfg(test)]
mod undetermined_tests;

pub use error::RefineError;
pub use evidence::{Against, Evidence, LineEvidence, evidence_without_model, line_evidence};
pub use logs::Logs;
pub use refiner::{FITTED_SHARE, Refiner};
pub use terms::factors;

//! Diagnosis: compares a log that a model does not explain with every effect of the library. It identifies the missing
//! effect, its uncertainty and the effects that are indistinguishable from it, or reports that nothing in the library
//! explains the log.
//!
//! | stage | file |
//! |---|---|
//! | the logs are cleaned and reduced to blocks, without faults and spectral lines, and the noise is stated | `prepared` |
//! | every effect is tested, and the residual is searched | `search` |
//! | the results become findings and a verdict | `findings` |
//!
//! The tests are in the order of their evidence (docs/decisions/diagnosis.md): faults of the data, lines in the
//! spectrum, slow effects in block means, then an open search for effects outside the library.

mod answer;
mod clean_log;
mod correction;
mod dead_zone;
mod diagnose;
mod error_in_blocks;
mod faults;
mod findings;
mod hypothesis;
mod left_over;
mod leverage;
mod limits;
mod lines;
mod measured_reduction;
mod open;
mod power;
mod predicted_reduction;
mod prepared;
mod question;
mod search;
mod shape;
mod shared_signal;
mod slow;
mod telegraph;
mod testable;
mod visibility;

#[cfg(test)]
mod bursts_tests;
#[cfg(test)]
mod estimate_tests;
#[cfg(test)]
mod faults_tests;
#[cfg(test)]
mod nothing_tested_tests;
#[cfg(test)]
mod planted_tests;
#[cfg(test)]
mod rests_tests;
#[cfg(test)]
mod thermometer_tests;
#[cfg(test)]
mod visibility_tests;

pub use crate::rms::rms_reduction;
#[cfg(feature = "page-types")]
pub(crate) use answer::FindingWithRms;
pub(crate) use answer::finding_with_rms;
pub use answer::{
    CorrectionTerm, Diagnosis, Finding, NoiseReport, Rejected, Separation, SharedSignal, Size, Untested,
    Verdict,
};
pub(crate) use correction::{as_after_steps, is_step, step_time};
pub use correction::{correction, is_fast};
pub use diagnose::{diagnose, estimate};
pub use error_in_blocks::ErrorInBlocks;
pub(crate) use findings::not_identifiable;
pub use measured_reduction::{diagnose_and_measure, with_measured_reduction};
pub use open::Lead;
pub(crate) use question::keeps_bias;
pub use question::{DiagnoseError, Given, MIN_BLOCKS, Question};
pub use shared_signal::with_shared_signal;
pub use visibility::{Course, Visibility, visibility};

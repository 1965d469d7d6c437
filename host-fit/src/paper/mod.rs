//! The paper's comparison on any log: Yule-Walker, covariance, modified covariance and Burg, on samples as measured and
//! de-noised, against FOS on samples as measured, at every model order.
//!
//! The rows at rest are split in three, in the order of time: *train* (every model is fitted), *evaluate* (one is chosen) and *predict*
//! (all are evaluated). Two mean square errors are always given:
//!
//! - *as in the paper*: each method predicts the kind of samples it was fitted to, so de-noised samples from de-noised samples;
//! - *same target*: every method predicts the samples as measured from samples as measured.
//!
//! Only the second compares methods. Residuals are computed sample by sample with the arithmetic of the refit; the tests compare them with
//! fos-core.

mod compare;
mod curves;
mod evaluate;
mod figures;
mod position_error;
mod result;
mod settings;
mod split;

#[cfg(test)]
mod tests;

pub use compare::{PaperError, compare};
pub use curves::Curves;
pub use figures::figures;
pub use result::{Cell, Comparison, Entry, Evaluated};
pub use settings::Settings;
pub use split::{Split, SplitError};

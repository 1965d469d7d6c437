//! Findings from the results of the searches: sizes in data-sheet units, predicted reductions, rivals and experiments,
//! and the verdict in a sentence.
//!
//! | file | subject |
//! |---|---|
//! | `assembly` | all parts of a diagnosis; the findings of faults and of noise |
//! | `lines`, `slow` | lines and slow effects as findings |
//! | `powers` | coefficients of a polynomial about the mean of its input |
//! | `verdict` | the findings that remain beside an unexplained residual; the outcome in a sentence |
//! | `diagnosis` | composition of findings and leads |

mod assembly;
mod diagnosis;
mod doubt;
mod lines;
mod powers;
mod rejected;
mod slow;
mod verdict;

pub(super) use assembly::Assembly;
pub(crate) use doubt::not_identifiable;
pub(super) use verdict::{is_confirmed, listed, sentence, verdict};

//! From what the searches found to an answer: sizes in data-sheet units, the fall to expect, rivals and experiments,
//! the verdict in a sentence.
//!
//! | file | subject |
//! |---|---|
//! | `assembly` | everything that an answer is made of; the findings of faults and of noise |
//! | `lines`, `slow` | lines and slow effects as findings |
//! | `verdict` | what an unexplained rest leaves of the findings; the outcome in a sentence |
//! | `diagnosis` | findings and leads put together |

mod assembly;
mod diagnosis;
mod doubt;
mod lines;
mod rejected;
mod slow;
mod verdict;

pub(super) use assembly::Assembly;
pub(crate) use doubt::not_identifiable;
pub(super) use verdict::{listed, sentence, verdict};

//! Third stage of a diagnosis, findings from the results of the searches: sizes in data-sheet units, predicted
//! reductions, rivals and experiments, and the verdict in a sentence.
//!
//! | file | subject |
//! |---|---|
//! | `faults_and_noise` | faults and noise as findings |
//! | `lines`, `slow` | lines and slow effects as findings |
//! | `powers` | coefficients of a polynomial about the mean of its input |
//! | `verdict` | the findings that remain beside an unexplained residual; the outcome in a sentence |
//! | `diagnosis` | composition of findings and leads |

mod diagnosis;
mod doubt;
mod faults_and_noise;
mod lines;
mod powers;
mod rejected;
mod slow;
mod verdict;

pub(crate) use doubt::not_identifiable;
pub(super) use verdict::{is_confirmed, listed, sentence, verdict};

use super::answer::Finding;
use super::prepared::Prepared;
use super::question::DiagnoseError;
use super::search::SearchResults;

/// Composes the findings and the diagnosis from the results of the searches in a prepared log.
pub(super) struct Composer<'a> {
    pub(super) prepared: &'a Prepared<'a>,
    pub(super) results: SearchResults,
}

impl Composer<'_> {
    /// Returns the slow effects in the order of the search, then the lines.
    pub(super) fn estimates(&self) -> Result<Vec<Finding>, DiagnoseError> {
        let mut findings = self.slow_findings(&self.results.slow.found.iter().collect::<Vec<_>>())?;
        findings.extend(self.line_findings()?);
        Ok(findings)
    }
}

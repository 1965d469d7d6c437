//! Effects that were tried and rejected, with reasons.

use super::Composer;
use crate::detect::answer::{Finding, Rejected};
use crate::detect::open::Lead;
use crate::detect::slow::MAX_FOUND;
use crate::effects::Band;

/// Least score of an effect alone for which a reason is given.
const LEAST_SCORE: f64 = 9.0;

impl Composer<'_> {
    /// Returns the effects that were tried and rejected, with reasons. `all_findings` holds all findings before they were
    /// compared with the leads.
    pub(super) fn rejected(
        &self,
        findings: &[Finding],
        all_findings: &[Finding],
        leads: &[Lead],
    ) -> Vec<Rejected> {
        let is_found = |id: &str| findings.iter().any(|finding| finding.effect == id);
        let effects = all_findings.iter().filter(|finding| finding.band != Band::Data);
        let names: Vec<&str> = effects.map(|finding| finding.name.as_str()).collect();
        let beside = match names[..] {
            [] => "the further noise that was found".to_owned(),
            _ => names.join(" and "),
        };
        let why = |id: &str, score: f64, left: Option<f64>| -> Option<String> {
            let rival_of =
                findings.iter().find(|finding| finding.confounded_with.iter().any(|rival| rival == id));
            let lead = leads.first().map(|lead| lead.follows.as_str());
            match (rival_of, left) {
                _ if score < LEAST_SCORE => None,
                _ if all_findings.iter().any(|found| found.effect == id) => {
                    lead.map(|lead| format!("found, but a larger residual follows {lead}"))
                }
                (Some(finding), _) => {
                    Some(format!("in this log it is indistinguishable from {}", finding.name))
                }
                (None, Some(left)) if left < LEAST_SCORE => {
                    Some(format!("after {beside} its score is {left:.0}"))
                }
                (None, Some(left)) => Some(format!(
                    "after {beside} its score is {left:.0}; one search finds at most {MAX_FOUND} effects"
                )),
                (None, None) => Some(format!("contained in {beside}")),
            }
        };
        // the score of an effect that the log could not have shown means nothing
        let is_untested = |id: &str| self.results.untested.iter().any(|untested| untested.effect == id);
        let tried = self.results.slow.tried.iter().filter(|(id, _)| !is_found(id) && !is_untested(id));
        tried
            .map(|(id, score)| {
                let left =
                    self.results.slow.beside.iter().find(|(other, _)| other == id).map(|(_, score)| *score);
                Rejected { effect: id.clone(), score: *score, why: why(id, *score, left) }
            })
            .collect()
    }
}

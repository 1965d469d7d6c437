//! What an unexplained rest leaves of the findings, and the outcome in a sentence.

use crate::detect::answer::{Finding, Verdict};
use crate::detect::open::Lead;
use crate::effects::Band;

/// Findings are kept beside an unexplained rest if they explain so many times as much.
const OUTWEIGHS: f64 = 5.0;

/// Leaves those findings beside an unexplained rest that explain far more than it.
pub(crate) fn outweighed(findings: &mut Vec<Finding>, leads: &[Lead]) {
    let most = leads.iter().map(|lead| lead.gain).fold(0.0, f64::max);
    findings.retain(|finding| finding.band == Band::Data || finding.gain > OUTWEIGHS * most);
}

/// The outcome in a sentence.
pub(crate) fn sentence(verdict: Verdict, findings: &[Finding], leads: &[Lead]) -> String {
    match verdict {
        Verdict::NothingMissing => {
            "Nothing is missing: what is left looks like the noise of the unit.".to_owned()
        }
        Verdict::Unexplained => {
            let lead = leads.first().map(|lead| lead.follows.as_str()).unwrap_or("nothing that is logged");
            let beside = match findings.first() {
                Some(finding) => format!(" beside {}", finding.name),
                None => String::new(),
            };
            format!(
                "Something is missing{beside}, and nothing in the library explains it; a lead: it follows {lead}."
            )
        }
        Verdict::Missing => {
            let finding = &findings[0];
            let params: Vec<String> =
                finding.params.iter().map(|(name, value)| format!("{name} = {value:.4}")).collect();
            let params = if params.is_empty() { String::new() } else { format!(" ({})", params.join(", ")) };
            let drop = match finding.predicted_reduction > 0.0 {
                true => {
                    format!("; with it the error should fall by {:.1} %", 100.0 * finding.predicted_reduction)
                }
                false if findings.len() > 1 && finding.band == Band::Slow => {
                    ", which alone helps little: the others are still missing".to_owned()
                }
                false => String::new(),
            };
            let rivals = match finding.confounded_with.is_empty() {
                true => String::new(),
                false => format!(" This log cannot tell it from {}.", finding.confounded_with.join(", ")),
            };
            format!("Most likely missing: {}{params}{drop}.{rivals}", finding.name)
        }
    }
}

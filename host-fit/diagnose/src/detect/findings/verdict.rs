//! Effect of unexplained residuals on the findings, and the outcome in a sentence.

use crate::detect::answer::{Finding, Verdict};
use crate::detect::correction::is_step;
use crate::detect::open::{Lead, LeadKind};
use crate::effects::Band;
use crate::rms::rms_reduction;
use fos_data::text::rounded;

/// Ratio of gains from which on a finding stands beside an unexplained residual.
const OUTWEIGHS: f64 = 5.0;

/// Least share of the predicted reduction that confirms an effect.
const CONFIRMED: f64 = 0.5;

/// Effect that explains nothing: other faults of the data hide slow effects, gaps only make a log shorter.
const GAPS: &str = "dropped_samples";

/// Returns true if the reduction measured on the evaluation log confirms the predicted one.
pub(crate) fn is_confirmed(finding: &Finding) -> bool {
    let predicted = finding.predicted_reduction;
    predicted > 0.0 && finding.measured_reduction.is_some_and(|measured| measured >= CONFIRMED * predicted)
}

/// Returns the outcome; `tested` is true if any slow effect was tested. Keeps the findings that explain far more than
/// any lead in their band: an effect that is clear by itself is reported although another residual is present, which is
/// described too.
pub(crate) fn verdict(findings: &mut Vec<Finding>, leads: &[Lead], tested: bool) -> Verdict {
    let most = |finding: &Finding| {
        let against = leads.iter().filter(|lead| lead.decides && is_wide(lead.band) == is_wide(finding.band));
        let weight = |lead: &Lead| match lead.kind {
            // a stressed package yields in jumps, which do not contradict the temperature that it follows
            LeadKind::Jumps if finding.shows_against.is_some() => 0.0,
            // only against the largest of the jumps
            LeadKind::Jumps if is_step(finding) => lead.gain,
            // another effect was refuted by the log that confirms this one
            LeadKind::Refuted if is_confirmed(finding) => 0.0,
            _ => OUTWEIGHS * lead.gain,
        };
        against.map(weight).fold(0.0, f64::max)
    };
    let gain = |findings: &[Finding]| -> f64 { findings.iter().filter_map(|finding| finding.gain).sum() };
    let before = gain(findings);
    findings.retain(|finding| finding.gain.is_none_or(|gain| gain > most(finding)));
    let withheld = before - gain(findings);
    let has_slow_lead = leads.iter().any(|lead| lead.decides && !is_wide(lead.band));
    // a fault of the data is conclusive only if no physical effect was found
    let is_fault = |finding: &Finding| finding.band == Band::Data;
    let only_faults = findings.iter().all(is_fault);
    let claims =
        || findings.iter().filter(|finding| finding.doubt.is_none() && (only_faults || !is_fault(finding)));
    let is_slow = |finding: &Finding| matches!(finding.band, Band::Slow | Band::Stochastic);
    let slow_is_explained = !has_slow_lead || claims().any(is_slow) && gain(findings) > OUTWEIGHS * withheld;
    match (findings.is_empty(), leads.iter().all(|lead| !lead.decides)) {
        (true, true) if tested => Verdict::NothingMissing,
        (_, true) if !tested && findings.iter().all(|finding| finding.effect == GAPS) => {
            Verdict::NotEnoughData
        }
        (false, _) if slow_is_explained && claims().next().is_some() => Verdict::Missing,
        _ => Verdict::Unexplained,
    }
}

/// Returns the outcome in a sentence.
pub(crate) fn sentence(verdict: Verdict, findings: &[Finding], leads: &[Lead]) -> String {
    match verdict {
        Verdict::NothingMissing => match leads.first() {
            None => "Nothing is missing: the residual looks like sensor noise.".to_owned(),
            Some(lead) => {
                format!("Nothing is missing that matters. A trace in the residual follows {}.", lead.follows)
            }
        },
        Verdict::Unexplained if leads.is_empty() => {
            let doubtful = findings.first().map_or_else(String::new, |finding| {
                let why = finding.doubt.as_deref().unwrap_or("it explains only part of the error");
                format!(": {}, but {why}", finding.name)
            });
            format!("Something is missing, and its best explanation is not conclusive{doubtful}.")
        }
        Verdict::Unexplained => {
            let lead = leads.first().map(|lead| lead.follows.as_str()).unwrap_or("nothing that is logged");
            let beside = match findings.first().filter(|finding| finding.band != Band::Data) {
                Some(finding) => format!(" beside {}", finding.name),
                None => String::new(),
            };
            let faults = faults(findings);
            format!(
                "Something is missing{beside}, and nothing in the library explains it. A lead: the residual follows {lead}.{faults}"
            )
        }
        Verdict::NotEnoughData => format!("Not enough data to test any slow effect.{}", faults(findings)),
        Verdict::Missing if findings[0].band == Band::Data => {
            let beside = match leads.first() {
                Some(lead) => format!("A trace in the residual follows {}", lead.follows),
                None => "No physical effect was found".to_owned(),
            };
            format!("{beside}.{}", faults(findings))
        }
        Verdict::Missing => {
            let finding = &findings[0];
            let claims: Vec<&Finding> = findings
                .iter()
                .filter(|other| {
                    other.doubt.is_none()
                        && other.band != Band::Data
                        && is_wide(other.band) == is_wide(finding.band)
                })
                .collect();
            let claims = if claims.is_empty() { vec![finding] } else { claims };
            let rivals = match finding.confounded_with.is_empty() {
                true => String::new(),
                false => format!(
                    " In this log it is indistinguishable from {}.",
                    finding.confounded_with.join(", ")
                ),
            };
            let beside = leads
                .first()
                .map_or_else(String::new, |lead| format!(" A smaller residual follows {}.", lead.follows));
            let faults = faults(findings);
            let names = listed(claims.iter().map(|claim| with_params(claim)));
            let drop = drop(&claims);
            format!("Most likely missing: {names}{drop}.{rivals}{beside}{faults}")
        }
    }
}

/// Returns true for an effect in the samples, which block means do not show.
fn is_wide(band: Band) -> bool {
    band == Band::Wide
}

/// Describes the reduction predicted for all of these findings together; each is predicted with those before it in the
/// model.
fn drop(claims: &[&Finding]) -> String {
    let left: f64 = claims.iter().map(|claim| 1.0 - claim.predicted_reduction).product();
    let reduction = rms_reduction(1.0 - left);
    if reduction <= 0.0 {
        return String::new();
    }
    let with = match claims.len() {
        1 => "it",
        2 => "both",
        _ => "all of them",
    };
    let of = if is_wide(claims[0].band) { "of the samples" } else { "of the slow error" };
    format!("; with {with} the RMS {of} should fall by {:.1} %", 100.0 * reduction)
}

pub(in crate::detect) fn listed(names: impl Iterator<Item = String>) -> String {
    let mut names: Vec<String> = names.collect();
    let last = names.pop().unwrap_or_default();
    if names.is_empty() { last } else { format!("{} and {last}", names.join(", ")) }
}

/// Lists the faults of the data among the findings as a sentence; empty without any.
pub(super) fn faults(findings: &[Finding]) -> String {
    let faults = findings.iter().filter(|finding| finding.band == Band::Data);
    let faults: Vec<String> = faults.map(with_params).collect();
    if faults.is_empty() { String::new() } else { format!(" Faults of the data: {}.", faults.join(", ")) }
}

/// Returns the name of a finding with its parameters.
fn with_params(finding: &Finding) -> String {
    let params = finding.params.iter().map(|(name, value)| format!("{name} = {}", rounded(*value, 3)));
    let params: Vec<String> = params.collect();
    match params.is_empty() {
        true => finding.name.clone(),
        false => format!("{} ({})", finding.name, params.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::faults_and_noise::bare;
    use super::*;
    use crate::effects::Library;

    fn finding(measured_reduction: Option<f64>) -> Finding {
        let library = Library::built_in();
        let (gain, predicted_reduction) = (Some(100.0), 0.4);
        Finding { gain, predicted_reduction, measured_reduction, ..bare(library.get("temp_linear").unwrap()) }
    }

    fn refuted(gain: f64) -> Lead {
        Lead::new(LeadKind::Refuted, "another effect".to_owned(), Band::Slow, gain)
    }

    /// A drift with temperature whose reduction the evaluation log confirmed was withheld for a weak effect that the same
    /// log refuted.
    #[test]
    fn refuted_effect_does_not_withhold_a_confirmed_one() {
        let outcome = |measured| {
            let mut findings = vec![finding(measured)];
            (verdict(&mut findings, &[refuted(30.0)], true), findings.len())
        };
        assert_eq!(outcome(Some(0.39)), (Verdict::Missing, 1));
        assert_eq!(outcome(Some(0.1)), (Verdict::Unexplained, 0));
        assert_eq!(outcome(None), (Verdict::Unexplained, 0));
    }
}

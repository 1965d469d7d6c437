//! Standing of an axis and of a study, as shown by the tab, the overview and the banner. Green only if the log allowed
//! the tests and every added effect has paid.

use serde::Serialize;

use fos_diagnose::detect::{Diagnosis, Untested, Verdict};
use fos_diagnose::effects::Band;
use fos_diagnose::study::{Refinement, RefinementStep};

/// Outcome for an axis, or the worst of a study's axes; later ones are worse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub(super) enum Outcome {
    /// Everything that the log allows was tested, and nothing was found.
    NothingMissing,
    /// Too little was tested for an all-clear.
    NotEnoughData,
    /// Nothing was found but faults of the data, such as missing samples.
    DataFault,
    /// An added effect does not reduce the error by more than noise.
    DidNotPay,
    /// Something is missing that no effect of the library explains.
    Unexplained,
    /// Effects of the library are missing.
    Missing,
}

/// Standing of one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Standing {
    pub(super) outcome: Outcome,
    pub(super) sentence: String,
    /// Data to record so that the tests become possible.
    pub(super) record: Vec<String>,
}

/// Smallest relative reduction of an RMS on evaluation data that counts: less is within its scatter, and unnoticeable.
const PAYS: f64 = 0.02;

/// Largest relative growth of the RMS of the samples that may be rounding.
const GROWS: f64 = 1e-3;

/// Text by which needs that a longer rest would meet are recognised; other needs are a column or a motion.
const AT_REST: &str = "at rest";

/// Returns true if an added effect reduces the error of its band by more than noise and leaves the samples no noisier.
pub(super) fn pays(before: &RefinementStep, after: &RefinementStep) -> bool {
    let Some(added) = &after.added else { return true };
    let fell = 1.0 - (1.0 - added.measured_reduction).max(0.0).sqrt();
    // a stochastic effect changes the noise model only, and predicts no reduction
    let claims = added.finding.band != Band::Stochastic && added.finding.predicted_reduction > 0.0;
    !claims || is_gain(fell, before.left.wide.sqrt(), after.left.wide.sqrt())
}

fn is_gain(fell: f64, samples_before: f64, samples_after: f64) -> bool {
    fell >= PAYS && samples_after <= (1.0 + GROWS) * samples_before
}

impl Standing {
    pub(super) fn of(diagnosis: &Diagnosis, refinement: Option<&Refinement>) -> Self {
        let needs = |wanted: fn(&str) -> bool| {
            let needs = diagnosis.untested.iter().flat_map(|untested| &untested.needs);
            let mut needs: Vec<String> = needs.filter(|need| wanted(need)).cloned().collect();
            needs.sort_unstable();
            needs.dedup();
            needs
        };
        let longer = needs(|need| need.contains(AT_REST));
        let said = diagnosis.sentence.clone();
        let steps = refinement.map_or(&[][..], |refinement| &refinement.steps);
        let unpaid = steps.windows(2).rfind(|steps| !pays(&steps[0], &steps[1]));
        let (outcome, sentence, record) = match (diagnosis.verdict, unpaid) {
            // a trace in the residual is mentioned in the sentence
            (Verdict::Missing, _) if has_only_faults(diagnosis) => (Outcome::DataFault, said, Vec::new()),
            (Verdict::Missing, _) => (Outcome::Missing, said, Vec::new()),
            (Verdict::Unexplained, _) => (Outcome::Unexplained, said, Vec::new()),
            (Verdict::NotEnoughData, _) => {
                let record = if longer.is_empty() { needs(|_| true) } else { longer };
                (Outcome::NotEnoughData, said, record)
            }
            (Verdict::NothingMissing, Some(steps)) => (Outcome::DidNotPay, did_not_pay(steps), Vec::new()),
            (Verdict::NothingMissing, None) if !longer.is_empty() => {
                (Outcome::NotEnoughData, too_little_rest(diagnosis), longer)
            }
            (Verdict::NothingMissing, None) => (Outcome::NothingMissing, said, Vec::new()),
        };
        Self { outcome, sentence, record }
    }
}

/// Returns true if every finding is a fault of the data rather than an effect of the sensor.
fn has_only_faults(diagnosis: &Diagnosis) -> bool {
    diagnosis.findings.iter().all(|finding| finding.band == Band::Data)
}

/// Largest number of effects that a sentence lists.
const LISTED: usize = 3;

fn too_little_rest(diagnosis: &Diagnosis) -> String {
    let is_short = |untested: &&Untested| untested.needs.iter().any(|need| need.contains(AT_REST));
    let effects: Vec<String> = diagnosis
        .untested
        .iter()
        .filter(is_short)
        .map(|untested| untested.effect.replace('_', " "))
        .collect();
    let more = match effects.len().saturating_sub(LISTED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let listed = effects[..effects.len().min(LISTED)].join(", ");
    format!("Nothing was found, but the log has too little time at rest to test {listed}{more}.")
}

fn did_not_pay(steps: &[RefinementStep]) -> String {
    let [before, after] = steps else { return String::new() };
    let name = after.added.as_ref().map_or("", |added| added.finding.name.as_str());
    let change = |of: fn(&RefinementStep) -> f64| 100.0 * ((of(after) / of(before)).sqrt() - 1.0);
    let (slow, samples) = (change(|step| step.left.slow), change(|step| step.left.wide));
    format!(
        "Adding {name} did not pay: the slow error changed by {slow:+.1} % and the error of the samples by {samples:+.1} % on data that were not fitted. Undo it."
    )
}

/// Returns the worst outcome of a study's axes; an all-clear only once every axis has one. None while nothing is known.
pub(super) fn worst(outcomes: impl IntoIterator<Item = Option<Outcome>>) -> Option<Outcome> {
    let outcomes: Vec<Option<Outcome>> = outcomes.into_iter().collect();
    let worst = outcomes.iter().copied().flatten().max()?;
    let is_complete = outcomes.iter().all(Option::is_some);
    (worst > Outcome::NothingMissing || is_complete).then_some(worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_study_is_as_its_worst_axis_and_green_only_when_all_are_known() {
        use Outcome::{Missing, NotEnoughData, NothingMissing};
        assert_eq!(worst([None, None]), None);
        assert_eq!(worst([Some(NothingMissing), None]), None);
        assert_eq!(worst([Some(NothingMissing), Some(NothingMissing)]), Some(NothingMissing));
        assert_eq!(worst([Some(NotEnoughData), None]), Some(NotEnoughData));
        assert_eq!(worst([Some(NothingMissing), Some(Missing), Some(NotEnoughData)]), Some(Missing));
    }

    #[test]
    fn a_small_reduction_or_noisier_samples_are_no_gain() {
        assert!(is_gain(0.78, 0.125, 0.076));
        // a g-sensitivity of 81 times the typical size: 1 % of the slow error, and noisier samples
        assert!(!is_gain(0.01, 0.125, 0.126));
        assert!(!is_gain(0.01, 0.125, 0.125));
        assert!(!is_gain(0.1, 0.125, 0.126));
    }

    fn diagnosis(untested: serde_json::Value) -> Diagnosis {
        serde_json::from_value(serde_json::json!({
            "target": "gx_rads", "unit": "rad/s", "verdict": "nothing_missing", "sentence": "Nothing is missing.",
            "findings": [], "leads": [], "rejected": [], "tested": ["temp_linear"], "untested": untested,
            "noise": { "levels": { "white": 1e-4, "flicker": 1e-5, "walk": 1e-7, "gauss_markov": null },
                "learnt_from": "a test", "block_s": 1.0, "blocks": 60 },
            "cautions": [],
        }))
        .unwrap()
    }

    #[test]
    fn dropped_samples_alone_are_a_fault_of_the_data_and_no_missing_effect() {
        let mut found = diagnosis(serde_json::json!([]));
        found.verdict = Verdict::Missing;
        found.findings = serde_json::from_value(serde_json::json!([{
            "effect": "dropped_samples", "name": "dropped samples", "band": "data", "params": { "frac": 7.8e-4 },
            "params_interval": {}, "sizes": [], "gain": null, "score": null, "expected_drop": 0.0,
            "expected_drop_ci": [0.0, 0.0], "confounded_with": [], "separate": [], "shows_against": null,
            "shows_from_to_s": null, "correction": [], "limits": {},
        }]))
        .unwrap();
        assert_eq!(Standing::of(&found, None).outcome, Outcome::DataFault);
        found.findings[0].band = Band::Slow;
        assert_eq!(Standing::of(&found, None).outcome, Outcome::Missing);
    }

    #[test]
    fn no_all_clear_where_the_rests_are_too_short_for_an_effect() {
        let missing_column = serde_json::json!([{ "effect": "supply_sensitivity", "needs": ["supply_v"] }]);
        assert_eq!(Standing::of(&diagnosis(missing_column), None).outcome, Outcome::NothingMissing);
        let short = serde_json::json!([{ "effect": "bias_ramp", "needs": ["30 s at rest, 1 s more than this log has"] }]);
        let standing = Standing::of(&diagnosis(short), None);
        assert_eq!(standing.outcome, Outcome::NotEnoughData);
        assert_eq!(standing.record, ["30 s at rest, 1 s more than this log has"]);
    }
}

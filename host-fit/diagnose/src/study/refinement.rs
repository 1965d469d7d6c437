//! What a study remembers of refining an axis: the logs, and every step.

use serde::ser::SerializeSeq;
use serde::{Deserialize, Serialize, Serializer};

use crate::detect::Finding;
use crate::effects::Effect;
use crate::rms::{RmsTwins, WithRms, rms_reduction};
use fos_data::recording::{LoadOptions, Source};
use fos_fit::cost::Cost;
use fos_fit::evaluate::ModelErrors;
use fos_fit::model::UnitModel;

/// An axis of a study that effects were added to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Refinement {
    /// The axis, by its column.
    pub column: String,
    pub logs: LogSources,
    /// The model before anything was added, then after each effect.
    #[serde(rename = "stairs", serialize_with = "with_rms")]
    #[cfg_attr(feature = "page-types", ts(as = "Vec<StepWithRms>"))]
    pub steps: Vec<RefinementStep>,
}

/// The logs that effects were estimated from and judged on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct LogSources {
    /// The log with the hidden effect.
    pub field: Source,
    /// A quiet log that the noise was learnt from.
    pub quiet: Option<Source>,
    /// The log that the errors are of; none: the rows of the field log from `fitted_rows` on.
    pub judged: Option<Source>,
    /// Rows of the field log that effects are estimated from, from the first on.
    pub fitted_rows: usize,
    #[serde(flatten)]
    pub read: LoadOptions,
}

/// A state of the model, and its errors on rows that were not fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct RefinementStep {
    /// What was added; none in the state before.
    pub added: Option<Added>,
    #[cfg_attr(feature = "page-types", ts(type = "unknown"))]
    pub model: UnitModel,
    /// All errors, on the judged rows.
    pub errors: ModelErrors,
    /// Variance of the 1-s means, and of the samples, of what the physical part leaves on the judged rows.
    pub left: Left,
    /// What the axis costs on the device.
    pub cost: Cost,
}

/// An effect that was added.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Added {
    /// The effect itself: the study can be read without the file it came from.
    pub effect: Effect,
    /// What it was found to be, with the reduction that is predicted.
    #[serde(serialize_with = "crate::detect::finding_with_rms")]
    #[cfg_attr(feature = "page-types", ts(as = "crate::detect::FindingWithRms"))]
    pub finding: Finding,
    /// The reduction that was measured, in the band of the effect.
    #[serde(rename = "realised_fall")]
    pub measured_reduction: f64,
}

/// What the physical part leaves of the error, in the square of the axis' unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Left {
    /// Variance of 1-s means.
    pub slow: f64,
    /// Variance of the samples.
    pub wide: f64,
    /// Mean on the judged rows less that on the rows that effects are estimated from, in the axis' unit: what the
    /// model's bias is off by. Absent where the log does not tell, and in studies from before it was kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias: Option<f64>,
}

impl LogSources {
    /// What differs from the logs of `now`, in words; empty if they are the same.
    pub(crate) fn changes(&self, now: &Self) -> String {
        let mut changes = Vec::new();
        let of = |which: &str, then: Option<&Source>, now: Option<&Source>| match (then, now) {
            (then, now) if then == now => None,
            (Some(then), Some(now)) if then.path == now.path => {
                Some(format!("{} (the {which}) has changed since", then.path))
            }
            (Some(then), Some(now)) => Some(format!("the {which} was {} and is now {}", then.path, now.path)),
            (Some(then), None) => Some(format!("the {which} was {} and is not given now", then.path)),
            (None, Some(now)) => Some(format!("{} is given as the {which} and was not then", now.path)),
            (None, None) => None,
        };
        changes.extend(of("log to explain", Some(&self.field), Some(&now.field)));
        changes.extend(of("reference log", self.quiet.as_ref(), now.quiet.as_ref()));
        changes.extend(of("evaluation log", self.judged.as_ref(), now.judged.as_ref()));
        if self.read != now.read {
            changes.push("the logs were read with other options".to_owned());
        }
        if changes.is_empty() && self != now {
            changes.push(format!("{} rows were fitted then and {} now", self.fitted_rows, now.fitted_rows));
        }
        changes.join("; ")
    }
}

impl Refinement {
    /// The effects that were added, in order.
    pub fn added(&self) -> impl Iterator<Item = &Added> {
        self.steps.iter().filter_map(|step| step.added.as_ref())
    }

    /// The state as it is now.
    pub fn last(&self) -> Option<&RefinementStep> {
        self.steps.last()
    }
}

#[cfg(feature = "page-types")]
crate::rms::twinned!(StepWithRms, RefinementStep);

/// Steps with the RMS of the slow error before and after each, and the measured reduction in the band of the effect.
fn with_rms<S: Serializer>(steps: &[RefinementStep], serializer: S) -> Result<S::Ok, S::Error> {
    let mut sequence = serializer.serialize_seq(Some(steps.len()))?;
    let mut rms_before = None;
    for step in steps {
        let rms_after = Some(step.left.slow.sqrt());
        let twins = RmsTwins {
            rms_before,
            rms_after,
            rms_reduction: step.added.as_ref().map(|added| rms_reduction(added.measured_reduction)),
            ..RmsTwins::default()
        };
        sequence.serialize_element(&WithRms { of: step, twins })?;
        rms_before = rms_after;
    }
    sequence.end()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(path: &str, digest: &str) -> Source {
        Source { sha256: digest.to_owned(), ..Source::made_by(path) }
    }

    /// A changed evaluation log was blamed on the log to explain.
    #[test]
    fn names_the_log_that_changed_and_no_other() {
        let then = LogSources {
            field: source("field.csv", "a"),
            quiet: Some(source("quiet.csv", "b")),
            judged: Some(source("later.csv", "c")),
            fitted_rows: 10,
            read: LoadOptions::default(),
        };
        assert_eq!(then.changes(&then), "");
        let judged = LogSources { judged: Some(source("later.csv", "d")), ..then.clone() };
        assert_eq!(then.changes(&judged), "later.csv (the evaluation log) has changed since");
        let field = LogSources { field: source("other.csv", "e"), ..then.clone() };
        assert_eq!(then.changes(&field), "the log to explain was field.csv and is now other.csv");
        let none = LogSources { quiet: None, ..then.clone() };
        assert_eq!(then.changes(&none), "the reference log was quiet.csv and is not given now");
        let read =
            LogSources { read: LoadOptions { rate_hz: Some(9.0), ..LoadOptions::default() }, ..then.clone() };
        assert_eq!(then.changes(&read), "the logs were read with other options");
    }
}

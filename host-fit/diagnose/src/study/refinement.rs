//! Record of the refinement of an axis in a study: the logs, and every step.

use serde::ser::SerializeSeq;
use serde::{Deserialize, Serialize, Serializer};

use crate::detect::Finding;
use crate::effects::Effect;
use crate::rms::{RmsTwins, WithRms, rms_reduction};
use fos_data::recording::{LoadOptions, Source};
use fos_fit::cost::Cost;
use fos_fit::evaluate::ModelErrors;
use fos_fit::single_axis::SingleAxisModel;

/// Axis of a study that effects were added to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Refinement {
    /// Column of the axis.
    pub column: String,
    pub logs: LogSources,
    /// Model before any effect was added, then after each.
    #[serde(serialize_with = "with_rms")]
    #[cfg_attr(feature = "page-types", ts(as = "Vec<StepWithRms>"))]
    pub steps: Vec<RefinementStep>,
}

/// Logs that effects were estimated from and evaluated on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct LogSources {
    /// Log to explain.
    pub log: Source,
    /// Reference log for the noise.
    pub reference: Option<Source>,
    /// Evaluation log; without one, the rows of the log to explain from `fitted_rows` on.
    pub evaluation: Option<Source>,
    /// Number of rows of the log to explain, from the first on, that effects are estimated from.
    pub fitted_rows: usize,
    #[serde(flatten)]
    pub read: LoadOptions,
}

/// State of the model, with its errors on rows that were not fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct RefinementStep {
    /// Effect added in this step; none in the first state.
    pub added: Option<Added>,
    #[cfg_attr(feature = "page-types", ts(type = "unknown"))]
    pub model: SingleAxisModel,
    /// Errors on the evaluation rows.
    pub errors: ModelErrors,
    /// Variances of the residual of the physical part on the evaluation rows.
    pub left: Left,
    /// Cost of the axis on the device.
    pub cost: Cost,
}

/// Effect that was added.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Added {
    /// Definition of the effect, so that the study can be read without its file.
    pub effect: Effect,
    /// Finding as estimated, with the predicted reduction.
    #[serde(serialize_with = "crate::detect::finding_with_rms")]
    #[cfg_attr(feature = "page-types", ts(as = "crate::detect::FindingWithRms"))]
    pub finding: Finding,
    /// Measured reduction, in the band of the effect.
    #[serde(rename = "realised_fall")]
    pub measured_reduction: f64,
}

/// Residual of the physical part, in the square of the axis' unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Left {
    /// Mean square of the 1-s means: about their mean, or, if the evaluation rows continue the log to explain, about the
    /// bias of that.
    pub slow: f64,
    /// Variance of the samples.
    pub wide: f64,
    /// Error of the model's bias: mean on the evaluation rows minus the mean on the rows that effects are estimated
    /// from, in the axis' unit. Absent if the log does not show the bias, and in studies of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias: Option<f64>,
}

impl LogSources {
    /// Describes the differences from the logs of `now`; empty if they are the same.
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
        changes.extend(of("log to explain", Some(&self.log), Some(&now.log)));
        changes.extend(of("reference log", self.reference.as_ref(), now.reference.as_ref()));
        changes.extend(of("evaluation log", self.evaluation.as_ref(), now.evaluation.as_ref()));
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
    /// Returns the added effects, in order.
    pub fn added(&self) -> impl Iterator<Item = &Added> {
        self.steps.iter().filter_map(|step| step.added.as_ref())
    }

    /// Returns the last state.
    pub fn last(&self) -> Option<&RefinementStep> {
        self.steps.last()
    }
}

#[cfg(feature = "page-types")]
crate::rms::twinned!(StepWithRms, RefinementStep);

/// Serialises steps with the RMS of the slow error before and after each, and the measured reduction in the band of the
/// effect.
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

    /// A changed evaluation log was reported as a change of the log to explain.
    #[test]
    fn changes_list_only_the_changed_log() {
        let then = LogSources {
            log: source("log.csv", "a"),
            reference: Some(source("reference.csv", "b")),
            evaluation: Some(source("later.csv", "c")),
            fitted_rows: 10,
            read: LoadOptions::default(),
        };
        assert_eq!(then.changes(&then), "");
        let evaluation = LogSources { evaluation: Some(source("later.csv", "d")), ..then.clone() };
        assert_eq!(then.changes(&evaluation), "later.csv (the evaluation log) has changed since");
        let other = LogSources { log: source("other.csv", "e"), ..then.clone() };
        assert_eq!(then.changes(&other), "the log to explain was log.csv and is now other.csv");
        let none = LogSources { reference: None, ..then.clone() };
        assert_eq!(then.changes(&none), "the reference log was reference.csv and is not given now");
        let read =
            LogSources { read: LoadOptions { rate_hz: Some(9.0), ..LoadOptions::default() }, ..then.clone() };
        assert_eq!(then.changes(&read), "the logs were read with other options");
    }
}

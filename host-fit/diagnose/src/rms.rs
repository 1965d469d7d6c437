//! Reductions of an RMS, beside the shares of variance in JSON: `rms_reduction` is 1 − √(1 − share).

use serde::ser::SerializeSeq;
use serde::{Serialize, Serializer};

use crate::compare::{AxisComparison, MODEL};
use crate::detect::{Finding, rms_reduction};
use crate::study::RefinementStep;
use fos_fit::evaluate::Rival;

/// A value with its reductions as RMS.
#[derive(Serialize)]
struct WithRms<'a, T> {
    #[serde(flatten)]
    of: &'a T,
    #[serde(skip_serializing_if = "Option::is_none")]
    rms_before: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rms_after: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rms_reduction: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rms_reduction_interval: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    measured_rms_reduction: Option<f64>,
}

impl<'a, T> WithRms<'a, T> {
    fn new(of: &'a T) -> Self {
        Self {
            of,
            rms_before: None,
            rms_after: None,
            rms_reduction: None,
            rms_reduction_interval: None,
            measured_rms_reduction: None,
        }
    }
}

impl<'a> WithRms<'a, Finding> {
    fn of_finding(finding: &'a Finding) -> Self {
        Self {
            rms_reduction: Some(rms_reduction(finding.predicted_reduction)),
            rms_reduction_interval: Some(finding.predicted_reduction_interval.map(rms_reduction)),
            measured_rms_reduction: finding.measured_reduction.map(rms_reduction),
            ..Self::new(finding)
        }
    }
}

/// Findings with the predicted and the measured reduction of the RMS.
pub(crate) fn findings<S: Serializer>(findings: &[Finding], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(findings.iter().map(WithRms::of_finding))
}

/// A finding with the predicted and the measured reduction of the RMS.
pub(crate) fn finding<S: Serializer>(finding: &Finding, serializer: S) -> Result<S::Ok, S::Error> {
    WithRms::of_finding(finding).serialize(serializer)
}

/// Steps with the RMS of the slow error before and after each, and the measured reduction in the band of the effect.
pub(crate) fn steps<S: Serializer>(steps: &[RefinementStep], serializer: S) -> Result<S::Ok, S::Error> {
    let mut sequence = serializer.serialize_seq(Some(steps.len()))?;
    let mut rms_before = None;
    for step in steps {
        let rms_after = Some(step.left.slow.sqrt());
        sequence.serialize_element(&WithRms {
            rms_before,
            rms_after,
            rms_reduction: step.added.as_ref().map(|added| rms_reduction(added.measured_reduction)),
            ..WithRms::new(step)
        })?;
        rms_before = rms_after;
    }
    sequence.end()
}

/// Axes with the RMS of the slow error in a free run: of the constant mean, and of the model.
pub(crate) fn axes<S: Serializer>(axes: &[AxisComparison], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(axes.iter().map(|axis| {
        let [before, after] = axis.slow_errors();
        WithRms {
            rms_before: before,
            rms_after: after,
            rms_reduction: before
                .zip(after)
                .filter(|(before, _)| *before > 0.0)
                .map(|(before, after)| 1.0 - after / before),
            ..WithRms::new(axis)
        }
    }))
}

impl AxisComparison {
    /// RMS of the slow error in a free run, in the unit of the axis: of the constant mean, and of the model.
    pub fn slow_errors(&self) -> [Option<f64>; 2] {
        [Rival::Mean.name(), MODEL].map(|name| {
            let errors = self.errors.iter().find(|errors| errors.model == name);
            errors.and_then(|errors| errors.slow_error_coast).map(f64::sqrt)
        })
    }
}

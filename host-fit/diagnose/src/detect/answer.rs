//! Result of a diagnosis as plain data, the same for tables, JSON and pages.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize, Serializer};

use super::open::Lead;
use crate::effects::{Band, Effect};
use crate::rms::{RmsTwins, WithRms, rms_reduction};
use fos_fit::noise::NoiseLevels;

/// Outcome of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// One or more effects of the library are missing from the model.
    Missing,
    /// The residual looks like the noise of the device.
    NothingMissing,
    /// There is a missing effect that nothing in the library explains.
    Unexplained,
    /// No slow effect could be tested: the log is too short, too little of it is at rest, or it lacks the columns that
    /// the effects need. Neither a finding nor an all-clear.
    NotEnoughData,
}

impl Verdict {
    /// Returns the verdict in readable form.
    pub fn words(self) -> &'static str {
        match self {
            Self::Missing => "missing effect",
            Self::NothingMissing => "nothing missing",
            Self::Unexplained => "unexplained",
            Self::NotEnoughData => "not enough data",
        }
    }

    /// Returns true if the diagnosis reports a missing effect or an unexplained error.
    pub fn is_alarm(self) -> bool {
        matches!(self, Self::Missing | Self::Unexplained)
    }
}

/// Diagnosis of one axis: the effects that are missing from its model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Diagnosis {
    /// Column that was explained.
    pub target: String,
    /// Unit of the column, of the noise and of the corrections.
    pub unit: String,
    pub verdict: Verdict,
    /// Outcome in a sentence.
    pub sentence: String,
    /// Missing effects, best first, then faults of the data.
    #[serde(serialize_with = "with_rms")]
    #[cfg_attr(feature = "page-types", ts(as = "Vec<FindingWithRms>"))]
    pub findings: Vec<Finding>,
    /// Further quantities that the residual follows. They are leads, not findings.
    pub leads: Vec<Lead>,
    /// Effects that were tried and rejected, with their scores, the highest first.
    pub rejected: Vec<Rejected>,
    /// Slow effects that were tested. Empty if the log allows no such test; the verdict is then never
    /// [`Verdict::NothingMissing`].
    #[serde(default)]
    pub tested: Vec<String>,
    /// Effects that could not be tested, with the data that they need.
    pub untested: Vec<Untested>,
    /// Noise levels that the scores are based on.
    pub noise: NoiseReport,
    /// Reasons to read the result with care.
    pub cautions: Vec<String>,
    /// Properties of the log that are neither faults nor reasons for doubt, such as its duty cycle.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Detected motion in a log at rest, in words.
    #[serde(default)]
    pub moved: Vec<String>,
    /// Slow signal that the axis shares with other axes of the log, if several were diagnosed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shared_signal: Option<SharedSignal>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Finding {
    /// Identifier in the library, as `thermal_lag`.
    pub effect: String,
    pub name: String,
    /// Band of the error: block means, single samples, the data themselves, or noise.
    pub band: Band,
    /// Value of the parameter, by name.
    pub params: BTreeMap<String, f64>,
    /// 95 % intervals of the parameters, where they are known.
    #[cfg_attr(feature = "page-types", ts(as = "BTreeMap<String, [Option<f64>; 2]>"))]
    pub params_interval: BTreeMap<String, [f64; 2]>,
    /// Sizes in data-sheet units, one per regressor.
    pub sizes: Vec<Size>,
    /// Decrease of −2 ln L. None for faults of the data, which are counted and not weighed.
    pub gain: Option<f64>,
    /// Gain minus a penalty for its coefficients and for every candidate tried; accepted from 9 (lines from 15). None
    /// for faults of the data.
    pub score: Option<f64>,
    /// Predicted reduction as a share of the error's variance: of 1-s means (slow) or of samples (wide).
    #[serde(rename = "expected_drop")]
    pub predicted_reduction: f64,
    /// 90 % interval of the predicted reduction.
    #[serde(rename = "expected_drop_ci")]
    pub predicted_reduction_interval: [f64; 2],
    /// Reduction measured on the evaluation log, with the findings before it in the model; a share of the variance.
    #[serde(rename = "realised_fall", default, skip_serializing_if = "Option::is_none")]
    pub measured_reduction: Option<f64>,
    /// Reason why the finding is not conclusive; `None` if it is conclusive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubt: Option<String>,
    /// Effects that are indistinguishable from it in this log.
    pub confounded_with: Vec<String>,
    /// Experiments that separate them.
    pub separate: Vec<Separation>,
    /// Column against which the effect shows best, if any.
    pub shows_against: Option<String>,
    /// Stretch of the log in which the effect is largest: begin and end as timestamps, s.
    pub shows_from_to_s: Option<[f64; 2]>,
    /// Regressors with their coefficients in SI, as the model uses them.
    pub correction: Vec<CorrectionTerm>,
    /// Limits to which inputs are clamped, by the text of the input: the range in which a curve may be extrapolated.
    #[serde(default)]
    pub limits: BTreeMap<String, [f64; 2]>,
}

/// Coefficient in data-sheet units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Size {
    pub of: String,
    /// Value in `unit`.
    pub value: f64,
    /// 95 % interval in `unit`; in JSON an end that is not finite is null.
    #[cfg_attr(feature = "page-types", ts(as = "[Option<f64>; 2]"))]
    pub interval: [f64; 2],
    /// Unit as on data sheets.
    pub unit: String,
}

impl Size {
    /// Returns a size with its 95 % interval, `half` to either side; `si` is the size of one `unit` in that of `value`.
    pub(crate) fn around(of: impl Into<String>, value: f64, half: f64, si: f64, unit: impl ToString) -> Self {
        let interval = [(value - half) / si, (value + half) / si];
        Self { of: of.into(), value: value / si, interval, unit: unit.to_string() }
    }
}

/// Experiment that separates a finding from a rival.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Separation {
    /// Identifier of the rival.
    pub effect: String,
    pub experiment: String,
}

/// Term of a correction: coefficient times regressor, in the unit of the axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct CorrectionTerm {
    /// Products of inputs, their sum, or `clock:step(t)`, which is 1 from t seconds after the first sample on and in
    /// every later log.
    pub regressor: String,
    /// Coefficient, in the unit of the axis per unit of the regressor.
    pub coefficient: f64,
    pub standard_error: f64,
}

/// Effect that was tried and rejected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Rejected {
    /// Identifier in the library, as `thermal_lag`.
    pub effect: String,
    /// Score of the effect alone on the log.
    pub score: f64,
    /// Reason for the rejection, if its score alone would have made it a finding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
}

/// Effect that could not be tested.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Untested {
    /// Identifier in the library, as `thermal_lag`.
    pub effect: String,
    /// Data that the log lacks: a column that is absent, begins too late or never changes, or time at rest.
    pub needs: Vec<String>,
}

impl Untested {
    pub(crate) fn of(effect: &Effect, needs: Vec<String>) -> Self {
        Self { effect: effect.id.clone(), needs }
    }

    /// Returns the data that are needed, in words.
    pub(crate) fn needs(&self) -> impl Iterator<Item = &str> {
        self.needs.iter().map(String::as_str)
    }
}

/// Noise model behind a diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct NoiseReport {
    /// Noise levels with all findings in the model, in the unit of the axis.
    pub levels: NoiseLevels,
    /// Source of the noise levels, in words.
    pub learnt_from: String,
    /// Length of the blocks for slow effects, s.
    pub block_s: f64,
    /// Number of blocks.
    pub blocks: usize,
}

/// Slow signal that several axes of a log share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct SharedSignal {
    /// Columns of the axes that share it.
    pub axes: Vec<String>,
    /// Correlation of the changes from one mean to the next, of each of these axes with the others.
    pub correlations: Vec<f64>,
    /// Length of the means, s.
    pub mean_s: f64,
    /// Signal at each mean: time in s after the first sample, and value in standard deviations.
    pub course: Vec<[f64; 2]>,
}

#[cfg(feature = "page-types")]
crate::rms::twinned!(FindingWithRms, Finding);

impl<'a> WithRms<'a, Finding> {
    fn of_finding(finding: &'a Finding) -> Self {
        let twins = RmsTwins {
            rms_reduction: Some(rms_reduction(finding.predicted_reduction)),
            rms_reduction_interval: Some(finding.predicted_reduction_interval.map(rms_reduction)),
            measured_rms_reduction: finding.measured_reduction.map(rms_reduction),
            ..RmsTwins::default()
        };
        Self { of: finding, twins }
    }
}

/// Serialises findings with the predicted and the measured reduction of the RMS.
fn with_rms<S: Serializer>(findings: &[Finding], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(findings.iter().map(WithRms::of_finding))
}

/// Serialises a finding with the predicted and the measured reduction of the RMS.
pub(crate) fn finding_with_rms<S: Serializer>(finding: &Finding, serializer: S) -> Result<S::Ok, S::Error> {
    WithRms::of_finding(finding).serialize(serializer)
}

//! What a diagnosis says: plain data, the same for tables, JSON and pages.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize, Serializer};

use super::open::Lead;
use crate::effects::Band;
use crate::rms::{RmsTwins, WithRms, rms_reduction};
use fos_fit::noise::NoiseLevels;

/// The outcome in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// One or more effects of the library are missing from the model.
    Missing,
    /// The log looks like the noise of the unit.
    NothingMissing,
    /// Something is missing, and nothing in the library explains it.
    Unexplained,
    /// No slow effect could be tested: the log is too short, too little of it is at rest, or the effects need columns
    /// that it lacks. Neither a finding nor an all-clear.
    NotEnoughData,
}

impl Verdict {
    /// Spelled for people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Missing => "missing effect",
            Self::NothingMissing => "nothing missing",
            Self::Unexplained => "unexplained",
            Self::NotEnoughData => "not enough data",
        }
    }

    /// Whether the diagnosis reports a missing or an unexplained error.
    pub fn is_alarm(self) -> bool {
        matches!(self, Self::Missing | Self::Unexplained)
    }
}

/// What is missing from a model on a log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Diagnosis {
    /// The column that was explained.
    pub target: String,
    /// Unit of the column, which noise and corrections are in.
    pub unit: String,
    pub verdict: Verdict,
    /// The outcome in a sentence.
    pub sentence: String,
    /// Missing effects, best first, then faults of the data.
    #[serde(serialize_with = "with_rms")]
    #[cfg_attr(feature = "page-types", ts(as = "Vec<FindingWithRms>"))]
    pub findings: Vec<Finding>,
    /// What else the log follows; leads and no findings.
    pub leads: Vec<Lead>,
    /// Effects that were tried and rejected, with their score; the nearest first.
    pub rejected: Vec<Rejected>,
    /// Slow effects that were tested. Empty if the log allows no such test; the verdict is then never
    /// [`Verdict::NothingMissing`].
    #[serde(default)]
    pub tested: Vec<String>,
    /// Effects that could not be tested, with the data that would be needed.
    pub untested: Vec<Untested>,
    /// The noise levels that the evidence rests on.
    pub noise: NoiseReport,
    /// Why the answer should be taken with care.
    pub cautions: Vec<String>,
    /// Properties of the log that are neither faults nor reasons for doubt, as its duty cycle.
    #[serde(default)]
    pub notes: Vec<String>,
    /// When the unit was moved though it was meant to be at rest, in words.
    #[serde(default)]
    pub moved: Vec<String>,
    /// A slow signal that the axis shares with others of the log, where several were diagnosed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shared_signal: Option<SharedSignal>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Finding {
    /// As in the library, as `thermal_lag`.
    pub effect: String,
    pub name: String,
    /// In block means, in single samples, in the data themselves, or as noise.
    pub band: Band,
    /// Its parameter, by name.
    pub params: BTreeMap<String, f64>,
    /// 95 % intervals of the parameters, where they are known.
    #[cfg_attr(feature = "page-types", ts(as = "BTreeMap<String, [Option<f64>; 2]>"))]
    pub params_interval: BTreeMap<String, [f64; 2]>,
    /// Its size in data-sheet units, one per regressor.
    pub sizes: Vec<Size>,
    /// By how much −2 ln L falls with it. None for faults of the data, which are counted and not weighed.
    pub gain: Option<f64>,
    /// The gain after the price of its coefficients and of everything that was tried; accepted from 9 (lines from 15).
    /// None for faults of the data.
    pub score: Option<f64>,
    /// Share of the error of its band that should go: of the variance of 1-s means (slow), of the samples (wide).
    #[serde(rename = "expected_drop")]
    pub predicted_reduction: f64,
    /// Its 90 % interval.
    #[serde(rename = "expected_drop_ci")]
    pub predicted_reduction_interval: [f64; 2],
    /// The reduction that was measured on the log that was given to judge on, those before it in the model.
    #[serde(rename = "realised_fall", default, skip_serializing_if = "Option::is_none")]
    pub measured_reduction: Option<f64>,
    /// Why it is no claim; none where nothing speaks against it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubt: Option<String>,
    /// Effects that this log cannot tell from it.
    pub confounded_with: Vec<String>,
    /// The experiments that separate them.
    pub separate: Vec<Separation>,
    /// The column against which it shows best, if any.
    pub shows_against: Option<String>,
    /// Where in the log it is largest: begin and end, s as stamped.
    pub shows_from_to_s: Option<[f64; 2]>,
    /// Its regressors and their coefficients in SI, as the model takes them.
    pub correction: Vec<CorrectionTerm>,
    /// Limits that inputs are kept inside, by their text: how far a curve may be followed.
    #[serde(default)]
    pub limits: BTreeMap<String, [f64; 2]>,
}

/// A coefficient in data-sheet units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Size {
    pub of: String,
    /// In `unit`.
    pub value: f64,
    /// 95 % interval; in JSON an end that is not finite is null.
    #[cfg_attr(feature = "page-types", ts(as = "[Option<f64>; 2]"))]
    pub interval: [f64; 2],
    /// As data sheets state it; `value` and `interval` are in it.
    pub unit: String,
}

/// The experiment that tells a finding from a rival.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Separation {
    /// Identifier of the rival.
    pub effect: String,
    pub experiment: String,
}

/// One term of a correction: coefficient times regressor, in the axis' unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct CorrectionTerm {
    /// Products of inputs, their sum, or `clock:step(t)`: 1 from t seconds after the first sample on, and in every
    /// later log.
    pub regressor: String,
    /// Coefficient, unit of the axis per unit of the product.
    pub coefficient: f64,
    pub standard_error: f64,
}

/// An effect that was tried and rejected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Rejected {
    /// As in the library, as `thermal_lag`.
    pub effect: String,
    /// Its score alone on the log.
    pub score: f64,
    /// Why it is no finding, if its score alone would have made it one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
}

/// An effect that could not be tried.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Untested {
    /// As in the library, as `thermal_lag`.
    pub effect: String,
    /// The data that the log lacks, in words: a column that is not there, begins too late or never changes; time at rest.
    pub needs: Vec<String>,
}

impl Untested {
    /// What would be needed, in words.
    pub(crate) fn needs(&self) -> impl Iterator<Item = &str> {
        self.needs.iter().map(String::as_str)
    }
}

/// The noise behind a diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct NoiseReport {
    /// Levels with everything that was found, unit of the axis.
    pub levels: NoiseLevels,
    /// Where they were learnt from.
    pub learnt_from: String,
    /// Length of the blocks that slow effects were looked for in, s.
    pub block_s: f64,
    /// How many blocks there are.
    pub blocks: usize,
}

/// A slow signal that several axes of a log share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct SharedSignal {
    /// The axes that share it, as columns.
    pub axes: Vec<String>,
    /// Correlation of each of these axes with the others, of changes from one mean to the next.
    pub correlations: Vec<f64>,
    /// Length of the means, s.
    pub mean_s: f64,
    /// Time of each mean, s after the first sample, and the signal there, in standard deviations.
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

/// Findings with the predicted and the measured reduction of the RMS.
fn with_rms<S: Serializer>(findings: &[Finding], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(findings.iter().map(WithRms::of_finding))
}

/// A finding with the predicted and the measured reduction of the RMS.
pub(crate) fn finding_with_rms<S: Serializer>(finding: &Finding, serializer: S) -> Result<S::Ok, S::Error> {
    WithRms::of_finding(finding).serialize(serializer)
}

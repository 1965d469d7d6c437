//! How an axis was fitted, as a study keeps it.

use fos_core::Factor;
use serde::{Deserialize, Serialize};

use super::options::FitMethod;
use super::poses::FittedPose;

/// How one axis was fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisReport {
    pub column: String,
    /// The reference column that was subtracted; none if the log is taken as static.
    pub reference_column: Option<String>,
    pub method: FitMethod,
    /// Candidates searched, or lags of an autoregression.
    pub candidates: usize,
    /// Rows that counted.
    pub rows: usize,
    /// Every term in the order of its selection; none for an autoregression, which has all lags.
    pub steps: Vec<SelectionStep>,
    /// Models of the same size that the data cannot tell from this one.
    pub ties: Vec<TiedModel>,
    /// Terms of the physical part that were asked for and left out, since the data say nothing of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOut>,
    /// Samples that are no measurements, and were left out.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub spikes: usize,
    /// The poses that it was fitted in, each with a constant of its own; none where there is one, or where gravity does
    /// not bear on it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub poses: Vec<FittedPose>,
    /// Why the search stopped, or what was done instead, in words.
    pub stopped: String,
    /// Condition number of the final terms, columns scaled.
    pub condition_number: f64,
    /// Mean square of the residual on the training data as measured, scaled units.
    pub mse: f64,
    /// Mean square of the remainder on the training data, scaled units.
    pub mean_square: f64,
    /// Lag-1 autocorrelation of the remainder on the training data.
    pub lag_1: f64,
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// A term of the physical part of which the data say nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    pub input: String,
    /// Its coefficient as estimated, scaled units.
    pub coefficient: f64,
    /// The standard error of that, scaled units.
    pub standard_error: f64,
}

/// One step of the search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SelectionStep {
    /// The monomial, in words.
    pub monomial: String,
    pub factors: Vec<Factor>,
    /// Q: drop of the mean square error, scaled units.
    pub mse_reduction: f64,
    /// ERR: the same over the mean square of the remainder.
    pub error_reduction_ratio: f64,
    /// Mean square error after the step, scaled units.
    pub mse: f64,
}

/// A model of the same size that the data cannot tell from the chosen one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TiedModel {
    /// Monomials of the chosen model that it lacks, in words.
    pub leaves: Vec<String>,
    /// Monomials that it has instead.
    pub enters: Vec<String>,
    /// n·ln(MSE of it / MSE of the chosen model); a parameter that does nothing lowers it by 1 on average.
    pub deviance: f64,
}

//! Report of the fit of an axis, as stored in a study.

use fos_core::Factor;
use serde::{Deserialize, Serialize};

use super::options::FitMethod;
use super::poses::FittedPose;

/// Report of the fit of one axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisReport {
    pub column: String,
    /// Reference column that was subtracted; none if the log is assumed to be static.
    pub reference_column: Option<String>,
    pub method: FitMethod,
    /// Number of candidates, or number of lags of an autoregression.
    pub candidates: usize,
    /// Number of rows used.
    pub rows: usize,
    /// Terms in the order of their selection; empty for an autoregression, which has all lags.
    pub steps: Vec<SelectionStep>,
    /// Models of the same size that are indistinguishable from this one.
    pub ties: Vec<TiedModel>,
    /// Requested physical terms that were excluded because they are not significant.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOut>,
    /// Number of outliers, which were excluded.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub spikes: usize,
    /// Orientations of the fitted rows, each with its own constant; empty if there is only one, or if gravity does not
    /// act on the axis.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub poses: Vec<FittedPose>,
    /// Reason why the search stopped, or the remedy applied, in words.
    pub stopped: String,
    /// Condition number of the final terms with scaled columns.
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

/// A physical term that is not significant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    pub input: String,
    /// Estimated coefficient, scaled units.
    pub coefficient: f64,
    /// Standard error of the coefficient, scaled units.
    pub standard_error: f64,
}

/// One step of the search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SelectionStep {
    /// Monomial in words.
    pub monomial: String,
    pub factors: Vec<Factor>,
    /// Q: reduction of the mean square error, scaled units.
    pub mse_reduction: f64,
    /// ERR: Q divided by the mean square of the remainder.
    pub error_reduction_ratio: f64,
    /// Mean square error after the step, scaled units.
    pub mse: f64,
}

/// A model of the same size that is indistinguishable from the chosen one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TiedModel {
    /// Monomials of the chosen model that it lacks, in words.
    pub leaves: Vec<String>,
    /// Monomials that it has instead.
    pub enters: Vec<String>,
    /// n·ln(its MSE / MSE of the chosen model); a parameter without effect decreases it by 1 on average.
    pub deviance: f64,
}

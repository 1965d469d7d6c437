//! Estimated numbers with their intervals.

use serde::Serialize;

/// Share of cases in which an interval holds the true value.
pub const LEVEL: f64 = 0.95;

/// Degree to which the log determines a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Determined {
    Well,
    /// The interval is several times as wide as those of other parameters: an orientation is missing.
    Weakly,
    /// The interval is that of the values which parts of this kind have, not of this log.
    NotByThisLog,
}

/// One number of a calibration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Identifier, `accelerometer.bias.x`.
    pub id: String,
    /// Spelled for people: "accelerometer x bias".
    pub label: String,
    pub value: f64,
    /// Half the width of the 95 % interval, in `unit`.
    pub half_width: f64,
    /// Unit of the value; empty for a ratio.
    pub unit: String,
    pub determined: Determined,
}

impl Parameter {
    /// True for values inside the 95 % interval, widened by `margin` on either side.
    pub fn holds(&self, value: f64, margin: f64) -> bool {
        (value - self.value).abs() <= self.half_width + margin
    }
}

/// Names of the axes, x, y, z.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// Standard deviations and correlations of a covariance, row by row.
pub(crate) fn correlations(covariance: &nalgebra::DMatrix<f64>) -> Vec<Vec<f64>> {
    let deviation = |i: usize| covariance[(i, i)].sqrt();
    (0..covariance.nrows())
        .map(|i| {
            let row = (0..covariance.ncols()).map(|j| {
                let correlation = covariance[(i, j)] / (deviation(i) * deviation(j));
                if correlation.is_finite() { correlation.clamp(-1.0, 1.0) } else { 0.0 }
            });
            row.collect()
        })
        .collect()
}

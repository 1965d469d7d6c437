//! A noise level with its interval, and the likelihood that it is estimated with.

use serde::Serialize;

use super::levels::Regression;
use super::model::NoiseLevels;

/// Increase of −2 ln L at the ends of an interval: the 90 % quantile of χ² with one degree of freedom.
pub(super) const RISE: f64 = 2.705_543;

/// Estimate of one level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Level {
    /// Most likely value; none if the interval includes zero.
    pub value: Option<f64>,
    /// Lower end of the 90 % interval; none if it includes zero.
    pub low: Option<f64>,
    /// Upper end of the 90 % interval, which is also the 95 % limit if there is no lower end.
    pub high: f64,
}

impl Level {
    /// Returns the value, or its upper limit if there is none.
    pub fn at_most(&self) -> f64 {
        self.value.unwrap_or(self.high)
    }
}

/// −2 ln L of the part of the data that no regressor can explain (restricted likelihood).
pub(super) fn restricted_deviance(regression: &Regression<'_>, levels: NoiseLevels) -> f64 {
    let gls = regression.at(levels).gls;
    gls.deviance() + gls.log_determinant_of_information()
}

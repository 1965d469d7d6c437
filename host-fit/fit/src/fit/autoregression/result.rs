//! Common result of the methods, and their errors.

use std::fmt;

use thiserror::Error;

use crate::candidates::MAX_LAG;

/// Method of estimating an autoregression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Levinson-Durbin recursion on the biased autocorrelation.
    YuleWalker,
    /// Forward least squares.
    Covariance,
    /// Forward and backward least squares.
    ModifiedCovariance,
    Burg,
}

impl fmt::Display for Method {
    /// Formats the name as on the command line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::YuleWalker => "yule-walker",
            Self::Covariance => "covariance",
            Self::ModifiedCovariance => "modified-covariance",
            Self::Burg => "burg",
        })
    }
}

impl Method {
    pub const ALL: [Self; 4] = [Self::YuleWalker, Self::Covariance, Self::ModifiedCovariance, Self::Burg];
}

/// Estimated autoregression of order p.
#[derive(Debug, Clone, PartialEq)]
pub struct Autoregression {
    /// Coefficients a_1 … a_p.
    pub coefficients: Vec<f64>,
    /// Reflection coefficients γ_1 … γ_p; empty for the two least-squares methods, which have none.
    pub reflection: Vec<f64>,
    /// Estimated variance of e, unit of r²: by (9e) for Yule-Walker and Burg, the mean squared residual for the others.
    pub innovation_variance: f64,
}

#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum AutoregressionError {
    #[error("order {0} is outside 1 to {MAX_LAG}")]
    Order(usize),
    #[error(
        "{rows} rows have {order} samples before them; more than {order} are needed for an order of {order}"
    )]
    TooShort { rows: usize, order: usize },
    #[error("a sample is not finite: split the series there")]
    NotFinite,
    #[error(
        "{method} at order {order}: rounding alone would change the coefficients by more than {TRUSTED:e} of their size; take the mean off, lower the order, or use another method"
    )]
    IllConditioned { method: Method, order: usize },
}

/// Largest accepted relative error of the coefficients by rounding.
pub const TRUSTED: f64 = 1e-6;

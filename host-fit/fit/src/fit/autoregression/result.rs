//! What every method gives: coefficients of the prediction, in one form; or why there are none.

use std::fmt;

use thiserror::Error;

use crate::candidates::MAX_LAG;

/// How an autoregression is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// From the biased autocorrelation, by Levinson-Durbin.
    YuleWalker,
    /// Least squares, forward.
    Covariance,
    /// Least squares, forward and backward.
    ModifiedCovariance,
    Burg,
}

impl fmt::Display for Method {
    /// As on the command line.
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

/// An estimated autoregression of order p.
#[derive(Debug, Clone, PartialEq)]
pub struct Autoregression<T = f64> {
    /// a_1 … a_p.
    pub coefficients: Vec<T>,
    /// γ_1 … γ_p; empty for the two least-squares methods, which have none.
    pub reflection: Vec<T>,
    /// Estimated variance of e: by (9e) for Yule-Walker and Burg, the mean squared residual for the others. Unit of r².
    pub innovation_variance: f64,
}

/// Why there is no estimate.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum AutoregressionError {
    /// An order of nothing, or further back than a model may reach.
    #[error("order {0} is outside 1 to {MAX_LAG}")]
    Order(usize),
    /// Too little to fit to.
    #[error(
        "{rows} rows have {order} samples before them; more than {order} are needed for an order of {order}"
    )]
    TooShort {
        /// Rows whose lags were all measured.
        rows: usize,
        order: usize,
    },
    /// NaN or infinite samples.
    #[error("a sample is not finite: split the series there")]
    NotFinite,
    /// Coefficients would be rounding error.
    #[error(
        "{method} at order {order}: rounding alone would change the coefficients by more than {TRUSTED:e} of their size; take the mean off, lower the order, or use another method"
    )]
    IllConditioned {
        method: Method,
        /// The order at which it shows.
        order: usize,
    },
}

/// The largest relative error of the coefficients by rounding that is not refused.
pub const TRUSTED: f64 = 1e-6;

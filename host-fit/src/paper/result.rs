//! Results of the comparison: every method at every order, with both errors.

use serde::Serialize;

use fos_fit::fit::autoregression::Method;

/// A method and the kind of samples it uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Entry {
    /// Autoregression of the measured samples.
    Raw(#[serde(serialize_with = "in_words")] Method),
    /// Autoregression of de-noised samples.
    Denoised(#[serde(serialize_with = "in_words")] Method),
    /// FOS of this cross-product degree, on the measured samples.
    Fos(usize),
}

fn in_words<S: serde::Serializer>(method: &Method, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(method)
}

impl std::fmt::Display for Entry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Raw(method) => write!(f, "{method}"),
            Self::Denoised(method) => write!(f, "de-noised, {method}"),
            Self::Fos(degree) => write!(f, "fos, CP {degree}"),
        }
    }
}

/// One method at one order. Errors in the square of the axis' unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// Method and samples.
    pub entry: Entry,
    /// Model order: the largest output lag, L.
    pub order: u16,
    /// Result, or the reason for its absence.
    pub result: Result<Evaluated, String>,
}

/// Evaluation of one model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluated {
    /// Number of terms without the constant.
    pub terms: usize,
    /// MSE on the prediction part; each method predicts the kind of samples it was fitted to.
    pub mse_as_fitted: f64,
    /// MSE on the prediction part, on the measured samples.
    pub mse_same_target: f64,
    /// MSE on the evaluation part, on the measured samples.
    pub mse_evaluation: f64,
    /// `mse_as_fitted` is below the noise floor of the measured samples.
    pub as_fitted_below_floor: bool,
    /// `mse_same_target` is below the noise floor.
    pub same_target_below_floor: bool,
    /// Position error as defined in the paper, from `mse_as_fitted`, m.
    pub position_error_as_fitted_m: Option<f64>,
    /// Position error from `mse_same_target`, m.
    pub position_error_same_target_m: Option<f64>,
    /// Time of a fit, de-noising and search included, s.
    pub time_s: f64,
}

/// The comparison of one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Column of the log format, such as `gx_rads`.
    pub column: String,
    /// Unit of the column; errors are in its square.
    pub unit: String,
    /// True sample rate, Hz.
    pub rate_hz: f64,
    /// Number of samples in each of the three parts.
    pub samples: [usize; 3],
    /// Highest frequency preserved by de-noising, Hz.
    pub band_hz: f64,
    /// Variance of the prediction part: the MSE of predicting its mean.
    pub variance: f64,
    /// Least MSE of any linear predictor from the series' own past, on the prediction part, with its 95 % interval.
    pub noise_floor: Option<(f64, (f64, f64))>,
    /// Every method at every order.
    pub cells: Vec<Cell>,
    /// Index of the chosen FOS model, which has the least MSE on the evaluation part.
    pub chosen: Option<usize>,
}

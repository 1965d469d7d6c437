//! What the comparison comes to: every method at every order, with both errors.

use serde::Serialize;

use fos_fit::fit::autoregression::Method;

/// A method, on which samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Entry {
    /// An autoregression of samples as measured.
    Raw(#[serde(serialize_with = "in_words")] Method),
    /// An autoregression of de-noised samples.
    Denoised(#[serde(serialize_with = "in_words")] Method),
    /// FOS of this cross-product degree, on samples as measured.
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
    /// The result, or why there is none.
    pub result: Result<Judged, String>,
}

/// What a model does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judged {
    /// Terms, the constant apart.
    pub terms: usize,
    /// MSE on the prediction part, each method on what it was fitted to.
    pub mse_as_fitted: f64,
    /// MSE on the prediction part, samples as measured.
    pub mse_same_target: f64,
    /// MSE on the evaluation part, samples as measured.
    pub mse_evaluation: f64,
    /// `mse_as_fitted` lies below the noise floor of the samples as measured.
    pub as_fitted_below_floor: bool,
    /// `mse_same_target` does.
    pub same_target_below_floor: bool,
    /// The paper's position error from each of the two, m.
    pub position_error_as_fitted_m: Option<f64>,
    /// The same from the second.
    pub position_error_same_target_m: Option<f64>,
    /// Time of a fit, de-noising and search included, s.
    pub time_s: f64,
}

/// The comparison of one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// As in the log format, as `gx_rads`.
    pub column: String,
    /// Unit of the column; errors are in its square.
    pub unit: String,
    /// True sample rate, Hz.
    pub rate_hz: f64,
    /// Samples in the three parts.
    pub samples: [usize; 3],
    /// Highest frequency that de-noising keeps whole, Hz.
    pub band_hz: f64,
    /// Variance of the prediction part: the MSE of predicting its mean.
    pub variance: f64,
    /// Least MSE of any linear predictor from the series' own past, on the prediction part, with its 95 % interval.
    pub noise_floor: Option<(f64, (f64, f64))>,
    /// Every method at every order.
    pub cells: Vec<Cell>,
    /// Index of the FOS model chosen: the least MSE on the evaluation part.
    pub chosen: Option<usize>,
}

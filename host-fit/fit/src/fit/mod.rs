//! Fitting: selection of terms and estimation of their coefficients.

pub mod autoregression;
pub mod axis;
mod axis_error;
mod axis_report;
pub mod exchange;
pub mod fos;
mod householder;
mod least_squares;
pub mod options;
mod physical;
pub mod physical_range;
mod pool;
mod poses;
pub mod refit;
pub mod regressors;
mod stochastic;
pub mod stop;
pub mod textbook;

use std::ops::Range;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::candidates::{Candidates, Monomial};
use crate::moments::{Moments, NoRows, Rows};
pub use autoregression::{Autoregression, AutoregressionError};
pub use axis::{AxisFit, fit_axes, fit_axis, rest, training_rows};
pub use axis_error::AxisError;
pub use axis_report::{AxisReport, LeftOut, SelectionStep, TiedModel};
pub use exchange::Tie;
pub use fos::{Selection, Step};
pub(crate) use options::input_text;
pub use options::{FitMethod, FitOptions, InputSpec, Train};
pub use poses::FittedPose;
pub use refit::{Refit, RefitError};
pub use stop::{Stop, StopRule, Stopped};

/// A fitted model: the selected terms, and their least-squares coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Terms in the order chosen, without the constant.
    pub terms: Vec<Monomial>,
    /// Record of the search: order, error after each step, reason why it stopped.
    pub selection: Selection,
    /// Coefficients, their errors and the mean square error, for the terms in the same order.
    pub refit: Refit,
    /// Models of the same size that are indistinguishable from this one, best first; empty after a greedy search.
    pub ties: Vec<Tie>,
}

/// Search strategy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Search {
    /// Forward selection without removal, as in the paper.
    Greedy,
    /// Forward selection, then exchange of terms until nothing improves.
    Exchange,
}

impl FromStr for Search {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "greedy" => Ok(Self::Greedy),
            "exchange" => Ok(Self::Exchange),
            other => Err(format!("{other:?} is not one of greedy, exchange")),
        }
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FitError {
    #[error(transparent)]
    NoRows(#[from] NoRows),
    #[error(transparent)]
    Refit(#[from] RefitError),
}

/// Fast orthogonal search over gap-free `segments` of the signals, then an orthogonal refit of what it chose.
///
/// `signals`: column 0 is the output, column i + 1 is input i. The caller centres and scales them to about
/// unit variance: an offset that dwarfs the signal costs the search digits.
///
/// ```
/// use fos_core::{u, y};
/// use fos_fit::candidates::Candidates;
/// use fos_fit::fit::{Search, StopRule, fit};
///
/// let input: Vec<f64> = (0..500).map(|n| f64::from(n * n % 97) / 50.0 - 1.0).collect();
/// let mut output = vec![1.0; 500];
/// for n in 1..500 {
///     output[n] = 0.1 + 0.5 * output[n - 1] + 0.3 * input[n];
/// }
/// let pool = Candidates::builder().output(1..=3, 2).input(0, 0..=2, 1).cross_products(2).build()?;
/// let fit = fit(&[&output, &input], &[0..500], &pool, &StopRule::default(), Search::Exchange)?;
/// assert_eq!(fit.terms, [vec![u(0, 0)], vec![y(1)]]);
/// assert!((fit.refit.coefficients[0] - 0.3).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If the signals do not fit the pool or the segments.
pub fn fit(
    signals: &[&[f64]],
    segments: &[Range<usize>],
    pool: &Candidates,
    rule: &StopRule,
    search: Search,
) -> Result<Fit, FitError> {
    let rows = Rows::usable(signals, segments, pool.factors());
    let gram = Moments::accumulate(signals, &rows, pool).gram()?;
    let greedy = fos::search(&gram, rule);
    let selection = match search {
        Search::Greedy => greedy,
        Search::Exchange => exchange::refine(&gram, rule, greedy),
    };
    let chosen: Vec<usize> = selection.candidates().collect();
    let ties = match search {
        Search::Greedy => Vec::new(),
        Search::Exchange => exchange::ties(&gram, &chosen),
    };
    let terms: Vec<Monomial> = chosen.iter().map(|i| pool.monomials()[*i].clone()).collect();
    let refit = refit::refit(signals, &rows, &terms)?;
    Ok(Fit { terms, selection, refit, ties })
}

#[cfg(test)]
mod exact_tests;
#[cfg(test)]
mod reference_tests;
#[cfg(test)]
mod tests;

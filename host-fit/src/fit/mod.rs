//! Fitting: choosing terms and finding their coefficients.

pub mod axis;
pub mod fos;
mod householder;
pub mod options;
pub mod physical;
pub mod refit;
pub mod regressors;
pub mod stop;
pub mod textbook;

use std::ops::Range;

use thiserror::Error;

use crate::candidates::{Candidates, Monomial};
use crate::moments::{GramError, Moments, Rows, SignalsError};
pub use axis::{AxisError, AxisFit, AxisReport, SelectionStep, fit_axis, training_rows};
pub use fos::{Selection, Step};
pub use options::{FitOptions, InputSpec, Stop, Train};
pub use refit::{Refit, RefitError};
pub use stop::{NoiseRule, StopRule, Stopped};

/// A model chosen and fitted: what was selected, and its least-squares coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The terms, in the order chosen, the constant apart.
    pub terms: Vec<Monomial>,
    /// The search: order, error after each step, why it stopped.
    pub selection: Selection,
    /// Coefficients, their errors, and the mean square error, of the terms in the same order.
    pub refit: Refit,
}

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FitError {
    /// The signals do not fit the pool.
    #[error(transparent)]
    Signals(#[from] SignalsError),
    /// No rows to average over.
    #[error(transparent)]
    Gram(#[from] GramError),
    /// The chosen terms cannot be solved for.
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
/// use host_fit::candidates::Candidates;
/// use host_fit::fit::{StopRule, fit};
///
/// let input: Vec<f64> = (0..500).map(|n| f64::from(n * n % 97) / 50.0 - 1.0).collect();
/// let mut output = vec![1.0; 500];
/// for n in 1..500 {
///     output[n] = 0.1 + 0.5 * output[n - 1] + 0.3 * input[n];
/// }
/// let pool = Candidates::builder().output(1..=3, 2).input(0, 0..=2, 1).cross_products(2).build()?;
/// let fit = fit(&[&output, &input], &[0..500], &pool, &StopRule::default())?;
/// assert_eq!(fit.terms, [vec![u(0, 0)], vec![y(1)]]);
/// assert!((fit.refit.coefficients[0] - 0.3).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Signals that do not fit the pool, no usable row, or too few for the terms chosen.
pub fn fit(
    signals: &[&[f64]],
    segments: &[Range<usize>],
    pool: &Candidates,
    rule: &StopRule,
) -> Result<Fit, FitError> {
    let rows = Rows::usable(signals, segments, pool.factors())?;
    let gram = Moments::accumulate(signals, &rows, pool)?.gram(pool)?;
    let selection = fos::search(&gram, rule);
    let terms: Vec<Monomial> = selection.candidates().map(|i| pool.monomials()[i].clone()).collect();
    let refit = refit::refit(signals, &rows, &terms)?;
    Ok(Fit { terms, selection, refit })
}

#[cfg(test)]
mod reference_tests;
#[cfg(test)]
mod tests;

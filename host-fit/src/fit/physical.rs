//! The physical part of an axis: terms over inputs only, estimated with coloured errors.

use std::ops::Range;

use fos_core::{u, y};

use super::FitError;
use super::refit;
use super::regressors::Regressors;
use crate::candidates::Monomial;
use crate::model::FittedTerm;
use crate::moments::Rows;

/// Orders of the autoregression that whitens the physical part's errors, and the rounds that it takes.
const WHITENING_ORDER: u16 = 10;
const WHITENING_ROUNDS: usize = 3;

/// The coefficients of the physical part, by least squares with coloured errors (Cochrane and Orcutt 1949): output and
/// inputs are whitened by an autoregression of the residual, so that a coefficient is per kelvin and not what is left
/// of it after ten lags.
///
/// # Errors
///
/// Too few rows, or inputs that the data cannot tell apart.
pub fn fit(regressors: &Regressors, inputs: Range<u8>) -> Result<Vec<FittedTerm>, FitError> {
    let monomials: Vec<Monomial> = inputs.map(|input| vec![u(input, 0)]).collect();
    let lags: Vec<Monomial> = (1..=WHITENING_ORDER).map(|lag| vec![y(lag)]).collect();
    let mut whitened: Vec<Vec<f64>> = regressors.columns().iter().map(|column| column.to_vec()).collect();
    let mut round = 0;
    loop {
        let columns: Vec<&[f64]> = whitened.iter().map(Vec::as_slice).collect();
        let rows = Rows::usable(&columns, &regressors.stretches, monomials.iter().flatten())?;
        let solution = refit::refit(&columns, &rows, &monomials)?;
        if round == WHITENING_ROUNDS {
            return Ok(FittedTerm::of(&monomials, &solution));
        }
        round += 1;
        let residual: Vec<f64> = (0..regressors.remainder.len())
            .map(|row| {
                let explained = solution.coefficients.iter().zip(&regressors.inputs);
                regressors.remainder[row] - explained.map(|(c, input)| c * input[row]).sum::<f64>()
            })
            .collect();
        let rows = Rows::usable(&[&residual], &regressors.stretches, lags.iter().flatten())?;
        let colour = refit::refit(&[&residual], &rows, &lags)?.coefficients;
        whitened = regressors
            .columns()
            .iter()
            .map(|column| whiten(column, &regressors.stretches, &colour))
            .collect();
    }
}

/// x(n) − Σ a_k·x(n−k); NaN where that would reach back before its stretch.
fn whiten(column: &[f64], stretches: &[Range<usize>], colour: &[f64]) -> Vec<f64> {
    let mut whitened = vec![f64::NAN; column.len()];
    for stretch in stretches {
        for row in (stretch.start + colour.len()).min(stretch.end)..stretch.end {
            let past = colour.iter().enumerate().map(|(k, a)| a * column[row - k - 1]);
            whitened[row] = column[row] - past.sum::<f64>();
        }
    }
    whitened
}

//! Physical part of an axis: terms over inputs only, estimated with coloured errors.

use std::ops::Range;

use fos_core::{u, y};

use super::FitError;
use super::axis_report::LeftOut;
use super::refit;
use super::regressors::Regressors;
use super::stop::Stop;
use crate::candidates::{MAX_INPUT, Monomial};
use crate::model::FittedTerm;
use crate::moments::Rows;
use crate::single_axis::SingleAxisModel;

/// Order of the autoregression that whitens the physical part's errors, and number of iterations.
const WHITENING_ORDER: u16 = 10;
const WHITENING_ROUNDS: usize = 3;

/// Returns the largest number of levels for [`fit`]: each takes the index of an input behind those of the model.
pub(super) fn most_levels(regressors: &Regressors) -> usize {
    (usize::from(MAX_INPUT) + 1).saturating_sub(regressors.inputs.len())
}

/// Fits the physical part over `inputs` and `levels`, columns of constants that hold for part of the rows. A term whose
/// coefficient noise alone might have produced is excluded, the least significant first, and the others are estimated
/// again: in the model it would follow its input and only do harm. Returns the terms, one input each, and those that
/// were excluded.
pub(super) fn fit(
    model: &SingleAxisModel,
    regressors: &Regressors,
    mut inputs: Vec<u8>,
    levels: &[Vec<f64>],
) -> Result<(Vec<FittedTerm>, Vec<LeftOut>), FitError> {
    let mut left_out = Vec::new();
    loop {
        let (terms, rows) = coefficients(regressors, &inputs, levels)?;
        // as for a term of the search (`stop`), with the requested terms as the pool
        let least = Stop::Multiplicity.threshold(rows, inputs.len() + left_out.len()) * rows as f64;
        let sureness = |term: &FittedTerm| {
            term.standard_error.map_or(f64::INFINITY, |error| (term.coefficient / error).powi(2))
        };
        let weakest = (0..terms.len()).min_by(|a, b| sureness(&terms[*a]).total_cmp(&sureness(&terms[*b])));
        match weakest.filter(|index| sureness(&terms[*index]) < least) {
            None => return Ok((terms, left_out)),
            Some(index) => {
                let FittedTerm { coefficient, standard_error, .. } = terms[index];
                let standard_error = standard_error.unwrap_or(f64::NAN);
                let input = model.inputs[usize::from(inputs.remove(index))].name.clone();
                left_out.push(LeftOut { input, coefficient, standard_error });
            }
        }
    }
}

/// Estimates the coefficients of the physical part by least squares with coloured errors (Cochrane and Orcutt 1949):
/// output and inputs are whitened by an autoregression of the residual, so that a coefficient is per kelvin rather than
/// its remainder after ten lags. Also returns the rows used.
fn coefficients(
    regressors: &Regressors,
    inputs: &[u8],
    levels: &[Vec<f64>],
) -> Result<(Vec<FittedTerm>, usize), FitError> {
    if inputs.is_empty() {
        return Ok((Vec::new(), 0));
    }
    let n_rows = regressors.remainder.len();
    let levels = levels.iter().map(|level| &level[..n_rows]);
    let all: Vec<&[f64]> = regressors.columns().into_iter().chain(levels).collect();
    // a level is an input like any other, but not a term of the model
    let level_inputs = (regressors.inputs.len()..all.len() - 1).filter_map(|input| u8::try_from(input).ok());
    let estimated: Vec<u8> = inputs.iter().copied().chain(level_inputs).collect();
    let monomials: Vec<Monomial> = estimated.iter().map(|input| vec![u(*input, 0)]).collect();
    let lags: Vec<Monomial> = (1..=WHITENING_ORDER).map(|lag| vec![y(lag)]).collect();
    let mut whitened: Vec<Vec<f64>> = all.iter().map(|column| column.to_vec()).collect();
    let mut round = 0;
    // terminates after WHITENING_ROUNDS, converged or not
    loop {
        let columns: Vec<&[f64]> = whitened.iter().map(Vec::as_slice).collect();
        let rows = Rows::usable(&columns, &regressors.stretches, monomials.iter().flatten());
        let solution = refit::refit(&columns, &rows, &monomials)?;
        if round == WHITENING_ROUNDS {
            let mut terms = solution.terms(&monomials);
            terms.truncate(inputs.len());
            return Ok((terms, solution.rows));
        }
        round += 1;
        let residual: Vec<f64> = (0..n_rows)
            .map(|row| {
                let explained = solution.coefficients.iter().zip(&estimated);
                let explained = explained.map(|(c, input)| c * all[usize::from(*input) + 1][row]);
                regressors.remainder[row] - explained.sum::<f64>()
            })
            .collect();
        let rows = Rows::usable(&[&residual], &regressors.stretches, lags.iter().flatten());
        let colour = refit::refit(&[&residual], &rows, &lags)?.coefficients;
        whitened = all.iter().map(|column| whiten(column, &regressors.stretches, &colour)).collect();
    }
}

/// Returns x(n) − Σ a_k·x(n−k); NaN if that reaches back beyond its stretch.
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

//! Stochastic part of an axis: terms of the remainder that predict it, by any of the methods.

use std::ops::Range;

use fos_core::y;

use super::autoregression;
use super::axis_error::AxisError;
use super::axis_report::{AxisReport, SelectionStep, TiedModel};
use super::options::{FitMethod, FitOptions};
use super::pool;
use super::refit::{self, Refit};
use super::regressors::Regressors;
use super::stop::{StopRule, Stopped};
use crate::candidates::{Candidates, Monomial, monomial_text_named};
use crate::model::FittedTerm;
use crate::moments::Rows;
use crate::signal::{self, autocorrelation::autocorrelation};
use crate::single_axis::SingleAxisModel;

/// A stochastic part, scaled units.
pub(super) struct StochasticPart {
    pub(super) constant: f64,
    pub(super) terms: Vec<FittedTerm>,
    pub(super) report: AxisReport,
}

/// Fits the stochastic part of the axis of `model`; the inputs after those of the physical part are candidates.
pub(super) fn fit(
    model: &SingleAxisModel,
    regressors: &Regressors,
    options: &FitOptions,
) -> Result<StochasticPart, AxisError> {
    let column = &model.axis().column;
    let rows: usize = regressors.stretches.iter().map(Range::len).sum();
    // before the pool is made: it may be larger than any memory
    pool::check(column, rows, model.inputs.len(), options)?;
    match options.method {
        FitMethod::Fos => {
            let pool = pool::pool(model.inputs.len(), options)
                .map_err(|source| AxisError::Candidates { column: column.clone(), source })?;
            search(model, regressors, options, &pool)
        }
        FitMethod::Linear(method) => autoregress(model, regressors, options, method),
    }
}

fn search(
    model: &SingleAxisModel,
    regressors: &Regressors,
    options: &FitOptions,
    pool: &Candidates,
) -> Result<StochasticPart, AxisError> {
    let rule = StopRule { max_terms: options.max_terms, stop: options.stop };
    let fit = super::fit(&regressors.columns(), &regressors.stretches, pool, &rule, options.search)
        .map_err(|source| AxisError::Search { column: model.axis().column.clone(), source })?;
    let names: Vec<&str> = model.inputs.iter().map(|named| named.name.as_str()).collect();
    let name = |factors: &Monomial| monomial_text_named(factors, "r", &names);
    let named = |candidates: &[usize]| candidates.iter().map(|i| name(&pool.monomials()[*i])).collect();
    let shared = about(model, regressors, options, pool.len(), &fit.refit);
    let mut mse = fit.selection.initial_mse;
    let steps = fit.terms.iter().zip(&fit.refit.mse_reductions).map(|(factors, reduction)| {
        mse -= reduction;
        SelectionStep {
            monomial: name(factors),
            factors: factors.clone(),
            mse_reduction: *reduction,
            error_reduction_ratio: reduction / shared.mean_square,
            mse,
        }
    });
    let ties = fit.ties.iter().map(|tie| TiedModel {
        leaves: named(&tie.leaves),
        enters: named(&tie.enters),
        deviance: tie.deviance,
    });
    let stopped = match fit.selection.stopped {
        Stopped::Noise { candidate, mse_reduction, needed } => format!(
            "stopped: the best candidate left, {}, reduces the MSE by {mse_reduction:.2e}; noise alone does so up to {needed:.2e}",
            name(&pool.monomials()[candidate])
        ),
        Stopped::MaxTerms => "stopped at the most terms allowed".to_owned(),
        Stopped::Rounding => "stopped: other terms reduce the MSE by less than its rounding error; the signal is so smooth that its lags are nearly sums of one another".to_owned(),
        Stopped::MostMoves => "stopped after as many exchanges as are allowed; another might lower the error further".to_owned(),
        Stopped::NothingLeft => "stopped: every candidate is in the model or collinear with it".to_owned(),
        Stopped::Exact => "stopped: the residual is rounding error".to_owned(),
    };
    Ok(StochasticPart {
        constant: fit.refit.constant,
        terms: fit.refit.terms(&fit.terms),
        report: AxisReport { steps: steps.collect(), ties: ties.collect(), stopped, ..shared },
    })
}

/// Fits all lags up to L by a classical method, from the remainder as measured or de-noised.
fn autoregress(
    model: &SingleAxisModel,
    regressors: &Regressors,
    options: &FitOptions,
    method: autoregression::Method,
) -> Result<StochasticPart, AxisError> {
    let column = &model.axis().column;
    let failed = |source| AxisError::Autoregression { column: column.clone(), source };
    let order = usize::from(options.max_lag);
    let known = regressors.known_remainder();
    let mean = signal::mean(&known);
    let centred = known.iter().map(|stretch| stretch.iter().map(|r| r - mean).collect::<Vec<f64>>());
    let (prepared, how): (Vec<Vec<f64>>, String) = match &options.denoising {
        None => (centred.collect(), format!("all lags to {order}")),
        Some(denoising) => {
            let long = centred.filter(|stretch| stretch.len() >= denoising.shortest());
            let band = denoising.band_hz(1.0 / model.period_s);
            (
                long.map(|stretch| denoising.denoise(&stretch)).collect(),
                format!(
                    "all lags to {order}, from samples de-noised by {denoising}, which keeps 0 to {band:.4} Hz"
                ),
            )
        }
    };
    let prepared: Vec<&[f64]> = prepared.iter().map(Vec::as_slice).collect();
    let estimate = autoregression::estimate(method, &prepared, order).map_err(failed)?;

    // evaluated on the samples as measured, like every other model
    let monomials: Vec<Monomial> = (1..=options.max_lag).map(|lag| vec![y(lag)]).collect();
    let constant = mean * (1.0 - estimate.coefficients.iter().sum::<f64>());
    let remainder: &[f64] = &regressors.remainder;
    let rows = Rows::usable(&[remainder], &regressors.stretches, monomials.iter().flatten());
    let raw = refit::refit(&[remainder], &rows, &monomials)
        .map_err(|source| AxisError::Search { column: column.clone(), source: source.into() })?;
    let mse = refit::mean_square_error(&[remainder], &rows, constant, &monomials, &estimate.coefficients);
    let terms = monomials.iter().zip(&estimate.coefficients).zip(&raw.coefficient_errors);
    let terms = terms.map(|((factors, coefficient), error)| FittedTerm {
        coefficient: *coefficient,
        // all four methods have the same errors in long records; those of de-noised samples are unknown
        standard_error: options.denoising.is_none().then_some(*error),
        factors: factors.clone(),
    });
    Ok(StochasticPart {
        constant,
        terms: terms.collect(),
        report: AxisReport { stopped: how, mse, ..about(model, regressors, options, order, &raw) },
    })
}

/// Common part of the report of every method; `refit` is the least-squares solution for the same terms.
fn about(
    model: &SingleAxisModel,
    regressors: &Regressors,
    options: &FitOptions,
    candidates: usize,
    refit: &Refit,
) -> AxisReport {
    let axis = model.axis();
    let known = regressors.known_remainder();
    let power: f64 = known.iter().copied().flatten().map(|r| r * r).sum();
    AxisReport {
        column: axis.column.clone(),
        reference_column: None,
        method: options.method,
        candidates,
        rows: refit.rows,
        steps: Vec::new(),
        ties: Vec::new(),
        left_out: Vec::new(),
        spikes: 0,
        poses: Vec::new(),
        stopped: String::new(),
        condition_number: refit.condition,
        mse: refit.mse,
        mean_square: power / signal::sample_count(&known) as f64,
        lag_1: match (&axis.plain, axis.physical.is_empty()) {
            // nothing has been subtracted since
            (Some(plain), true) => plain.lag_1,
            _ => autocorrelation(&known, 1).map_or(0.0, |result| result.lag_1()),
        },
    }
}

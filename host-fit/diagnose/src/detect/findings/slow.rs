//! Slow effects as findings: their sizes, where each shows, rivals and experiments, and the reduction predicted for
//! each with those before it in the model.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::Composer;
use super::doubt::{beyond_fitted_range, shows_at_motion};
use super::faults_and_noise::{TWO_SIDED_95, bare, param};
use super::powers;
use crate::detect::answer::{CorrectionTerm, Finding, Separation, Size};
use crate::detect::correction::{mean_at_fit, step_share};
use crate::detect::hypothesis::Hypothesis;
use crate::detect::leverage;
use crate::detect::limits;
use crate::detect::predicted_reduction::{PredictedReduction, PredictedReductions, SlowEffect, Truth};
use crate::detect::question::{DiagnoseError, keeps_bias};
use crate::detect::slow::{Estimate, Found};
use crate::effects::{Detector, Effect, Inputs, Regressor};
use fos_data::recording::RecordingError;
use fos_data::text::rounded;
use fos_fit::noise::{Regression, combination};
use nalgebra::DMatrix;

impl Composer<'_> {
    /// Returns the slow effects ordered by what they reduce: each next one reduces the variance of the block means most
    /// while those after it are still in the error. The score of an effect does not give this order: with a lag in the
    /// error, the subtraction of a smaller effect may raise it.
    pub(super) fn by_reduction(&self) -> Vec<&Found> {
        let gls = &self.results.slow.fitted.gls;
        let coefficients = gls.coefficients();
        let n = self.prepared.reduced.means.len();
        let course =
            |found: &Found| combination(&found.hypothesis.columns(), &coefficients[found.place.clone()], n);
        let mut left: Vec<(&Found, Vec<f64>)> =
            self.results.slow.found.iter().map(|found| (found, course(found))).collect();
        let mut error = gls.unexplained(&self.prepared.reduced.means, &self.regressors());
        for (_, course) in &left {
            error.iter_mut().zip(course).for_each(|(error, value)| *error += value);
        }
        let mut order = Vec::new();
        while !left.is_empty() {
            let without = |course: &[f64]| -> Vec<f64> {
                error.iter().zip(course).map(|(error, value)| error - value).collect()
            };
            let variance = |course: &[f64]| self.prepared.reduced.variance_in(&without(course), 0..n);
            let variances: Vec<f64> = left.iter().map(|(_, course)| variance(course)).collect();
            let next = (0..left.len()).min_by(|a, b| variances[*a].total_cmp(&variances[*b])).unwrap_or(0);
            let (found, course) = left.remove(next);
            error = without(&course);
            order.push(found);
        }
        order
    }

    /// Returns the regressors of the fit: those given, then those of the effects.
    fn regressors(&self) -> Vec<&[f64]> {
        let mut regressors: Vec<&[f64]> = self.results.given.iter().map(Vec::as_slice).collect();
        for found in &self.results.slow.found {
            regressors.extend(found.hypothesis.columns());
        }
        regressors
    }

    /// Returns the names, coefficients and standard errors of an effect that consists of powers of one input, about its
    /// mean in the log; empty for any other effect.
    fn about_mean(&self, found: &Found) -> Result<Vec<(String, f64, f64)>, DiagnoseError> {
        let gls = &self.results.slow.fitted.gls;
        let Some(input) = powers::input_of(&found.hypothesis.regressors) else { return Ok(Vec::new()) };
        let at: Option<Vec<usize>> =
            found.place.clone().map(|place| gls.kept.iter().position(|index| *index == place)).collect();
        let Some(at) = at else { return Ok(Vec::new()) };
        let mean = rounded(mean_at_fit(self.prepared.inputs(), input)?, 3);
        let value: f64 = mean.parse().unwrap_or(0.0);
        let all = gls.covariance();
        let covariance = DMatrix::from_fn(at.len(), at.len(), |row, column| all[(at[row], at[column])]);
        let moved = powers::about(value, &gls.coefficients()[found.place.clone()], &covariance);
        let named = moved.into_iter().enumerate();
        Ok(named.map(|(k, (value, error))| (powers::name(input, &mean, k + 1), value, error)).collect())
    }

    /// Returns the slow effects in this order, each with the reduction predicted with those before it in the model.
    pub(super) fn slow_findings(&self, order: &[&Found]) -> Result<Vec<Finding>, DiagnoseError> {
        let slow = &self.results.slow;
        if order.is_empty() {
            return Ok(Vec::new());
        }
        let coefficients = slow.fitted.gls.coefficients();
        let covariance = slow.fitted.gls.covariance();
        let kept = &slow.fitted.gls.kept;
        let inputs = self.prepared.inputs();
        let estimates: Vec<Estimate> =
            order.iter().map(|found| Estimate::of(&slow.fitted.gls, found.place.clone())).collect();
        let mut limits = Vec::new();
        for (found, own) in order.iter().zip(&estimates) {
            let regressors = &found.hypothesis.regressors;
            limits.push(limits::limits(inputs, regressors, &own.coefficients, &own.covariance)?);
        }
        let reductions = self.reductions(order, estimates, &limits)?;
        let mut findings = Vec::new();
        for (own, (found, reduction)) in order.iter().zip(reductions).enumerate() {
            let effect: &Arc<Effect> = &found.hypothesis.effect;
            let value = found.hypothesis.value;
            let mut sizes = Vec::new();
            let mut correction = Vec::new();
            let centred = self.about_mean(found)?;
            for ((column, &term), place) in found.hypothesis.terms.iter().enumerate().zip(found.place.clone())
            {
                let Some(at) = kept.iter().position(|index| *index == place) else { continue };
                let (coefficient, error) = (coefficients[place], covariance[(at, at)].sqrt());
                let product = match effect.search {
                    Detector::Terms => found.hypothesis.regressors[column].to_string(),
                    _ => format!("clock:step({})", value.unwrap_or(0.0)),
                };
                if let Some(unit) = effect.unit(term, &self.prepared.column) {
                    let own = || (product.clone(), coefficient, error);
                    let (of, value, error) = centred.get(column).cloned().unwrap_or_else(own);
                    sizes.push(Size::around(of, value, TWO_SIDED_95 * error, unit.si, unit));
                }
                correction.push(CorrectionTerm { regressor: product, coefficient, standard_error: error });
            }
            let confounded_with: Vec<String> =
                found.rivals.iter().map(|(rival, _)| rival.effect.id.clone()).collect();
            let interval = found.log_error.zip(value).map(|(error, value)| {
                let factor = (TWO_SIDED_95 * error).exp();
                [value / factor, value * factor]
            });
            let params = value.map(|value| param(effect, value)).unwrap_or_default();
            let shows = &self.shows(found, &coefficients);
            findings.push(Finding {
                params_interval: params.keys().filter_map(|name| Some((name.clone(), interval?))).collect(),
                params,
                sizes,
                gain: Some(found.gain),
                score: Some(found.score),
                doubt: reduction
                    .beyond
                    .and_then(beyond_fitted_range)
                    .or_else(|| self.shows_at_motion(found, shows)),
                predicted_reduction: reduction.median,
                predicted_reduction_interval: reduction.interval,
                separate: self.separations(&effect.id, &confounded_with),
                confounded_with,
                shows_against: found
                    .hypothesis
                    .regressors
                    .iter()
                    .find_map(|regressor| regressor.columns().next().map(str::to_owned)),
                shows_from_to_s: shows.as_ref().map(|blocks| self.times(blocks)),
                correction,
                limits: limits[own].clone(),
                ..bare(effect)
            });
        }
        Ok(findings)
    }

    fn separations(&self, id: &str, rivals: &[String]) -> Vec<Separation> {
        let experiment = |rival: &String| {
            let effect = self.prepared.library().get(rival).ok();
            let known = self.prepared.library().separation(id, rival).map(str::to_owned);
            known.or_else(|| effect.map(|effect| effect.experiment.clone()))
        };
        rivals
            .iter()
            .filter_map(|rival| Some(Separation { effect: rival.clone(), experiment: experiment(rival)? }))
            .collect()
    }

    /// Returns the blocks in which an effect shows most: the twentieth of the log in which it is furthest from its mean,
    /// or about a step.
    fn shows(&self, found: &Found, coefficients: &[f64]) -> Option<Range<usize>> {
        let blocks = &self.prepared.reduced.blocks;
        let length = (blocks.len() / 20).max(1);
        if found.hypothesis.effect.search == Detector::Step {
            let time_s = found.hypothesis.value?;
            let step = (0..blocks.len()).take_while(|block| blocks.middle_s(*block) < time_s).count();
            let start = step.saturating_sub(length / 2).min(blocks.len() - length);
            return Some(start..start + length);
        }
        let columns = found.hypothesis.columns();
        let size = |block: usize| -> f64 {
            found.place.clone().zip(&columns).map(|(place, column)| coefficients[place] * column[block]).sum()
        };
        let windows = (0..=blocks.len() - length).step_by((length / 4).max(1));
        let power = |start: &usize| (*start..start + length).map(|block| size(block).powi(2)).sum::<f64>();
        let start = windows.max_by(|a, b| power(a).total_cmp(&power(b)))?;
        Some(start..start + length)
    }

    /// Returns the rows of these blocks and of all between them.
    fn rows(&self, blocks: &Range<usize>) -> Range<usize> {
        let all = &self.prepared.reduced.blocks.blocks;
        all[blocks.start].rows.start..all[blocks.end - 1].rows.end
    }

    /// Returns begin and end of these blocks, s.
    fn times(&self, blocks: &Range<usize>) -> [f64; 2] {
        let (rows, time) = (self.rows(blocks), &self.prepared.log().time_s);
        [time[rows.start], time[rows.end - 1]]
    }

    /// Returns the reason if an effect that follows nothing logged shows mostly in rows that are excluded as motion.
    fn shows_at_motion(&self, found: &Found, shows: &Option<Range<usize>>) -> Option<String> {
        let blocks = shows.as_ref().filter(|_| !found.is_backed())?;
        let rows = self.rows(blocks);
        let known = self.prepared.reduced.blocks.known();
        let excluded = rows.clone().filter(|row| !known[*row]).count() as f64 / rows.len().max(1) as f64;
        shows_at_motion(self.times(blocks), excluded)
    }

    /// Predicts the reduction by each effect with those before it in the model.
    fn reductions(
        &self,
        order: &[&Found],
        estimates: Vec<Estimate>,
        limits: &[BTreeMap<String, [f64; 2]>],
    ) -> Result<Vec<PredictedReduction>, DiagnoseError> {
        let fitted = self.prepared.inputs();
        let evaluation = self.prepared.evaluation().filter(|(evaluation, _)| {
            let inputs = Inputs::new(evaluation);
            let mut regressors = order.iter().flat_map(|found| &found.hypothesis.regressors);
            regressors.all(|regressor| is_logged(&inputs, regressor))
        });
        let (log, from) = evaluation.unwrap_or((self.prepared.log(), 0));
        let continues = keeps_bias(log, &self.prepared.column, from);
        let mut in_blocks = PredictedReductions::blocks(log, &self.prepared.column, from)?;
        Arc::make_mut(&mut in_blocks.blocks).flicker_from_s = self.prepared.reduced.blocks.flicker_from_s;
        let blocks = &in_blocks.blocks;
        let other = evaluation.map(|(evaluation, _)| Inputs::new(evaluation));
        let inputs = other.as_ref().unwrap_or(fitted);
        // about the mean of the fitted log, as in `correction`: a step is compared in mean squares, in which 25 °C times
        // a temperature coefficient would count as error
        let about_fit = |regressor: &Regressor, values: &[f64]| -> Result<Vec<f64>, RecordingError> {
            let mean = mean_at_fit(fitted, regressor)?;
            Ok(blocks.means(values).iter().map(|value| value - mean).collect())
        };
        let mut effects: Vec<SlowEffect> = Vec::new();
        for ((found, estimate), limits) in order.iter().zip(estimates).zip(limits) {
            let effect = &found.hypothesis.effect;
            let means = |hypothesis: &Hypothesis| -> Result<Vec<Vec<f64>>, RecordingError> {
                let columns = hypothesis.regressors.iter();
                columns.map(|regressor| about_fit(regressor, &inputs.regressor(regressor)?)).collect()
            };
            let unknown = || DiagnoseError::UnknownCoefficients { effect: effect.id.clone() };
            let factor = estimate.factor().ok_or_else(unknown)?;
            let mut found_so = Truth {
                columns: means(&found.hypothesis)?,
                coefficients: estimate.coefficients,
                factor,
                odds: 1.0,
            };
            let mut corrected = Vec::new();
            for regressor in &found.hypothesis.regressors {
                corrected.push(about_fit(regressor, &inputs.regressor_within(regressor, limits)?)?);
            }
            if effect.search == Detector::Step {
                let time_s = found.hypothesis.value.unwrap_or(0.0);
                // a past step is a constant in another log, relative to the mean of its own log
                let share = step_share(self.prepared.log(), time_s);
                let after = |block: usize| evaluation.is_some() || blocks.middle_s(block) > time_s;
                let column: Vec<f64> =
                    (0..blocks.len()).map(|block| f64::from(u8::from(after(block))) - share).collect();
                found_so.columns.push(column.clone());
                corrected.push(column);
            }
            let is_step = effect.search == Detector::Step && log.is_bias_known(&self.prepared.column);
            let mut alternatives = Vec::new();
            for other in &found.alternatives {
                if !other.hypothesis.regressors.iter().all(|regressor| is_logged(inputs, regressor)) {
                    continue;
                }
                alternatives.push(Truth {
                    columns: means(&other.hypothesis)?,
                    coefficients: other.estimate.coefficients.clone(),
                    factor: other.estimate.factor().ok_or_else(unknown)?,
                    odds: other.odds,
                });
            }
            effects.push(SlowEffect {
                is_about_fit: is_step || continues,
                found: found_so,
                alternatives,
                corrected,
            });
        }
        let regressors = self.regressors();
        let regression = Regression {
            blocks: &self.prepared.reduced.blocks,
            y: &self.prepared.reduced.means,
            regressors: &regressors,
            prior: &self.results.slow.prior,
        };
        let reductions = PredictedReductions {
            log: &in_blocks,
            regression: &regression,
            fitted: &self.results.slow.fitted,
            continues_s: continues.then(|| self.prepared.log().duration_s()),
        };
        let reduction = |at: usize| {
            let learnt = order[at].hypothesis.columns();
            let beyond = leverage::beyond(&learnt, &effects[at].corrected).filter(|_| evaluation.is_some());
            Ok(PredictedReduction { beyond, ..reductions.of(&effects[at], &effects[at + 1..])? })
        };
        (0..effects.len()).map(reduction).collect()
    }
}

fn is_logged(inputs: &Inputs<'_>, regressor: &Regressor) -> bool {
    inputs.logged(regressor).as_ref() == Some(regressor)
}

//! From what the searches found to an answer: sizes in data-sheet units, the fall to expect, rivals and experiments, the
//! verdict in a sentence.

use fos_data::column::Column;
use std::collections::BTreeMap;
use std::rc::Rc;

use super::answer::{
    CorrectionTerm, Diagnosis, Finding, NoiseReport, Rejected, Separation, Size, Untested, Verdict,
};
use super::correction::step_share;
use super::error_in_blocks::ErrorInBlocks;
use super::faults::Fault;
use super::left_over::LeftOver;
use super::limits;
use super::lines::{self, Line};
use super::open::Lead;
use super::predicted_reduction::{Estimate, PredictedReduction, PredictedReductions, SlowEffect};
use super::question::{DiagnoseError, Question, is_bias_known};
use super::shape::Misshape;
use super::slow::{ExtraNoise, Found, SlowResult};
use crate::effects::{Band, Effect, Inputs, Search, SizeUnit};
use fos_data::recording::Recording;
use fos_fit::noise::Regression;

/// Quantile of 95 % intervals, and of 90 % ones.
const TWO_SIDED_95: f64 = 1.96;
const TWO_SIDED_90: f64 = 1.645;

/// More steps than this are jumps to and fro and no longer a shock.
const MOST_STEPS: usize = 1;

/// Findings are kept beside an unexplained rest if they explain so many times as much.
const OUTWEIGHS: f64 = 5.0;

/// Everything that an answer is made of.
pub(super) struct Assembly<'a> {
    pub(super) question: &'a Question<'a>,
    pub(super) column: &'a str,
    pub(super) reduced: &'a ErrorInBlocks,
    pub(super) given: &'a [Vec<f64>],
    pub(super) faults: &'a [Fault],
    pub(super) lines: &'a [Line],
    pub(super) slow: &'a SlowResult,
    pub(super) left: LeftOver,
    pub(super) untested: Vec<Untested>,
    pub(super) learnt_from: String,
}

impl Assembly<'_> {
    /// The answer.
    pub(super) fn diagnosis(self) -> Result<Diagnosis, DiagnoseError> {
        let mut findings = self.fault_findings()?;
        let mut others = self.line_findings()?;
        let mut order: Vec<&Found> = self.slow.found.iter().collect();
        order.sort_by(|a, b| b.score.total_cmp(&a.score));
        others.extend(self.slow_findings(order)?);
        others.extend(self.noise_finding()?);
        others.sort_by(|a, b| b.score.total_cmp(&a.score));
        findings.extend(others);

        let mut leads = self.left.leads.clone();
        leads.extend(self.left.misshapes.iter().map(lead_of));
        if self.left.instead {
            let library = self.question.library;
            findings.retain(|finding| {
                let effect = library.get(&finding.effect);
                finding.band != Band::Stochastic
                    && (finding.band != Band::Slow
                        || effect.is_ok_and(|effect| !effect.follows_clock_alone()))
            });
        }
        let is_step = |finding: &Finding| {
            let effect = self.question.library.get(&finding.effect);
            effect.is_ok_and(|effect| effect.search == Search::Step)
        };
        let steps = findings.iter().filter(|finding| is_step(finding)).count();
        if steps > MOST_STEPS {
            let gain = findings.iter().filter(|finding| is_step(finding)).map(|finding| finding.gain).sum();
            leads.push(Lead { follows: format!("{steps} jumps of the bias"), gain, score: gain, share: 0.0 });
            findings.retain(|finding| !is_step(finding));
        }
        for line in self.lines.iter().filter(|line| line.duty < lines::STEADY) {
            let share = match line.duty {
                duty if duty < 0.01 => "less than 1 %".to_owned(),
                duty => format!("{:.0} %", 100.0 * duty),
            };
            let follows = format!(
                "interference near {:.2} Hz that is there for {share} of the time",
                line.frequency_hz
            );
            leads.push(Lead { follows, gain: line.score, score: line.score, share: 0.0 });
        }
        leads.sort_by(|a, b| b.score.total_cmp(&a.score));
        let verdict = match (leads.is_empty(), findings.is_empty()) {
            (false, _) => Verdict::Unexplained,
            (true, false) => Verdict::Missing,
            (true, true) => Verdict::NothingMissing,
        };
        if verdict == Verdict::Unexplained {
            outweighed(&mut findings, &leads);
        }
        let found: Vec<&str> = findings.iter().map(|finding| finding.effect.as_str()).collect();
        let rejected = self
            .slow
            .tried
            .iter()
            .filter(|(id, _)| !found.contains(&id.as_str()))
            .map(|(id, score)| Rejected { effect: id.clone(), score: *score })
            .collect();
        let mut cautions = Vec::new();
        if self.question.quiet.is_none() {
            cautions
                .push("no quiet log: slow wander of the sensor itself may be taken for an effect".to_owned());
        }
        Ok(Diagnosis {
            target: self.column.to_owned(),
            unit: Column::named(self.column).unit().label().to_owned(),
            verdict,
            sentence: sentence(verdict, &findings, &leads),
            findings,
            leads,
            rejected,
            untested: self.untested,
            noise: NoiseReport {
                levels: self.slow.fitted.levels,
                learnt_from: self.learnt_from,
                block_s: self.reduced.blocks.length_s,
                blocks: self.reduced.blocks.len(),
            },
            cautions,
        })
    }

    fn found_as(&self, search: Search, value: f64) -> Result<&Effect, DiagnoseError> {
        Ok(self.question.library.found_as(search, self.column, value)?)
    }

    fn separations(&self, id: &str, rivals: &[String]) -> Vec<Separation> {
        let experiment = |rival: &String| {
            let effect = self.question.library.get(rival).ok();
            let known = self.question.library.separation(id, rival).map(str::to_owned);
            known.or_else(|| effect.map(|effect| effect.experiment.clone()))
        };
        rivals
            .iter()
            .filter_map(|rival| Some(Separation { effect: rival.clone(), experiment: experiment(rival)? }))
            .collect()
    }

    fn fault_findings(&self) -> Result<Vec<Finding>, DiagnoseError> {
        let of = |search: Search, value: f64| -> Result<Finding, DiagnoseError> {
            let effect = self.found_as(search, value)?;
            Ok(Finding { params: param(effect, value), ..bare(effect, f64::MAX.sqrt()) })
        };
        self.faults
            .iter()
            .map(|fault| match fault {
                Fault::Saturation { share, .. } => of(Search::Saturation, *share),
                Fault::Dropped { share } => of(Search::DroppedSamples, *share),
                Fault::Coarse { multiple, .. } => of(Search::CoarseSteps, *multiple),
            })
            .collect()
    }

    pub(super) fn line_findings(&self) -> Result<Vec<Finding>, DiagnoseError> {
        let known = self.reduced.blocks.known();
        let samples: Vec<f64> =
            self.reduced.error.iter().zip(known).filter(|(_, known)| **known).map(|(e, _)| *e).collect();
        let variance = fos_fit::signal::variance(&[&samples]);
        let steady = self.lines.iter().filter(|line| line.duty >= lines::STEADY);
        steady
            .map(|line| {
                let search = if line.coherent { Search::Line } else { Search::WanderingLine };
                let effect = self.found_as(search, line.frequency_hz)?;
                let mut finding = Finding {
                    params: param(effect, line.frequency_hz),
                    score: line.score,
                    gain: line.score,
                    ..bare(effect, line.score)
                };
                let unit = SizeUnit::of_axis(Column::named(self.column));
                let error = TWO_SIDED_95 * line.amplitude_error;
                finding.sizes = vec![Size {
                    of: "amplitude".to_owned(),
                    value: line.amplitude / unit.si,
                    interval: [(line.amplitude - error) / unit.si, (line.amplitude + error) / unit.si],
                    unit: unit.to_string(),
                }];
                finding.params_interval = finding
                    .params
                    .keys()
                    .map(|name| {
                        let error = TWO_SIDED_95 * line.frequency_error;
                        (name.clone(), [line.frequency_hz - error, line.frequency_hz + error])
                    })
                    .collect();
                if line.coherent {
                    let (sin, cos) = line.phase.sin_cos();
                    let hz = line.frequency_hz;
                    finding.correction = [("sine", cos), ("cosine", sin)]
                        .map(|(transform, part)| CorrectionTerm {
                            regressor: format!("clock:{transform}({hz})"),
                            coefficient: line.amplitude * part,
                            standard_error: line.amplitude_error,
                        })
                        .to_vec();
                    // E Â² = A² + 2σ², and what a wrong Â and phase leave is 2σ² more
                    let square = |a: f64| {
                        (0.5 * (a * a - 4.0 * line.amplitude_error.powi(2)) / variance).clamp(0.0, 1.0)
                    };
                    let error = TWO_SIDED_90 * line.amplitude_error + SPREAD_OF_VARIANCE * line.amplitude;
                    finding.predicted_reduction = square(line.amplitude);
                    finding.predicted_reduction_interval =
                        [square(line.amplitude - error), square(line.amplitude + error)];
                }
                Ok(finding)
            })
            .collect()
    }

    fn noise_finding(&self) -> Result<Option<Finding>, DiagnoseError> {
        let slow = self.slow;
        Ok(match slow.noise {
            ExtraNoise::None => None,
            ExtraNoise::Walk => {
                let effect = self.found_as(Search::RandomWalk, 0.0)?;
                Some(Finding { gain: slow.noise_gain, ..bare(effect, slow.noise_score) })
            }
            ExtraNoise::GaussMarkov(process) => {
                let effect = self.found_as(Search::GaussMarkov, process.tau_s)?;
                let mut finding = Finding {
                    params: param(effect, process.tau_s),
                    gain: slow.noise_gain,
                    ..bare(effect, slow.noise_score)
                };
                let unit = SizeUnit::of_axis(Column::named(self.column));
                let value = process.deviation / unit.si;
                finding.sizes = vec![Size {
                    of: "standard deviation".to_owned(),
                    value,
                    interval: [f64::NAN; 2],
                    unit: unit.to_string(),
                }];
                Some(finding)
            }
        })
    }

    /// The slow effects in this order, each with the fall to expect once those before it are in the model.
    pub(super) fn slow_findings(&self, order: Vec<&Found>) -> Result<Vec<Finding>, DiagnoseError> {
        let slow = self.slow;
        if order.is_empty() {
            return Ok(Vec::new());
        }
        let coefficients = slow.fitted.gls.coefficients();
        let covariance = slow.fitted.gls.covariance();
        let kept = &slow.fitted.gls.kept;
        let inputs = Inputs::new(self.question.field);
        let mut limits = Vec::new();
        for found in &order {
            let hypothesis = &found.hypothesis;
            let own = Estimate::of(found, slow);
            limits.push(limits::limits(&inputs, &hypothesis.regressors, &own.coefficients, &own.covariance)?);
        }
        let falls = self.falls(&order, &limits)?;
        let mut findings = Vec::new();
        for (own, (found, fall)) in order.iter().zip(falls).enumerate() {
            let effect: &Rc<Effect> = &found.hypothesis.effect;
            let value = found.hypothesis.value;
            let mut sizes = Vec::new();
            let mut correction = Vec::new();
            for ((column, &term), place) in found.hypothesis.terms.iter().enumerate().zip(found.place.clone())
            {
                let Some(at) = kept.iter().position(|index| *index == place) else { continue };
                let (coefficient, error) = (coefficients[place], covariance[(at, at)].sqrt());
                let product = match effect.search {
                    Search::Terms => found.hypothesis.regressors[column].to_string(),
                    _ => format!("clock:step({})", value.unwrap_or(0.0)),
                };
                if let Some(unit) = effect.unit(term, self.column) {
                    let half = TWO_SIDED_95 * error;
                    sizes.push(Size {
                        of: product.clone(),
                        value: coefficient / unit.si,
                        interval: [(coefficient - half) / unit.si, (coefficient + half) / unit.si],
                        unit: unit.to_string(),
                    });
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
            findings.push(Finding {
                params_interval: params.keys().filter_map(|name| Some((name.clone(), interval?))).collect(),
                params,
                sizes,
                gain: found.gain,
                predicted_reduction: fall.median,
                predicted_reduction_interval: fall.interval,
                separate: self.separations(&effect.id, &confounded_with),
                confounded_with,
                shows_against: found
                    .hypothesis
                    .regressors
                    .iter()
                    .find_map(|regressor| regressor.columns().next().map(str::to_owned)),
                shows_from_to_s: self.shows(found, &coefficients),
                correction,
                limits: limits[own].clone(),
                ..bare(effect, found.score)
            });
        }
        Ok(findings)
    }

    /// The twentieth of the log in which the effect is furthest from its mean.
    fn shows(&self, found: &Found, coefficients: &[f64]) -> Option<[f64; 2]> {
        let blocks = &self.reduced.blocks;
        let columns = found.hypothesis.columns();
        let size = |block: usize| -> f64 {
            found.place.clone().zip(&columns).map(|(place, column)| coefficients[place] * column[block]).sum()
        };
        let length = (blocks.len() / 20).max(1);
        let windows = (0..=blocks.len() - length).step_by((length / 4).max(1));
        let power = |start: &usize| (*start..start + length).map(|block| size(block).powi(2)).sum::<f64>();
        let start = windows.max_by(|a, b| power(a).total_cmp(&power(b)))?;
        let time = &self.question.field.time_s;
        let (first, last) = (&blocks.blocks[start], &blocks.blocks[start + length - 1]);
        Some([time[first.rows.start], time[last.rows.end - 1]])
    }

    /// The fall to expect from each effect once those before it are in the model.
    fn falls(
        &self,
        order: &[&Found],
        limits: &[BTreeMap<String, [f64; 2]>],
    ) -> Result<Vec<PredictedReduction>, DiagnoseError> {
        let judged = self.question.judged.filter(|judged| {
            let inputs = Inputs::new(judged);
            let is_known = |regressor| inputs.logged(regressor).as_ref() == Some(regressor);
            order.iter().all(|found| found.hypothesis.regressors.iter().all(is_known))
        });
        let log: &Recording = judged.unwrap_or(self.question.field);
        let mut blocks = ErrorInBlocks::in_slow_blocks(log, self.column)?.blocks;
        blocks.flicker_from_s = self.reduced.blocks.flicker_from_s;
        let inputs = Inputs::new(log);
        let mut effects: Vec<SlowEffect> = Vec::new();
        for (found, limits) in order.iter().zip(limits) {
            let Estimate { coefficients, covariance } = Estimate::of(found, self.slow);
            let (mut columns, mut corrected) = (Vec::new(), Vec::new());
            for regressor in &found.hypothesis.regressors {
                columns.push(blocks.means(&inputs.regressor(regressor)?));
                corrected.push(blocks.means(&inputs.regressor_within(regressor, limits)?));
            }
            if found.hypothesis.effect.search == Search::Step {
                let time_s = found.hypothesis.value.unwrap_or(0.0);
                // a step of the past is a constant in another log, about the mean of the one it was found in
                let share = step_share(self.question.field, time_s);
                let after = |block: usize| judged.is_some() || blocks.middle_s(block) > time_s;
                columns
                    .push((0..blocks.len()).map(|block| f64::from(u8::from(after(block))) - share).collect());
                corrected.push(columns[0].clone());
            }
            let is_step = found.hypothesis.effect.search == Search::Step && is_bias_known(log, self.column);
            effects.push(SlowEffect { is_step, columns, corrected, coefficients, covariance });
        }
        let mut regressors: Vec<&[f64]> = self.given.iter().map(Vec::as_slice).collect();
        for found in &self.slow.found {
            regressors.extend(found.hypothesis.columns());
        }
        let regression = Regression {
            blocks: &self.reduced.blocks,
            y: &self.reduced.means,
            regressors: &regressors,
            prior: &self.slow.prior,
        };
        let falls =
            PredictedReductions { blocks: &blocks, regression: &regression, fitted: &self.slow.fitted };
        (0..effects.len()).map(|at| Ok(falls.of(&effects[at], &effects[at + 1..])?)).collect()
    }
}

/// Relative uncertainty of the variance of the samples of another log: the wander that it happens to have.
const SPREAD_OF_VARIANCE: f64 = 0.01;

/// A finding that says no more than its name and score.
fn bare(effect: &Effect, score: f64) -> Finding {
    Finding {
        effect: effect.id.clone(),
        name: effect.name.clone(),
        band: effect.band,
        params: BTreeMap::new(),
        params_interval: BTreeMap::new(),
        sizes: Vec::new(),
        gain: score,
        score,
        predicted_reduction: 0.0,
        predicted_reduction_interval: [0.0; 2],
        measured_reduction: None,
        confounded_with: Vec::new(),
        separate: Vec::new(),
        shows_against: None,
        shows_from_to_s: None,
        correction: Vec::new(),
        limits: BTreeMap::new(),
    }
}

fn param(effect: &Effect, value: f64) -> BTreeMap<String, f64> {
    effect.parameter.iter().map(|parameter| (parameter.name.clone(), value)).collect()
}

fn lead_of(misshape: &Misshape) -> Lead {
    match misshape {
        Misshape::Jumps { kurtosis, gain } => Lead {
            follows: format!("jumps at moments of their own (excess kurtosis {kurtosis:.1} of what is left)"),
            gain: *gain,
            score: *kurtosis,
            share: 0.0,
        },
        Misshape::Level { follows, spread, score } => Lead {
            follows: match follows {
                Some(column) => {
                    format!("a noise level that changes by {:.0} % with {column}", 100.0 * spread)
                }
                None => format!("a noise level that changes by {:.0} % over the log", 100.0 * spread),
            },
            gain: *score,
            score: *score,
            share: 0.0,
        },
    }
}

/// Leaves those findings beside an unexplained rest that explain far more than it.
pub(super) fn outweighed(findings: &mut Vec<Finding>, leads: &[Lead]) {
    let most = leads.iter().map(|lead| lead.gain).fold(0.0, f64::max);
    findings.retain(|finding| finding.band == Band::Data || finding.gain > OUTWEIGHS * most);
}

/// The outcome in a sentence.
pub(super) fn sentence(verdict: Verdict, findings: &[Finding], leads: &[Lead]) -> String {
    match verdict {
        Verdict::NothingMissing => {
            "Nothing is missing: what is left looks like the noise of the unit.".to_owned()
        }
        Verdict::Unexplained => {
            let lead = leads.first().map(|lead| lead.follows.as_str()).unwrap_or("nothing that is logged");
            let beside = match findings.first() {
                Some(finding) => format!(" beside {}", finding.name),
                None => String::new(),
            };
            format!(
                "Something is missing{beside}, and nothing in the library explains it; a lead: it follows {lead}."
            )
        }
        Verdict::Missing => {
            let finding = &findings[0];
            let params: Vec<String> =
                finding.params.iter().map(|(name, value)| format!("{name} = {value:.4}")).collect();
            let params = if params.is_empty() { String::new() } else { format!(" ({})", params.join(", ")) };
            let drop = match finding.predicted_reduction > 0.0 {
                true => {
                    format!("; with it the error should fall by {:.1} %", 100.0 * finding.predicted_reduction)
                }
                false if findings.len() > 1 && finding.band == Band::Slow => {
                    ", which alone helps little: the others are still missing".to_owned()
                }
                false => String::new(),
            };
            let rivals = match finding.confounded_with.is_empty() {
                true => String::new(),
                false => format!(" This log cannot tell it from {}.", finding.confounded_with.join(", ")),
            };
            format!("Most likely missing: {}{params}{drop}.{rivals}", finding.name)
        }
    }
}

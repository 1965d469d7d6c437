//! Smallest size of each effect that a recording shows, and from which it is distinguishable from its rivals: what to record
//! before anybody records it.
//!
//! With an effect of size s the expected gain in −2 ln L over the model without it is
//!
//! min over the noise levels θ of  s²·xᵀC_θ⁻¹x + D(θ) + P(θ),
//!
//! where x is the regressor, D(θ) = Σ_k (S₀/S_θ − 1 − ln(S₀/S_θ)) is what the noise itself loses under levels other than its
//! own (Whittle 1953, over the frequencies k/T of the block means) and P what the prior adds: without the effect, larger noise
//! levels explain a part of it. The square root of the gain scatters by 1 about that of its expectation.

use std::sync::Arc;

use fos_data::recording::{LoadOptions, Recording, RecordingError, Source};
use fos_fit::noise::{Gls, LogLevels, NoiseLevels, dot, expected_rise, least_where, minimise};

use super::error_in_blocks::ErrorInBlocks;
use super::hypothesis::{Hypotheses, Hypothesis};
use super::prepared::{prior_of, too_short};
use super::question::{DiagnoseError, MIN_BLOCKS, Question};
use super::slow::{ACCEPT, INSEPARABLE, INSIDE, SlowSearch};
use super::testable::Testable;
use crate::effects::{Detector, Effect, Inputs, Library};

/// Quantile of the normal distribution at 90 %: the probability with which an effect of the stated size is found.
const NINETY_PERCENT: f64 = 1.281_552;

/// Sizes are searched over this many doublings of the size with unit information.
const MOST_DOUBLINGS: i32 = 20;

/// Quantile of the normal distribution for a two-sided 90 % interval.
const TWO_SIDED_90: f64 = 1.644_854;

/// Interval between the samples of a planned recording, s: slow effects are seen in means over seconds.
const PLANNED_PERIOD_S: f64 = 1.0;

/// A recording at rest that is planned: the temperature rises from a start by `span_k` and returns, `cycles` times, as a
/// cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course {
    /// Length of the recording, s.
    pub seconds: f64,
    /// Temperature at the start, °C.
    pub start_c: f64,
    /// Difference between the highest and the lowest temperature, K.
    pub span_k: f64,
    /// Number of rises; each is followed by a fall, so that half a cycle is a rise alone.
    pub cycles: f64,
}

/// Smallest size of an effect that a recording shows, of one term of the effect.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Visibility {
    /// Identifier of the effect, as `thermal_lag`.
    pub effect: String,
    /// Regressor of the term whose coefficient is the size.
    pub regressor: String,
    /// Value of its parameter that the sizes hold for; none for an effect without a parameter.
    pub parameter: Option<f64>,
    /// Unit of the sizes, as `dps/K`.
    pub unit: String,
    /// Coefficient that is found with 90 % probability; none if it cannot be found at any size.
    pub detected_from: Option<f64>,
    /// Half width of the 90 % interval of the coefficient, with the other effects known.
    pub half_width: f64,
    /// Coefficient that is distinguishable from every rival with 90 % probability; none if it is not at any size.
    pub distinguishable_from: Option<f64>,
    /// Rival that is most like the effect in this recording; none if no other effect follows the same columns.
    pub rival: Option<String>,
    /// Largest coefficient that is typical of such sensors, where known.
    pub typical: Option<f64>,
}

impl Course {
    /// The planned recording, with `target` at 0 throughout: only its inputs matter.
    pub fn recording(&self, target: &str) -> Result<Recording, RecordingError> {
        let rows = (self.seconds / PLANNED_PERIOD_S).floor() as usize;
        let time_s: Vec<f64> = (0..rows).map(|row| row as f64 * PLANNED_PERIOD_S).collect();
        let phase = |time_s: &f64| std::f64::consts::TAU * self.cycles * time_s / self.seconds;
        let temp_c =
            time_s.iter().map(|time_s| self.start_c + 0.5 * self.span_k * (1.0 - phase(time_s).cos()));
        let columns = vec![
            ("temp_c".to_owned(), temp_c.collect()),
            (target.to_owned(), vec![0.0; rows]),
            ("still".to_owned(), vec![1.0; rows]),
            ("t_s".to_owned(), time_s),
        ];
        let source = Source::made_by("planned recording");
        Recording::from_columns(source, columns, &LoadOptions::default())
    }
}

/// Smallest sizes of the slow effects of `library` on axis `target` that `recording` shows, if `reference`, a log of the same
/// device at rest, states its noise. Effects without a regressor in the recording are absent.
pub fn visibility(
    recording: &Recording,
    reference: &Recording,
    target: &str,
    library: &Library,
) -> Result<Vec<Visibility>, DiagnoseError> {
    let column = recording.axis(target)?.name.clone();
    let inputs = Inputs::new(recording);
    let question = Question { reference: Some(reference), ..Question::new(recording, &column, library) };
    let Testable { mut effects, known, .. } = Testable::of(&question, &inputs, &column)?;
    effects.retain(|effect| effect.search == Detector::Terms);
    let reference = ErrorInBlocks::new(reference, &column, &[])?;
    let reduced = ErrorInBlocks::where_known(recording, &column, &[], &known)?;
    for log in [&reference, &reduced] {
        if log.blocks.beyond_levels() < MIN_BLOCKS {
            return Err(too_short(&column, log));
        }
    }
    let prior = prior_of(None, &reduced, Some(&reference))?;
    let hypotheses = Hypotheses::new(inputs, &reduced.blocks, &column);
    let given = vec![vec![1.0; reduced.blocks.len()]];
    let search = SlowSearch {
        blocks: &reduced.blocks,
        y: &reduced.means,
        given: &given,
        hypotheses: &hypotheses,
        axes: 1,
        effects: &effects,
        free_walk_prior: prior,
        prior,
    };
    let planned = Planned { search, levels: NoiseLevels::from_logs(&prior.mean), column: &column };
    effects.iter().filter_map(|effect| planned.visibility(effect).transpose()).collect()
}

/// A recording with the noise that its axis will have.
struct Planned<'a> {
    search: SlowSearch<'a>,
    levels: NoiseLevels,
    column: &'a str,
}

impl Planned<'_> {
    /// Visibility of an effect at the middle of its parameter's grid; none if its regressor never changes, or if its
    /// coefficient has no unit on this axis.
    fn visibility(&self, effect: &Arc<Effect>) -> Result<Option<Visibility>, DiagnoseError> {
        let hypotheses = self.search.hypotheses;
        let grid = hypotheses.grid(effect);
        let Some(value) = grid.get(grid.len() / 2).copied() else { return Ok(None) };
        let hypothesis = hypotheses.make(effect, value)?;
        let Some(place) = hypothesis.terms.iter().position(|term| *term == self.own_term(effect)) else {
            return Ok(None);
        };
        let (term, column) = (hypothesis.terms[place], &hypothesis.columns[place]);
        let Some(unit) = effect.unit(term, self.column) else { return Ok(None) };
        let information = self.information(column, &[], &self.levels);
        if information <= 0.0 {
            return Ok(None);
        }
        let alone = hypothesis.with_terms(&[place]);
        let threshold = (ACCEPT + self.search.price(1, &alone, &[])).max(0.0);
        let needed = (threshold.sqrt() + NINETY_PERCENT).powi(2);
        let detected_from = self.size_with_gain(needed, column);
        let rival = self.nearest_rival(effect, &effect.terms[term].regressor, column)?;
        // the difference of the gains is normal about its expectation λ with standard deviation 2√λ
        let apart = NINETY_PERCENT + (NINETY_PERCENT.powi(2) + INSEPARABLE).sqrt();
        let distinguishable_from = match &rival {
            None => detected_from,
            Some((_, information)) if *information > 0.0 => {
                detected_from.map(|size| size.max(apart / information.sqrt()))
            }
            Some(_) => None,
        };
        Ok(Some(Visibility {
            effect: effect.id.clone(),
            regressor: effect.terms[term].regressor.clone(),
            parameter: value,
            detected_from: detected_from.map(|size| size / unit.si),
            half_width: TWO_SIDED_90 / information.sqrt() / unit.si,
            distinguishable_from: distinguishable_from.map(|size| size / unit.si),
            rival: rival.map(|(rival, _)| rival),
            typical: effect.typical(term, self.column),
            unit: unit.to_string(),
        }))
    }

    /// The term that makes the effect different from the others: the first that is not all of another effect, as the square
    /// of a polynomial beside the line.
    fn own_term(&self, effect: &Effect) -> usize {
        let is_another = |regressor: &str| {
            self.search.effects.iter().any(|other| {
                other.id != effect.id && matches!(&other.terms[..], [only] if only.regressor == regressor)
            })
        };
        effect.terms.iter().position(|term| !is_another(&term.regressor)).unwrap_or(0)
    }

    /// One over the variance of the coefficient of `column` beside the constant and the columns of `others`.
    fn information(&self, column: &[f64], others: &[&[f64]], levels: &NoiseLevels) -> f64 {
        let mut beside: Vec<&[f64]> = self.search.given.iter().map(Vec::as_slice).collect();
        beside.extend(others);
        let gls = Gls::new(self.search.blocks, levels, column, &beside);
        dot(&gls.residual, &gls.residual)
    }

    /// Size, SI, at which the expected gain of `column` is `needed`; none if larger noise levels explain it at any size.
    fn size_with_gain(&self, needed: f64, column: &[f64]) -> Option<f64> {
        let unit = 1.0 / self.information(column, &[], &self.levels).sqrt();
        least_where(unit, MOST_DOUBLINGS, |size| self.gain(size, column) >= needed)
    }

    /// Expected gain in −2 ln L of an effect of this size over larger noise levels.
    fn gain(&self, size: f64, column: &[f64]) -> f64 {
        let (prior, blocks) = (&self.search.prior, self.search.blocks);
        let seconds = blocks.len() as f64 * blocks.length_s;
        // the prior takes nothing from its own mean
        let deviance = |logs: &LogLevels| {
            let other = NoiseLevels::from_logs(logs);
            size * size * self.information(column, &[], &other)
                + expected_rise(&self.levels, &other, seconds, blocks.length_s)
                + prior.deviance(logs)
        };
        minimise(prior.mean, deviance).1
    }

    /// The effect that is most like `column` at any value of its parameter well inside its range, and the information that
    /// the recording has of the difference. Effects that contain the regressor are no rivals.
    fn nearest_rival(
        &self,
        effect: &Effect,
        regressor: &str,
        column: &[f64],
    ) -> Result<Option<(String, f64)>, DiagnoseError> {
        let mut nearest: Option<(String, f64)> = None;
        let contains = |other: &Effect| other.terms.iter().any(|term| term.regressor == regressor);
        for other in self.search.effects.iter().filter(|other| other.id != effect.id && !contains(other)) {
            for value in self.search.hypotheses.grid(other) {
                if let (Some(parameter), Some(value)) = (&other.parameter, value)
                    && !(INSIDE * parameter.low..parameter.high / INSIDE).contains(&value)
                {
                    continue;
                }
                let Hypothesis { columns, .. } = self.search.hypotheses.make(other, value)?;
                let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
                let information = self.information(column, &columns, &self.levels);
                if nearest.as_ref().is_none_or(|(_, least)| information < *least) {
                    nearest = Some((other.id.clone(), information));
                }
            }
        }
        Ok(nearest)
    }
}

//! Adds effects to one axis of a model and measures the improvement.

use std::borrow::Cow;
use std::ops::Range;

use fos_data::column::Column;
use fos_data::recording::Recording;
use fos_data::stillness;
use fos_fit::cost::Cost;
use fos_fit::evaluate::{ModelErrors, trace};
use fos_fit::fit::physical_range::{Part, physical_range};
use fos_fit::fit::regressors::Regressors;
use fos_fit::model::{FittedAxis, Plain};
use fos_fit::playback::Playback;
use fos_fit::single_axis::SingleAxisModel;

use super::error::RefineError;
use super::identifiable;
use super::observed_log::{Levelled, ObservedLog};
use super::terms;
use crate::detect::{
    DiagnoseError, Diagnosis, ErrorInBlocks, Finding, Given, Question, Verdict, as_after_steps, correction,
    diagnose, estimate, is_step, keeps_bias, with_measured_reduction,
};
use crate::effects::{Band, Detector, Effect, Library};
use crate::physical::physical;
use crate::study::{Added, Left, LogSources, Refinement, RefinementStep, Study, StudyAxisError};

/// Share of the log to explain from which effects are estimated if there is no evaluation log.
pub const FITTED_SHARE: f64 = 0.6;

/// Largest number of effects that are added automatically.
const MAX_AUTO_EFFECTS: usize = 6;

/// Logs used to refine one axis.
#[derive(Debug)]
pub struct Refiner<'a> {
    /// Rows from which effects are estimated.
    pub(super) log: ObservedLog<'a>,
    reference: Option<&'a Recording>,
    /// Evaluation log, and the rows of it that were not fitted.
    evaluation: ObservedLog<'a>,
    evaluation_rows: Range<usize>,
    library: &'a Library,
}

impl<'a> Refiner<'a> {
    /// `evaluation` is a separate evaluation log; without one the last part of `log` is reserved. One that begins where
    /// `log` ends is evaluated after it, so that lags and hysteresis have their states.
    pub fn new(
        log: &'a Recording,
        reference: Option<&'a Recording>,
        evaluation: Option<&'a Recording>,
        library: &'a Library,
    ) -> Self {
        let cut = (FITTED_SHARE * log.n_rows() as f64) as usize;
        let (log, evaluation, evaluation_rows) = match evaluation {
            Some(evaluation) => {
                let (evaluation, from) = evaluation.led_in_by(log);
                let rows = from..evaluation.n_rows();
                (ObservedLog::new(Cow::Borrowed(log)), ObservedLog::new(evaluation), rows)
            }
            None => {
                // in this order, for the search for motion in the whole log takes much memory
                let whole = ObservedLog::new(Cow::Borrowed(log));
                (ObservedLog::new(Cow::Owned(log.first_rows(cut))), whole, cut..log.n_rows())
            }
        };
        Self { log, reference, evaluation, evaluation_rows, library }
    }

    /// Returns the effects that can be added.
    pub fn library(&self) -> &'a Library {
        self.library
    }

    /// Returns the number of rows from which effects are estimated.
    pub fn fitted_rows(&self) -> usize {
        self.log.whole.n_rows()
    }

    /// Returns the state before any effect is added: the fitted axis of the study with the bias of the log to explain.
    pub fn first_step(&self, model: &SingleAxisModel) -> Result<RefinementStep, RefineError> {
        let left = self.left(model, &[])?;
        let log = self.measured(&model.axis().column);
        self.step(self.recalibrated(model.clone(), &[], &log)?, None, left)
    }

    /// Starts the refinement of an axis of a study; `logs` are stored in it.
    pub fn begin(&self, study: &Study, column: &str, logs: LogSources) -> Result<Refinement, RefineError> {
        self.refuse_other_sensor(study, column)?;
        let steps = vec![self.first_step(&study.axis_alone(column)?)?];
        Ok(Refinement { column: column.to_owned(), logs, steps })
    }

    fn refuse_other_sensor(&self, study: &Study, column: &str) -> Result<(), RefineError> {
        let Some((triad, _)) = Column::named(column).place() else { return Ok(()) };
        match study.contradiction(&self.log.whole, triad) {
            None => Ok(()),
            Some([study, found]) => {
                let (log, column) = (self.log.whole.paths(), column.to_owned());
                Err(RefineError::OtherSensor { log, column, study, found })
            }
        }
    }

    /// Resumes the refinement of an axis of a study if it was made with these logs; otherwise starts it if nothing was
    /// added yet.
    pub fn resume(&self, study: &Study, column: &str, logs: LogSources) -> Result<Refinement, RefineError> {
        match study.refinement_of(column) {
            Some(refinement) if refinement.logs == logs => Ok(refinement.clone()),
            Some(refinement) if refinement.added().next().is_some() => {
                let (column, changes) = (column.to_owned(), refinement.logs.changes(&logs));
                Err(RefineError::OtherLogs { column, changes })
            }
            _ => self.begin(study, column, logs),
        }
    }

    /// Checks that an effect has a correction on this axis. The error states the alternative.
    pub fn can_add(&self, column: &str, effect: &Effect) -> Result<(), RefineError> {
        if effect.search == Detector::Step && !self.log.whole.is_bias_known(column) {
            let help = "at rest an accelerometer shows gravity beside its bias, and in a later log a step of one is indistinguishable from a step of the other; log the true values (`ref_…`)";
            return Err(RefineError::NothingToTakeOff(effect.id.clone(), help));
        }
        can_be_added(effect)
    }

    /// Checks that a detected effect can be added: it has a correction, and the log determines it. The error states the
    /// alternative, or the log to record.
    pub fn can_add_finding(
        &self,
        column: &str,
        effect: &Effect,
        finding: &Finding,
    ) -> Result<(), RefineError> {
        self.can_add(column, effect)?;
        identifiable::identified(finding, effect, column)
    }

    /// Diagnoses the model at the end of `refinement`.
    pub fn diagnose(&self, refinement: &Refinement) -> Result<Diagnosis, RefineError> {
        let wide = refinement.added().filter(|added| added.finding.band == Band::Wide);
        let wide: Vec<Finding> = wide.map(|added| added.finding.clone()).collect();
        let log = self.without_base(refinement, &wide)?;
        let given = refinement.added().filter(|added| added.finding.band != Band::Wide).map(|added| Given {
            effect: added.effect.id.clone(),
            value: added.finding.params.values().next().copied(),
        });
        let given: Vec<Given> = given.collect();
        let library = self.library_with(refinement);
        let question = Question { given: &given, ..self.question(&log, &refinement.column, &library) };
        let added: Vec<Finding> = refinement.added().map(|added| added.finding.clone()).collect();
        let evaluation = self.without(refinement, &added, &self.evaluation.whole)?;
        let field_residual = self.without_base(refinement, &added)?;
        let mut diagnosis = with_measured_reduction(
            diagnose(&question)?,
            &field_residual,
            &evaluation,
            &self.evaluation_rows,
        )?;
        // the diagnosis fits the added effects again, so it does not see that they made the model worse
        if diagnosis.verdict == Verdict::NothingMissing
            && let Some((verdict, sentence)) =
                identifiable::all_clear_refuted(refinement, self.continues(&refinement.column))
        {
            (diagnosis.verdict, diagnosis.sentence) = (verdict, sentence);
        }
        Ok(diagnosis)
    }

    /// Returns the model of `refinement` with `effect` added. All effects are estimated again, together with those that
    /// the diagnosis finds, so that a missing effect does not bias the others.
    pub fn add(&self, refinement: &Refinement, effect: &Effect) -> Result<RefinementStep, RefineError> {
        self.can_add(&refinement.column, effect)?;
        self.add_beside(refinement, effect, &self.diagnose(refinement)?)
    }

    fn add_beside(
        &self,
        refinement: &Refinement,
        effect: &Effect,
        diagnosis: &Diagnosis,
    ) -> Result<RefinementStep, RefineError> {
        let library = self.library_with(refinement);
        let mut wanted: Vec<String> = refinement.added().map(|added| added.effect.id.clone()).collect();
        // there may be several lines and several steps
        let repeats = effect.search.is_repeatable();
        if wanted.contains(&effect.id) && !repeats {
            return Err(RefineError::Twice(effect.id.clone()));
        }
        wanted.push(effect.id.clone());
        let in_model = wanted.len();
        // an effect that is not conclusive would take a share of the error that the others explain
        let found = diagnosis.findings.iter().filter(|f| f.band == Band::Slow && f.doubt.is_none());
        wanted.extend(found.filter(|finding| finding.effect != effect.id).map(|f| f.effect.clone()));
        let log = self.without_base(refinement, &[])?;
        let question = self.question(&log, &refinement.column, &library);
        let mut findings = match estimate(&question, &wanted) {
            // an additional effect that cannot be estimated must not prevent the estimation of the others
            Err(DiagnoseError::NotThere { effect, .. }) if wanted[in_model..].contains(&effect) => {
                estimate(&question, &wanted[..in_model])?
            }
            findings => findings?,
        };
        let in_question = in_model - 1;
        identifiable::identifiable(&findings[..in_model], &library, &refinement.column)?;
        let [first, ..] = &refinement.steps[..] else {
            return Err(StudyAxisError::NothingAdded(refinement.column.clone()).into());
        };
        self.check_errors(&first.model, &findings, in_question, effect)?;
        findings.truncate(in_model);
        let mut model = first.model.clone();
        let effects = terms::add(&mut model, &findings, &self.log.whole)?;
        let log = self.measured(&refinement.column);
        let log = as_after_steps(&findings, &refinement.column, &log)?;
        let model = self.recalibrated(model, &effects, &log)?;
        let Some(finding) = findings.last().cloned() else {
            return Err(RefineError::NothingToTakeOff(effect.id.clone(), "the log does not show it"));
        };
        let before = refinement.last().map_or(first.left, |last| last.left);
        let after = self.left(&first.model, &findings)?;
        let measured_reduction = match finding.band {
            Band::Wide => 1.0 - after.wide / before.wide,
            // a step is a constant in every later log and contributes no variance
            _ if is_step(&finding) && !self.continues(&refinement.column) => {
                match (before.bias, after.bias) {
                    (Some(was), Some(is)) => 1.0 - (after.slow + is * is) / (before.slow + was * was),
                    _ => 0.0,
                }
            }
            _ => 1.0 - after.slow / before.slow,
        };
        let added = Added { effect: effect.clone(), finding, measured_reduction };
        self.step(model, Some(added), after)
    }

    /// Adds the effects that a diagnosis finds, the one with the largest predicted reduction first, until none is worth
    /// adding. Returns the added steps; `progress` is called with each diagnosis and step.
    pub fn add_best(
        &self,
        refinement: &Refinement,
        progress: &mut dyn FnMut(&Diagnosis, Option<&RefinementStep>),
    ) -> Result<Vec<RefinementStep>, RefineError> {
        let mut refinement = refinement.clone();
        let (mut steps, mut refused) = (Vec::new(), Vec::new());
        // effects that cancel in part reduce the error only together: the steps up to the least error are kept
        let (mut left, mut least, mut kept) = (1.0, 1.0, 0);
        // terminates after MAX_AUTO_EFFECTS; a rejected finding is not tried again before another is added
        while steps.len() < MAX_AUTO_EFFECTS {
            let diagnosis = self.diagnose(&refinement)?;
            let worth_adding = diagnosis.findings.iter().filter(|finding| {
                let effect = self.library.get(&finding.effect);
                let can_be_added = effect
                    .is_ok_and(|effect| self.can_add_finding(&refinement.column, effect, finding).is_ok());
                let is_claim = !finding.correction.is_empty() && finding.doubt.is_none();
                is_claim && can_be_added && !refused.contains(&finding.effect)
            });
            // in the order of the diagnosis: two effects may cancel in part, and the one that helps most alone comes first;
            // but a course in time alone may stand in for an effect that follows a logged quantity
            let best = worth_adding
                .min_by_key(|finding| (finding.band != Band::Slow, finding.shows_against.is_none()));
            let Some(best) = best.filter(|_| diagnosis.verdict != Verdict::NothingMissing) else {
                progress(&diagnosis, None);
                break;
            };
            let step = match self.add_beside(&refinement, self.library.get(&best.effect)?, &diagnosis) {
                Err(
                    RefineError::NotIdentifiable { .. }
                    | RefineError::MakesWorse { .. }
                    | RefineError::Diagnose(DiagnoseError::NotThere { .. }),
                ) => {
                    refused.push(best.effect.clone());
                    continue;
                }
                step => step?,
            };
            progress(&diagnosis, Some(&step));
            left *= step.added.as_ref().map_or(1.0, |added| 1.0 - added.measured_reduction);
            // beside it they may be identifiable
            refused.clear();
            refinement.steps.push(step.clone());
            steps.push(step);
            if left < least {
                (least, kept) = (left, steps.len());
            }
        }
        steps.truncate(kept);
        Ok(steps)
    }

    /// Returns the library with the effects of the model as they were when they were added.
    fn library_with(&self, refinement: &Refinement) -> Library {
        let mut library = self.library.clone();
        refinement.added().for_each(|added| library.add(added.effect.clone()));
        library
    }

    fn question<'q>(&'q self, log: &'q Recording, column: &'q str, library: &'q Library) -> Question<'q> {
        let (evaluation, evaluation_from) = (Some(&*self.evaluation.whole), self.evaluation_rows.start);
        Question {
            reference: self.reference,
            evaluation,
            evaluation_from,
            ..Question::new(log, column, library)
        }
    }

    /// Returns the log to explain after the physical part of the initial model and `found` are subtracted.
    pub(super) fn without_base(
        &self,
        refinement: &Refinement,
        found: &[Finding],
    ) -> Result<Cow<'_, Recording>, RefineError> {
        self.without(refinement, found, &self.log.whole)
    }

    /// Returns `log` after the physical part of the initial model and `found` are subtracted.
    fn without<'l>(
        &self,
        refinement: &Refinement,
        found: &[Finding],
        log: &'l Recording,
    ) -> Result<Cow<'l, Recording>, RefineError> {
        let has_base = refinement.steps.first().is_some_and(|first| !first.model.axis().physical.is_empty());
        if found.is_empty() && !has_base {
            return Ok(Cow::Borrowed(log));
        }
        let mut values = log.channel(&refinement.column)?.values.to_vec();
        if let Some(first) = refinement.steps.first() {
            let base = physical(&first.model, log)?.swap_remove(0);
            values.iter_mut().zip(&base).for_each(|(value, base)| *value -= base);
        }
        let taken = correction(found, &self.log.whole, log)?;
        values.iter_mut().zip(&taken).for_each(|(value, taken)| *value -= taken);
        Ok(Cow::Owned(log.with_values(&refinement.column, values)))
    }

    /// Recalibrates a model: the bias is the mean of the residual of the physical part, and the ranges cover both. `log`
    /// is the log to explain with the steps in it removed, as in later logs; `effects` holds the positions of the added
    /// terms, effect by effect.
    fn recalibrated(
        &self,
        mut model: SingleAxisModel,
        effects: &[Range<usize>],
        log: &Recording,
    ) -> Result<SingleAxisModel, RefineError> {
        let column = model.axis().column.clone();
        let before = model.axis().parameters.physical_limits();
        model.axis_mut().parameters.physical_range = fos_core::Range::unlimited();
        let is_bias_known = log.is_bias_known(&column);
        let Levelled { log, known, level } = self.log.levelled(&model, log, 0..log.n_rows())?;
        let parameters = &mut model.axis_mut().parameters;
        match is_bias_known {
            true => parameters.offset = level,
            false => (parameters.reference, parameters.offset) = (level, 0.0),
        }
        let playback = Playback::new(&log, &model, &known)?;
        let mut alone = model.clone();
        alone.axis_mut().stochastic.clear();
        let regressors = Regressors::of(&alone, &playback, log.n_rows())?;
        let inputs = &alone.inputs;
        let FittedAxis { parameters, physical, plain, .. } = model.axis_mut();
        let base = &physical[..effects.first().map_or(physical.len(), |first| first.start)];
        let parts = effects.iter().map(|places| (&physical[places.clone()], fos_core::Range::unlimited()));
        let parts = parts.chain([(base, before)]).map(|(terms, within)| Part { terms, within });
        let parts: Vec<Part<'_>> = parts.collect();
        // as for the ranges of the inputs: at rest or not
        let rows = (0..log.n_rows()).filter(|row| playback.knows_inputs(*row));
        parameters.physical_range = physical_range(inputs, &regressors.inputs, rows, &parts);
        let range = &mut parameters.range;
        for value in regressors.known(&regressors.remainder) {
            (range.low, range.high) = (range.low.min(value), range.high.max(value));
        }
        *plain = Some(self.plain(&column)?);
        Ok(model)
    }

    /// Returns the log to explain without detected motion.
    pub(super) fn log(&self) -> &Recording {
        self.log.at_rest()
    }

    /// Returns the evaluation log without detected motion.
    pub(super) fn evaluation(&self) -> &Recording {
        self.evaluation.at_rest()
    }

    /// Returns the rows of the evaluation log that were not fitted.
    pub(super) fn evaluation_rows(&self) -> Range<usize> {
        self.evaluation_rows.clone()
    }

    /// Returns the error of `log` in blocks of the slow error, and its samples after the physical part of `base` and
    /// `findings` are subtracted.
    pub(super) fn reduced_without(
        &self,
        base: &SingleAxisModel,
        findings: &[Finding],
        log: &Recording,
    ) -> Result<(ErrorInBlocks, Vec<f64>), RefineError> {
        let reduced = ErrorInBlocks::in_slow_blocks(log, &base.axis().column)?;
        let mut left = reduced.error.clone();
        let base = physical(base, log)?.swap_remove(0);
        left.iter_mut().zip(&base).for_each(|(left, base)| *left -= base);
        let taken = correction(findings, &self.log.whole, log)?;
        left.iter_mut().zip(&taken).for_each(|(left, taken)| *left -= taken);
        Ok((reduced, left))
    }

    /// Returns the log to explain without outliers of an axis.
    fn measured(&self, column: &str) -> Cow<'_, Recording> {
        let log = &self.log.whole;
        log.without_outliers(column, 0..log.n_rows(), &stillness::find(log).still).0
    }

    /// Returns the data for the simpler rivals, from the log to explain as read.
    fn plain(&self, column: &str) -> Result<Plain, RefineError> {
        let log = &*self.log.whole;
        let (error, known) = (log.error_series(column)?, self.log.known_rows(column)?);
        let rows = log.stretches_where(|row| known[row] && error.values[row].is_finite());
        let stretches: Vec<&[f64]> = rows.into_iter().map(|rows| &error.values[rows]).collect();
        Ok(Plain::of(&stretches.concat(), &stretches))
    }

    /// Returns the errors on the evaluation rows after the physical part of `base` and `findings` are subtracted.
    fn left(&self, base: &SingleAxisModel, findings: &[Finding]) -> Result<Left, RefineError> {
        let log = self.reduced_without(base, findings, self.log())?;
        let evaluation = self.reduced_without(base, findings, self.evaluation())?;
        Ok(self.left_in(&base.axis().column, &log, &evaluation))
    }

    /// Returns the errors on the evaluation rows of a residual, given for the log to explain and for the evaluation log.
    pub(super) fn left_in(
        &self,
        column: &str,
        (log, left_of_log): &(ErrorInBlocks, Vec<f64>),
        (reduced, left): &(ErrorInBlocks, Vec<f64>),
    ) -> Left {
        let rows = &self.evaluation_rows;
        let bias = log.slow_mean(left_of_log, &(0..self.log.whole.n_rows()));
        Left {
            slow: match self.continues(column) {
                true => reduced.slow_mean_square(left, rows, bias),
                false => reduced.slow_variance(left, rows),
            },
            wide: reduced.wide_variance(left, rows),
            bias: self.evaluation.whole.is_bias_known(column).then(|| reduced.slow_mean(left, rows) - bias),
        }
    }

    /// Returns true if the axis has the bias of the log to explain in the evaluated rows.
    pub(super) fn continues(&self, column: &str) -> bool {
        keeps_bias(self.evaluation(), column, self.evaluation_rows.start)
    }

    fn step(
        &self,
        model: SingleAxisModel,
        added: Option<Added>,
        left: Left,
    ) -> Result<RefinementStep, RefineError> {
        let (rows, column) = (self.evaluation_rows.clone(), &model.axis().column);
        let Levelled { log, known, level } =
            self.evaluation.levelled(&model, &self.evaluation.whole, rows.clone())?;
        let mut evaluated = model.clone();
        if !log.is_bias_known(column) {
            // another orientation has another constant
            let parameters = &mut evaluated.axis_mut().parameters;
            (parameters.reference, parameters.offset) = (level, 0.0);
        }
        let playback = Playback::new(&log, &evaluated, &known)?;
        let trace = trace(&evaluated, &playback, rows)?;
        let name = match &added {
            None => "before".to_owned(),
            Some(added) => format!("+ {}", added.effect.id),
        };
        let errors = ModelErrors::of(&trace, 0, &name, column, None);
        let cost = Cost::of(&model);
        Ok(RefinementStep { added, model, errors, left, cost })
    }
}

/// Rejects effects without a correction.
fn can_be_added(effect: &Effect) -> Result<(), RefineError> {
    let help = match effect.band {
        Band::Data => "fix the recording: another full scale, a faster bus, a finer output",
        Band::Stochastic => "fit the stochastic part again on this log",
        Band::Wide if effect.search != Detector::Line => {
            "use a filter before the model, or another output rate"
        }
        _ => return Ok(()),
    };
    Err(RefineError::NothingToTakeOff(effect.id.clone(), help))
}

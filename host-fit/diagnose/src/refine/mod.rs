//! Grows a model by physical effects: estimates them together on a log where the model fails, puts them into its physical
//! part, and judges every step on rows that were not fitted.

mod cost;
mod evidence;
mod logs;
mod stair;
mod terms;

use fos_data::column::Column;
use std::borrow::Cow;
use std::ops::Range;

use fos_core::ModelError;

pub use cost::Cost;
pub use evidence::{Against, Evidence};
pub use logs::Logs;
pub use stair::{Added, Growth, GrowthLogs, Left, Stair};

use crate::detect::{
    DiagnoseError, Diagnosis, Finding, Given, Question, Reduced, Verdict, as_after_steps, correction,
    diagnose, estimate, is_bias_known, is_step,
};
use crate::effects::{Band, Effect, EffectError, Library, Search};
use crate::study::Study;
use fos_data::recording::{Recording, RecordingError};
use fos_data::stillness::{self, KnownBy};
use fos_fit::evaluate::{ModelErrors, trace};
use fos_fit::fit::regressors::Regressors;
use fos_fit::model::{FittedAxis, Plain, UnitModel};
use fos_fit::playback::Feed;
use fos_fit::signal;

/// Share of the field log that effects are estimated from where no other log is there to judge on.
pub const FITTED_SHARE: f64 = 0.6;

/// Most effects that are added one after the other without being asked.
const MOST: usize = 6;

/// Why an effect cannot be added.
#[derive(Debug, thiserror::Error)]
pub enum GrowError {
    /// A column is missing.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The effect cannot be estimated.
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    /// The effect is not known.
    #[error(transparent)]
    Effect(#[from] EffectError),
    /// fos-core refuses the model.
    #[error(
        "the grown model cannot be run: {0}\nhelp: take an effect back first, of another axis too (`host-fit undo`), or fit fewer axes together"
    )]
    Model(#[from] ModelError),
    /// The study has no such axis.
    #[error("the study has no axis {column}; it has {}\nhelp: --axis names one of them", .axes.join(", "))]
    NoAxis {
        /// What was asked for.
        column: String,
        /// What there is.
        axes: Vec<String>,
    },
    /// It is there already.
    #[error(
        "{0} is in the model already\nhelp: `host-fit history STUDY` shows what was added, `host-fit undo STUDY` takes the last back"
    )]
    Twice(String),
    /// There is nothing to take off.
    #[error("{0}: nothing of it can be taken off sample by sample\nhelp: {1}")]
    NothingToTakeOff(String, &'static str),
    /// Nothing was added.
    #[error("nothing was added to {0}\nhelp: `host-fit add STUDY EFFECT --from LOG` adds an effect")]
    NothingAdded(String),
}

/// The logs that an axis grows on.
#[derive(Debug)]
pub struct Ground<'a> {
    /// The rows that effects are estimated from.
    field: Cow<'a, Recording>,
    /// A quiet log.
    quiet: Option<&'a Recording>,
    /// The log that errors are of, and the rows of it that were not fitted.
    judged: &'a Recording,
    judged_rows: Range<usize>,
    library: &'a Library,
}

impl<'a> Ground<'a> {
    /// `judged` is a log of its own; without one the last part of `field` is kept back.
    pub fn new(
        field: &'a Recording,
        quiet: Option<&'a Recording>,
        judged: Option<&'a Recording>,
        library: &'a Library,
    ) -> Self {
        let cut = (FITTED_SHARE * field.n_rows() as f64) as usize;
        match judged {
            Some(judged) => {
                let judged_rows = 0..judged.n_rows();
                Self { field: Cow::Borrowed(field), quiet, judged, judged_rows, library }
            }
            None => Self {
                field: Cow::Owned(field.first_rows(cut)),
                quiet,
                judged: field,
                judged_rows: cut..field.n_rows(),
                library,
            },
        }
    }

    /// Rows that effects are estimated from.
    pub fn fitted_rows(&self) -> usize {
        self.field.n_rows()
    }

    /// The state before anything is added: the axis of the study as it was fitted, its bias that of the field log.
    ///
    /// # Errors
    ///
    /// A column is missing, or fos-core refuses the model.
    pub fn first_stair(&self, model: &UnitModel) -> Result<Stair, GrowError> {
        let left = self.left(model, &[])?;
        let field = self.measured(&model.axes[0].column);
        self.stair(self.settled(model.clone(), &field)?, None, left)
    }

    /// An axis of a study, before anything is added to it; `logs` as the study is to remember them.
    ///
    /// # Errors
    ///
    /// There is no such axis, a column is missing, or fos-core refuses the model.
    pub fn begin(&self, study: &Study, column: &str, logs: GrowthLogs) -> Result<Growth, GrowError> {
        let stairs = vec![self.first_stair(&study.axis_alone(column)?)?];
        Ok(Growth { column: column.to_owned(), logs, stairs })
    }

    /// Whether an effect leaves anything to subtract on this axis.
    ///
    /// # Errors
    ///
    /// What to do instead.
    pub fn can_add(&self, column: &str, effect: &Effect) -> Result<(), GrowError> {
        if effect.search == Search::Step && !is_bias_known(&self.field, column) {
            let help = "at rest an accelerometer shows gravity beside its bias, and a step of the one cannot be told from the other in a later log; with the true values (`ref_…`) it can";
            return Err(GrowError::NothingToTakeOff(effect.id.clone(), help));
        }
        can_be_added(effect)
    }

    /// What is missing from the model as it is after `growth`.
    ///
    /// # Errors
    ///
    /// A column is missing, or the log is too short.
    pub fn diagnose(&self, growth: &Growth) -> Result<Diagnosis, GrowError> {
        let wide = growth.added().filter(|added| added.finding.band == Band::Wide);
        let wide: Vec<Finding> = wide.map(|added| added.finding.clone()).collect();
        let field = self.without_base(growth, &wide)?;
        let given = growth.added().filter(|added| added.finding.band != Band::Wide).map(|added| Given {
            effect: added.effect.id.clone(),
            value: added.finding.params.values().next().copied(),
        });
        let given: Vec<Given> = given.collect();
        let question = Question { given: &given, ..self.question(&field, &growth.column, self.library) };
        Ok(diagnose(&question)?)
    }

    /// The model of `growth` and `effect`, all effects estimated anew together, and together with what the diagnosis finds
    /// beside them: an effect that is still missing must not colour those that are there.
    ///
    /// # Errors
    ///
    /// The effect is there already or has nothing to take off, a column that it needs is missing, the log is too short.
    pub fn add(&self, growth: &Growth, effect: &Effect) -> Result<Stair, GrowError> {
        self.can_add(&growth.column, effect)?;
        self.add_beside(growth, effect, &self.diagnose(growth)?)
    }

    fn add_beside(
        &self,
        growth: &Growth,
        effect: &Effect,
        diagnosis: &Diagnosis,
    ) -> Result<Stair, GrowError> {
        let mut library = self.library.clone();
        let mut wanted: Vec<String> = Vec::new();
        for added in growth.added() {
            library.add(added.effect.clone());
            wanted.push(added.effect.id.clone());
        }
        // lines and steps there may be several of
        let repeats = added_again(effect);
        if wanted.contains(&effect.id) && !repeats {
            return Err(GrowError::Twice(effect.id.clone()));
        }
        wanted.push(effect.id.clone());
        let in_model = wanted.len();
        let found = diagnosis.findings.iter().filter(|finding| finding.band == Band::Slow);
        wanted.extend(found.filter(|finding| finding.effect != effect.id).map(|f| f.effect.clone()));
        let field = self.without_base(growth, &[])?;
        let mut findings = estimate(&self.question(&field, &growth.column, &library), &wanted)?;
        findings.truncate(in_model);
        let [first, ..] = &growth.stairs[..] else {
            return Err(GrowError::NothingAdded(growth.column.clone()));
        };
        let mut model = first.model.clone();
        terms::add(&mut model, &findings, &self.field)?;
        let field = self.measured(&growth.column);
        let model = self.settled(model, &as_after_steps(&findings, &growth.column, &field)?)?;
        let Some(finding) = findings.last().cloned() else {
            return Err(GrowError::NothingToTakeOff(effect.id.clone(), "the log does not show it"));
        };
        let before = growth.last().map_or(first.left, |last| last.left);
        let after = self.left(&first.model, &findings)?;
        let realised_fall = match finding.band {
            Band::Wide => 1.0 - after.wide / before.wide,
            // a constant in every later log: no variance tells of it
            _ if is_step(&finding) => match (before.bias, after.bias) {
                (Some(was), Some(is)) => 1.0 - (after.slow + is * is) / (before.slow + was * was),
                _ => 0.0,
            },
            _ => 1.0 - after.slow / before.slow,
        };
        let added = Added { effect: effect.clone(), finding, realised_fall };
        self.stair(model, Some(added), after)
    }

    /// Adds what a diagnosis finds, the effect first that should help most, until nothing is worth adding; the stairs that were added. `progress` is told each.
    ///
    /// # Errors
    ///
    /// As for [`Ground::diagnose`] and [`Ground::add`].
    pub fn add_best(
        &self,
        growth: &Growth,
        mut progress: impl FnMut(&Diagnosis, Option<&Stair>),
    ) -> Result<Vec<Stair>, GrowError> {
        let mut growth = growth.clone();
        let mut stairs = Vec::new();
        // ends after MOST: each stair fell on rows that were not fitted, but the next is estimated anew with all before it
        while stairs.len() < MOST {
            let diagnosis = self.diagnose(&growth)?;
            let worth_adding = diagnosis.findings.iter().filter(|finding| {
                let effect = self.library.get(&finding.effect);
                let can_be_added = effect.is_ok_and(|effect| self.can_add(&growth.column, effect).is_ok());
                !finding.correction.is_empty() && can_be_added
            });
            // two effects may cancel in part: the one that helps most alone comes first
            let best = worth_adding.max_by(|a, b| {
                let rank = |finding: &Finding| (finding.band == Band::Slow, finding.expected_drop);
                rank(a).0.cmp(&rank(b).0).then(rank(a).1.total_cmp(&rank(b).1))
            });
            let Some(best) = best.filter(|_| diagnosis.verdict != Verdict::NothingMissing) else {
                progress(&diagnosis, None);
                break;
            };
            let stair = self.add_beside(&growth, self.library.get(&best.effect)?, &diagnosis)?;
            progress(&diagnosis, Some(&stair));
            // on data that were not fitted it did not help: not worth its cost
            if stair.added.as_ref().is_some_and(|added| added.realised_fall <= 0.0) {
                break;
            }
            growth.stairs.push(stair.clone());
            stairs.push(stair);
        }
        Ok(stairs)
    }

    fn question<'q>(&'q self, field: &'q Recording, column: &'q str, library: &'q Library) -> Question<'q> {
        Question {
            field,
            quiet: self.quiet,
            judged: Some(self.judged),
            target: column,
            sheet: None,
            full_scale: None,
            lsb: None,
            library,
            given: &[],
        }
    }

    /// The field log without what the model had before it grew, and without `found`.
    fn without_base(&self, growth: &Growth, found: &[Finding]) -> Result<Recording, GrowError> {
        let mut values = self.field.channel(&growth.column)?.values.to_vec();
        if let Some(first) = growth.stairs.first() {
            let base = self.physical(&first.model, &self.field)?;
            values.iter_mut().zip(&base).for_each(|(value, base)| *value -= base);
        }
        let taken = correction(found, &self.field, &self.field)?;
        values.iter_mut().zip(&taken).for_each(|(value, taken)| *value -= taken);
        Ok(self.field.with_values(&growth.column, values))
    }

    /// The physical part of an axis, in its unit, one value per row of `log`.
    fn physical(&self, model: &UnitModel, log: &Recording) -> Result<Vec<f64>, GrowError> {
        if model.axes[0].physical.is_empty() {
            return Ok(vec![0.0; log.n_rows()]);
        }
        let known = known_rows(log, &model.axes[0].column);
        let feed = Feed::new(log, model, &known)?;
        let mut alone = model.clone();
        alone.axes[0].stochastic.clear();
        alone.axes[0].parameters.constant = 0.0;
        let mut predictor = alone.predictor::<f64>()?;
        let offset = alone.axes[0].parameters.offset;
        let predicted = (0..log.n_rows()).map(|row| {
            feed.catch_up(&mut predictor, row);
            feed.coast(&mut predictor, row)[0].predicted - offset
        });
        Ok(predicted.collect())
    }

    /// The model with the bias of `log`: the mean of what its physical part leaves there, and the range of it. `log` is the
    /// field log as it is in later logs, without the steps that happened in it.
    fn settled(&self, mut model: UnitModel, log: &Recording) -> Result<UnitModel, GrowError> {
        let column = model.axes[0].column.clone();
        let (level, is_bias_known) = self.level(&model, log, 0..log.n_rows())?;
        let parameters = &mut model.axes[0].parameters;
        match is_bias_known {
            true => parameters.offset = level,
            false => (parameters.reference, parameters.offset) = (level, 0.0),
        }
        let known = known_rows(log, &column);
        let feed = Feed::new(log, &model, &known)?;
        let mut alone = model.clone();
        alone.axes[0].stochastic.clear();
        let regressors = Regressors::of(&alone, &feed, log.n_rows())?;
        let FittedAxis { parameters, plain, .. } = &mut model.axes[0];
        let range = &mut parameters.range;
        for value in regressors.known(&regressors.remainder) {
            (range.low, range.high) = (range.low.min(value), range.high.max(value));
        }
        *plain = Some(self.plain(&column)?);
        Ok(model)
    }

    /// The field log without samples of an axis that are no measurements.
    fn measured(&self, column: &str) -> Cow<'_, Recording> {
        self.field.without_spikes(column, 0..self.field.n_rows(), &stillness::find(&self.field).still).0
    }

    /// What a rival has seen: the field log as it was.
    fn plain(&self, column: &str) -> Result<Plain, GrowError> {
        let (error, known) = (self.field.error_series(column)?, known_rows(&self.field, column));
        let rows = self.field.stretches_where(|row| known[row] && error.values[row].is_finite());
        let stretches: Vec<&[f64]> = rows.into_iter().map(|rows| &error.values[rows]).collect();
        Ok(Plain::of(&stretches.concat(), &stretches))
    }

    /// Mean of measured − reference − p over the known rows among `rows`, and whether that is the bias.
    fn level(
        &self,
        model: &UnitModel,
        log: &Recording,
        rows: Range<usize>,
    ) -> Result<(f64, bool), GrowError> {
        let axis = &model.axes[0];
        let error = log.error_series(&axis.column)?;
        let physical = self.physical(model, log)?;
        let known = known_rows(log, &axis.column);
        let left = rows.filter(|row| known[*row]).map(|row| error.values[row] - physical[row]);
        let left: Vec<f64> = left.filter(|value| value.is_finite()).collect();
        Ok((signal::mean(&[&left]), is_bias_known(log, &axis.column)))
    }

    /// What the model before it grew and the findings leave of the error on the judged rows.
    fn left(&self, base: &UnitModel, findings: &[Finding]) -> Result<Left, GrowError> {
        let column = &base.axes[0].column;
        let of = |log: &Recording| -> Result<(Reduced, Vec<f64>), GrowError> {
            let reduced = Reduced::in_slow_blocks(log, column)?;
            let mut left = reduced.error.clone();
            let base = self.physical(base, log)?;
            left.iter_mut().zip(&base).for_each(|(left, base)| *left -= base);
            let taken = correction(findings, &self.field, log)?;
            left.iter_mut().zip(&taken).for_each(|(left, taken)| *left -= taken);
            Ok((reduced, left))
        };
        let (field, left_of_field) = of(&self.field)?;
        let (reduced, left) = of(self.judged)?;
        let rows = &self.judged_rows;
        let moved = || {
            let bias = field.slow_mean(&left_of_field, &(0..self.field.n_rows()));
            reduced.slow_mean(&left, rows) - bias
        };
        Ok(Left {
            slow: reduced.slow_variance(&left, rows),
            wide: reduced.wide_variance(&left, rows),
            bias: is_bias_known(self.judged, column).then(moved),
        })
    }

    fn stair(&self, model: UnitModel, added: Option<Added>, left: Left) -> Result<Stair, GrowError> {
        let column = model.axes[0].column.clone();
        let known = known_rows(self.judged, &column);
        let mut judged = model.clone();
        let (level, is_bias_known) = self.level(&model, self.judged, self.judged_rows.clone())?;
        if !is_bias_known {
            // another pose has another constant
            (judged.axes[0].parameters.reference, judged.axes[0].parameters.offset) = (level, 0.0);
        }
        let feed = Feed::new(self.judged, &judged, &known)?;
        let trace = trace::<f64>(&judged, &feed, self.judged_rows.clone(), |_| {})?;
        let name = match &added {
            None => "before".to_owned(),
            Some(added) => format!("+ {}", added.effect.id),
        };
        let errors = ModelErrors::of(&trace, 0, &name, &column, None);
        let cost = Cost::of(&model);
        Ok(Stair { added, model, errors, left, cost })
    }
}

/// Rows whose error is known: with a reference, or at rest. On a shaker nothing is at rest, and all rows count, as they do in
/// a diagnosis.
fn known_rows(log: &Recording, column: &str) -> Vec<bool> {
    if let Ok(reference) = log.channel(&Column::named(column).reference()) {
        return reference.values.iter().map(|value| value.is_finite()).collect();
    }
    let rest = stillness::find(log);
    let at_rest = rest.still.iter().filter(|still| **still).count();
    match rest.known_by {
        KnownBy::Detector if at_rest < log.n_rows() / 2 => vec![true; log.n_rows()],
        _ => rest.still,
    }
}

/// Whether there can be several of it in one model.
fn added_again(effect: &Effect) -> bool {
    matches!(effect.id.as_str(), "spectral_line" | "bias_step")
}

/// Effects that leave nothing to subtract are told apart by what to do instead.
///
/// # Errors
///
/// What to do instead.
fn can_be_added(effect: &Effect) -> Result<(), GrowError> {
    let help = match effect.band {
        Band::Data => "repair the data: another full scale, a faster bus, a finer output",
        Band::Stochastic => "fit the stochastic part again on this log: `host-fit fit LOG`",
        Band::Wide if effect.id != "spectral_line" => {
            "a filter in front of the model, or another output rate"
        }
        _ => return Ok(()),
    };
    Err(GrowError::NothingToTakeOff(effect.id.clone(), help))
}

impl Study {
    /// The growth of an axis, if any.
    pub fn growth_of(&self, column: &str) -> Option<&Growth> {
        self.growth.iter().find(|growth| growth.column == column)
    }

    /// The axis of the study alone, as it was before it grew.
    ///
    /// # Errors
    ///
    /// There is none.
    pub fn axis_alone(&self, column: &str) -> Result<UnitModel, GrowError> {
        let index = self.model.axes.iter().position(|axis| axis.column == column);
        index.map(|index| self.model.only(index)).ok_or_else(|| GrowError::NoAxis {
            column: column.to_owned(),
            axes: self.model.axes.iter().map(|axis| axis.column.clone()).collect(),
        })
    }

    /// Keeps `growth`, and puts its last state into the model.
    pub fn keep(&mut self, growth: Growth) {
        if let Some(last) = growth.last() {
            self.replace(&growth.column, last.model.clone());
        }
        match self.growth.iter_mut().find(|other| other.column == growth.column) {
            Some(known) => *known = growth,
            None => self.growth.push(growth),
        }
    }

    /// Takes the last effect that was added to `column` back; its identifier.
    ///
    /// # Errors
    ///
    /// Nothing was added.
    pub fn undo(&mut self, column: &str) -> Result<String, GrowError> {
        let nothing = || GrowError::NothingAdded(column.to_owned());
        let growth = self.growth.iter_mut().find(|growth| growth.column == column).ok_or_else(nothing)?;
        let added = growth.last().and_then(|stair| stair.added.as_ref()).ok_or_else(nothing)?;
        let effect = added.effect.id.clone();
        growth.stairs.pop();
        let growth = growth.clone();
        self.keep(growth);
        Ok(effect)
    }

    fn replace(&mut self, column: &str, model: UnitModel) {
        let axes = (0..self.model.axes.len()).map(|index| {
            if self.model.axes[index].column == column { model.clone() } else { self.model.only(index) }
        });
        let mut axes = axes.collect::<Vec<_>>().into_iter();
        if let Some(mut unit) = axes.next() {
            axes.for_each(|axis| unit.absorb(axis));
            self.model = unit;
        }
    }
}

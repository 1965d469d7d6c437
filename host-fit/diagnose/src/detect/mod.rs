//! What is missing: compares a log that a model does not explain with every effect of the library, and says which one is
//! missing, how sure that is, what it cannot be told from, or that nothing in the library explains it.
//!
//! The order is that of the evidence (docs/decisions/diagnosis.md): faults of the data, lines in the spectrum, slow effects
//! in block means, then an open search for what the library does not know.

mod answer;
mod cleaned;
mod correction;
mod error_in_blocks;
mod faults;
mod findings;
mod hypothesis;
mod limits;
mod lines;
mod measured_reduction;
mod open;
mod predicted_reduction;
mod shape;
mod slow;
mod testable;

#[cfg(test)]
mod faults_tests;
#[cfg(test)]
mod lines_tests;

use fos_data::column::Column;
use std::rc::Rc;

pub use answer::{
    CorrectionTerm, Diagnosis, Finding, NoiseReport, Rejected, Separation, Size, Untested, Verdict,
};
pub(crate) use correction::{as_after_steps, is_step, step_time};
pub use correction::{correction, is_fast};
pub use measured_reduction::with_measured_reduction;
pub use open::Lead;

use crate::effects::{Band, Effect, Inputs, Library, Search};
use fos_data::case::DataSheet;
use fos_data::recording::{Recording, RecordingError};
use fos_fit::noise::{Fitted, LevelPrior, NoiseLevels, Regression};

use cleaned::Cleaned;
pub use error_in_blocks::ErrorInBlocks;
use faults::{Converter, Fault};
use findings::Assembly;
use hypothesis::Hypotheses;
use lines::Line;
use shape::Misshape;
use slow::{ExtraNoise, SlowResult, SlowSearch};
use testable::{Testable, lacking};

/// What to explain, and what is known beside it.
#[derive(Debug, Clone, Copy)]
pub struct Question<'a> {
    /// The log to explain.
    pub field: &'a Recording,
    /// A quiet log of the same unit, in which nothing is missing.
    pub quiet: Option<&'a Recording>,
    /// The log that a correction is to be judged on: its inputs say how much should fall there. By default the field log.
    pub judged: Option<&'a Recording>,
    /// The column to explain.
    pub target: &'a str,
    /// What the data sheet says of the axis.
    pub sheet: Option<DataSheet>,
    /// Full scale of the axis, in its unit.
    pub full_scale: Option<f64>,
    /// Least significant bit of the axis, in its unit.
    pub lsb: Option<f64>,
    /// The effects to try.
    pub library: &'a Library,
    /// Effects that the model already has, with their parameters: they are never found again.
    pub given: &'a [Given],
}

/// An effect that a model already has.
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    /// Its identifier.
    pub effect: String,
    /// The value of its parameter.
    pub value: Option<f64>,
}

/// Why there is no diagnosis.
#[derive(Debug, thiserror::Error)]
pub enum DiagnoseError {
    /// A column is missing.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// An effect is not known.
    #[error(transparent)]
    Effect(#[from] crate::effects::EffectError),
    /// An effect that was asked for does not show in the log.
    #[error("{effect} cannot be estimated from this log: {reason}")]
    NotThere {
        /// The effect.
        effect: String,
        /// Why.
        reason: String,
    },
    /// An axis that does not measure.
    #[error(
        "{column}: every value at rest is {value:?}: a stuck or unconnected axis\nhelp: leave the axis out"
    )]
    Stuck {
        /// The column.
        column: String,
        /// The value.
        value: f64,
    },
    /// Too little to say anything.
    #[error(
        "{column}: {blocks} blocks of {length_s:.1} s at rest; at least {} are needed to tell an effect from drifting noise\nhelp: a longer log at rest, or one with a reference",
        MIN_BLOCKS
    )]
    TooShort {
        /// The column.
        column: String,
        /// Blocks in which it is known.
        blocks: usize,
        /// Their length, s.
        length_s: f64,
    },
}

/// Whether a log tells the bias of an axis, and not only how it changes: an accelerometer at rest shows gravity, and in another
/// pose another part of it.
pub(crate) fn is_bias_known(log: &Recording, column: &str) -> bool {
    log.channel(&Column::named(column).reference()).is_ok() || !Column::named(column).is_specific_force()
}

/// Fewest blocks that a diagnosis is made of: below 60 the search over twenty effects has no power left.
pub const MIN_BLOCKS: usize = 60;

/// Leads that explain less than this share of what the findings explain do not make the answer *unexplained*: a strong
/// effect is never reproduced to the last digit by a thermometer that lags.
const LEAD_SHARE: f64 = 0.03;

/// Coarse steps above this many standard deviations of the noise hide every slow effect in the stairs they make.
const STAIRS: f64 = 2.5;

/// What a diagnosis begins with: the log reduced, what is known of the noise, what the model has already.
struct Prepared {
    column: String,
    faults: Vec<Fault>,
    testable: Testable,
    reduced: ErrorInBlocks,
    prior: LevelPrior,
    given: Vec<Vec<f64>>,
    /// The axis measures shaking, and no reference says what of it.
    shaken: bool,
    /// Standard deviation of the noise without coarse steps: of the quiet log, where there is one.
    fast_deviation: f64,
}

impl Prepared {
    fn new(question: &Question<'_>) -> Result<Self, DiagnoseError> {
        let Question { field, target, library, .. } = *question;
        let column = field.axis(target)?.name.clone();
        let converter = Converter { full_scale: question.full_scale, lsb: question.lsb };
        let faults = faults::find(field, question.quiet, &column, &converter);
        let inputs = Inputs::new(field);
        let testable = Testable::of(question, &inputs, &column)?;
        let reduced = ErrorInBlocks::where_known(field, &column, &faults, &testable.known)?;
        if reduced.blocks.len() < MIN_BLOCKS {
            let (blocks, length_s) = (reduced.blocks.len(), reduced.blocks.length_s);
            return Err(DiagnoseError::TooShort { column, blocks, length_s });
        }
        let quiet = question.quiet.map(|quiet| ErrorInBlocks::new(quiet, &column, &[])).transpose()?;
        let shaken = Column::named(&column).is_specific_force()
            && quiet.as_ref().is_some_and(|quiet| reduced.fast_deviation() > SHAKEN * quiet.fast_deviation());
        let prior = prior(question, &reduced, quiet.as_ref());
        // shaking adds to the noise of block means what no quiet log tells of
        let (prior, reduced) = match shaken {
            true => (prior.widened(SHAKING), reduced.shaken()),
            false => (prior, reduced),
        };
        let mut given = vec![vec![1.0; reduced.blocks.len()]];
        let hypotheses = Hypotheses::new(&inputs, &reduced.blocks, &column);
        for Given { effect, value } in question.given {
            let effect = Rc::new(library.get(effect)?.clone());
            given.extend(hypotheses.make(&effect, *value)?.columns.iter().cloned());
        }
        let fast_deviation = quiet.as_ref().unwrap_or(&reduced).fast_deviation();
        Ok(Self { column, faults, testable, reduced, prior, given, shaken, fast_deviation })
    }

    fn search<'s>(&'s self, hypotheses: &'s Hypotheses<'s>, effects: &'s [Rc<Effect>]) -> SlowSearch<'s> {
        SlowSearch {
            blocks: &self.reduced.blocks,
            y: &self.reduced.means,
            given: &self.given,
            hypotheses,
            effects,
            prior: self.prior,
        }
    }

    fn assembly<'s>(
        &'s self,
        question: &'s Question<'s>,
        lines: &'s [Line],
        slow: &'s SlowResult,
        left: LeftOver,
        untested: Vec<Untested>,
    ) -> Assembly<'s> {
        let Self { column, faults, reduced, given, .. } = self;
        let learnt_from = learnt_from(question);
        Assembly { question, column, reduced, given, faults, lines, slow, left, untested, learnt_from }
    }

    /// Whether slow effects drown in the stairs that a converter makes.
    fn in_stairs(&self) -> bool {
        self.reduced.clipped_through
            || self.faults.iter().any(|fault| match fault {
                Fault::Coarse { step, .. } => *step > STAIRS * self.fast_deviation,
                // the mean of a swing that is cut off moves with the swing
                Fault::Saturation { .. } => self.shaken,
                Fault::Dropped { .. } => false,
            })
    }
}

/// Says what is missing.
///
/// # Errors
///
/// A column is missing, or the log is too short.
pub fn diagnose(question: &Question<'_>) -> Result<Diagnosis, DiagnoseError> {
    let logs = Cleaned::of(question)?;
    let mut diagnosis = diagnose_cleaned(&logs.question(question))?;
    diagnosis.cautions.extend(logs.cautions());
    Ok(diagnosis)
}

fn diagnose_cleaned(question: &Question<'_>) -> Result<Diagnosis, DiagnoseError> {
    let prepared = Prepared::new(question)?;
    let Prepared { column, faults, reduced, given, shaken, .. } = &prepared;
    let inputs = Inputs::new(question.field);
    let hypotheses = Hypotheses::new(&inputs, &reduced.blocks, column);
    let stairs = prepared.in_stairs();
    let effects = if stairs { &[][..] } else { &prepared.testable.effects };
    let lines = if stairs { Vec::new() } else { lines(question, column, reduced, *shaken)? };
    let slow = prepared.search(&hypotheses, effects).run()?;
    let left = match stairs {
        true => LeftOver::default(),
        false => left_over(question, column, reduced, given, &slow, (faults.is_empty(), *shaken)),
    };
    let mut untested = prepared.testable.untested.clone();
    let silent = slow.silent.iter().map(|effect| Testable::adds_nothing(effect, &inputs, column));
    untested.extend(silent);
    if stairs {
        let needs = vec!["samples that are neither clipped nor in coarse steps".to_owned()];
        let hidden = prepared.testable.effects.iter();
        untested.extend(hidden.map(|effect| Untested { effect: effect.id.clone(), needs: needs.clone() }));
    }
    prepared.assembly(question, &lines, &slow, left, untested).diagnosis()
}

/// Estimates effects together whether they are missing or not, in this order: their parameters, sizes, and the fall that
/// each should bring once those before it are in the model. Several lines are taken by their strength.
///
/// # Errors
///
/// A column is missing, the log is too short, or an effect leaves nothing in it.
pub fn estimate(question: &Question<'_>, effects: &[String]) -> Result<Vec<Finding>, DiagnoseError> {
    let logs = Cleaned::of(question)?;
    let question = &logs.question(question);
    let prepared = Prepared::new(question)?;
    let Prepared { column, reduced, shaken, .. } = &prepared;
    let inputs = Inputs::new(question.field);
    let hypotheses = Hypotheses::new(&inputs, &reduced.blocks, column);
    let not_there = |effect: &str, reason: &str| DiagnoseError::NotThere {
        effect: effect.to_owned(),
        reason: reason.to_owned(),
    };
    let mut wanted = Vec::new();
    for id in effects {
        let effect = question.library.get(id)?;
        match lacking(effect, &inputs, column) {
            None => return Err(not_there(id, &format!("it does not strike {column}"))),
            Some(missing) if !missing.is_empty() => {
                return Err(not_there(id, &format!("the log has no {}", missing.join(", "))));
            }
            Some(_) if matches!(effect.search, Search::Terms | Search::Step) => {
                wanted.push(Rc::new(effect.clone()));
            }
            Some(_) => {}
        }
    }
    let slow = prepared.search(&hypotheses, &prepared.testable.effects).estimate(&wanted)?;
    let lines = lines(question, column, reduced, *shaken)?;
    let assembly = prepared.assembly(question, &lines, &slow, LeftOver::default(), Vec::new());
    let mut slow_findings = assembly.slow_findings(slow.found.iter().collect())?.into_iter();
    let mut line_findings = assembly.line_findings()?.into_iter();
    effects
        .iter()
        .map(|id| {
            let found = match question.library.get(id)?.band {
                Band::Wide => line_findings.find(|finding| finding.effect == *id),
                _ => slow_findings.find(|finding| finding.effect == *id),
            };
            found.filter(|finding| !finding.correction.is_empty()).ok_or_else(|| {
                not_there(
                    id,
                    "nothing of it shows: what it follows does not change, or it drowns in the noise",
                )
            })
        })
        .collect()
}

/// An accelerometer whose samples scatter so many times as much as in the quiet log is being shaken.
const SHAKEN: f64 = 1.5;

/// Variances of the logarithms of its noise levels beyond those of a quiet log: its white noise may be ten times as much.
const SHAKING: [f64; 3] = [4.0, 0.0, 0.0];

/// Lines that are errors: an accelerometer on a shaker rightly shows those that its neighbours show too, and those that come
/// and go.
fn lines(
    question: &Question<'_>,
    column: &str,
    reduced: &ErrorInBlocks,
    shaken: bool,
) -> Result<Vec<Line>, DiagnoseError> {
    let mut lines = lines::of(reduced, question.field);
    if shaken {
        lines.retain(|line| line.duty >= lines::STEADY);
        for other in ["ax_mps2", "ay_mps2", "az_mps2"].into_iter().filter(|other| *other != column) {
            if question.field.channel(other).is_ok() {
                let other = ErrorInBlocks::new(question.field, other, &[])?;
                lines.retain(|line| !lines::is_shared(question.field, &other, line));
            }
        }
    }
    Ok(lines)
}

/// The whitened residual but for the tenth of the blocks in which the effects that were found change most: there they leave
/// what they do not reproduce to the last digit, a delay of a few samples or a thermometer's, and that is no jump.
fn away_from_effects(reduced: &ErrorInBlocks, slow: &SlowResult) -> Vec<f64> {
    let residual = &slow.fitted.gls.residual;
    if slow.found.is_empty() {
        return residual.clone();
    }
    let coefficients = slow.fitted.gls.coefficients();
    let mut effect = vec![0.0; residual.len()];
    for found in &slow.found {
        for (place, column) in found.place.clone().zip(found.hypothesis.columns()) {
            effect.iter_mut().zip(column).for_each(|(sum, value)| *sum += coefficients[place] * value);
        }
    }
    let whitened = slow.fitted.levels.whiten(&reduced.blocks, &[&effect]);
    let mut blocks: Vec<usize> = (0..residual.len()).collect();
    blocks.sort_by(|a, b| whitened.columns[0][*a].abs().total_cmp(&whitened.columns[0][*b].abs()));
    blocks.truncate(residual.len() * 9 / 10);
    blocks.into_iter().map(|block| residual[block]).collect()
}

/// What is known of the noise before the field log is looked at.
fn prior(question: &Question<'_>, field: &ErrorInBlocks, quiet: Option<&ErrorInBlocks>) -> LevelPrior {
    let quiet = quiet.filter(|quiet| quiet.blocks.len() >= MIN_BLOCKS);
    let start = match (&question.sheet, quiet) {
        (Some(sheet), _) => LevelPrior::of_data_sheet(sheet),
        (None, Some(quiet)) => LevelPrior::of_log(&quiet.blocks, &quiet.means),
        (None, None) => LevelPrior::of_log(&field.blocks, &field.means),
    };
    match quiet {
        Some(quiet) => start.learnt(&quiet.blocks, &quiet.means, &[vec![1.0; quiet.blocks.len()]]),
        None => start,
    }
}

fn learnt_from(question: &Question<'_>) -> String {
    match (question.sheet.is_some(), question.quiet.is_some()) {
        (true, true) => "the quiet log, with the data sheet as prior",
        (false, true) => "the quiet log",
        (true, false) => "the data sheet; no quiet log was given",
        (false, false) => "the log itself; neither a quiet log nor a data sheet was given",
    }
    .to_owned()
}

/// What the library leaves.
#[derive(Default)]
struct LeftOver {
    leads: Vec<Lead>,
    misshapes: Vec<Misshape>,
    /// The leads explain more than findings that follow nothing logged, and than further noise.
    instead: bool,
}

/// A lead must be this much better than what it stands for: odds of 150 to 1.
const INSTEAD: f64 = 10.0;

fn left_over(
    question: &Question<'_>,
    column: &str,
    reduced: &ErrorInBlocks,
    given: &[Vec<f64>],
    slow: &SlowResult,
    (sound, shaken): (bool, bool),
) -> LeftOver {
    let regressors = |keep: &dyn Fn(&slow::Found) -> bool| -> Vec<&[f64]> {
        let mut regressors: Vec<&[f64]> = given.iter().map(Vec::as_slice).collect();
        for found in slow.found.iter().filter(|found| keep(found)) {
            regressors.extend(found.hypothesis.columns());
        }
        regressors
    };
    let left = |regressors: &[&[f64]], fitted: &Fitted, prior: &LevelPrior| {
        open::Left {
            recording: question.field,
            blocks: &reduced.blocks,
            target: column,
            y: &reduced.means,
            regressors,
            fitted,
            prior,
            shaken,
        }
        .leads()
    };
    let explained: f64 = slow.found.iter().map(|found| found.gain).sum();
    let mut leads = left(&regressors(&|_| true), &slow.fitted, &slow.prior);
    leads.retain(|lead| lead.gain > LEAD_SHARE * explained);
    let mut misshapes = Vec::new();
    // the noise of an accelerometer that is shaken is the shaking
    if !shaken {
        let quiet = away_from_effects(reduced, slow);
        misshapes.extend(shape::jumps(&quiet, LEAD_SHARE * explained, slow.noise != ExtraNoise::None));
    }
    if sound && !shaken {
        misshapes.extend(shape::level(question.field, &reduced.blocks, column, !slow.found.is_empty()));
    }
    // what follows nothing that is logged may stand for something that does
    let is_backed = |found: &slow::Found| !found.hypothesis.effect.follows_clock_alone();
    let unbacked: f64 = slow.found.iter().filter(|found| !is_backed(found)).map(|found| found.score).sum();
    let replaced = unbacked + slow.noise_score;
    if replaced > 0.0 {
        let backed = regressors(&is_backed);
        let regression = Regression {
            blocks: &reduced.blocks,
            y: &reduced.means,
            regressors: &backed,
            prior: &slow.quiet_prior,
        };
        let fitted = regression.fit(NoiseLevels::from_logs(&slow.quiet_prior.mean));
        let instead = left(&backed, &fitted, &slow.quiet_prior);
        if instead.first().is_some_and(|lead| lead.score > replaced + INSTEAD) {
            return LeftOver { leads: instead, misshapes, instead: true };
        }
    }
    LeftOver { leads, misshapes, instead: false }
}

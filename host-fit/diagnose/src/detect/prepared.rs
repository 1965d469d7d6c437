//! Preparation of a diagnosis: the log in blocks, its faults, the noise prior, and the effects that the model already
//! has.

use std::sync::Arc;

use fos_data::case::DataSheet;
use fos_data::column::Column;
use fos_fit::noise::{LevelPrior, UnknownLevels};

use super::error_in_blocks::ErrorInBlocks;
use super::faults::{self, Converter, Fault};
use super::hypothesis::Hypotheses;
use super::question::{DiagnoseError, Given, MIN_BLOCKS, Question};
use super::slow::SlowSearch;
use super::testable::Testable;
use crate::effects::{Effect, Inputs};

/// Steps above this multiple of the noise's standard deviation hide every slow effect.
pub(super) const STAIRS: f64 = 2.5;

/// Ratio of the scatter of samples to that of the reference log from which on an accelerometer counts as shaken.
const SHAKEN: f64 = 1.5;

/// Variances added to the logarithms of the noise levels of a shaken log: its white noise may be ten times that of a
/// reference log.
const SHAKING: [f64; 3] = [4.0, 0.0, 0.0];

/// Least number of blocks from which noise and lines can be estimated; slow effects need [`MIN_BLOCKS`].
const MIN_NOISE_BLOCKS: usize = 10;

/// Standard deviation of the logarithm of an unknown random walk.
const FREE_WALK: f64 = 3.0;

/// Input of a diagnosis: the reduced log, the noise prior, and the effects that the model already has.
pub(super) struct Prepared {
    pub(super) column: String,
    pub(super) faults: Vec<Fault>,
    pub(super) testable: Testable,
    pub(super) reduced: ErrorInBlocks,
    pub(super) prior: LevelPrior,
    /// Prior for trying a random walk larger than that of the reference log.
    free_walk_prior: LevelPrior,
    /// Number of inertial axes of the log.
    axes: usize,
    pub(super) given: Vec<Vec<f64>>,
    /// True if the axis measures shaking and there is no reference for it.
    pub(super) shaken: bool,
    /// Standard deviation of the noise without coarse steps, from the reference log if there is one.
    pub(super) fast_deviation: f64,
}

impl Prepared {
    /// Prepares a question whose log to explain is clean.
    pub(super) fn new(question: &Question<'_>) -> Result<Self, DiagnoseError> {
        let Question { log, target, library, .. } = *question;
        let column = log.axis(target)?.name.clone();
        let converter = Converter { full_scale: question.full_scale, lsb: question.lsb };
        let faults = faults::find(log, question.reference, &column, &converter);
        let is_known = question.reference.is_some() || question.sheet.is_some();
        if let Some(value) = faults::only_value(log, &column)
            && !(is_known && faults.iter().any(|fault| matches!(fault, Fault::Coarse { .. })))
        {
            let step = faults::hidden_step(log, &column).or(question.lsb).unwrap_or(f64::NAN);
            return Err(DiagnoseError::CoarseSteps { column, value, step });
        }
        let inputs = Inputs::new(log);
        let testable = Testable::of(question, &inputs, &column)?;
        let reduced = ErrorInBlocks::where_known(log, &column, &faults, &testable.known)?;
        if reduced.blocks.beyond_levels() < MIN_NOISE_BLOCKS {
            return Err(too_short(&column, &reduced));
        }
        let reference =
            question.reference.map(|reference| ErrorInBlocks::new(reference, &column, &[])).transpose()?;
        let shaken = Column::named(&column).is_specific_force()
            && reference
                .as_ref()
                .is_some_and(|reference| reduced.fast_deviation() > SHAKEN * reference.fast_deviation());
        let prior = prior_of(question.sheet.as_ref(), &reduced, reference.as_ref())?;
        // shaking adds noise to block means that no reference log shows
        let (prior, reduced) = match shaken {
            true => (prior.widened(SHAKING)?, reduced.shaken()),
            false => (prior, reduced),
        };
        let mut given = vec![vec![1.0; reduced.blocks.len()]];
        let hypotheses = Hypotheses::new(&inputs, &reduced.blocks, &column);
        for Given { effect, value } in question.given {
            let effect = Arc::new(library.get(effect)?.clone());
            given.extend(hypotheses.make(&effect, *value)?.columns.iter().cloned());
        }
        let fast_deviation = reference.as_ref().unwrap_or(&reduced).fast_deviation();
        let free_walk_prior = prior.with_free_walk(FREE_WALK)?;
        let axes = log.axes()?.len();
        Ok(Self {
            axes,
            free_walk_prior,
            column,
            faults,
            testable,
            reduced,
            prior,
            given,
            shaken,
            fast_deviation,
        })
    }

    pub(super) fn search<'s>(
        &'s self,
        hypotheses: &'s Hypotheses<'s>,
        effects: &'s [Arc<Effect>],
    ) -> SlowSearch<'s> {
        SlowSearch {
            blocks: &self.reduced.blocks,
            y: &self.reduced.means,
            given: &self.given,
            hypotheses,
            axes: self.axes,
            effects,
            prior: self.prior,
            free_walk_prior: self.free_walk_prior,
        }
    }

    /// Returns true if there are too few blocks for slow effects.
    pub(super) fn is_short(&self) -> bool {
        self.reduced.blocks.beyond_levels() < MIN_BLOCKS
    }

    /// Describes what a log that is too short for slow effects needs: time at rest, or the columns that are unknown for
    /// most of it.
    pub(super) fn time_needed(&self, question: &Question<'_>) -> Result<String, DiagnoseError> {
        // as in `is_short`: the first block after each turn only determines a level
        let blocks = &self.reduced.blocks;
        let (has_s, wanted) =
            (blocks.beyond_levels() as f64 * blocks.length_s, MIN_BLOCKS as f64 * blocks.length_s);
        let any_inputs = ErrorInBlocks::new(question.log, &self.column, &self.faults)?;
        Ok(match any_inputs.blocks.beyond_levels() < MIN_BLOCKS {
            true => format!("{wanted:.0} s at rest, {:.0} s more than this log has", (wanted - has_s).ceil()),
            false => format!(
                "values of every logged input over {wanted:.0} s at rest; they are all known in only {has_s:.0} s"
            ),
        })
    }

    /// Rejects a log that is too short for slow effects.
    pub(super) fn long_enough(&self) -> Result<(), DiagnoseError> {
        if self.is_short() { Err(too_short(&self.column, &self.reduced)) } else { Ok(()) }
    }

    /// Returns true if coarse steps, clipping or a dead zone hide slow effects.
    pub(super) fn hides_slow_effects(&self) -> bool {
        self.reduced.clipped_through
            || self.faults.iter().any(|fault| match fault {
                Fault::Coarse { step, .. } => *step > STAIRS * self.fast_deviation,
                // the mean of a clipped oscillation changes with its amplitude
                Fault::Saturation { .. } => self.shaken,
                Fault::Dropped { .. } => false,
                // its value at rest does not depend on the bias
                Fault::DeadZone(_) => true,
            })
    }
}

pub(super) fn too_short(column: &str, reduced: &ErrorInBlocks) -> DiagnoseError {
    let (blocks, length_s) = (reduced.blocks.beyond_levels(), reduced.blocks.length_s);
    DiagnoseError::TooShort { column: column.to_owned(), blocks, length_s }
}

/// Returns the noise prior before the log to explain is used: from the data sheet and the reference log, or from the scatter
/// of the log itself if there is neither.
pub(super) fn prior_of(
    sheet: Option<&DataSheet>,
    log: &ErrorInBlocks,
    reference: Option<&ErrorInBlocks>,
) -> Result<LevelPrior, UnknownLevels> {
    let reference = reference.filter(|reference| reference.blocks.beyond_levels() >= MIN_BLOCKS);
    let start = match (sheet, reference) {
        (Some(sheet), _) => LevelPrior::of_data_sheet(sheet),
        (None, Some(reference)) => LevelPrior::of_log(&reference.blocks, &reference.means),
        (None, None) => LevelPrior::of_log(&log.blocks, &log.means),
    };
    match reference {
        Some(reference) => {
            Ok(start.learnt(&reference.blocks, &reference.means, &[vec![1.0; reference.blocks.len()]])?)
        }
        None => Ok(start),
    }
}

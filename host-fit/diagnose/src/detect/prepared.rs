//! First stage of a diagnosis: the clean log in blocks, its faults, the noise prior, and the effects that the model
//! already has.

use std::borrow::Cow;
use std::sync::Arc;

use fos_data::case::DataSheet;
use fos_data::column::Column;
use fos_data::disturbance;
use fos_data::recording::{Recording, RecordingError};
use fos_data::text::rounded;
use fos_fit::noise::{LevelPrior, UnknownLevels};

use super::clean_log::Excluded;
use super::dead_zone::Searched;
use super::error_in_blocks::ErrorInBlocks;
use super::faults::{self, Converter, Fault};
use super::hypothesis::Hypotheses;
use super::lines::{self, Line};
use super::question::{DiagnoseError, Given, MIN_BLOCKS, Question};
use super::slow::SlowSearch;
use super::testable::Testable;
use crate::effects::{Effect, Inputs, Library};

/// Steps above this multiple of the noise's standard deviation hide every slow effect.
const STAIRS: f64 = 2.5;

/// Relative difference of sampling rates beyond which two logs may be of different devices.
const OTHER_RATE: f64 = 0.1;

/// Ratio of the scatter of samples to that of the reference log from which on an accelerometer counts as shaken.
const SHAKEN: f64 = 1.5;

/// Variances added to the logarithms of the noise levels of a shaken log: its white noise may be ten times that of a
/// reference log.
const SHAKING: [f64; 3] = [4.0, 0.0, 0.0];

/// Least number of blocks from which noise and lines can be estimated; slow effects need [`MIN_BLOCKS`].
const MIN_NOISE_BLOCKS: usize = 10;

/// Standard deviation of the logarithm of an unknown random walk.
const FREE_WALK: f64 = 3.0;

/// A question that is ready for the searches.
pub(super) struct Prepared<'a> {
    /// The question with its logs as read, with outliers and motion.
    question: Question<'a>,
    excluded: Excluded<'a>,
    excluded_of_reference: Option<Excluded<'a>>,
    evaluation: Option<Cow<'a, Recording>>,
    /// Column to explain.
    pub(super) column: String,
    pub(super) faults: Vec<Fault>,
    pub(super) testable: Testable,
    /// The error of the clean log in block means.
    pub(super) reduced: ErrorInBlocks,
    /// Hypotheses on the clean log.
    pub(super) hypotheses: Hypotheses<'a>,
    prior: LevelPrior,
    /// Prior for trying a random walk larger than that of the reference log.
    free_walk_prior: LevelPrior,
    /// Number of inertial axes of the log.
    axes: usize,
    /// Regressors of every model: the constant and the effects that the model already has.
    pub(super) given: Vec<Vec<f64>>,
    /// True if the axis measures shaking and there is no reference for it.
    pub(super) shaken: bool,
    /// Standard deviation of the noise without coarse steps, from the reference log if there is one.
    fast_deviation: f64,
}

impl<'a> Prepared<'a> {
    /// Cleans the logs of a question and reduces the log to explain to blocks.
    pub(super) fn new(question: &Question<'a>) -> Result<Self, DiagnoseError> {
        let column = question.log.axis(question.target)?.name.clone();
        let mut others = question.reference.into_iter().chain(question.evaluation);
        others.try_for_each(|other| question.log.refuse_other_sensor(other))?;
        let (log, excluded) = Excluded::of(question.log, &column, has_coarse_steps(question))?;
        let reference =
            question.reference.map(|reference| Excluded::of(reference, &column, false)).transpose()?;
        [Some(question.log), question.reference, question.evaluation]
            .into_iter()
            .flatten()
            .try_for_each(disturbance::check)?;
        let evaluation = question.evaluation.map(|evaluation| disturbance::marked(evaluation).0);
        let (reference, excluded_of_reference) = reference.unzip();
        let reference = reference.as_deref();

        let converter = Converter { full_scale: question.full_scale, lsb: question.lsb };
        let mut faults = faults::find(&log, reference, &column, &converter);
        let is_known = reference.is_some() || question.sheet.is_some();
        if let Some(value) = faults::only_value(&log, &column)
            && !(is_known && faults.iter().any(|fault| matches!(fault, Fault::Coarse { .. })))
        {
            let step = faults::hidden_step(&log, &column).or(question.lsb).unwrap_or(f64::NAN);
            return Err(DiagnoseError::CoarseSteps { column, value, step });
        }
        let axes = log.axes()?.len();
        let inputs = Inputs::of(log);
        let log = inputs.recording();
        let testable = Testable::of(question, &inputs, &column)?;
        let reduced = ErrorInBlocks::where_known(log, &column, &faults, &testable.known)?;
        if reduced.blocks.beyond_levels() < MIN_NOISE_BLOCKS {
            return Err(too_short(&column, &reduced));
        }
        let reference = reference.map(|reference| ErrorInBlocks::of(reference, &column)).transpose()?;
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
        let fast_deviation = reference.as_ref().unwrap_or(&reduced).fast_deviation();
        let mut given = vec![vec![1.0; reduced.blocks.len()]];
        let hypotheses = Hypotheses::new(inputs, &reduced.blocks, &column);
        for Given { effect, value } in question.given {
            let effect = Arc::new(question.library.get(effect)?.clone());
            given.extend(hypotheses.make(&effect, *value)?.columns.iter().cloned());
        }
        if let Searched::Found(zone) = excluded.zone {
            faults.push(Fault::DeadZone(zone));
        }
        let free_walk_prior = prior.with_free_walk(FREE_WALK)?;
        Ok(Self {
            question: *question,
            excluded,
            excluded_of_reference,
            evaluation,
            column,
            faults,
            testable,
            reduced,
            hypotheses,
            prior,
            free_walk_prior,
            axes,
            given,
            shaken,
            fast_deviation,
        })
    }

    /// The log to explain, without motion and outliers.
    pub(super) fn log(&self) -> &Recording {
        self.inputs().recording()
    }

    /// Returns the spectral lines that are errors of the sensor.
    pub(super) fn lines(&self) -> Result<Vec<Line>, RecordingError> {
        lines::of(self.log(), &self.column, &self.reduced, self.shaken)
    }

    /// Removes the spectral lines from the block means, where a line of a few hertz is an oscillation of minutes, and
    /// returns them; none if clipping, coarse steps or a dead zone hide them.
    pub(super) fn remove_lines(&mut self) -> Result<Vec<Line>, RecordingError> {
        let lines = if self.hides_slow_effects() { Vec::new() } else { self.lines()? };
        self.reduced.means = lines::means_without(&lines, &self.reduced, self.log());
        Ok(lines)
    }

    /// Inputs of the clean log.
    pub(super) fn inputs(&self) -> &Inputs<'a> {
        self.hypotheses.inputs()
    }

    /// The evaluation log without motion, and its first row that is evaluated.
    pub(super) fn evaluation(&self) -> Option<(&Recording, usize)> {
        Some((self.evaluation.as_deref()?, self.question.evaluation_from))
    }

    pub(super) fn library(&self) -> &'a Library {
        self.question.library
    }

    /// Effects that the model already has.
    pub(super) fn effects_in_model(&self) -> &'a [Given] {
        self.question.given
    }

    pub(super) fn has_reference(&self) -> bool {
        self.question.reference.is_some()
    }

    /// True if the log would not show a dead zone.
    pub(super) fn hides_dead_zone(&self) -> bool {
        self.excluded.zone == Searched::NotShown
    }

    /// Search for these effects beside the regressors `given`.
    pub(super) fn slow_search<'s>(
        &'s self,
        given: &'s [Vec<f64>],
        effects: &'s [Arc<Effect>],
    ) -> SlowSearch<'s> {
        SlowSearch {
            blocks: &self.reduced.blocks,
            y: &self.reduced.means,
            given,
            hypotheses: &self.hypotheses,
            axes: self.axes,
            effects,
            prior: self.prior,
            free_walk_prior: self.free_walk_prior,
        }
    }

    /// Describes what the log lacks for a test of any slow effect; `None` if it can show them.
    pub(super) fn lacks(&self) -> Result<Option<String>, DiagnoseError> {
        Ok(match (self.hides_slow_effects(), self.is_short()) {
            (true, _) => {
                Some("samples that are neither clipped nor in coarse steps nor in a dead zone".to_owned())
            }
            (false, true) => Some(self.time_needed()?),
            (false, false) => None,
        })
    }

    /// Returns true if there are too few blocks for slow effects.
    pub(super) fn is_short(&self) -> bool {
        self.reduced.blocks.beyond_levels() < MIN_BLOCKS
    }

    /// Describes what a log that is too short for slow effects needs: time at rest, or the columns that are unknown for
    /// most of it.
    pub(super) fn time_needed(&self) -> Result<String, DiagnoseError> {
        // as in `is_short`: the first block after each turn only determines a level
        let blocks = &self.reduced.blocks;
        let (has_s, wanted) =
            (blocks.beyond_levels() as f64 * blocks.length_s, MIN_BLOCKS as f64 * blocks.length_s);
        let any_inputs = ErrorInBlocks::new(self.log(), &self.column, &self.faults)?;
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

    /// Describes the motion that was excluded.
    pub(super) fn motion(&self) -> Vec<String> {
        disturbance::describe_disturbances(self.excluded.whole, &self.excluded.disturbances)
    }

    /// Describes how the device was switched on and off, if it was.
    pub(super) fn duty_cycle(&self) -> Option<String> {
        self.excluded.whole.duty_cycle().map(|cycle| cycle.to_string())
    }

    /// Describes where the noise levels are from.
    pub(super) fn learnt_from(&self) -> &'static str {
        match (self.question.sheet.is_some(), self.has_reference()) {
            (true, true) => "the reference log, with the data sheet as prior",
            (false, true) => "the reference log",
            (true, false) => "the data sheet; there is no reference log",
            (false, false) => "the log itself; there is neither a reference log nor a data sheet",
        }
    }

    /// Returns the warnings about the logs that concern the column to explain.
    pub(super) fn cautions(&self) -> Vec<String> {
        let mut cautions = self.excluded.cautions(&self.column);
        let of_reference = self.excluded_of_reference.iter().flat_map(|log| log.cautions(&self.column));
        cautions.extend(of_reference.map(|caution| format!("reference log: {caution}")));
        let others =
            [("reference log", self.question.reference), ("evaluation log", self.question.evaluation)];
        let here = self.question.log.rate.true_hz;
        for (name, other) in others {
            let there = other.map_or(here, |other| other.rate.true_hz);
            if (there / here - 1.0).abs() > OTHER_RATE {
                let [there, here] = [there, here].map(|rate| rounded(rate, 3));
                cautions.push(format!(
                    "the {name} runs at {there} Hz and the log to explain at {here} Hz; record both with the same device and settings"
                ));
            }
        }
        cautions
    }
}

/// Returns true if the known step of the axis is so coarse that the noise of the data sheet may not show: the axis may
/// then repeat one value at rest.
fn has_coarse_steps(question: &Question<'_>) -> bool {
    // noise densities of data sheets are one-sided
    let noise = |sheet: DataSheet| sheet.noise_density / (2.0 * question.log.rate.period_s).sqrt();
    question.lsb.zip(question.sheet).is_some_and(|(lsb, sheet)| lsb > STAIRS * noise(sheet))
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

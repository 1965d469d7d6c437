//! Input of a diagnosis, and its errors.

use fos_data::case::DataSheet;
use fos_data::recording::{Recording, RecordingError};

use crate::effects::Library;

/// A log to explain and the available knowledge about its axis.
#[derive(Debug, Clone, Copy)]
pub struct Question<'a> {
    pub log: &'a Recording,
    /// Reference log of the same device, without a missing effect.
    pub reference: Option<&'a Recording>,
    /// Evaluation log, whose inputs determine the predicted reduction. By default the log to explain.
    pub evaluation: Option<&'a Recording>,
    /// First row of the evaluation log that is evaluated. Those before it only set the states of lags and hysteresis.
    pub evaluation_from: usize,
    /// Column to explain.
    pub target: &'a str,
    /// Noise of the axis according to the data sheet.
    pub sheet: Option<DataSheet>,
    /// Full scale of the axis, in its unit.
    pub full_scale: Option<f64>,
    /// Least significant bit of the axis, in its unit.
    pub lsb: Option<f64>,
    pub library: &'a Library,
    /// Effects that the model already has, with their parameters; they are not searched for.
    pub given: &'a [Given],
}

impl<'a> Question<'a> {
    /// Returns the question for axis `target` of a log without further knowledge.
    pub fn new(log: &'a Recording, target: &'a str, library: &'a Library) -> Self {
        Self {
            log,
            reference: None,
            evaluation: None,
            evaluation_from: 0,
            target,
            sheet: None,
            full_scale: None,
            lsb: None,
            library,
            given: &[],
        }
    }
}

/// An effect that the model already has.
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    pub effect: String,
    /// Value of the parameter.
    pub value: Option<f64>,
}

/// Error that prevents a diagnosis.
#[derive(Debug, thiserror::Error)]
pub enum DiagnoseError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error(transparent)]
    Effect(#[from] crate::effects::EffectError),
    #[error(transparent)]
    Noise(#[from] fos_fit::noise::UnknownLevels),
    /// The coefficients of an effect have no covariance, for example because data are not finite.
    #[error(
        "{effect}: the uncertainty of its coefficients is not identifiable from this log: their covariance is not positive definite\nhelp: record a longer log at rest, without outliers"
    )]
    UnknownCoefficients { effect: String },
    #[error(
        "{effect} cannot be estimated from this log: {reason}\nhelp: a log in which what the effect follows is logged and changes"
    )]
    NotThere { effect: String, reason: String },
    #[error(
        "{column} repeats one value, {value:?}, for {seconds:.1} s of {all_s:.1} s at rest: stuck or not connected\nhelp: leave the axis out with `axis`"
    )]
    Stuck { column: String, value: f64, seconds: f64, all_s: f64 },
    #[error(
        "{column}: every value at rest is {value:?}: coarse steps of {step:.3e} hide its noise and all changes that are smaller\nhelp: choose a finer range of the sensor, or leave the axis out with `axis`"
    )]
    CoarseSteps {
        column: String,
        value: f64,
        /// Step of the other axes of the triad, in their unit.
        step: f64,
    },
    #[error(
        "{column}: {:.1} s at rest; at least {:.0} s are needed to tell an effect from drifting noise\nhelp: record a longer log at rest, or one with the true values (`ref_…`)",
        *blocks as f64 * length_s,
        MIN_BLOCKS as f64 * length_s
    )]
    TooShort {
        column: String,
        /// Number of blocks in which the column is known.
        blocks: usize,
        length_s: f64,
    },
}

/// Returns true if an axis has the bias of the rows before `from` in the rows of `log` from there on: the device ran on,
/// and no orientation changed. The error there counts about that bias, which a later log may not have.
pub(crate) fn keeps_bias(log: &Recording, column: &str, from: usize) -> bool {
    from > 0 && (log.is_bias_known(column) || log.turns.is_empty())
}

/// Least number of blocks for slow effects: below 60 the search over twenty effects has no power.
pub const MIN_BLOCKS: usize = 60;

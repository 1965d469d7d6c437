//! What a diagnosis is asked, and why there may be none.

use fos_data::case::DataSheet;
use fos_data::column::Column;
use fos_data::recording::{Recording, RecordingError};

use crate::effects::Library;

/// What to explain, and what is known beside it.
#[derive(Debug, Clone, Copy)]
pub struct Question<'a> {
    pub field: &'a Recording,
    /// A quiet log of the same unit, in which nothing is missing.
    pub quiet: Option<&'a Recording>,
    /// The log that a correction is to be judged on: its inputs say how much should fall there. By default the field
    /// log.
    pub judged: Option<&'a Recording>,
    /// The column to explain.
    pub target: &'a str,
    /// What the data sheet says of the axis.
    pub sheet: Option<DataSheet>,
    /// Full scale of the axis, in its unit.
    pub full_scale: Option<f64>,
    /// Least significant bit of the axis, in its unit.
    pub lsb: Option<f64>,
    pub library: &'a Library,
    /// Effects that the model already has, with their parameters: they are never found again.
    pub given: &'a [Given],
}

impl<'a> Question<'a> {
    /// The axis `target` of a log, with nothing known beside it.
    pub fn new(field: &'a Recording, target: &'a str, library: &'a Library) -> Self {
        Self {
            field,
            quiet: None,
            judged: None,
            target,
            sheet: None,
            full_scale: None,
            lsb: None,
            library,
            given: &[],
        }
    }
}

/// An effect that a model already has.
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    pub effect: String,
    /// The value of its parameter.
    pub value: Option<f64>,
}

/// Why there is no diagnosis.
#[derive(Debug, thiserror::Error)]
pub enum DiagnoseError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// An effect is not known.
    #[error(transparent)]
    Effect(#[from] crate::effects::EffectError),
    /// The noise cannot be told.
    #[error(transparent)]
    Noise(#[from] fos_fit::noise::UnknownLevels),
    /// The coefficients of an effect have no covariance, as of data that are not finite.
    #[error(
        "{effect}: the uncertainty of its coefficients is not identifiable from this log: their covariance is not positive definite\nhelp: record a longer log at rest, without outliers"
    )]
    UnknownCoefficients { effect: String },
    /// An effect that was asked for does not show in the log.
    #[error(
        "{effect} cannot be estimated from this log: {reason}\nhelp: a log in which what the effect follows is logged and changes"
    )]
    NotThere { effect: String, reason: String },
    /// An axis that does not measure.
    #[error(
        "{column} repeats one value, {value:?}, for {seconds:.1} s of {all_s:.1} s at rest: stuck or not connected\nhelp: leave the axis out with `axis`"
    )]
    Stuck {
        column: String,
        value: f64,
        /// How long it is stuck, s.
        seconds: f64,
        /// Time at rest, s.
        all_s: f64,
    },
    /// Steps that hide all noise.
    #[error(
        "{column}: every value at rest is {value:?}: coarse steps of {step:.3e} hide its noise and all changes that are smaller\nhelp: choose a finer range of the sensor, or leave the axis out with `axis`"
    )]
    CoarseSteps {
        column: String,
        value: f64,
        /// The step of the other axes of its triad, in its unit.
        step: f64,
    },
    /// Too little to say anything.
    #[error(
        "{column}: {:.1} s at rest; at least {:.0} s are needed to tell an effect from drifting noise\nhelp: record a longer log at rest, or one with the true values (`ref_…`)",
        *blocks as f64 * length_s,
        MIN_BLOCKS as f64 * length_s
    )]
    TooShort {
        column: String,
        /// Blocks in which it is known.
        blocks: usize,
        /// Their length, s.
        length_s: f64,
    },
}

/// Whether a log tells the bias of an axis, and not only how it changes: an accelerometer at rest shows gravity, and in
/// another pose another part of it.
pub(crate) fn is_bias_known(log: &Recording, column: &str) -> bool {
    log.channel(&Column::named(column).reference()).is_ok() || !Column::named(column).is_specific_force()
}

/// Fewest blocks that a diagnosis is made of: below 60 the search over twenty effects has no power left.
pub const MIN_BLOCKS: usize = 60;

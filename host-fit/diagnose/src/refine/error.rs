//! Why an effect cannot be added.

use fos_core::ModelError;
use fos_data::recording::RecordingError;

use crate::detect::DiagnoseError;
use crate::effects::EffectError;
use crate::physical::PhysicalError;
use crate::study::StudyAxisError;

/// Why an effect cannot be added.
#[derive(Debug, thiserror::Error)]
pub enum RefineError {
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
        "the grown model cannot be run: {0}\nhelp: take an effect back first, of another axis too, or fit fewer axes together"
    )]
    Model(#[from] ModelError),
    /// What the model corrects cannot be told.
    #[error(transparent)]
    Physical(#[from] PhysicalError),
    /// The study has no such axis, or nothing was added to it.
    #[error(transparent)]
    Study(#[from] StudyAxisError),
    /// The log is of another sensor than the study, or was corrected otherwise.
    #[error(
        "{log} does not go with the study: the study's {column} is {study}, that of the log {found}\nhelp: a log of the same sensor, recorded in the same way; --topic chooses the sensor of a log"
    )]
    OtherSensor {
        /// The log.
        log: String,
        /// The axis.
        column: String,
        /// What the study's is, in words.
        study: String,
        /// What the log's is, in words.
        found: String,
    },
    /// It is there already.
    #[error(
        "{0} is in the model already\nhelp: the history of the study shows what was added; undo takes the last back"
    )]
    Twice(String),
    /// What was added before was estimated and judged elsewhere.
    #[error(
        "{column} was refined on {log}; its steps cannot be compared with those on another log\nhelp: leave the logs out to go on there, or take the steps back first (undo)"
    )]
    OtherLogs {
        /// The axis.
        column: String,
        /// The log that it was refined on.
        log: String,
    },
    /// There is nothing to take off.
    #[error("{0}: nothing of it can be taken off sample by sample\nhelp: {1}")]
    NothingToTakeOff(String, &'static str),
}

//! Reasons why an effect cannot be added.

use fos_core::ModelError;
use fos_data::recording::RecordingError;

use crate::detect::DiagnoseError;
use crate::effects::EffectError;
use crate::physical::PhysicalError;
use crate::study::StudyAxisError;

/// Reason why an effect cannot be added.
#[derive(Debug, thiserror::Error)]
pub enum RefineError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    #[error(transparent)]
    Effect(#[from] EffectError),
    #[error(
        "the grown model cannot be run: {0}\nhelp: take an effect back first, of another axis too, or fit fewer axes together"
    )]
    Model(#[from] ModelError),
    #[error(transparent)]
    Physical(#[from] PhysicalError),
    #[error(transparent)]
    Study(#[from] StudyAxisError),
    #[error(
        "{log} does not go with the study: the study's {column} is {study}, that of the log {found}\nhelp: a log of the same sensor, recorded in the same way; `topic` chooses the sensor of a log"
    )]
    OtherSensor { log: String, column: String, study: String, found: String },
    #[error(
        "{0} is in the model already\nhelp: the history of the study shows what was added; undo takes the last back"
    )]
    Twice(String),
    #[error(
        "{effect} is not identifiable from this log: {reason}\nhelp: record a log that shows it: {experiment}"
    )]
    NotIdentifiable { effect: String, reason: String, experiment: String },
    #[error(
        "{effect} was not added: with it the {what} over the evaluation log grows {growth}\nhelp: record a log that shows the effect: {experiment}"
    )]
    MakesWorse {
        effect: String,
        /// Kind of error: the mean or the RMS.
        what: &'static str,
        /// Error before and after, and its uncertainty, with the unit.
        growth: String,
        experiment: String,
    },
    #[error(
        "{column} was refined on other data: {changes}; steps on different data cannot be compared\nhelp: put the same logs back to go on, or take the steps back first (undo)"
    )]
    OtherLogs { column: String, changes: String },
    #[error("{0}: it cannot be subtracted sample by sample\nhelp: {1}")]
    NothingToTakeOff(String, &'static str),
}

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
        "{log} does not go with the study: the study's {column} is {study}, that of the log {found}\nhelp: a log of the same sensor, recorded in the same way; `topic` chooses the sensor of a log"
    )]
    OtherSensor {
        log: String,
        column: String,
        /// What the study's is, in words.
        study: String,
        /// What the log's is, in words.
        found: String,
    },
    #[error(
        "{0} is in the model already\nhelp: the history of the study shows what was added; undo takes the last back"
    )]
    Twice(String),
    /// The log does not determine it.
    #[error(
        "{effect} is not identifiable from this log: {reason}\nhelp: record a log that shows it: {experiment}"
    )]
    NotIdentifiable {
        effect: String,
        reason: String,
        /// The experiment that would identify it.
        experiment: String,
    },
    /// With it the error of the evaluation log is larger than without.
    #[error(
        "{effect} was not added: with it the {what} over the evaluation log grows {growth}\nhelp: record a log that shows the effect: {experiment}"
    )]
    MakesWorse {
        effect: String,
        /// Which error: the mean or the RMS.
        what: &'static str,
        /// Error before and after, and what may be chance, with the unit.
        growth: String,
        /// The experiment that would identify it.
        experiment: String,
    },
    /// What was added before was estimated and evaluated on other data.
    #[error(
        "{column} was refined on other data: {changes}; steps on different data cannot be compared\nhelp: put the same logs back to go on, or take the steps back first (undo)"
    )]
    OtherLogs {
        column: String,
        /// What differs from then, in words.
        changes: String,
    },
    /// There is nothing to take off.
    #[error("{0}: it cannot be subtracted sample by sample\nhelp: {1}")]
    NothingToTakeOff(String, &'static str),
}

//! Orientations in which an accelerometer without a reference is fitted.
//!
//! At rest it shows gravity in addition to its bias, and gravity is constant only within one orientation. So each
//! orientation has its own constant, and the model learns only changes within an orientation: with temperature, with
//! time, from sample to sample.

use std::ops::Range;

use fos_data::observed::ObservedAxis;
use fos_data::pose::{self, Pose};
use fos_data::recording::{Recording, RecordingError};
use fos_data::stillness::Stillness;
use serde::{Deserialize, Serialize};

use super::axis_error::AxisError;

/// Orientation in which an axis was fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FittedPose {
    /// Begin as timestamp, s.
    pub from_s: f64,
    /// Specific force measured by the accelerometers of the log in it, m/s².
    pub force: Vec<f64>,
}

/// Orientations of the training part; a single one for an axis on which gravity does not act.
pub(super) struct Poses<'a> {
    column: &'a str,
    stillness: &'a Stillness,
    training: Range<usize>,
    fitted: Vec<FittedPose>,
}

impl<'a> Poses<'a> {
    pub(super) fn of(
        recording: &Recording,
        stillness: &'a Stillness,
        column: &'a str,
        training: &Range<usize>,
    ) -> Result<Self, AxisError> {
        let mut poses = Self { column, stillness, training: training.clone(), fitted: Vec::new() };
        let observed = poses.observed(recording)?;
        if observed.error.is_bias_known() {
            return Ok(poses);
        }
        let columns = pose::columns_of(recording, column);
        for rows in observed.levels(training.clone()) {
            let mut in_level = vec![false; recording.n_rows()];
            in_level[rows.clone()].copy_from_slice(&stillness.still[rows]);
            match &pose::first_two(recording, &columns, &in_level)[..] {
                [] => {}
                [only] => poses.fitted.push(fitted_pose(recording, only)),
                [first, second, ..] => return Err(poses.two(recording, first, second)),
            }
        }
        if observed.turns.is_empty() {
            poses.fitted.clear();
        }
        Ok(poses)
    }

    /// Returns the axis in the rows that are fitted.
    fn observed<'r>(&self, recording: &'r Recording) -> Result<ObservedAxis<'r>, RecordingError>
    where
        'a: 'r,
    {
        Ok(ObservedAxis::at_rest(recording, self.stillness, self.column)?.within(&self.training))
    }

    fn two(&self, recording: &Recording, first: &Pose, second: &Pose) -> AxisError {
        let of = |pose: &Pose| (recording.time_s[pose.rows.start], pose.force.clone());
        let seconds = recording.time_s[first.rows.end - 1] - recording.time_s[0];
        AxisError::TwoPoses {
            column: self.column.to_owned(),
            first: of(first),
            second: of(second),
            train_s: seconds as u64,
        }
    }

    /// Returns the recording converted to the first orientation throughout, from the residual of `explained`, one value
    /// per row; `None` if there is only one.
    pub(super) fn in_first(&self, recording: &Recording, explained: &[f64]) -> Option<Recording> {
        let observed = self.observed(recording).ok().filter(|observed| !observed.turns.is_empty())?;
        let mut first = None;
        let moved = observed.with_levels(explained, |level| *first.get_or_insert(level));
        Some(recording.with_values(self.column, moved))
    }

    /// Returns an indicator column for each orientation except the first.
    pub(super) fn columns(&self, recording: &Recording) -> Result<Vec<Vec<f64>>, RecordingError> {
        let observed = self.observed(recording)?;
        let n_rows = recording.n_rows();
        let column = |rows: Range<usize>| {
            let mut column = vec![0.0; n_rows];
            column[rows].fill(1.0);
            column
        };
        let is_fitted = |rows: &Range<usize>| observed.known[rows.clone()].contains(&true);
        Ok(observed.levels(0..n_rows).into_iter().filter(is_fitted).skip(1).map(column).collect())
    }

    /// Converts to the form stored in a study: empty if there is only one.
    pub(super) fn fitted(self) -> Vec<FittedPose> {
        self.fitted
    }
}

fn fitted_pose(recording: &Recording, pose: &Pose) -> FittedPose {
    FittedPose { from_s: recording.time_s[pose.rows.start], force: pose.force.clone() }
}

//! Orientations in which an accelerometer without a reference is fitted.
//!
//! At rest it shows gravity in addition to its bias, and gravity is constant only within one orientation. So each
//! orientation has its own constant, and the model learns only changes within an orientation: with temperature, with
//! time, from sample to sample.

use std::ops::Range;

use fos_data::pose::{self, Pose};
use fos_data::recording::{Recording, Reference};
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
    /// Rows that are fitted.
    used: Vec<bool>,
    turns: Vec<usize>,
    fitted: Vec<FittedPose>,
}

impl<'a> Poses<'a> {
    /// # Errors
    ///
    /// Gravity changes its direction in rows that are marked as rest.
    pub(super) fn of(
        recording: &Recording,
        stillness: &Stillness,
        (column, reference): (&'a str, &Reference),
        training: &Range<usize>,
    ) -> Result<Self, AxisError> {
        let mut used = stillness.still.clone();
        used[training.end..].fill(false);
        let mut poses = Self { column, used, turns: Vec::new(), fitted: Vec::new() };
        if !pose::has_unknown_level(column, reference) {
            return Ok(poses);
        }
        poses.turns = stillness.turns.iter().copied().filter(|turn| training.contains(turn)).collect();
        let columns = pose::columns_of(recording, column);
        for rows in pose::levels_between(&poses.turns, 0..training.end) {
            let mut in_level = vec![false; recording.n_rows()];
            in_level[rows.clone()].copy_from_slice(&poses.used[rows]);
            match &pose::first_two(recording, &columns, &in_level)[..] {
                [] => {}
                [only] => poses.fitted.push(fitted_pose(recording, only)),
                [first, second, ..] => return Err(poses.two(recording, first, second)),
            }
        }
        if poses.turns.is_empty() {
            poses.fitted.clear();
        }
        Ok(poses)
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

    /// Returns the recording converted to the first orientation throughout, from the residual of `explained` in each
    /// row; `None` if there is only one.
    pub(super) fn in_first(
        &self,
        recording: &Recording,
        explained: impl Fn(usize) -> f64,
    ) -> Option<Recording> {
        if self.turns.is_empty() {
            return None;
        }
        let values = &recording.channel(self.column).ok()?.values;
        let explained: Vec<f64> = (0..values.len()).map(explained).collect();
        let mut first = None;
        let as_first = |level| *first.get_or_insert(level);
        let moved = pose::with_levels(values, &explained, &self.used, &self.turns, as_first);
        Some(recording.with_values(self.column, moved))
    }

    /// Returns an indicator column for each orientation except the first.
    pub(super) fn columns(&self) -> Vec<Vec<f64>> {
        let levels = pose::levels_between(&self.turns, 0..self.used.len());
        let column = |rows: &Range<usize>| {
            let mut column = vec![0.0; self.used.len()];
            column[rows.clone()].fill(1.0);
            column
        };
        let is_fitted = |rows: &&Range<usize>| self.used[(*rows).clone()].contains(&true);
        levels.iter().filter(is_fitted).skip(1).map(column).collect()
    }

    /// Converts to the form stored in a study: empty if there is only one.
    pub(super) fn fitted(self) -> Vec<FittedPose> {
        self.fitted
    }
}

fn fitted_pose(recording: &Recording, pose: &Pose) -> FittedPose {
    FittedPose { from_s: recording.time_s[pose.rows.start], force: pose.force.clone() }
}

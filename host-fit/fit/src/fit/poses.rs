//! The poses that an accelerometer without a reference is fitted in.
//!
//! At rest it shows gravity beside its bias, and gravity is one value in one pose only. So each pose has a constant of
//! its own, and what is learnt is what happens within a pose: with temperature, with time, from sample to sample.

use std::ops::Range;

use fos_data::pose::{self, Pose};
use fos_data::recording::{Recording, Reference};
use fos_data::stillness::Stillness;
use serde::{Deserialize, Serialize};

use super::axis_error::AxisError;

/// A pose that an axis was fitted in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FittedPose {
    /// From when on, s as stamped.
    pub from_s: f64,
    /// What the accelerometers of the log show in it, m/s².
    pub force: Vec<f64>,
}

/// The poses of the training part; of an axis that gravity does not bear on one without a turn.
pub(super) struct Poses<'a> {
    column: &'a str,
    /// Rows that are fitted.
    used: Vec<bool>,
    turns: Vec<usize>,
    told: Vec<FittedPose>,
}

impl<'a> Poses<'a> {
    /// # Errors
    ///
    /// Gravity turns where the log claims rest.
    pub(super) fn of(
        recording: &Recording,
        stillness: &Stillness,
        (column, reference): (&'a str, &Reference),
        training: &Range<usize>,
    ) -> Result<Self, AxisError> {
        let mut used = stillness.still.clone();
        used[training.end..].fill(false);
        let mut poses = Self { column, used, turns: Vec::new(), told: Vec::new() };
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
                [only] => poses.told.push(told(recording, only)),
                [first, second, ..] => return Err(poses.two(recording, first, second)),
            }
        }
        if poses.turns.is_empty() {
            poses.told.clear();
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

    /// The recording as if it had lain in the first pose throughout, by what `explained` leaves of each row; `None` if
    /// it did.
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

    /// A column for each pose but the first, 1 in its rows.
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

    /// As a study keeps them: none where there is one.
    pub(super) fn told(self) -> Vec<FittedPose> {
        self.told
    }
}

fn told(recording: &Recording, pose: &Pose) -> FittedPose {
    FittedPose { from_s: recording.time_s[pose.rows.start], force: pose.force.clone() }
}

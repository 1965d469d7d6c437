//! A log without outliers and motion, and the warnings about it.

use std::borrow::Cow;

use super::dead_zone::{self, Searched};
use super::question::DiagnoseError;
use fos_data::column::Column;
use fos_data::disturbance::{self, Disturbance};
use fos_data::recording::{LogWarning, Recording};

/// Motion and outliers that were excluded from a log for one of its columns.
#[derive(Debug)]
pub(super) struct Excluded<'a> {
    /// The log as read.
    pub(super) whole: &'a Recording,
    still: Vec<bool>,
    /// Detected motion.
    pub(super) disturbances: Vec<Disturbance>,
    /// Result of the search for a dead zone in the column.
    pub(super) zone: Searched,
}

impl<'a> Excluded<'a> {
    /// Returns the log without motion and without the outliers of `column`. A column that repeats one value all the time
    /// is accepted if `is_coarse`.
    pub(super) fn of(
        whole: &'a Recording,
        column: &str,
        is_coarse: bool,
    ) -> Result<(Cow<'a, Recording>, Self), DiagnoseError> {
        let (at_rest, disturbances) = disturbance::marked(whole);
        // an outlier is not motion, although a motion detector may report it
        let still = at_rest.still.clone().unwrap_or_else(|| vec![true; whole.n_rows()]);
        let zone = match Column::named(column).is_angular_rate() {
            true => dead_zone::search(&whole.channel(column)?.values),
            false => Searched::None,
        };
        // inside a dead zone a gyro repeats one value, which is not a stuck sensor
        if matches!(zone, Searched::Found(_)) {
            return Ok((at_rest, Self { whole, still, disturbances, zone }));
        }
        if let Some((value, [seconds, all_s])) = whole.stuck_axis(column, &still)
            && !(is_coarse && seconds == all_s)
        {
            return Err(DiagnoseError::Stuck { column: column.to_owned(), value, seconds, all_s });
        }
        let clean = match at_rest {
            Cow::Borrowed(whole) => whole.without_outliers(column, 0..whole.n_rows(), &still).0,
            Cow::Owned(marked) => {
                Cow::Owned(marked.without_outliers(column, 0..whole.n_rows(), &still).0.into_owned())
            }
        };
        Ok((clean, Self { whole, still, disturbances, zone }))
    }

    /// Returns the warnings about the log that concern `column`.
    pub(super) fn cautions(&self, column: &str) -> Vec<String> {
        let concerns_column = |warning: &LogWarning| match warning {
            LogWarning::NotGravity { .. } | LogWarning::LevelAfterPause(_) => {
                Column::named(column).is_specific_force()
            }
            _ => true,
        };
        let odd = self.whole.warnings_about(&[column], &self.still);
        odd.iter().filter(|warning| concerns_column(warning)).map(ToString::to_string).collect()
    }
}

//! A log of a refinement: as read, without detected motion, and with one level in all orientations.

use std::borrow::Cow;
use std::ops::Range;

use fos_data::column::Column;
use fos_data::disturbance;
use fos_data::observed::ObservedAxis;
use fos_data::recording::{Recording, RecordingError};
use fos_data::stillness::{self, KnownBy};
use fos_fit::single_axis::SingleAxisModel;

use super::error::RefineError;
use crate::physical::physical;

/// A log from which effects are estimated, or on which they are evaluated.
#[derive(Debug)]
pub(super) struct ObservedLog<'a> {
    pub(super) whole: Cow<'a, Recording>,
    /// The log without detected motion; `None` if there is none.
    at_rest: Option<Recording>,
}

/// A log with the same level of one axis in all orientations.
pub(super) struct Levelled<'l> {
    pub(super) log: Cow<'l, Recording>,
    /// Rows in which the error is known.
    pub(super) known: Vec<bool>,
    /// Mean of the error after the physical part is subtracted, in the unit of the axis; 0 without a known row.
    pub(super) level: f64,
}

impl<'a> ObservedLog<'a> {
    pub(super) fn new(whole: Cow<'a, Recording>) -> Self {
        let at_rest = match disturbance::marked(&whole).0 {
            Cow::Borrowed(_) => None,
            Cow::Owned(marked) => Some(marked),
        };
        Self { whole, at_rest }
    }

    /// Returns the log without detected motion.
    pub(super) fn at_rest(&self) -> &Recording {
        self.at_rest.as_ref().unwrap_or(&self.whole)
    }

    /// Returns the rows in which the error of `column` is known: with a reference as in a diagnosis, otherwise at rest. On a
    /// shaker nothing is at rest and all rows count.
    pub(super) fn known_rows(&self, column: &str) -> Result<Vec<bool>, RecordingError> {
        let log = self.at_rest();
        if log.channel(&Column::named(column).reference()).is_ok() {
            return Ok(ObservedAxis::stated(log, column)?.known);
        }
        let stillness = stillness::find(&self.whole);
        let at_rest = stillness.still.iter().filter(|still| **still).count();
        Ok(match stillness.known_by {
            KnownBy::Detector if at_rest < stillness.still.len() / 2 => vec![true; stillness.still.len()],
            _ => stillness.still,
        })
    }

    /// Levels the only axis of `model` in `log`, which has the rows of this one and perhaps other values. The level is
    /// that of `rows`.
    pub(super) fn levelled<'l>(
        &self,
        model: &SingleAxisModel,
        log: &'l Recording,
        rows: Range<usize>,
    ) -> Result<Levelled<'l>, RefineError> {
        let column = &model.axis().column;
        let known = self.known_rows(column)?;
        let turns = if log.is_bias_known(column) { &[][..] } else { &self.at_rest().turns };
        let observed = ObservedAxis { error: log.error_series(column)?, known, turns: Cow::Borrowed(turns) };
        let explained = physical(model, log)?.swap_remove(0);
        let level = observed.level(&explained, rows).unwrap_or_default();
        let levelled = match turns {
            [] => Cow::Borrowed(log),
            _ => Cow::Owned(log.with_values(column, observed.with_levels(&explained, |_| level))),
        };
        Ok(Levelled { log: levelled, known: observed.known, level })
    }
}

//! Error of one axis of a log, the rows that show it, and where its level is unknown.

use std::borrow::Cow;
use std::ops::Range;

use crate::pose::levels_between;
use crate::recording::{ErrorSeries, Recording, RecordingError, Reference};
use crate::statistics::mean;
use crate::stillness::Stillness;

/// Share of rows at rest from which on a log counts as recorded at rest. Motion in it is then handling, which the
/// reference does not include.
const AT_REST: f64 = 0.5;

/// One axis of a log: its error, the rows in which the error is known, and the rows from which its level is another one.
#[derive(Debug, Clone)]
pub struct ObservedAxis<'a> {
    pub error: ErrorSeries<'a>,
    /// Rows in which the error is known; one flag per row.
    pub known: Vec<bool>,
    /// Rows from which gravity may add another unknown constant. Empty for an axis whose bias is known.
    pub turns: Cow<'a, [usize]>,
}

impl<'a> ObservedAxis<'a> {
    /// Observes `column` in the rows at rest that `stillness` finds.
    pub fn at_rest(
        log: &'a Recording,
        stillness: &'a Stillness,
        column: &str,
    ) -> Result<Self, RecordingError> {
        Ok(Self::new(log.error_series(column)?, &stillness.turns, |row| stillness.still[row]))
    }

    /// Observes `column` in the rows at rest that `log` states, and with a reference also in those of a log that mostly
    /// moves. A log without that statement is at rest throughout.
    pub fn stated(log: &'a Recording, column: &str) -> Result<Self, RecordingError> {
        let error = log.error_series(column)?;
        let still = log.still.as_deref();
        let rest = still.map_or(log.n_rows(), |still| still.iter().filter(|still| **still).count());
        let has_reference = matches!(error.reference, Reference::Channel(_));
        let counts_moving = has_reference && (rest as f64) < AT_REST * log.n_rows() as f64;
        let counts = |row: usize| counts_moving || still.is_none_or(|still| still[row]);
        Ok(Self::new(error, &log.turns, counts))
    }

    fn new(error: ErrorSeries<'a>, turns: &'a [usize], counts: impl Fn(usize) -> bool) -> Self {
        let known = error.values.iter().enumerate().map(|(row, value)| value.is_finite() && counts(row));
        let known = known.collect();
        let turns = if error.is_bias_known() { &[] } else { turns };
        Self { error, known, turns: Cow::Borrowed(turns) }
    }

    /// Restricts the axis to `rows`.
    pub fn within(mut self, rows: &Range<usize>) -> Self {
        self.known[..rows.start].fill(false);
        self.known[rows.end..].fill(false);
        self.turns = self.turns.iter().copied().filter(|turn| rows.contains(turn)).collect();
        self
    }

    /// Returns the ranges of one level each within `rows`.
    pub fn levels(&self, rows: Range<usize>) -> Vec<Range<usize>> {
        levels_between(&self.turns, rows)
    }

    /// Returns the mean of error − `explained`, one value per row, over the known rows among `rows`; `None` without
    /// one.
    pub fn level(&self, explained: &[f64], rows: Range<usize>) -> Option<f64> {
        let left = rows.filter(|row| self.known[*row]).map(|row| self.error.values[row] - explained[row]);
        let left: Vec<f64> = left.filter(|value| value.is_finite()).collect();
        (!left.is_empty()).then(|| mean(&[&left]))
    }

    /// Returns the error with a shifted level in each orientation: [`level`](Self::level) becomes the result of `wanted`.
    /// A constant within one orientation cannot be attributed to an error.
    pub fn with_levels(&self, explained: &[f64], mut wanted: impl FnMut(f64) -> f64) -> Vec<f64> {
        let mut moved = self.error.values.to_vec();
        for rows in self.levels(0..moved.len()) {
            let Some(level) = self.level(explained, rows.clone()) else { continue };
            let shift = level - wanted(level);
            moved[rows].iter_mut().for_each(|value| *value -= shift);
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{LoadOptions, Source};
    use crate::stillness::KnownBy;

    /// Ten samples of an accelerometer, with a reference if asked for; `value` is the error.
    fn log(has_reference: bool, value: impl Fn(usize) -> f64) -> Recording {
        let reference = if has_reference { 9.8 } else { 0.0 };
        let mut columns = vec![
            ("t_s".to_owned(), (0..10).map(|row| 0.1 * row as f64).collect()),
            ("ax_mps2".to_owned(), (0..10).map(|row| value(row) + reference).collect()),
        ];
        if has_reference {
            columns.push(("ref_ax_mps2".to_owned(), vec![9.8; 10]));
        }
        Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).expect("a log")
    }

    #[test]
    fn a_reference_covers_motion_only_in_a_log_that_mostly_moves() {
        let known = |has_reference, rest: usize| {
            let still: Vec<bool> = (0..10).map(|row| row < rest).collect();
            let log = log(has_reference, |_| 0.1).with_rests(still, Vec::new());
            let observed = ObservedAxis::stated(&log, "ax_mps2").expect("an axis");
            observed.known.iter().filter(|known| **known).count()
        };
        assert_eq!([known(true, 8), known(true, 5), known(true, 4)], [8, 5, 10]);
        assert_eq!([known(false, 8), known(false, 4)], [8, 4]);
    }

    #[test]
    fn every_orientation_has_a_level_of_its_own_unless_the_bias_is_known() {
        let stillness = Stillness {
            still: vec![true; 10],
            known_by: KnownBy::Assumed,
            disturbances: vec![],
            turns: vec![4],
            limits: None,
        };
        let turned = |row: usize| if row < 4 { 1.0 } else { 3.0 };
        let unknown = log(false, |row| if row == 7 { f64::NAN } else { turned(row) });
        let observed = ObservedAxis::at_rest(&unknown, &stillness, "ax_mps2").expect("an axis");
        assert_eq!(observed.levels(0..10), [0..4, 4..10]);
        assert_eq!(observed.level(&[0.5; 10], 4..10), Some(2.5));
        assert_eq!(observed.level(&[0.5; 10], 7..8), None);
        let moved = observed.with_levels(&[0.0; 10], |_| 1.0);
        assert!(moved.iter().enumerate().all(|(row, value)| *value == 1.0 || row == 7), "{moved:?}");
        let observed = observed.within(&(0..4));
        assert_eq!((observed.levels(0..4).len(), observed.turns.len()), (1, 0));
        let known = log(true, turned);
        let observed = ObservedAxis::at_rest(&known, &stillness, "ax_mps2").expect("an axis");
        assert!(observed.turns.is_empty());
    }
}

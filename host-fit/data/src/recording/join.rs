//! Concatenates several recordings of one device. Filters and lags restart at each boundary, unless a recording begins
//! where the one before it ends: the device ran on, as with a logger that starts a new file every hour.

use std::borrow::Cow;
use std::sync::Arc;

use super::{Boundary, Quality, Recording, RecordingError};

/// Relative difference of rates beyond which recordings do not share a model. A model's lags are in samples: at 2 %
/// they are as far off in time as a model can bear.
const SAME_RATE: f64 = 0.02;

/// Longest time from the end of a recording to the start of one that continues it, in sampling periods: no device
/// restarts within a few samples.
const LONGEST_STEP: f64 = 10.0;

impl Recording {
    /// Returns this recording after `before` and the number of rows of `before`, if it continues that; else this
    /// recording and 0. A model evaluated on both has its states where this recording begins.
    pub fn led_in_by(&self, before: &Self) -> (Cow<'_, Self>, usize) {
        let joined = before.periods_to(self).map(|_| Self::join(vec![before.clone(), self.clone()]));
        match joined {
            Some(Ok(joined)) => (Cow::Owned(joined), before.n_rows()),
            _ => (Cow::Borrowed(self), 0),
        }
    }

    /// Number of sampling periods from the last row to the first of `next`, if `next` begins, by its timestamps, where
    /// this recording ends.
    fn periods_to(&self, next: &Self) -> Option<u64> {
        let step_s = next.time_s.first()? - self.time_s.last()?;
        let periods = step_s / self.rate.period_s;
        (periods > 0.5 && periods <= LONGEST_STEP).then(|| periods.round() as u64)
    }

    /// Concatenates recordings: the channels that all of them have, with a segment boundary between any two unless one
    /// continues the other. Times continue from one to the next.
    ///
    /// # Errors
    /// The list is empty, or the recordings have different rates, sensors or corrections, or no channel in common.
    pub fn join(recordings: Vec<Self>) -> Result<Self, RecordingError> {
        let mut rest = recordings.into_iter();
        let mut joined = rest.next().ok_or(RecordingError::NothingToJoin)?;
        for next in rest {
            joined.append(next)?;
        }
        Ok(joined)
    }

    fn append(&mut self, next: Self) -> Result<(), RecordingError> {
        let (here, there) = (self.rate.true_hz, next.rate.true_hz);
        if (there / here - 1.0).abs() > SAME_RATE {
            return Err(RecordingError::RatesDiffer {
                path: next.paths(),
                rate_hz: there,
                expected_hz: here,
            });
        }
        self.refuse_other_sensor(&next)?;
        let (rows, periods) = (self.n_rows(), self.periods_to(&next));
        self.channels.retain(|channel| next.channels.iter().any(|other| same(channel, other)));
        if self.channels.is_empty() {
            return Err(RecordingError::NothingInCommon { path: next.paths(), others: self.paths() });
        }
        for channel in &mut self.channels {
            let other = next.channels.iter().find(|other| same(channel, other));
            Arc::make_mut(&mut channel.values)
                .extend(other.into_iter().flat_map(|other| other.values.iter()));
        }
        // the mean period weighted by rows
        let weight = next.n_rows() as f64 / (rows + next.n_rows()) as f64;
        self.rate.period_s += weight * (next.rate.period_s - self.rate.period_s);
        self.rate.true_hz = 1.0 / self.rate.period_s;
        self.rate.jitter_s = self.rate.jitter_s.max(next.rate.jitter_s);

        let last_s = self.time_s.last().copied().unwrap_or(0.0);
        let first_s = next.time_s.first().copied().unwrap_or(0.0);
        let shift_s = if periods.is_some() { 0.0 } else { last_s + self.rate.period_s - first_s };
        self.time_s.extend(next.time_s.iter().map(|time_s| time_s + shift_s));
        let missing = periods.map_or(0, |periods| periods - 1);
        let tick =
            self.segments.last().map_or(0, |segment| segment.tick + segment.rows.len() as u64) + missing;
        for mut segment in next.segments {
            segment.rows = segment.rows.start + rows..segment.rows.end + rows;
            segment.tick += tick;
            if segment.boundary == Boundary::Start {
                match (periods, self.segments.last_mut()) {
                    (Some(1), Some(last)) => {
                        last.rows.end = segment.rows.end;
                        continue;
                    }
                    (Some(_), _) => (segment.boundary, segment.missing_before) = (Boundary::Gap, missing),
                    (None, _) => segment.boundary = Boundary::Recording,
                }
            }
            self.segments.push(segment);
        }
        self.detected = Default::default();
        self.still = match (self.still.take(), next.still) {
            (Some(mut still), Some(more)) => {
                still.extend(more);
                Some(still)
            }
            _ => None,
        };
        self.turns.extend(next.turns.iter().map(|turn| turn + rows));
        self.quality.add(next.quality);
        // of the first: later ones come from the same kind of source
        self.alignment = self.alignment.take().or(next.alignment);
        self.sources.extend(next.sources);
        Ok(())
    }
}

fn same(channel: &super::Channel, other: &super::Channel) -> bool {
    channel.name == other.name && channel.unit == other.unit
}

impl Quality {
    /// Adds the counts of both; row positions refer to the files they were found in and are kept of the first only.
    fn add(&mut self, other: Self) {
        self.rows_in_file += other.rows_in_file;
        self.rows_unusable += other.rows_unusable;
        self.rows_repeated += other.rows_repeated;
        self.stamps_repeated += other.stamps_repeated;
        self.clock_back += other.clock_back;
        self.gaps += other.gaps;
        self.samples_missing += other.samples_missing;
        self.pauses += other.pauses;
        self.paused_s += other.paused_s;
        self.missing_cells.extend(other.missing_cells);
        let more = other.empty_axes.into_iter().filter(|axis| !self.empty_axes.contains(axis));
        self.empty_axes.extend(more.collect::<Vec<_>>());
        self.failed_reads.extend(other.failed_reads);
        self.clock.extend(other.clock);
        if self.assumed_map.is_empty() {
            self.assumed_map = other.assumed_map;
        }
        self.text_columns.extend(other.text_columns);
        self.first_text = self.first_text.take().or(other.first_text);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, Source};
    use super::*;

    fn recording(rate_hz: f64, columns: &[(&str, usize)]) -> Recording {
        let columns = columns.iter().map(|(name, rows)| ((*name).to_owned(), vec![1.5; *rows])).collect();
        let options = LoadOptions { rate_hz: Some(rate_hz), ..LoadOptions::default() };
        Recording::from_columns(Source::made_by("test"), columns, &options).unwrap()
    }

    #[test]
    fn joined_recordings_have_a_boundary() {
        let first = recording(100.0, &[("gx_rads", 30), ("temp_c", 30)]);
        let second = recording(101.0, &[("supply_v", 20), ("gx_rads", 20)]);
        let joined = Recording::join(vec![first, second]).unwrap();
        assert_eq!(joined.n_rows(), 50);
        assert_eq!(joined.channels().iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["gx_rads"]);
        assert_eq!(joined.channels()[0].values.len(), 50);
        let boundaries: Vec<_> = joined.segments.iter().map(|s| (s.rows.clone(), s.boundary)).collect();
        assert_eq!(boundaries, [(0..30, Boundary::Start), (30..50, Boundary::Recording)]);
        assert!(joined.time_s.is_sorted());
        assert_eq!(joined.sources.len(), 2);
        // two fifths of the rows at the other period
        let period_s = 0.6 / 100.0 + 0.4 / 101.0;
        assert!((joined.rate.period_s - period_s).abs() < 1e-12);
    }

    /// A thermal lag restarted in the second file of a logger that had merely begun a new file.
    #[test]
    fn recording_that_begins_where_another_ends_continues_it() {
        let from = |start_s: f64| {
            let time_s = (0..30).map(|row| start_s + 0.01 * f64::from(row)).collect();
            let columns = vec![("t_s".to_owned(), time_s), ("gx_rads".to_owned(), vec![1.5; 30])];
            Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap()
        };
        let joined = |start_s: f64| {
            let joined = Recording::join(vec![from(5.0), from(start_s)]).unwrap();
            let segments =
                joined.segments.iter().map(|s| (s.rows.clone(), s.boundary, s.missing_before, s.tick));
            (segments.collect::<Vec<_>>(), joined.time_s[30])
        };
        assert!(from(5.0).periods_to(&from(5.3)).is_some() && from(5.0).periods_to(&from(5.0)).is_none());
        assert_eq!([5.3, 5.0].map(|start_s| from(start_s).led_in_by(&from(5.0)).1), [30, 0]);
        assert_eq!(joined(5.3), (vec![(0..60, Boundary::Start, 0, 0)], 5.3));
        assert_eq!(joined(5.32).0[1], (30..60, Boundary::Gap, 2, 32));
        // a minute later the device may have been off; and stamps that start again at 0 tell nothing
        for start_s in [0.0, 65.3] {
            let (segments, time_s) = joined(start_s);
            assert_eq!(segments[1], (30..60, Boundary::Recording, 0, 30));
            assert!((time_s - 5.3).abs() < 1e-9);
        }
    }

    #[test]
    fn rejects_incompatible_recordings() {
        let one = || recording(100.0, &[("gx_rads", 30)]);
        let faster = Recording::join(vec![one(), recording(103.0, &[("gx_rads", 30)])]).unwrap_err();
        assert!(faster.to_string().contains("103"), "{faster}");
        let other = Recording::join(vec![one(), recording(100.0, &[("gy_rads", 30)])]).unwrap_err();
        assert!(other.to_string().contains("no channel"), "{other}");
        assert!(Recording::join(Vec::new()).is_err());
    }
}

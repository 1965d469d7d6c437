//! Rows of a recording on the regular sample grid: segments, and the boundaries between them.

use std::ops::Range;

use crate::statistics::median;

/// Shortest pause of a recorder, s: a shorter wait is a buffer that was not read in time or a busy bus.
const SHORTEST_PAUSE_S: f64 = 1.0;

/// Minimum number of pauses that establish a rule. Losses at random moments have exponential intervals, of which 28 %
/// lie within [`SIMILAR`] of their median: that nearly all of eight do happens once in ten thousand logs.
const MIN_PAUSES: usize = 8;

/// Largest ratio of two similar lengths.
const SIMILAR: f64 = 1.5;

/// Share of the pauses that must be similar, and lie at similar intervals.
const REGULAR_SHARE: f64 = 0.9;

/// Largest number of missing samples that is exact (a period known to 1e-4 is one sample off); beyond it the two sides
/// are not used together to measure the period.
pub(super) const EXACT_MISSING: u64 = 5_000;

/// A stretch of rows without gaps.
///
/// **Rule.** Let T be the sample period and `late(i) = stamp(i) − i·T`. A missing sample delays every later row by T
/// permanently; jitter and bursts delay a few rows. So a gap is looked for where two rows are at least 1.25 T apart, and
/// it is accepted if the *level* of `late` after it exceeds the level before it by more than half a period:
/// round(rise / T) samples are missing.
///
/// - Stamped sample by sample (regular or jittered): the level is the median over 16 to 64 rows, more for more scatter,
///   and ends at the next interval that scatter does not explain (another gap).
/// - Bursts: samples arrive late, never early, so the level is the lower envelope, the minimum over 16 bursts or
///   eight times the wait, until a slow host has caught up (64 to 4096 rows). The age of the freshest sample at a
///   poll drifts as the two clocks slip, which lifts the envelope by up to half a period within one window: here
///   the rise must exceed 0.75 T. Rows with timestamps that run backward are not part of the envelope.
///
/// In both cases the rise must exceed six times its own scatter: of a median of that many timestamps; for bursts as
/// measured over all long intervals of the log. So if a host is so slow that the envelope is ragged, a short loss is not
/// detected.
///
/// A gap is placed where the rows fit best on both sides: least absolute deviation for jitter; for bursts the longest
/// interval between the last row that is too early to come after the gap and the first that is not late.
///
/// A gap of ten seconds is a pause, and so is every long interval of a duty-cycled log (bursts of samples with intervals
/// of a second and more between them that are most of its time, or regular): the log is complete, with many segments.
///
/// Time that goes back by more than T, and stays back, is a restart of the clock: a boundary with an unknown number of
/// missing samples. A wrong timestamp of a row or two is no gap. Boundaries that do not depend on timestamps (a change
/// of `segment`, skipped rows) are given.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Rows of the segment.
    pub rows: Range<usize>,
    /// Index of its first row on the regular sample grid; the first row of the recording is 0.
    pub tick: u64,
    /// Samples missing between the previous segment and this one.
    pub missing_before: u64,
    pub boundary: Boundary,
}

/// Reason why a segment starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// The recording starts.
    Start,
    Gap,
    /// Nothing was recorded for a while: a duty-cycled log, or one that was off for ten seconds or more. No sample was
    /// lost; `missing_before` is the number that would have been taken.
    Pause,
    /// The `segment` column changes.
    SegmentColumn,
    /// Time goes back; the number of missing samples is unknown (`missing_before` is 0).
    ClockBack,
    /// Another recording starts.
    Recording,
}

/// Minimum duration of a pause, s: a bus or a radio link that loses samples recovers within seconds.
const PAUSE_S: f64 = 10.0;

/// A boundary known without timestamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mark {
    pub(super) row: usize,
    pub(super) boundary: Boundary,
    /// Number of samples known to be missing.
    pub(super) missing: u64,
}

/// Rows of a recording on the regular sample grid.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) segments: Vec<Segment>,
    pub(super) clock_back: u64,
}

impl Grid {
    /// Marks long gaps as pauses.
    pub(super) fn with_pauses(mut self, period_s: f64) -> Self {
        for segment in &mut self.segments {
            if segment.boundary == Boundary::Gap && segment.missing_before as f64 * period_s >= PAUSE_S {
                segment.boundary = Boundary::Pause;
            }
        }
        if let Some((pauses, _)) = regular_pauses(&self.segments, period_s) {
            pauses.into_iter().for_each(|pause| self.segments[pause].boundary = Boundary::Pause);
        }
        self
    }

    /// Grid index of every row.
    pub(super) fn ticks(&self) -> Vec<u64> {
        self.segments.iter().flat_map(|s| (0..s.rows.len() as u64).map(move |i| s.tick + i)).collect()
    }

    /// Stretches with an exact row count: short gaps are counted exactly, other boundaries are not.
    pub(super) fn unbroken(&self) -> Vec<Range<usize>> {
        let mut stretches: Vec<Range<usize>> = Vec::new();
        for segment in &self.segments {
            let counted = segment.boundary == Boundary::Gap && segment.missing_before <= EXACT_MISSING;
            match stretches.last_mut() {
                Some(last) if counted => last.end = segment.rows.end,
                _ => stretches.push(segment.rows.clone()),
            }
        }
        stretches
    }
}

/// Segments that begin after a pause at a regular interval, and the usual burst and pause, in samples; `None` if the
/// pauses are irregular.
pub(super) fn regular_pauses(segments: &[Segment], period_s: f64) -> Option<(Vec<usize>, [f64; 2])> {
    let is_wait = |segment: &Segment| {
        matches!(segment.boundary, Boundary::Gap | Boundary::Pause)
            && segment.missing_before as f64 * period_s >= SHORTEST_PAUSE_S
    };
    let waits: Vec<usize> = (1..segments.len()).filter(|place| is_wait(&segments[*place])).collect();
    if waits.len() < MIN_PAUSES {
        return None;
    }
    let length = |wait: usize| segments[wait].missing_before as f64;
    let lengths: Vec<f64> = waits.iter().map(|wait| length(*wait)).collect();
    // from the end of a pause to the start of the next, losses within the burst included
    let bursts = waits.windows(2).map(|pair| (segments[pair[1]].tick - segments[pair[0]].tick) as f64);
    let bursts: Vec<f64> = bursts.zip(&lengths[1..]).map(|(every, wait)| every - wait).collect();
    let (usual_wait, usual_burst) = (median(&mut lengths.clone()), median(&mut bursts.clone()));
    let is_similar = |value: f64, usual: f64| value < SIMILAR * usual && usual < SIMILAR * value;
    let share = |values: &[f64], usual: f64| {
        values.iter().filter(|value| is_similar(**value, usual)).count() as f64 / values.len() as f64
    };
    let is_regular = share(&lengths, usual_wait).min(share(&bursts, usual_burst)) >= REGULAR_SHARE;
    let pauses: Vec<usize> = waits.into_iter().filter(|wait| is_similar(length(*wait), usual_wait)).collect();
    is_regular.then_some((pauses, [usual_burst, usual_wait]))
}

//! Finds missing samples from timestamps alone, by the rule documented at [`Segment`](super::Segment).

use std::ops::Range;

use super::grid::{Boundary, Grid, Mark, Segment};
use super::rate::{FirstLook, MAD_TO_SD, Stamps, median};

/// Shortest interval examined, periods. With jitter of sd 0.2 T, 0.4 % of single missing samples make a shorter one;
/// these are found at a neighbouring row.
const SUSPECT_WAIT: f64 = 1.25;

/// Number of standard deviations of jitter by which an interval must exceed T to be a gap for certain.
const OBVIOUS_SIGMAS: f64 = 6.0;

/// Rise of the level from which a sample is missing, periods: jittered timestamps, bursts.
const RISE_JITTERED: f64 = 0.5;
const RISE_BURSTS: f64 = 0.75;

/// Minimum ratio of the rise to its own scatter, so that a log of a million rows has no false gap.
const RISE_SIGMAS: f64 = 6.0;

/// Number of suspects at which the scatter of the rise is measured in logs with bursts; more do not improve it.
const RISES_SAMPLED: usize = 1000;

/// Number of rows in which a host works off its backlog, per sample period of its absence.
const CATCH_UP: f64 = 8.0;

/// Minimum and maximum number of rows that determine a level: jittered timestamps, bursts.
const ROWS_JITTERED: (f64, f64) = (16.0, 64.0);
const ROWS_BURSTS: (f64, f64) = (64.0, 4096.0);

/// Share of its window from which an envelope is reliable at the end of a log. With fewer rows the rise must exceed that
/// of ten mean bursts.
const ENVELOPE_SHARE: f64 = 0.25;
const BURSTS_AT_END: f64 = 10.0;

/// Maximum number of missing samples in one gap, 150 years at 200 Hz: beyond it the timestamps are nonsense, and ticks
/// must not overflow.
const MAX_MISSING: f64 = 1e12;

/// Finds all boundaries. `marks` are in order of rows, at most one per row.
pub(super) fn find(time_s: &[f64], look: &FirstLook, marks: &[Mark]) -> Grid {
    let mut search = Search::new(time_s, look, marks);
    let mut marks = marks.iter().peekable();
    let mut row = 1;
    // terminates: `place` may go back to half a window before `row`, but no further than the last boundary, and then a
    // boundary is accepted behind that one; without a boundary it is a row further
    while row < time_s.len() {
        while search.settled.len() < row {
            search.settle();
        }
        if let Some(mark) = marks.next_if(|mark| mark.row == row) {
            search.accept_mark(mark);
        } else if search.steps_back(row) {
            search.grid.clock_back += 1;
            if search.rise(row) < -RISE_JITTERED {
                search.accept(row, Boundary::ClockBack, 0);
            }
        } else if search.wait(row) >= SUSPECT_WAIT && search.missing(row) > 0 {
            row = search.place(row);
        }
        row += 1;
    }
    search.finish()
}

struct Search<'a> {
    time_s: &'a [f64],
    period_s: f64,
    bursts: bool,
    /// Number of rows that determine a level.
    window: usize,
    /// Interval that is certainly a gap, periods.
    obvious_wait: f64,
    /// Scatter of single timestamps, periods (jittered timestamps).
    scatter: f64,
    /// Scatter of the rise where nothing is missing, periods (bursts).
    rise_scatter: f64,
    /// Mean number of rows from one long interval to the next (bursts).
    burst_rows: f64,
    marks: &'a [Mark],
    /// Lateness of the rows processed so far, with the gaps so far subtracted, s.
    settled: Vec<f64>,
    /// Lateness subtracted so far, s.
    offset_s: f64,
    grid: Grid,
}

impl<'a> Search<'a> {
    fn new(time_s: &'a [f64], look: &FirstLook, marks: &'a [Mark]) -> Search<'a> {
        let bursts = look.stamps == Stamps::Bursts;
        let window = if bursts {
            (16.0 * look.burst_rows).clamp(ROWS_BURSTS.0, ROWS_BURSTS.1)
        } else {
            // a median of w timestamps scatters by 1.25 σ / √w: for a rise of T/2 to be seven of the difference's
            (612.0 * look.scatter * look.scatter).clamp(ROWS_JITTERED.0, ROWS_JITTERED.1)
        };
        let sd_of_wait = std::f64::consts::SQRT_2 * look.scatter;
        let start = Segment { rows: 0..0, tick: 0, missing_before: 0, boundary: Boundary::Start };
        let mut search = Search {
            time_s,
            period_s: look.period_s,
            bursts,
            window: window as usize,
            obvious_wait: 1.0 + (OBVIOUS_SIGMAS * sd_of_wait).max(0.5),
            scatter: look.scatter,
            rise_scatter: 0.0,
            burst_rows: look.burst_rows,
            marks,
            settled: Vec::with_capacity(time_s.len()),
            offset_s: 0.0,
            grid: Grid { segments: vec![start], clock_back: 0 },
        };
        if bursts {
            search.rise_scatter = search.scatter_of_rises();
        }
        search
    }

    /// Scatter of the rise over the long intervals of the log, few of which are gaps, periods.
    fn scatter_of_rises(&self) -> f64 {
        let rows = self.window..self.time_s.len().saturating_sub(self.window);
        let suspects: Vec<usize> = rows.filter(|&row| self.wait(row) >= SUSPECT_WAIT).collect();
        let step = suspects.len().div_ceil(RISES_SAMPLED).max(1);
        let mut rises: Vec<f64> =
            suspects.into_iter().step_by(step).map(|row| self.rise_ahead(row).abs()).collect();
        MAD_TO_SD * median(&mut rises)
    }

    /// Interval before `row`, periods.
    fn wait(&self, row: usize) -> f64 {
        (self.time_s[row] - self.time_s[row - 1]) / self.period_s
    }

    fn steps_back(&self, row: usize) -> bool {
        self.wait(row) < -1.0
    }

    /// Lateness of a row not yet processed, s.
    fn late(&self, row: usize) -> f64 {
        (self.time_s[row] - self.time_s[0]) - self.period_s * row as f64 - self.offset_s
    }

    /// Marks the next row as processed.
    fn settle(&mut self) {
        let late = self.late(self.settled.len());
        self.settled.push(late);
    }

    /// Level of the lateness of `rows`, given by `late`.
    fn level(&self, rows: Range<usize>, late: impl Fn(usize) -> f64) -> f64 {
        if self.bursts {
            let first = rows.start;
            // time cannot run backward as rows arrive: such a timestamp is wrong
            rows.filter(|&i| i == first || self.time_s[i] >= self.time_s[i - 1])
                .map(late)
                .fold(f64::INFINITY, f64::min)
        } else {
            median(&mut rows.map(late).collect::<Vec<_>>())
        }
    }

    /// Rise of the level from before `row` to after it, periods. All rows before must be settled.
    fn rise(&self, row: usize) -> f64 {
        let before = self.level(row.saturating_sub(self.window_at(row))..row, |i| self.settled[i]);
        let after = self.level(row..self.end_of_window(row), |i| self.late(i));
        (after - before) / self.period_s
    }

    /// Rise at a row preceded by rows that are not settled yet.
    fn rise_ahead(&self, row: usize) -> f64 {
        let late = |i: usize| self.settled.get(i).copied().unwrap_or_else(|| self.late(i));
        // rows before a pause that is not settled yet are earlier by all of it
        let begin = row.saturating_sub(self.window_at(row)).max(self.last_pause(row).unwrap_or(0));
        let before = self.level(begin..row, late);
        let after = self.level(row..self.end_of_window(row), late);
        (after - before) / self.period_s
    }

    /// Number of rows that determine the levels before and after `row`.
    fn window_at(&self, row: usize) -> usize {
        if !self.bursts {
            return self.window;
        }
        self.window.max((CATCH_UP * self.wait(row)).min(ROWS_BURSTS.1) as usize)
    }

    /// End of the rows whose level is compared with that before `row`.
    fn end_of_window(&self, row: usize) -> usize {
        let end = (row + self.window_at(row)).min(self.time_s.len()).min(self.next_mark(row));
        // a timestamp that is wrong for one row returns with a long interval, which is no gap
        if self.bursts || self.steps_back(row) {
            return end;
        }
        (row + 1..end).find(|&i| self.wait(i) >= self.obvious_wait).unwrap_or(end)
    }

    fn next_mark(&self, row: usize) -> usize {
        let next = self.marks.partition_point(|mark| mark.row <= row);
        self.marks.get(next).map_or(self.time_s.len(), |mark| mark.row)
    }

    /// First row after the last pause before `row`.
    fn last_pause(&self, row: usize) -> Option<usize> {
        let before = &self.marks[..self.marks.partition_point(|mark| mark.row < row)];
        before.iter().rfind(|mark| mark.boundary == Boundary::Pause).map(|mark| mark.row)
    }

    /// Rise at `row` from which samples are missing, periods.
    fn needed_rise(&self, row: usize) -> f64 {
        let rows_after = self.end_of_window(row) - row;
        if self.bursts {
            let end = row + rows_after;
            let is_pause = |mark: &Mark| mark.row == end && mark.boundary == Boundary::Pause;
            let next = self.marks.partition_point(|mark| mark.row <= row);
            let ends = end == self.time_s.len() || self.marks.get(next).is_some_and(is_pause);
            let few = |rows: usize| (rows as f64) < ENVELOPE_SHARE * self.window_at(row) as f64;
            let at_end =
                ends && few(rows_after) || self.last_pause(row).is_some_and(|begin| few(row - begin));
            let end_effect = if at_end { BURSTS_AT_END * self.burst_rows } else { 0.0 };
            return RISE_BURSTS.max(RISE_SIGMAS * self.rise_scatter).max(end_effect);
        }
        // a median of w values scatters by 1.25 σ / √w
        let rows_before = row.min(self.window_at(row));
        let parts = 1.0 / rows_before as f64 + 1.0 / rows_after as f64;
        RISE_JITTERED.max(RISE_SIGMAS * 1.25 * self.scatter * parts.sqrt())
    }

    /// Number of samples missing at `row`, from the rise of the level there.
    fn count(&self, row: usize, rise: f64) -> u64 {
        if rise > self.needed_rise(row) { rise.round().clamp(1.0, MAX_MISSING) as u64 } else { 0 }
    }

    fn missing(&self, row: usize) -> u64 {
        self.count(row, self.rise(row))
    }

    /// Places a gap detected at `row` where it fits best, and accepts it. Returns the last row processed.
    fn place(&mut self, row: usize) -> usize {
        crate::interrupt::check();
        let at = if self.bursts { self.place_in_bursts(row) } else { self.place_in_jitter(row) };
        let missing = self.count(at, self.rise_ahead(at));
        if missing == 0 {
            return row;
        }
        self.settled.truncate(at);
        while self.settled.len() < at {
            self.settle();
        }
        self.accept(at, Boundary::Gap, missing);
        at
    }

    /// Row from which the level after fits better than the level before: least sum of absolute deviations.
    fn place_in_jitter(&self, row: usize) -> usize {
        let half = self.window / 2;
        let segment_start = self.grid.segments.last().map_or(0, |segment| segment.rows.start);
        let from = row.saturating_sub(half).max(segment_start + 1);
        let to = self.end_of_window(row).max(row + 1);
        let late = |i: usize| self.settled.get(i).copied().unwrap_or_else(|| self.late(i));
        let before = self.level(row.saturating_sub(self.window_at(row))..row, late);
        let after = before + self.missing(row) as f64 * self.period_s;
        let (mut cost, mut best) = (0.0, (f64::INFINITY, row));
        for at in from..to {
            if self.wait(at) >= 1.0 && cost < best.0 {
                best = (cost, at);
            }
            cost += (late(at) - before).abs() - (late(at) - after).abs();
        }
        best.1
    }

    /// Longest interval between the row where the level has risen fully and the first fresh row after it.
    fn place_in_bursts(&self, row: usize) -> usize {
        let end = (row + self.window_at(row)).min(self.next_mark(row));
        let suspects = (row..end).filter(|&i| self.wait(i) >= SUSPECT_WAIT && !self.steps_back(i));
        // the last burst before the gap may show a part of the rise already
        let (mut highest, mut at) = (f64::NEG_INFINITY, row);
        for suspect in suspects {
            let rise = self.rise_ahead(suspect);
            if rise > highest + 0.5 {
                (highest, at) = (rise, suspect);
            }
        }
        // no row from `at` on is too early to come after the gap, for `at` is where the level has risen
        let after = self.level(at..self.end_of_window(at), |i| self.late(i));
        let fresh = (at..end).find(|&i| self.late(i) < after + self.period_s).unwrap_or(at);
        (at..=fresh).max_by(|&a, &b| self.wait(a).total_cmp(&self.wait(b))).unwrap_or(at)
    }

    /// Accepts a known boundary; the timestamps may show that more samples are missing.
    fn accept_mark(&mut self, mark: &Mark) {
        let rise = self.rise(mark.row);
        let back = self.steps_back(mark.row) && rise < -RISE_JITTERED;
        self.grid.clock_back += u64::from(back);
        let missing = match mark.boundary {
            Boundary::Pause => rise.round().clamp(1.0, MAX_MISSING) as u64,
            _ => self.count(mark.row, rise),
        };
        self.accept(mark.row, mark.boundary, mark.missing.max(missing));
    }

    fn accept(&mut self, row: usize, boundary: Boundary, missing_before: u64) {
        self.offset_s += self.rise(row) * self.period_s;
        let segments = &mut self.grid.segments;
        let (mut tick, mut start) = (0, 0);
        if let Some(last) = segments.last_mut() {
            last.rows.end = row;
            start = last.rows.start;
            tick = last.tick;
        }
        let tick = tick + (row - start) as u64 + missing_before;
        segments.push(Segment { rows: row..row, tick, missing_before, boundary });
    }

    fn finish(mut self) -> Grid {
        if let Some(last) = self.grid.segments.last_mut() {
            last.rows.end = self.time_s.len();
        }
        self.grid
    }
}

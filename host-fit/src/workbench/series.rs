//! A time series for display: every sample where there is room, else the lowest and highest of each bucket of time.

use std::ops::Range;

use serde::Serialize;

use fos_data::recording::Recording;
use fos_fit::evaluate::{AxisTrace, Trace};

/// What is shown beside the measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub(super) enum ViewKind {
    /// Predictions from the sample before.
    OneStep,
    /// Predictions from the model's own history, anew every 60 s.
    Coast,
    /// The same in means over 1 s.
    Slow,
}

/// Length of the means of the slow view, s.
const SLOW_S: f64 = 1.0;

/// Most buckets that are given at once.
pub(super) const WIDEST: usize = 8192;

/// A stretch of a time series.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Series {
    pub(super) from_s: f64,
    pub(super) to_s: f64,
    /// Of the samples, or of the means.
    pub(super) period_s: f64,
    /// Every sample is there; else each entry is a bucket.
    pub(super) exact: bool,
    /// Stamps, or middles of buckets, s.
    pub(super) time_s: Vec<f64>,
    /// As logged, less the reference where there is one.
    pub(super) measured: LowAndHigh,
    /// Measured less what is left; none without a model.
    pub(super) predicted: Option<LowAndHigh>,
    /// What is left.
    pub(super) left: Option<LowAndHigh>,
}

/// The lowest and the highest of each bucket; `None` where there is nothing. In f32, which keeps seven digits: more
/// than a screen shows, half the size of what a browser has to read.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct LowAndHigh {
    pub(super) low: Vec<Option<f32>>,
    pub(super) high: Vec<Option<f32>>,
}

impl LowAndHigh {
    fn push(&mut self, (low, high): (f64, f64)) {
        // a bucket without a finite value has a low above its high
        let known = low <= high;
        self.low.push(known.then_some(low as f32));
        self.high.push(known.then_some(high as f32));
    }
}

/// The values of an axis, row by row of the recording.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) recording: &'a Recording,
    pub(super) measured: &'a [f64],
    pub(super) reference: Option<&'a [f64]>,
    /// What is left, and which axis of it.
    pub(super) trace: Option<(&'a Trace, &'a AxisTrace)>,
}

impl Rows<'_> {
    fn measured(&self, row: usize) -> f64 {
        self.measured[row] - self.reference.map_or(0.0, |reference| reference[row])
    }

    fn left(&self, row: usize, kind: ViewKind) -> f64 {
        let Some((trace, axis)) = self.trace else { return f64::NAN };
        if !trace.rows.contains(&row) {
            return f64::NAN;
        }
        let at = row - trace.rows.start;
        match kind {
            ViewKind::OneStep => axis.one_step[at],
            ViewKind::Coast | ViewKind::Slow => axis.coast[at],
        }
    }
}

/// What there is of `rows` from `from_s` to `to_s`, in at most `width` entries.
pub(super) fn series(rows: Rows<'_>, kind: ViewKind, from_s: f64, to_s: f64, width: usize) -> Series {
    let width = width.clamp(2, WIDEST);
    let period_s = rows.recording.rate.period_s;
    let entries = match kind {
        ViewKind::Slow => means(rows, kind, from_s, to_s),
        _ => samples(rows, kind, from_s, to_s),
    };
    let period_s = if kind == ViewKind::Slow { SLOW_S.max(period_s) } else { period_s };
    let exact = entries.len() <= width;
    let mut shown = Series {
        from_s,
        to_s,
        period_s,
        exact,
        time_s: Vec::new(),
        measured: LowAndHigh::default(),
        predicted: rows.trace.map(|_| LowAndHigh::default()),
        left: rows.trace.map(|_| LowAndHigh::default()),
    };
    if exact {
        let mut before: Option<&Entry> = None;
        for entry in &entries {
            // a break between two pieces, so that no line is drawn across
            if let Some(before) = before.filter(|before| before.segment != entry.segment) {
                shown.push(0.5 * (before.time_s + entry.time_s), &Bucket::EMPTY);
            }
            shown.push(entry.time_s, &Bucket::EMPTY.with(entry));
            before = Some(entry);
        }
        return shown;
    }
    // buckets of equal time, each entry in exactly one
    let length = (to_s - from_s) / width as f64;
    let mut buckets = vec![Bucket::EMPTY; width];
    for entry in &entries {
        let place = (((entry.time_s - from_s) / length) as usize).min(width - 1);
        buckets[place] = buckets[place].with(entry);
    }
    for (place, bucket) in buckets.iter().enumerate() {
        shown.push(from_s + (place as f64 + 0.5) * length, bucket);
    }
    shown
}

impl Series {
    fn push(&mut self, time_s: f64, bucket: &Bucket) {
        self.time_s.push(time_s);
        self.measured.push(bucket.measured);
        if let Some(predicted) = &mut self.predicted {
            predicted.push(bucket.predicted);
        }
        if let Some(left) = &mut self.left {
            left.push(bucket.left);
        }
    }
}

/// The lowest and highest finite value of each; above one another where there is none.
#[derive(Debug, Clone, Copy)]
struct Bucket {
    measured: (f64, f64),
    predicted: (f64, f64),
    left: (f64, f64),
}

impl Bucket {
    const NOTHING: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);
    const EMPTY: Self = Self { measured: Self::NOTHING, predicted: Self::NOTHING, left: Self::NOTHING };

    fn with(self, entry: &Entry) -> Self {
        let wider = |(low, high): (f64, f64), value: f64| match value.is_finite() {
            true => (low.min(value), high.max(value)),
            false => (low, high),
        };
        Self {
            measured: wider(self.measured, entry.measured),
            predicted: wider(self.predicted, entry.measured - entry.left),
            left: wider(self.left, entry.left),
        }
    }
}

/// A sample, or a mean.
#[derive(Debug, Clone, Copy)]
struct Entry {
    time_s: f64,
    measured: f64,
    left: f64,
    /// Which piece of the recording it is in.
    segment: usize,
}

fn samples(rows: Rows<'_>, kind: ViewKind, from_s: f64, to_s: f64) -> Vec<Entry> {
    let mut entries = Vec::new();
    for (segment, piece) in rows.recording.segments.iter().enumerate() {
        for row in within(rows.recording, piece.rows.clone(), from_s, to_s) {
            let (measured, left) = (rows.measured(row), rows.left(row, kind));
            entries.push(Entry { time_s: rows.recording.time_s[row], measured, left, segment });
        }
    }
    entries
}

/// Means over the seconds of each piece, of the samples that are known.
fn means(rows: Rows<'_>, kind: ViewKind, from_s: f64, to_s: f64) -> Vec<Entry> {
    let per_block = ((SLOW_S / rows.recording.rate.period_s).round() as usize).max(1);
    let mut entries = Vec::new();
    for (segment, piece) in rows.recording.segments.iter().enumerate() {
        // blocks lie on the piece, not on the window: panning does not change them
        for first in piece.rows.clone().step_by(per_block) {
            let block = first..(first + per_block).min(piece.rows.end);
            let time_s = rows.recording.time_s[block.start + (block.len() - 1) / 2];
            if !(from_s..=to_s).contains(&time_s) {
                continue;
            }
            let mean = |value: &dyn Fn(usize) -> f64| {
                let finite = block.clone().map(value).filter(|value| value.is_finite());
                let (sum, count) = finite.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
                if count == 0 { f64::NAN } else { sum / f64::from(count) }
            };
            let measured = mean(&|row| rows.measured(row));
            let left = mean(&|row| rows.left(row, kind));
            entries.push(Entry { time_s, measured, left, segment });
        }
    }
    entries
}

/// The rows of a piece whose stamps lie in the window; stamps increase within a piece but for jitter.
fn within(recording: &Recording, piece: Range<usize>, from_s: f64, to_s: f64) -> impl Iterator<Item = usize> {
    piece.filter(move |row| (from_s..=to_s).contains(&recording.time_s[*row]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_data::recording::{LoadOptions, Source};

    fn log(rows: usize, gap_at: usize) -> Recording {
        let time: Vec<f64> =
            (0..rows).map(|n| n as f64 * 0.005 + if n >= gap_at { 2.0 } else { 0.0 }).collect();
        let values: Vec<f64> = (0..rows).map(|n| ((n * n) % 977) as f64 - 400.0).collect();
        let columns = vec![("t_s".to_owned(), time), ("gx_rads".to_owned(), values)];
        Recording::from_columns(Source::made_by("a test"), columns, &LoadOptions::default()).unwrap()
    }

    fn of(log: &Recording) -> Rows<'_> {
        let measured = &log.channel("gx_rads").unwrap().values;
        Rows { recording: log, measured, reference: None, trace: None }
    }

    #[test]
    fn no_peak_is_lost_at_any_width() {
        for width in [2, 7, 100, 1999] {
            let mut log = log(20_000, 5_000);
            for spike in [0, 4_999, 5_000, 12_345, 19_999] {
                let mut values = vec![0.0; 20_000];
                values[spike] = 7.0;
                log = log.with_values("gx_rads", values);
                let shown = series(of(&log), ViewKind::OneStep, 0.0, 102.0, width);
                let high: f32 = shown.measured.high.iter().flatten().sum();
                assert_eq!(high, 7.0, "the spike at {spike} lies in exactly one of {width} buckets");
                assert!(!shown.exact && shown.time_s.len() == width);
            }
        }
    }

    #[test]
    fn single_samples_are_given_as_they_are_and_a_gap_breaks_the_line() {
        let log = log(1_000, 500);
        let shown = series(of(&log), ViewKind::Coast, 2.49, 4.51, 2_000);
        assert!(shown.exact);
        // 2.490, 2.495, the break, 4.500, 4.505, 4.510
        assert_eq!(shown.time_s.len(), 6);
        assert_eq!(shown.measured.low, shown.measured.high);
        assert_eq!(shown.measured.low[2], None);
        let values = &log.channel("gx_rads").unwrap().values;
        assert_eq!(shown.measured.low[0], Some(values[498] as f32));
        assert_eq!(shown.predicted, None);
    }

    #[test]
    fn a_gap_wider_than_a_bucket_is_empty() {
        let log = log(20_000, 5_000);
        let shown = series(of(&log), ViewKind::OneStep, 0.0, 102.0, 200);
        let empty = shown.measured.low.iter().filter(|low| low.is_none()).count();
        // 2 s of 102 in 200 buckets: about four, less what hangs over at both ends
        assert!((2..=4).contains(&empty), "{empty}");
    }

    #[test]
    fn slow_means_are_direct_averages_and_stay_while_panning() {
        let log = log(20_000, 20_000);
        let values = &log.channel("gx_rads").unwrap().values;
        let shown = series(of(&log), ViewKind::Slow, 10.0, 20.0, 1_000);
        let direct = values[2000..2200].iter().sum::<f64>() / 200.0;
        let place = shown.time_s.iter().position(|time| (10.4..10.6).contains(time)).unwrap();
        assert_eq!(shown.measured.low[place], Some(direct as f32));
        let panned = series(of(&log), ViewKind::Slow, 10.3, 20.3, 1_000);
        assert!(panned.measured.low.contains(&Some(direct as f32)));
    }

    #[test]
    fn what_is_predicted_and_left_add_up_to_what_is_measured() {
        let log = log(2_000, 2_000);
        let left: Vec<f64> = (0..1_000).map(|n| f64::from(n % 7)).collect();
        let axis = AxisTrace { one_step: left.clone(), coast: left, ..AxisTrace::default() };
        let trace = Trace { rows: 1_000..2_000, period_s: 0.005, stretches: Vec::new(), axes: Vec::new() };
        let rows = Rows { trace: Some((&trace, &axis)), ..of(&log) };
        let shown = series(rows, ViewKind::OneStep, 0.0, 10.0, 4_000);
        let (left, predicted) = (shown.left.unwrap(), shown.predicted.unwrap());
        assert_eq!(left.low[999], None, "not judged");
        for at in 1_000..2_000 {
            assert_eq!(predicted.low[at].unwrap() + left.low[at].unwrap(), shown.measured.low[at].unwrap());
        }
    }
}

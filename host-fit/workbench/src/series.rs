//! Time series for display: every sample where there is room, else minimum and maximum of each bucket of time.

use serde::Serialize;

use fos_data::column::Column;
use fos_data::recording::Recording;
use fos_fit::evaluate::{AxisTrace, Trace};

/// Predictions that are shown with the measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub(super) enum ViewKind {
    /// One-step predictions.
    OneStep,
    /// Free run that restarts from measured history every 60 s.
    Coast,
    /// Means of the same free run.
    Slow,
}

/// Channels that are drawn below on the same time axis, where they are logged, and their names.
const BESIDE: [(&str, &str); 2] = [("temp_c", "temperature"), ("supply_v", "supply voltage")];

/// Largest number of buckets in an answer.
pub(super) const WIDEST: usize = 8192;

/// A stretch of a time series.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Series {
    pub(super) from_s: f64,
    pub(super) to_s: f64,
    /// Period of the samples or of the means, s.
    pub(super) period_s: f64,
    /// Length of the means, s; none for samples.
    pub(super) mean_s: Option<f64>,
    /// True if every sample is included; otherwise each entry is a bucket.
    pub(super) exact: bool,
    /// Timestamps, or middles of buckets, s.
    pub(super) time_s: Vec<f64>,
    /// Logged value, minus the reference where there is one.
    pub(super) measured: LowAndHigh,
    /// Measured value minus residual; none without a model.
    pub(super) predicted: Option<LowAndHigh>,
    /// Residual; none without a model.
    pub(super) left: Option<LowAndHigh>,
    /// The same two with the model before any effect was added; none if no effect was added.
    pub(super) predicted_before: Option<LowAndHigh>,
    pub(super) left_before: Option<LowAndHigh>,
    /// Temperature and supply voltage, where they are logged.
    pub(super) beside: Vec<Beside>,
}

/// Channel that is drawn below on the same time axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(super) struct Beside {
    pub(super) column: String,
    pub(super) label: String,
    pub(super) unit: &'static str,
    pub(super) values: LowAndHigh,
}

/// Minimum and maximum of each bucket; `None` without values. An f32 has seven digits, more than a screen shows, and
/// half the size for the browser to read.
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

/// Values of an axis, row by row of the recording.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) recording: &'a Recording,
    pub(super) measured: &'a [f64],
    pub(super) reference: Option<&'a [f64]>,
    /// Trace of the present model, and the axis in it.
    pub(super) trace: Option<(&'a Trace, &'a AxisTrace)>,
    /// The same of the model before any effect was added.
    pub(super) before: Option<(&'a Trace, &'a AxisTrace)>,
}

/// View, and length of its means.
#[derive(Debug, Clone, Copy)]
pub(super) struct Joined {
    pub(super) kind: ViewKind,
    /// Length of the means of the slow view, s.
    pub(super) mean_s: f64,
}

type OfAxis<'a> = Option<(&'a Trace, &'a AxisTrace)>;

impl Rows<'_> {
    fn measured(&self, row: usize) -> f64 {
        self.measured[row] - self.reference.map_or(0.0, |reference| reference[row])
    }

    /// Returns the residual with a model; NaN where it is unknown.
    fn left(of: OfAxis<'_>, row: usize, kind: ViewKind) -> f64 {
        let Some((trace, axis)) = of else { return f64::NAN };
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

/// Returns the part of `rows` from `from_s` to `to_s`, in at most `width` entries and a break at each gap.
pub(super) fn series(rows: Rows<'_>, joined: Joined, from_s: f64, to_s: f64, width: usize) -> Series {
    let width = width.clamp(2, WIDEST);
    let Joined { kind, mean_s } = joined;
    let period_s = rows.recording.rate.period_s;
    let beside: Vec<_> =
        BESIDE.iter().filter_map(|(column, _)| rows.recording.channel(column).ok()).collect();
    // copies a whole channel for each window only where cells are missing
    let held: Vec<_> = beside.iter().map(|channel| rows.recording.held_from_first(channel)).collect();
    let values = |row: usize| {
        let of_beside = |at: usize| held.get(at).map_or(f64::NAN, |values| values[row]);
        let left = Rows::left(rows.trace, row, kind);
        [rows.measured(row), left, Rows::left(rows.before, row, kind), of_beside(0), of_beside(1)]
    };
    let per_entry = match kind {
        ViewKind::Slow => ((mean_s / period_s).round() as usize).max(1),
        _ => 1,
    };
    let entries = entries(rows.recording, per_entry, values, from_s, to_s);
    let exact = entries.len() <= width;
    let mut columns: [LowAndHigh; DRAWN] = std::array::from_fn(|_| LowAndHigh::default());
    let mut time_s = Vec::new();
    let mut push = |time: f64, bucket: &Bucket| {
        time_s.push(time);
        for (column, values) in columns.iter_mut().zip(bucket) {
            column.push(*values);
        }
    };
    if exact {
        let mut before: Option<&Entry> = None;
        for entry in &entries {
            // a break between two pieces, so that no line is drawn across
            if let Some(before) = before.filter(|before| before.segment != entry.segment) {
                push(0.5 * (before.time_s + entry.time_s), &NOTHING);
            }
            let mut bucket = NOTHING;
            entry.widen(&mut bucket);
            push(entry.time_s, &bucket);
            before = Some(entry);
        }
    } else {
        // buckets of equal time, each entry in exactly one
        let length = (to_s - from_s) / width as f64;
        let mut buckets = vec![NOTHING; width];
        for entry in &entries {
            let place = (((entry.time_s - from_s) / length) as usize).min(width - 1);
            entry.widen(&mut buckets[place]);
        }
        for (place, bucket) in buckets.iter().enumerate() {
            push(from_s + (place as f64 + 0.5) * length, bucket);
        }
    }
    let [measured, left, left_before, first, second, predicted, predicted_before] = columns;
    let beside = beside.iter().zip([first, second]).map(|(channel, values)| {
        let unit = Column::named(&channel.name).unit().label();
        let label = BESIDE.iter().find(|(column, _)| *column == channel.name).map_or("", |(_, label)| label);
        Beside { column: channel.name.clone(), label: label.to_owned(), unit, values }
    });
    let beside = beside.collect();
    let is_slow = kind == ViewKind::Slow;
    Series {
        from_s,
        to_s,
        period_s: if is_slow { per_entry as f64 * period_s } else { period_s },
        mean_s: is_slow.then_some(mean_s),
        exact,
        time_s,
        measured,
        predicted: rows.trace.map(|_| predicted),
        left: rows.trace.map(|_| left),
        predicted_before: rows.before.map(|_| predicted_before),
        left_before: rows.before.map(|_| left_before),
        beside,
    }
}

/// Values of an entry: measured, residual, residual before any effect was added, and the channels beside.
const VALUES: usize = 3 + BESIDE.len();

/// Number of drawn values: those of an entry, and the predictions that follow from them.
const DRAWN: usize = VALUES + 2;

/// Minimum and maximum of the finite values of each; the minimum is above the maximum where there is none.
type Bucket = [(f64, f64); DRAWN];

const NOTHING: Bucket = [(f64::INFINITY, f64::NEG_INFINITY); DRAWN];

/// A sample, or a mean.
#[derive(Debug, Clone, Copy)]
struct Entry {
    time_s: f64,
    values: [f64; VALUES],
    /// Index of the segment of the recording.
    segment: usize,
}

impl Entry {
    /// Widens the range of each value of a bucket by those of this entry.
    fn widen(&self, bucket: &mut Bucket) {
        let [measured, left, left_before, ..] = self.values;
        let predicted = [measured - left, measured - left_before];
        for (range, value) in bucket.iter_mut().zip(self.values.into_iter().chain(predicted)) {
            if value.is_finite() {
                *range = (range.0.min(value), range.1.max(value));
            }
        }
    }
}

/// Returns the means of the known values over blocks of `per_entry` rows of each segment.
fn entries(
    recording: &Recording,
    per_entry: usize,
    values: impl Fn(usize) -> [f64; VALUES],
    from_s: f64,
    to_s: f64,
) -> Vec<Entry> {
    let mut entries = Vec::new();
    for (segment, piece) in recording.segments.iter().enumerate() {
        // blocks lie on the piece, not on the window: panning does not change them
        for first in piece.rows.clone().step_by(per_entry) {
            let block = first..(first + per_entry).min(piece.rows.end);
            let time_s = recording.time_s[block.start + (block.len() - 1) / 2];
            if !(from_s..=to_s).contains(&time_s) {
                continue;
            }
            let mut sums = [(0.0, 0_u32); VALUES];
            for row in block {
                for (sum, value) in sums.iter_mut().zip(values(row)).filter(|(_, value)| value.is_finite()) {
                    *sum = (sum.0 + value, sum.1 + 1);
                }
            }
            let mean = |(sum, count): (f64, u32)| if count == 0 { f64::NAN } else { sum / f64::from(count) };
            entries.push(Entry { time_s, values: sums.map(mean), segment });
        }
    }
    entries
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
        Rows { recording: log, measured, reference: None, trace: None, before: None }
    }

    fn by(kind: ViewKind) -> Joined {
        Joined { kind, mean_s: 1.0 }
    }

    #[test]
    fn no_peak_is_lost_at_any_width() {
        for width in [2, 7, 100, 1999] {
            let mut log = log(20_000, 5_000);
            for spike in [0, 4_999, 5_000, 12_345, 19_999] {
                let mut values = vec![0.0; 20_000];
                values[spike] = 7.0;
                log = log.with_values("gx_rads", values);
                let shown = series(of(&log), by(ViewKind::OneStep), 0.0, 102.0, width);
                let high: f32 = shown.measured.high.iter().flatten().sum();
                assert_eq!(high, 7.0, "the spike at {spike} lies in exactly one of {width} buckets");
                assert!(!shown.exact && shown.time_s.len() == width);
            }
        }
    }

    #[test]
    fn single_samples_are_given_as_they_are_and_a_gap_breaks_the_line() {
        let log = log(1_000, 500);
        let shown = series(of(&log), by(ViewKind::Coast), 2.49, 4.51, 2_000);
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
        let shown = series(of(&log), by(ViewKind::OneStep), 0.0, 102.0, 200);
        let empty = shown.measured.low.iter().filter(|low| low.is_none()).count();
        // 2 s of 102 in 200 buckets: about four, less what hangs over at both ends
        assert!((2..=4).contains(&empty), "{empty}");
    }

    #[test]
    fn slow_means_are_direct_averages_and_stay_while_panning() {
        let log = log(20_000, 20_000);
        let values = &log.channel("gx_rads").unwrap().values;
        let shown = series(of(&log), by(ViewKind::Slow), 10.0, 20.0, 1_000);
        let direct = values[2000..2200].iter().sum::<f64>() / 200.0;
        let place = shown.time_s.iter().position(|time| (10.4..10.6).contains(time)).unwrap();
        assert_eq!(shown.measured.low[place], Some(direct as f32));
        let panned = series(of(&log), by(ViewKind::Slow), 10.3, 20.3, 1_000);
        assert!(panned.measured.low.contains(&Some(direct as f32)));
    }

    #[test]
    fn prediction_and_residual_add_up_to_the_measurement() {
        let log = log(2_000, 2_000);
        let left: Vec<f64> = (0..1_000).map(|n| f64::from(n % 7)).collect();
        let axis = AxisTrace { one_step: left.clone(), coast: left, ..AxisTrace::default() };
        let trace = Trace {
            rows: 1_000..2_000,
            period_s: 0.005,
            stretches: Vec::new(),
            axes: Vec::new(),
            strapdown: None,
        };
        let rows = Rows { trace: Some((&trace, &axis)), ..of(&log) };
        let shown = series(rows, by(ViewKind::OneStep), 0.0, 10.0, 4_000);
        let (left, predicted) = (shown.left.unwrap(), shown.predicted.unwrap());
        assert_eq!(left.low[999], None, "not evaluated");
        for at in 1_000..2_000 {
            assert_eq!(predicted.low[at].unwrap() + left.low[at].unwrap(), shown.measured.low[at].unwrap());
        }
    }
}

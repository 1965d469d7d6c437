//! Residual against a delayed channel.

use serde::{Deserialize, Serialize};

use super::likelihood::{BlockResidual, Test};
use fos_data::recording::{Boundary, Recording};
use fos_fit::noise::{Blocks, Fitted, Gls, NoiseLevels};

/// Delays, s.
const DELAYS_S: [f64; 7] = [0.0, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];

pub(super) const N_DELAYS: usize = DELAYS_S.len();

/// Longest delay as a share of the log; beyond it too little of the channel remains.
const LONGEST_SHARE: f64 = 0.25;

/// Difference in gain up to which delays are indistinguishable from the best: 95 % point of χ²₁.
const INDISTINGUISHABLE: f64 = 3.84;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Delay {
    /// Delay, s.
    pub delay_s: f64,
    /// Increase of 2 ln L with the delayed channel as a linear term, at the same noise levels for all delays.
    pub gain: f64,
    /// Coefficient of the channel, in the axis' unit per unit of the channel.
    pub slope: f64,
    /// Standard error of the coefficient.
    pub slope_error: f64,
}

/// Gain by delay.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct LagProfile {
    pub delays: Vec<Delay>,
    /// Delay with the largest gain, s.
    pub best_s: f64,
    /// Shortest and longest delay that are indistinguishable from the best, s.
    pub possible_s: (f64, f64),
    /// Test of a linear term with the best delay, with the noise levels fitted.
    pub test: Test,
    /// p of the test, corrected for the number of delays (Bonferroni).
    pub p: f64,
}

/// Source rows of delayed columns in a recording, for every delay.
pub(super) struct Delays {
    shifts: [Shift; N_DELAYS],
}

/// Source rows for one delay, in pieces of consecutive rows.
struct Shift(Vec<Piece>);

/// Rows up to `end` whose source rows are consecutive, or are one held row.
#[derive(Debug, Clone, Copy)]
struct Piece {
    /// First row, and its source row.
    start: usize,
    from: usize,
    /// Increment of the source row: 1, or 0 if the value is held.
    step: usize,
    end: usize,
}

impl Piece {
    fn source(&self, row: usize) -> usize {
        self.from + (row - self.start) * self.step
    }
}

impl Delays {
    pub(super) fn new(recording: &Recording) -> Self {
        Self { shifts: DELAYS_S.map(|delay_s| Shift::new(recording, delay_s)) }
    }

    /// Returns the block means of a delayed column, by delay.
    pub(super) fn means(&self, blocks: &Blocks, column: &[f64]) -> [Vec<f64>; N_DELAYS] {
        let mut pieces = self.shifts.each_ref().map(|shift| shift.0.iter().copied());
        let mut now = pieces.each_mut().map(|pieces| pieces.next());
        let means = blocks.means_of(|row| {
            let mut values = [f64::NAN; N_DELAYS];
            for ((value, now), pieces) in values.iter_mut().zip(&mut now).zip(&mut pieces) {
                while now.is_some_and(|piece| piece.end <= row) {
                    *now = pieces.next();
                }
                if let Some(piece) = now {
                    *value = column[piece.source(row)];
                }
            }
            values
        });
        std::array::from_fn(|delay| means.iter().map(|means| means[delay]).collect())
    }
}

impl Shift {
    /// Before its recording begins a column has its first value; in a gap it has the last value before.
    fn new(recording: &Recording, delay_s: f64) -> Self {
        let delay = (delay_s / recording.rate.period_s).round() as u64;
        let segments = &recording.segments;
        let mut pieces: Vec<Piece> = Vec::new();
        // latest row that is not too late, and its segment
        let (mut from, mut within) = (0, 0);
        for segment in segments {
            if segment.boundary == Boundary::Recording {
                from = segment.rows.start;
            }
            for row in segment.rows.clone() {
                let tick = segment.tick + (row - segment.rows.start) as u64;
                while from < row {
                    while !segments[within].rows.contains(&(from + 1)) {
                        within += 1;
                    }
                    let of = &segments[within];
                    if of.tick + (from + 1 - of.rows.start) as u64 + delay > tick {
                        break;
                    }
                    from += 1;
                }
                match pieces.last_mut() {
                    Some(last) if last.source(row) == from => last.end = row + 1,
                    // the second row determines the increment
                    Some(last) if last.end == last.start + 1 && from == last.from => {
                        (last.step, last.end) = (0, row + 1);
                    }
                    _ => pieces.push(Piece { start: row, from, step: 1, end: row + 1 }),
                }
            }
        }
        Self(pieces)
    }
}

/// Computes the profile of a channel with the block means `delayed` by delay, under noise of `levels`. `None` if the
/// channel does not change.
pub(super) fn profile(
    residual: &BlockResidual<'_>,
    (null, levels): (&Fitted, &NoiseLevels),
    delayed: &[Vec<f64>; N_DELAYS],
) -> Option<LagProfile> {
    let blocks = residual.blocks;
    let span_s = blocks.middle_s(blocks.len() - 1) - blocks.middle_s(0);
    let ones = vec![1.0; blocks.len()];
    let alone = Gls::new(blocks, levels, residual.means, &[&ones]).deviance();
    let mut delays = Vec::new();
    let mut best: Option<(f64, &Vec<f64>)> = None;
    for (delay_s, values) in DELAYS_S.into_iter().zip(delayed) {
        if delay_s > LONGEST_SHARE * span_s {
            continue;
        }
        let gls = Gls::new(blocks, levels, residual.means, &[&ones, values]);
        if gls.kept.len() < 2 {
            continue;
        }
        let gain = alone - gls.deviance();
        let slope_error = gls.covariance()[(1, 1)].sqrt();
        delays.push(Delay { delay_s, gain, slope: gls.coefficients()[1], slope_error });
        if best.is_none_or(|(most, _)| gain > most) {
            best = Some((gain, values));
        }
    }
    let (most, values) = best?;
    let (test, _) = residual.test(null, std::slice::from_ref(values))?;
    let possible =
        || delays.iter().filter(|delay| delay.gain > most - INDISTINGUISHABLE).map(|delay| delay.delay_s);
    Some(LagProfile {
        best_s: delays.iter().find(|delay| delay.gain == most).map_or(0.0, |delay| delay.delay_s),
        possible_s: (possible().fold(f64::INFINITY, f64::min), possible().fold(0.0, f64::max)),
        p: (test.p * delays.len() as f64).min(1.0),
        test,
        delays,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fos_data::recording::{LoadOptions, Source};

    fn delayed(recording: &Recording, column: &[f64], delay_s: f64) -> Vec<f64> {
        let Shift(pieces) = Shift::new(recording, delay_s);
        assert!(pieces.windows(2).all(|pair| pair[0].end == pair[1].start), "{pieces:?}");
        let rows =
            pieces.iter().flat_map(|piece| (piece.start..piece.end).map(|row| column[piece.source(row)]));
        rows.collect()
    }

    /// Reference: a search backwards, row by row.
    #[test]
    fn pieces_match_row_by_row_search() {
        let mut time = Vec::new();
        for n in 0..400_u32 {
            let is_lost =
                (40..60).contains(&n) || (130..131).contains(&n) || n % 97 == 3 || (200..330).contains(&n);
            if !is_lost {
                time.push(f64::from(n));
            }
        }
        let log = || {
            let columns = vec![("t_s".to_owned(), time.clone()), ("temp_c".to_owned(), time.clone())];
            Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap()
        };
        let recording = Recording::join(vec![log(), log()]).unwrap();
        let column: Vec<f64> = (0..recording.n_rows()).map(|row| row as f64).collect();
        let tick_of = |row: usize| {
            let segment = recording.segments.iter().find(|segment| segment.rows.contains(&row)).unwrap();
            segment.tick + (row - segment.rows.start) as u64
        };
        for delay in [0, 1, 2, 7, 20, 21, 90, 129, 130, 131, 399, 1000] {
            for (row, then) in delayed(&recording, &column, f64::from(delay)).into_iter().enumerate() {
                let first = if row < time.len() { 0 } else { time.len() };
                let expected =
                    (first..=row).rev().find(|from| tick_of(*from) + u64::from(delay as u32) <= tick_of(row));
                assert_eq!(then, expected.unwrap_or(first) as f64, "row {row}, {delay} s");
            }
        }
    }

    #[test]
    fn delay_spans_gaps_and_holds_first_value() {
        let time: Vec<f64> = (0..100).filter(|n| !(40..60).contains(n)).map(f64::from).collect();
        let columns = vec![("t_s".to_owned(), time.clone()), ("temp_c".to_owned(), time.clone())];
        let recording =
            Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap();
        let delayed = delayed(&recording, &time, 5.0);
        for (now, then) in time.iter().zip(delayed) {
            let expected = match *now - 5.0 {
                before if before < 0.0 => 0.0,
                // in the gap nothing was logged: the last value before it holds
                inside if (40.0..60.0).contains(&inside) => 39.0,
                logged => logged,
            };
            assert_eq!(then, expected, "at {now} s");
        }
    }

    #[test]
    fn delay_stays_within_its_recording() {
        let log = |from: f64| {
            let values: Vec<f64> = (0..50).map(|n| from + f64::from(n)).collect();
            let time: Vec<f64> = (0..50).map(f64::from).collect();
            let columns = vec![("t_s".to_owned(), time), ("temp_c".to_owned(), values)];
            Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap()
        };
        let joined = Recording::join(vec![log(0.0), log(1000.0)]).unwrap();
        let delayed = delayed(&joined, &joined.channel("temp_c").unwrap().values, 10.0);
        assert_eq!((delayed[49], delayed[50], delayed[60], delayed[61]), (39.0, 1000.0, 1000.0, 1001.0));
    }
}

//! What is left against a channel as it was some time ago.

use serde::{Deserialize, Serialize};

use super::likelihood::{Remainder, Test};
use fos_data::recording::{Boundary, Recording};
use fos_fit::noise::Fitted;
use fos_fit::noise::{Gls, NoiseLevels};

/// Delays, s.
const DELAYS_S: [f64; 7] = [0.0, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];

/// A delay beyond this share of the log leaves too little of the channel.
const LONGEST_SHARE: f64 = 0.25;

/// Delays whose gain is less than this below the best are not told from it: 95 % point of χ²₁.
const NOT_TOLD: f64 = 3.84;

/// One delay.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Delay {
    /// The delay, s.
    pub delay_s: f64,
    /// By how much 2 ln L rises with the delayed channel as a linear term; the same noise levels for all delays.
    pub gain: f64,
    /// Its coefficient, the axis' unit per unit of the channel.
    pub slope: f64,
    /// Standard error of the coefficient.
    pub slope_error: f64,
}

/// The profile over delays.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct LagProfile {
    /// By ascending delay.
    pub delays: Vec<Delay>,
    /// The delay that explains most, s.
    pub best_s: f64,
    /// The shortest and longest delay that the log does not tell from it, s.
    pub possible_s: (f64, f64),
    /// A linear term with that delay, noise levels fitted along.
    pub test: Test,
    /// Its p after allowing for all delays (Bonferroni).
    pub p: f64,
}

/// Where every row of a recording lies on the grid of ticks, and where the recording that it belongs to begins.
pub(super) struct Grid {
    ticks: Vec<u64>,
    first_rows: Vec<usize>,
    period_s: f64,
}

impl Grid {
    pub(super) fn new(recording: &Recording) -> Self {
        let (mut ticks, mut first_rows) = (Vec::new(), Vec::new());
        let mut first_row = 0;
        for segment in &recording.segments {
            if segment.boundary == Boundary::Recording {
                first_row = segment.rows.start;
            }
            ticks.extend((0..segment.rows.len() as u64).map(|tick| segment.tick + tick));
            first_rows.extend(std::iter::repeat_n(first_row, segment.rows.len()));
        }
        Self { ticks, first_rows, period_s: recording.rate.period_s }
    }

    /// A column as it was `delay_s` ago; before its recording begins it is taken to have been as it begins.
    pub(super) fn delayed(&self, column: &[f64], delay_s: f64) -> Vec<f64> {
        let delay = (delay_s / self.period_s).round() as u64;
        let mut from = 0;
        self.ticks
            .iter()
            .zip(&self.first_rows)
            .enumerate()
            .map(|(row, (tick, first))| {
                from = from.max(*first);
                while from < row && self.ticks[from + 1] + delay <= *tick {
                    from += 1;
                }
                column[from]
            })
            .collect()
    }
}

/// The profile of `column`, one value per row, under noise of `levels`. `None` where the channel does not change.
pub(super) fn profile(
    remainder: &Remainder<'_>,
    (null, levels): (&Fitted, &NoiseLevels),
    grid: &Grid,
    column: &[f64],
) -> Option<LagProfile> {
    let blocks = remainder.blocks;
    let span_s = blocks.middle_s(blocks.len() - 1) - blocks.middle_s(0);
    let ones = vec![1.0; blocks.len()];
    let alone = Gls::new(blocks, levels, remainder.means, &[&ones]).deviance();
    let mut delays = Vec::new();
    let mut best: Option<(f64, Vec<f64>)> = None;
    for delay_s in DELAYS_S.into_iter().filter(|delay_s| *delay_s <= LONGEST_SHARE * span_s) {
        let values = blocks.means(&grid.delayed(column, delay_s));
        let gls = Gls::new(blocks, levels, remainder.means, &[&ones, &values]);
        if gls.kept.len() < 2 {
            continue;
        }
        let gain = alone - gls.deviance();
        let slope_error = gls.covariance()[(1, 1)].sqrt();
        delays.push(Delay { delay_s, gain, slope: gls.coefficients()[1], slope_error });
        if best.as_ref().is_none_or(|(most, _)| gain > *most) {
            best = Some((gain, values));
        }
    }
    let (most, values) = best?;
    let (test, _) = remainder.test(null, &[values])?;
    let possible = || delays.iter().filter(|delay| delay.gain > most - NOT_TOLD).map(|delay| delay.delay_s);
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

    #[test]
    fn a_delayed_channel_is_counted_in_seconds_over_gaps_and_held_before_its_beginning() {
        let time: Vec<f64> = (0..100).filter(|n| !(40..60).contains(n)).map(f64::from).collect();
        let columns = vec![("t_s".to_owned(), time.clone()), ("temp_c".to_owned(), time.clone())];
        let recording =
            Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap();
        let delayed = Grid::new(&recording).delayed(&time, 5.0);
        for (now, then) in time.iter().zip(delayed) {
            let expected = match *now - 5.0 {
                before if before < 0.0 => 0.0,
                // nothing was logged in the gap: the last before it
                inside if (40.0..60.0).contains(&inside) => 39.0,
                logged => logged,
            };
            assert_eq!(then, expected, "at {now} s");
        }
    }

    #[test]
    fn a_delay_never_reaches_into_the_log_before() {
        let log = |from: f64| {
            let values: Vec<f64> = (0..50).map(|n| from + f64::from(n)).collect();
            let time: Vec<f64> = (0..50).map(f64::from).collect();
            let columns = vec![("t_s".to_owned(), time), ("temp_c".to_owned(), values)];
            Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap()
        };
        let joined = Recording::join(vec![log(0.0), log(1000.0)]).unwrap();
        let delayed = Grid::new(&joined).delayed(&joined.channel("temp_c").unwrap().values, 10.0);
        assert_eq!((delayed[49], delayed[50], delayed[60], delayed[61]), (39.0, 1000.0, 1000.0, 1001.0));
    }
}

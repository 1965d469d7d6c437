//! Plausibility checks of a log: values that contradict the meaning of their column.

use crate::column::AXES;
use crate::column::Column;
use std::borrow::Cow;
use std::fmt;
use std::ops::Range;

use super::{ClockProblem, FailedReads, Recording};
use crate::interrupt::in_parallel;
use crate::pose;
use crate::spikes::{Spikes, spikes};
use crate::statistics::median;
use crate::stuck::{MIN_CHANGES, REFUSED_SHARE, coarse_step, least_change, stuck};
use crate::unit::STANDARD_GRAVITY_MPS2;

/// Relative deviation from gravity beyond the scale error and bias of any accelerometer at rest.
const GRAVITY_WITHIN: f64 = 0.15;

/// Rate at rest beyond any bias, rad/s: 57 °/s.
const RATE_AT_REST: f64 = 1.0;

/// Ratio of noise levels beyond which logs are not of one device in one place.
const NOISE_RATIO: f64 = 3.0;

/// Relative difference of rates beyond which logs do not share one clock.
const RATE_DIFFERS: f64 = 2e-3;

/// Minimum number of rows at rest without a change that show an axis to be coarser than its noise.
const MIN_AT_REST: usize = 1000;

/// A warning about implausible data in a log.
#[derive(Debug, Clone, PartialEq)]
pub enum LogWarning {
    /// An axis holds one value throughout, or is stuck for half of the log and more.
    Stuck {
        /// Column in the log format, such as `gx_rads`.
        column: String,
        /// Repeated value, in the column's unit.
        value: f64,
        /// Stuck duration and total duration, s.
        seconds: [f64; 2],
    },
    /// Isolated outliers.
    Spikes {
        /// Column in the log format, such as `gx_rads`.
        column: String,
        /// Number of outliers in the whole log.
        count: usize,
        /// The largest: its timestamp (s), its value, and its distance in standard deviations.
        worst: [f64; 3],
    },
    /// An axis repeats one value in some stretches; those rows are excluded.
    Held {
        /// Column in the log format, such as `gx_rads`.
        column: String,
        times: usize,
        /// Total duration, s.
        seconds: f64,
        /// Start and duration of the longest, s.
        longest: [f64; 2],
    },
    /// An axis whose steps are coarser than its noise.
    CoarseAxis {
        /// Column in the log format, such as `gx_rads`.
        column: String,
        /// Step, in the column's unit.
        step: f64,
    },
    /// Accelerometer levels differ across a pause.
    LevelAfterPause(String),
    /// Entries of a column map that were inferred from the values of a file without a header.
    AssumedMap(Vec<String>),
    /// Timestamps that do not match the sampling times.
    Clock(ClockProblem),
    /// Failed reads of a thermometer.
    FailedReads(FailedReads),
    /// A thermometer with coarse steps.
    CoarseSteps {
        /// Column in the log format, such as `temp_c`.
        column: String,
        /// Step, K.
        step: f64,
    },
    /// Two axes hold the same values.
    Same { columns: [String; 2] },
    /// Magnitude of the accelerometers at rest is not gravity.
    NotGravity {
        /// Median magnitude, m/s² as read.
        magnitude: f64,
    },
    /// A gyro shows a rate that no device at rest has.
    TurnsAtRest {
        /// Column in the log format, such as `gx_rads`.
        column: String,
        /// Median rate, rad/s as read.
        rate: f64,
    },
    /// Joined logs have different rates.
    RatesDiffer {
        /// Rate of the first log and the one that differs most, Hz.
        rates_hz: [f64; 2],
    },
    /// Joined logs have different noise levels.
    NoiseDiffers {
        /// Column in the log format, such as `gx_rads`.
        column: String,
        /// Ratio of the largest to the smallest noise level.
        ratio: f64,
    },
}

impl fmt::Display for LogWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stuck { column, value, seconds: [stuck, all] } => {
                write!(
                    f,
                    "{column} repeats one value, {value}, for {stuck:.1} s of {all:.1} s: stuck, or not connected"
                )
            }
            Self::Spikes { column, count: 1, worst: [time_s, _, times] } => {
                write!(f, "{column}: excluded 1 outlier ({times:.0} σ, at {time_s:.3} s)")
            }
            Self::Spikes { column, count, worst: [time_s, _, times] } => {
                write!(f, "{column}: excluded {count} outliers, the largest {times:.0} σ at {time_s:.3} s")
            }
            Self::Held { column, times, seconds, longest: [from_s, longest_s] } => {
                write!(f, "{column} repeats one value for {longest_s:.1} s from {from_s:.1} s: excluded")?;
                match times - 1 {
                    0 => Ok(()),
                    others => write!(f, ", with {others} shorter repeats; {seconds:.1} s in all"),
                }
            }
            Self::CoarseAxis { column, step } => write!(
                f,
                "{column} moves in steps of {step:.3e}, coarser than its noise: changes smaller than a step are hidden; choose a finer range of the sensor"
            ),
            Self::LevelAfterPause(text) => f.write_str(text),
            Self::AssumedMap(map) => {
                let map: Vec<String> = map.iter().map(|entry| format!("'{entry}'")).collect();
                write!(
                    f,
                    "the file has no header; its values show this column map: {}. Check it, and pass it with the file",
                    map.join(" ")
                )
            }
            Self::Clock(problem) => problem.fmt(f),
            Self::FailedReads(FailedReads { column, rows, share, said }) => {
                let said: Vec<String> = said.iter().map(f64::to_string).collect();
                if *share >= 1.0 {
                    return write!(
                        f,
                        "{column} is exactly {} °C in every row: not a temperature; the column is excluded",
                        said.join(" or ")
                    );
                }
                write!(
                    f,
                    "{column}: {rows} readings, {:.2} %, are exactly {} °C and no temperature: the thermometer was not read; they are taken for empty cells",
                    100.0 * share,
                    said.join(" or ")
                )
            }
            Self::CoarseSteps { column, step } => write!(
                f,
                "{column} moves in steps of {step} K: a diagnosis takes the temperature between two steps from a smooth curve; on the device a correction that follows it is off by up to half a step"
            ),
            Self::Same { columns: [one, other] } => write!(f, "{one} and {other} hold the same values"),
            Self::NotGravity { magnitude } => write!(
                f,
                "the accelerometers show {magnitude:.3} m/s² together, and gravity is {STANDARD_GRAVITY_MPS2:.2}: another unit (in the column map ax_mps2=ax:g), or without gravity"
            ),
            Self::TurnsAtRest { column, rate } => write!(
                f,
                "{column} shows {rate:.3} rad/s where the unit is at rest: another unit (in the column map {column}=NAME:dps), or it turns"
            ),
            Self::RatesDiffer { rates_hz: [one, other] } => write!(
                f,
                "the logs run at {one:.3} and {other:.3} Hz, and the lags of one model are samples: fit them one by one where that matters"
            ),
            Self::NoiseDiffers { column, ratio } => write!(
                f,
                "the noise of {column} is {ratio:.1} times as large in one log as in another: not at rest in both, or not one unit"
            ),
        }
    }
}

impl Recording {
    /// Warnings about all axes and the log as a whole. `still` marks the rows at rest.
    pub fn warnings(&self, still: &[bool]) -> Vec<LogWarning> {
        self.warnings_about(&AXES, still)
    }

    /// Warnings about these axes and the log as a whole.
    pub fn warnings_about(&self, wanted: &[&str], still: &[bool]) -> Vec<LogWarning> {
        let axes: Vec<&str> = AXES.into_iter().filter(|axis| self.channel(axis).is_ok()).collect();
        let of_axis = |place: usize| self.warnings_of(axes[place], &axes[place + 1..], wanted, still);
        let mut found = in_parallel(0..axes.len(), of_axis).concat();
        let assumed = Some(&self.quality.assumed_map).filter(|map| !map.is_empty());
        found.extend(assumed.cloned().map(LogWarning::AssumedMap));
        found.extend(self.quality.clock.iter().cloned().map(LogWarning::Clock));
        found.extend(self.quality.failed_reads.iter().cloned().map(LogWarning::FailedReads));
        found.extend(self.channels().iter().filter_map(|channel| {
            let step = self.coarse_step(channel)?;
            Some(LogWarning::CoarseSteps { column: channel.name.clone(), step })
        }));
        found.extend(self.not_gravity(still));
        if wanted.iter().any(|axis| self.channel(axis).is_ok() && !self.is_bias_known(axis)) {
            found.extend(pose::after_pauses(self, still).map(LogWarning::LevelAfterPause));
        }
        found.extend(self.rates_differ(&self.power_ons()));
        found
    }

    /// Warnings about one axis: on its own, if it is in `wanted`, and in comparison with the axes after it.
    fn warnings_of(&self, axis: &str, others: &[&str], wanted: &[&str], still: &[bool]) -> Vec<LogWarning> {
        let mut found = Vec::new();
        let logs: Vec<Range<usize>> = self.power_ons();
        let values = self.values(axis);
        for other in others {
            let same = |(a, b): (&f64, &f64)| a == b || a.is_nan() && b.is_nan();
            if (wanted.contains(&axis) || wanted.contains(other))
                && values.iter().zip(self.values(other)).all(same)
                && values.iter().any(|v| *v != values[0])
            {
                found.push(LogWarning::Same { columns: [axis.to_owned(), (*other).to_owned()] });
            }
        }
        if !wanted.contains(&axis) {
            return found;
        }
        if let Some(Spikes { rows, worst: (row, value, times) }) = self.spikes(axis, 0..self.n_rows(), still)
        {
            let (column, worst) = (axis.to_owned(), [self.time_s[row], value, times]);
            found.push(LogWarning::Spikes { column, count: rows.len(), worst });
        }
        found.extend(self.repeats(axis, still));
        let at_rest = |row: &usize| still[*row] && values[*row].is_finite();
        let rates = (0..self.n_rows()).filter(at_rest).map(|row| values[row]);
        let no_reference = self.channel(&Column::named(axis).reference()).is_err();
        if axis.starts_with('g')
            && no_reference
            && let Some(rate) = unusual_median(rates, |rate| rate.abs() > RATE_AT_REST)
        {
            found.push(LogWarning::TurnsAtRest { column: axis.to_owned(), rate });
        }
        let several = if logs.len() > 1 { logs } else { Vec::new() };
        let mut noise: Vec<f64> = several.into_iter().filter_map(|rows| fast_noise(&values[rows])).collect();
        noise.sort_by(f64::total_cmp);
        if let [quietest, .., loudest] = noise[..]
            && loudest > NOISE_RATIO * quietest
        {
            found.push(LogWarning::NoiseDiffers { column: axis.to_owned(), ratio: loudest / quietest });
        }
        found
    }

    /// Outliers of an axis among `rows` at rest, by its error.
    pub(crate) fn spikes(&self, axis: &str, rows: Range<usize>, still: &[bool]) -> Option<Spikes> {
        let error = self.error_series(axis).ok()?;
        let stretches = self.stretches_where(|row| rows.contains(&row) && still[row]);
        spikes(&error.values, &stretches)
    }

    /// Rows among `rows` at rest in which an axis repeats a value for longer than chance explains.
    fn stuck_rows(&self, axis: &str, rows: Range<usize>, still: &[bool]) -> Vec<Range<usize>> {
        stuck(self.values(axis), &self.stretches_where(|row| rows.contains(&row) && still[row]))
    }

    /// The same recording with the outliers and stuck values of an axis among `rows` at rest replaced by empty cells,
    /// and their number.
    pub fn without_outliers(&self, axis: &str, rows: Range<usize>, still: &[bool]) -> (Cow<'_, Self>, usize) {
        let spikes = self.spikes(axis, rows.clone(), still).map_or_else(Vec::new, |spikes| spikes.rows);
        let stuck = self.stuck_rows(axis, rows, still);
        if spikes.is_empty() && stuck.is_empty() {
            return (Cow::Borrowed(self), 0);
        }
        let mut values = self.values(axis).to_vec();
        spikes.iter().for_each(|row| values[*row] = f64::NAN);
        stuck.iter().for_each(|rows| values[rows.clone()].fill(f64::NAN));
        let left_out =
            values.iter().zip(self.values(axis)).filter(|(now, was)| now.is_nan() && !was.is_nan());
        let left_out = left_out.count();
        (Cow::Owned(self.with_values(axis, values)), left_out)
    }

    fn values(&self, column: &str) -> &[f64] {
        self.channel(column).map_or(&[], |channel| &channel.values)
    }

    /// Value at which an axis is stuck, with the stuck duration and the total time at rest, s: it has one value
    /// throughout, or repeats one improbably for so long that the log is rejected. Steps coarser than the noise do not
    /// count.
    pub fn stuck_axis(&self, axis: &str, still: &[bool]) -> Option<(f64, [f64; 2])> {
        let values = self.values(axis);
        let first = values.iter().copied().find(|value| !value.is_nan())?;
        let at_rest = |row: &usize| still[*row] && !values[*row].is_nan();
        let known = (0..values.len()).filter(at_rest).count();
        let seconds = |rows: usize| rows as f64 * self.rate.period_s;
        if values.iter().all(|value| value.is_nan() || *value == first) {
            let is_stuck = self.hidden_step(axis, still).is_none();
            return is_stuck.then(|| (first, [seconds(known), seconds(known)]));
        }
        let stuck = self.stuck_rows(axis, 0..self.n_rows(), still);
        let rows: usize = stuck.iter().map(Range::len).sum();
        let longest = stuck.iter().max_by_key(|rows| rows.len())?;
        let is_refused = rows as f64 >= REFUSED_SHARE * known as f64;
        is_refused.then(|| (values[longest.start], [seconds(rows), seconds(known)]))
    }

    /// Step of an axis, in its unit, if it is so coarse that it hides the noise. For an axis with a single code at each
    /// rest it is the step of its motion; for one with a single value, that of another axis of its triad, whose steps
    /// are as coarse.
    pub fn hidden_step(&self, axis: &str, still: &[bool]) -> Option<f64> {
        let stretches = self.stretches_where(|row| still[row]);
        let rest: usize = stretches.iter().map(Range::len).sum();
        // `Some(None)` for an axis without a coarse step; `None` for an axis that does not change
        let own = |axis: &str| -> Option<Option<f64>> {
            let values = self.values(axis);
            let changes = |rows: &Range<usize>| {
                values[rows.clone()].windows(2).filter(|pair| pair[0] != pair[1] && !pair[1].is_nan()).count()
            };
            if stretches.iter().map(changes).sum::<usize>() >= MIN_CHANGES {
                return Some(coarse_step(values, &stretches));
            }
            let moves = changes(&(0..values.len())) >= MIN_CHANGES;
            moves.then(|| (rest >= MIN_AT_REST).then(|| least_change(values)).flatten())
        };
        if let Some(step) = own(axis) {
            return step;
        }
        let (triad, _) = Column::named(axis).place()?;
        let others = AXES.into_iter().filter(|other| *other != axis && self.channel(other).is_ok());
        let of_triad = others.filter(|other| Column::named(other).place().is_some_and(|(of, _)| of == triad));
        of_triad.filter_map(own).flatten().reduce(f64::max)
    }

    fn repeats(&self, axis: &str, still: &[bool]) -> Option<LogWarning> {
        let column = axis.to_owned();
        if let Some((value, seconds)) = self.stuck_axis(axis, still) {
            return Some(LogWarning::Stuck { column, value, seconds });
        }
        if let Some(step) = self.hidden_step(axis, still) {
            return Some(LogWarning::CoarseAxis { column, step });
        }
        let stuck = self.stuck_rows(axis, 0..self.n_rows(), still);
        let seconds = |rows: usize| rows as f64 * self.rate.period_s;
        let longest = stuck.iter().max_by_key(|rows| rows.len())?;
        let longest = [self.time_s[longest.start], seconds(longest.len())];
        let all = stuck.iter().map(Range::len).sum();
        Some(LogWarning::Held { column, times: stuck.len(), seconds: seconds(all), longest })
    }

    fn not_gravity(&self, still: &[bool]) -> Option<LogWarning> {
        if AXES[..3]
            .iter()
            .any(|axis| self.channel(axis).is_err() || self.channel(&Column::named(axis).reference()).is_ok())
        {
            return None;
        }
        let [x, y, z] = [0, 1, 2].map(|axis| self.values(AXES[axis]));
        let square = |row: usize| x[row] * x[row] + y[row] * y[row] + z[row] * z[row];
        let at_rest = (0..self.n_rows()).filter(|row| still[*row]);
        let magnitudes = at_rest.map(|row| square(row).sqrt()).filter(|a| a.is_finite());
        let magnitude = unusual_median(magnitudes, |magnitude| {
            (magnitude / STANDARD_GRAVITY_MPS2 - 1.0).abs() > GRAVITY_WITHIN
        })?;
        Some(LogWarning::NotGravity { magnitude })
    }

    fn rates_differ(&self, logs: &[Range<usize>]) -> Option<LogWarning> {
        let rate = |rows: &Range<usize>| {
            let longest = self.segments.iter().filter(|segment| rows.contains(&segment.rows.start));
            let longest = longest.max_by_key(|segment| segment.rows.len())?.rows.clone();
            let seconds = self.time_s[longest.end - 1] - self.time_s[longest.start];
            (longest.len() > 1000 && seconds > 0.0).then(|| (longest.len() - 1) as f64 / seconds)
        };
        let rates: Vec<f64> = logs.iter().filter_map(rate).collect();
        let (first, others) = rates.split_first()?;
        let other = others.iter().max_by(|a, b| (*a - first).abs().total_cmp(&(*b - first).abs()))?;
        let differs = (other / first - 1.0).abs() > RATE_DIFFERS;
        differs.then_some(LogWarning::RatesDiffer { rates_hz: [*first, *other] })
    }
}

/// Median of `values` if it is unusual. If fewer than half of them are, it cannot be, and the sort is skipped.
fn unusual_median(
    values: impl Iterator<Item = f64> + Clone,
    is_unusual: impl Fn(f64) -> bool,
) -> Option<f64> {
    let (mut all, mut unusual) = (0_usize, 0_usize);
    for value in values.clone() {
        all += 1;
        unusual += usize::from(is_unusual(value));
    }
    if all == 0 || 2 * unusual < all {
        return None;
    }
    Some(median(&mut values.collect::<Vec<f64>>())).filter(|median| is_unusual(*median))
}

/// Sample-to-sample noise as a median, robust to shocks and steps; `None` for a constant.
fn fast_noise(values: &[f64]) -> Option<f64> {
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    (steps.len() > 50).then(|| median(&mut steps))
}

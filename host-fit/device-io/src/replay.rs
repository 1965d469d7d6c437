//! Runs an image over a recording on fos-core in f32, as a device does.

use std::ops::Range;

use fos_core::{Axis, Correction, Fixed, Image, ImageError, Scalar, Validity};
use fos_embedded::hub::{GRAVITY_MPS2, HubError, PERIOD_TOLERANCE, is_near_period, leads_away};
use fos_embedded::test_log::PredictorDigest;
use serde::Serialize;

use fos_data::recording::{Recording, RecordingError};
use fos_data::stillness::{KnownBy, Stillness};
use fos_fit::calibration::{Calibrated, hub_columns};
use fos_fit::evaluate::{ModelErrors, trace_in_f32};
use fos_fit::export::{NoColumn, model_of};
use fos_fit::model::{HostPredictor, UnitModel};
use fos_fit::playback::Playback;
use fos_fit::single_axis::SingleAxisModel;

/// An image cannot be run over a recording.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    #[error("the image cannot be run: {0}")]
    Image(#[from] ImageError),
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error(
        "{path}: a sample every {log_s:.6} s ({:.4} Hz), but the model was fitted to one every {model_s:.6} s ({:.4} Hz): a hub refuses it on a sensor that is more than {:.0} % off\nhelp: replay a log of the model's rate, or fit the model to logs of this one; --rate if the log's rate is read wrongly", 1.0 / .log_s, 1.0 / .model_s, 100.0 * PERIOD_TOLERANCE
    )]
    Period { path: String, model_s: f64, log_s: f64 },
    #[error(transparent)]
    NoColumn(#[from] NoColumn),
    #[error(
        "a hub refuses the image: {0}\nhelp: export a model of the axes and quantities of one six-axis sensor"
    )]
    Hub(#[from] HubError),
}

/// Result of a replay.
#[derive(Debug, Clone)]
pub struct Replay {
    /// Counts and digests.
    pub summary: Summary,
    /// Corrected value of each axis, one per row, in the axis' unit.
    pub corrected: Vec<Vec<f64>>,
}

/// Counts and digests of a replay.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Summary {
    /// Number of rows.
    pub rows: usize,
    /// Number of tracked rows; the others are coasted.
    pub tracked: usize,
    /// Source of the decision between tracking and coasting.
    pub still_known_by: KnownBy,
    /// Reason why the model does not run in fixed point; none if it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_in_fixed_point: Option<String>,
    /// One summary for each axis of the image.
    pub axes: Vec<AxisSummary>,
    /// Rests at which the correction leads away from gravity; none unless all three accelerometers are in the model.
    pub gravity: Option<Gravity>,
    /// CRC-64 of all innovations, tick by tick and axis by axis. Hexadecimal in JSON, because JSON numbers have 53 bits.
    #[serde(with = "hexadecimal")]
    #[cfg_attr(feature = "page-types", ts(as = "String"))]
    pub innovations_digest: u64,
    /// CRC-64 of all innovations, corrected values before the calibration, and validities.
    #[serde(with = "hexadecimal")]
    #[cfg_attr(feature = "page-types", ts(as = "String"))]
    pub corrections_digest: u64,
}

/// Rests of a replay, and those at which the corrected specific force is further from gravity than the measured one by more than a valid
/// model can cause ([`leads_away`]). Such a model was fitted to other data, for example to two orientations.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Gravity {
    /// Number of rests.
    pub rests: usize,
    /// Number of rows at rest.
    pub rows: usize,
    /// Rests with more than half of their rows away from gravity.
    pub rests_away: usize,
    /// Rows away from gravity.
    pub rows_away: usize,
    /// RMS over the rests of |a| − g, m/s²: of the mean measured and of the mean corrected specific force.
    #[cfg_attr(feature = "page-types", ts(as = "[f64; 2]"))]
    pub residual_mps2: [f64; 2],
}

/// One axis of a replay.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct AxisSummary {
    /// Column of the log format, such as `gx_rads`.
    pub column: String,
    /// Number of rows with an innovation.
    pub innovations: usize,
    /// RMS of the innovations in f32, in the axis' unit; NaN without innovations.
    #[cfg_attr(feature = "page-types", ts(as = "Option<f64>"))]
    pub innovation_rms_f32: f64,
    /// RMS of the innovations in f64, in the axis' unit; NaN without innovations.
    #[cfg_attr(feature = "page-types", ts(as = "Option<f64>"))]
    pub innovation_rms_f64: f64,
    /// Largest difference between f32 and f64, in the axis' unit; NaN without innovations.
    #[cfg_attr(feature = "page-types", ts(as = "Option<f64>"))]
    pub largest_difference: f64,
    /// Largest difference between fixed point and f64, in the axis' unit; NaN also if the model does not run in fixed point.
    #[cfg_attr(feature = "page-types", ts(as = "Option<f64>"))]
    pub largest_difference_fixed: f64,
    /// Share of the tracked rows with a valid correction that does not lead away from gravity; NaN without tracked rows.
    #[cfg_attr(feature = "page-types", ts(as = "Option<f64>"))]
    pub valid_share: f64,
    /// Remaining errors at rest in f32, the same as those of a comparison; none if the device never rests.
    pub errors: Option<ModelErrors>,
}

/// Cost of a scalar type against f64 on one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CostOfScalar {
    /// Largest difference of an innovation, divided by the RMS of all innovations.
    Relative(f64),
    /// Largest difference, in the axis' unit, for a model with innovations of exactly 0.
    NothingLeft(f64),
    /// No row has an innovation, because none was tracked with a full history.
    NotKnown,
}

impl AxisSummary {
    /// Cost of f32 on this axis.
    pub fn cost_of_f32(&self) -> CostOfScalar {
        self.cost_of(self.largest_difference)
    }

    /// Cost of fixed point on this axis.
    pub fn cost_of_fixed(&self) -> CostOfScalar {
        self.cost_of(self.largest_difference_fixed)
    }

    fn cost_of(&self, difference: f64) -> CostOfScalar {
        match self.innovation_rms_f64 {
            _ if self.innovations == 0 || difference.is_nan() => CostOfScalar::NotKnown,
            rms if rms > 0.0 => CostOfScalar::Relative(difference / rms),
            _ => CostOfScalar::NothingLeft(difference),
        }
    }
}

impl Replay {
    /// Columns of the corrected log: time and corrected axes.
    pub fn columns<'s>(&'s self, recording: &'s Recording) -> Vec<(&'s str, &'s [f64])> {
        let axes = self.summary.axes.iter().map(|axis| axis.column.as_str());
        let mut columns = vec![("t_s", recording.time_s.as_slice())];
        columns.extend(axes.zip(self.corrected.iter().map(Vec::as_slice)));
        columns
    }
}

mod hexadecimal {
    pub(super) fn serialize<S: serde::Serializer>(digest: &u64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("{digest:016x}"))
    }
}

/// Runs `image` over `recording`: tracks at rest, coasts in motion.
pub fn replay(
    image: &Image<'_>,
    recording: &Recording,
    stillness: &Stillness,
    axes: &[String],
) -> Result<Replay, ReplayError> {
    let n_axes = image.axes().count();
    let mut corrected = vec![Vec::with_capacity(recording.n_rows()); n_axes];
    let summary = run(image, recording, stillness, axes, |axis, calibrated| {
        corrected[axis].push(f64::from(calibrated));
    })?;
    Ok(Replay { summary, corrected })
}

/// Computes only the counts and digests of [`replay`], in little memory.
pub fn summary(
    image: &Image<'_>,
    recording: &Recording,
    stillness: &Stillness,
) -> Result<Summary, ReplayError> {
    run(image, recording, stillness, &[], |_, _| {})
}

/// Runs the image; `take` receives the calibrated value of every axis, row by row.
fn run(
    image: &Image<'_>,
    recording: &Recording,
    stillness: &Stillness,
    axes: &[String],
    mut take: impl FnMut(usize, f32),
) -> Result<Summary, ReplayError> {
    let (model_s, log_s) = (image.period_s(), recording.rate.period_s);
    if !is_near_period(model_s, log_s) {
        return Err(ReplayError::Period { path: recording.paths(), model_s, log_s });
    }
    let model = model_of(image, axes)?;
    let playback = Playback::new(recording, &model, &stillness.still)?;
    let mut single: HostPredictor<f32> = image.predictor()?;
    let mut double: HostPredictor<f64> = image.predictor()?;
    let fixed: Result<HostPredictor<Fixed>, ImageError> = image.predictor();
    let not_in_fixed_point = fixed.as_ref().err().map(ToString::to_string);
    let mut fixed = fixed.ok();
    let n_rows = recording.n_rows();
    let mut tallies = vec![Tally::default(); model.axes.len()];
    let mut digest = PredictorDigest::default();
    let mut rests = Rests::of(&model, &playback);
    let (mut calibrated, columns) = (Calibrated::of(image), hub_columns(recording));
    let mut values: Vec<f32> = Vec::with_capacity(model.axes.len());
    let mut tracked = 0;
    let (mut in_f32, mut in_f64, mut in_fixed) = (playback.feed(), playback.feed(), playback.feed());
    for row in 0..n_rows {
        let singles = in_f32.step(&mut single, row);
        digest.update(singles);
        let doubles = in_f64.step(&mut double, row);
        let fixed = fixed.as_mut().map(|fixed| in_fixed.step(fixed, row));
        tracked += usize::from(playback.is_still(row));
        values.clear();
        values.extend(singles.iter().map(|axis| axis.corrected));
        if let Some(calibrated) = &mut calibrated {
            calibrated.apply(&mut values, |channel| columns[channel].map(|column| column[row] as f32));
        }
        if let Some(rests) = &mut rests {
            rests.add(in_f32.sample(row).measured, row, singles, &values);
        }
        for (axis, (single, double)) in singles.iter().zip(doubles).enumerate() {
            take(axis, values[axis]);
            tallies[axis].add(single.innovation, double.innovation);
            if let Some(fixed) = fixed.and_then(|fixed| fixed.get(axis)) {
                tallies[axis].add_fixed(fixed.innovation, double.innovation);
            }
            tallies[axis].valid += usize::from(playback.is_still(row) && is_valid(single));
        }
    }
    if let Some(rests) = &rests {
        rests.take_out(&mut tallies);
    }
    let mut summaries = Vec::new();
    for (index, (axis, tally)) in model.axes.iter().zip(&tallies).enumerate() {
        let errors = errors(&model.only(index), recording, stillness)?;
        summaries.push(AxisSummary { errors, ..tally.summary(&axis.column, tracked) });
    }
    Ok(Summary {
        rows: n_rows,
        tracked,
        still_known_by: stillness.known_by,
        not_in_fixed_point,
        axes: summaries,
        gravity: rests.map(|rests| rests.total()),
        innovations_digest: digest.innovations(),
        corrections_digest: digest.corrections(),
    })
}

/// Remaining errors of an axis at rest, in f32; none if they are never known. Called for one axis at a time, because a trace is as large as
/// four channels of the log.
fn errors(
    alone: &SingleAxisModel,
    recording: &Recording,
    stillness: &Stillness,
) -> Result<Option<ModelErrors>, ReplayError> {
    let playback = Playback::new(recording, alone, &stillness.still)?;
    let left = trace_in_f32(alone, &playback, 0..recording.n_rows());
    let left = left.map_err(|error| ReplayError::Image(ImageError::Model(error)))?;
    let errors = ModelErrors::of(&left, 0, "image", &alone.axis().column, None);
    // An accelerometer that lies in another orientation throughout the log has none.
    Ok(Some(errors).filter(|errors| errors.one_step_mse.is_finite()))
}

/// Rests of a replay, and which of their rows are away from gravity.
struct Rests {
    /// Indices of the accelerometers in the model.
    accelerometers: [usize; 3],
    rests: Vec<RestTally>,
    /// Index of the rest that contains the latest row, or of the next one.
    at: usize,
}

struct RestTally {
    rows: Range<usize>,
    away: usize,
    /// Rows with an otherwise valid correction, for each accelerometer.
    valid: [usize; 3],
    /// Sums over the rows of the measured and of the calibrated specific force.
    sums: [[f64; 3]; 2],
}

impl RestTally {
    fn is_away(&self) -> bool {
        2 * self.away > self.rows.len()
    }

    /// |a| − g of the mean measured and of the mean calibrated specific force, m/s².
    fn residuals(&self) -> [f64; 2] {
        let rows = self.rows.len() as f64;
        self.sums.map(|sum| {
            let square: f64 = sum.iter().map(|axis| (axis / rows).powi(2)).sum();
            square.sqrt() - f64::from(GRAVITY_MPS2)
        })
    }
}

impl Rests {
    /// None unless all three accelerometers are in the model.
    fn of(model: &UnitModel, playback: &Playback<'_>) -> Option<Self> {
        let place = |wanted| model.axes.iter().position(|axis| axis.parameters.axis == wanted);
        let accelerometers = [place(Axis::Ax)?, place(Axis::Ay)?, place(Axis::Az)?];
        let rests = playback.still_stretches(0..playback.n_rows()).into_iter();
        let rests =
            rests.map(|rows| RestTally { rows, away: 0, valid: [0; 3], sums: [[0.0; 3]; 2] }).collect();
        Some(Self { accelerometers, rests, at: 0 })
    }

    fn add(&mut self, measured: &[f32], row: usize, corrections: &[Correction<f32>], calibrated: &[f32]) {
        while self.rests.get(self.at).is_some_and(|rest| rest.rows.end <= row) {
            self.at += 1;
        }
        let Some(rest) = self.rests.get_mut(self.at).filter(|rest| rest.rows.contains(&row)) else { return };
        let measured = self.accelerometers.map(|axis| measured[axis]);
        let corrected = self.accelerometers.map(|axis| corrections[axis].corrected);
        rest.away += usize::from(leads_away(&measured, &corrected));
        let calibrated = self.accelerometers.map(|axis| calibrated[axis]);
        for (sum, values) in rest.sums.iter_mut().zip([measured, calibrated]) {
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += f64::from(value));
        }
        for (valid, axis) in rest.valid.iter_mut().zip(self.accelerometers) {
            *valid += usize::from(is_valid(&corrections[axis]));
        }
    }

    /// Subtracts the rows away from gravity from the valid ones.
    fn take_out(&self, tallies: &mut [Tally]) {
        for rest in self.rests.iter().filter(|rest| rest.is_away()) {
            for (valid, axis) in rest.valid.iter().zip(self.accelerometers) {
                tallies[axis].valid -= valid;
            }
        }
    }

    fn total(&self) -> Gravity {
        let away = self.rests.iter().filter(|rest| rest.is_away());
        let residuals: Vec<[f64; 2]> = self.rests.iter().map(RestTally::residuals).collect();
        let rms = |at: usize| {
            let known = residuals.iter().map(|residual| residual[at]).filter(|residual| residual.is_finite());
            let squares: Vec<f64> = known.map(|residual| residual * residual).collect();
            (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
        };
        Gravity {
            rests: self.rests.len(),
            rows: self.rests.iter().map(|rest| rest.rows.len()).sum(),
            rests_away: away.count(),
            rows_away: self.rests.iter().map(|rest| rest.away).sum(),
            residual_mps2: [rms(0), rms(1)],
        }
    }
}

/// Valid, apart from the flag of the start.
fn is_valid(correction: &Correction<f32>) -> bool {
    let caution = Validity::OWN_HISTORY | Validity::WARMING_UP;
    correction.validity | caution == caution
}

#[derive(Debug, Clone, Default)]
struct Tally {
    innovations: usize,
    single_squares: f64,
    double_squares: f64,
    largest_difference: f64,
    largest_difference_fixed: Option<f64>,
    valid: usize,
}

impl Tally {
    fn add(&mut self, single: Option<f32>, double: Option<f64>) {
        let (Some(single), Some(double)) = (single.map(f64::from), double) else { return };
        self.innovations += 1;
        self.single_squares += single * single;
        self.double_squares += double * double;
        self.largest_difference = self.largest_difference.max((single - double).abs());
    }

    fn add_fixed(&mut self, fixed: Option<Fixed>, double: Option<f64>) {
        let (Some(fixed), Some(double)) = (fixed.map(Fixed::to_f64), double) else { return };
        let before = self.largest_difference_fixed.unwrap_or(0.0);
        self.largest_difference_fixed = Some(before.max((fixed - double).abs()));
    }

    fn summary(&self, column: &str, tracked: usize) -> AxisSummary {
        // 0/0 without rows: NaN, as documented.
        let rms = |squares: f64| (squares / self.innovations as f64).sqrt();
        AxisSummary {
            column: column.to_owned(),
            innovations: self.innovations,
            innovation_rms_f32: rms(self.single_squares),
            innovation_rms_f64: rms(self.double_squares),
            largest_difference: if self.innovations > 0 { self.largest_difference } else { f64::NAN },
            largest_difference_fixed: self.largest_difference_fixed.unwrap_or(f64::NAN),
            valid_share: self.valid as f64 / tracked as f64,
            errors: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regression test: 0/0 was printed as NaN.
    #[test]
    fn reports_cost_of_f32_or_reason() {
        let cost = |innovations: &[(f32, f64)]| {
            let mut tally = Tally::default();
            innovations.iter().for_each(|(single, double)| tally.add(Some(*single), Some(*double)));
            tally.summary("gx_rads", innovations.len()).cost_of_f32()
        };
        assert_eq!(cost(&[(2.0, 1.0), (-1.0, -1.0)]), CostOfScalar::Relative(1.0));
        assert_eq!(cost(&[(0.0, 0.0), (0.5, 0.0)]), CostOfScalar::NothingLeft(0.5));
        assert_eq!(cost(&[]), CostOfScalar::NotKnown);
    }
}

//! Feeds the rows of a recording to a predictor, as on the device.

use fos_data::column::Column;
use std::ops::Range;
use std::sync::Arc;

use fos_core::{Axis, AxisParameters, Correction, OTHER_POSE, PoseGate, Predictor, Sample, Scalar};

use crate::model::{AXES, FittedAxis, INPUTS, LoggedQuantity, UnitModel};
use fos_data::recording::{Boundary, Recording, RecordingError, runs};

/// View of a recording through the columns that a model needs. Rows are those of the recording.
pub struct Playback<'a> {
    measured: Vec<&'a [f64]>,
    reference: Vec<Reference<'a>>,
    /// Parameters of each axis whose true value at rest is the model's own reference; a device tracks it conditionally.
    gated: Vec<Option<AxisParameters<f64>>>,
    quantities: Vec<Arc<Vec<f64>>>,
    still: &'a [bool],
    /// Rows that do not follow the row before them, in order.
    breaks: Vec<(usize, Break)>,
    /// Rows in which an axis has no value.
    unmeasured: Vec<usize>,
}

enum Reference<'a> {
    Constant(f64),
    Column(&'a [f64]),
    /// The constant in the orientation of the fit, NaN in any other, where the component of gravity is unknown. It is
    /// determined in hindsight by the mean of a still stretch: it defines the rows of an evaluation, and not the
    /// knowledge of a device at the time.
    Pose(Vec<f64>),
}

impl Reference<'_> {
    fn at(&self, row: usize) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Column(values) => values[row],
            Self::Pose(values) => values[row],
        }
    }
}

/// Returns the parameters of an axis that a device tracks only in the orientation of its fit.
fn gated((axis, reference): (&FittedAxis, &Reference<'_>)) -> Option<AxisParameters<f64>> {
    let is_own = matches!(reference, Reference::Constant(_) | Reference::Pose(_));
    (is_own && matches!(axis.parameters.axis, Axis::Ax | Axis::Ay | Axis::Az)).then_some(axis.parameters)
}

/// Interruption before a row that does not follow the row before it.
#[derive(Debug, Clone, Copy)]
enum Break {
    Missing(u32),
    /// The device was switched on again: all states are reset.
    Recording,
}

/// Number of missing ticks if it is unknown: more than any gap limit, so that histories restart.
const UNKNOWN_TICKS: u64 = 256;

impl<'a> Playback<'a> {
    /// `still` marks the rows in which the true value is known.
    pub fn new(
        recording: &'a Recording,
        model: &UnitModel,
        still: &'a [bool],
    ) -> Result<Self, RecordingError> {
        let mut measured = Vec::new();
        let mut reference = Vec::new();
        for axis in &model.axes {
            measured.push(recording.channel(&axis.column)?.values.as_slice());
            reference.push(match recording.channel(&Column::named(&axis.column).reference()) {
                Ok(channel) => Reference::Column(&channel.values),
                Err(_) => Reference::Constant(axis.parameters.reference),
            });
        }
        let held = |logged: &LoggedQuantity| Ok(recording.held(recording.channel(&logged.column)?));
        let quantities = model.quantities.iter().map(held).collect::<Result<_, RecordingError>>()?;
        let breaks = recording
            .segments
            .iter()
            .filter_map(|segment| {
                let missing = |ticks| Break::Missing(u32::try_from(ticks).unwrap_or(u32::MAX));
                let before = match segment.boundary {
                    Boundary::Start => return None,
                    Boundary::Recording => Break::Recording,
                    Boundary::Gap | Boundary::Pause => missing(segment.missing_before),
                    Boundary::SegmentColumn | Boundary::ClockBack => {
                        missing(segment.missing_before.max(UNKNOWN_TICKS))
                    }
                };
                Some((segment.rows.start, before))
            })
            .collect();
        let is_unmeasured = |row: &usize| measured.iter().any(|values| !values[*row].is_finite());
        let unmeasured = (0..recording.n_rows()).filter(is_unmeasured).collect();
        let mut playback =
            Self { measured, reference, gated: Vec::new(), quantities, still, breaks, unmeasured };
        playback.exclude_other_poses(model);
        playback.gated = model.axes.iter().zip(&playback.reference).map(gated).collect();
        Ok(playback)
    }

    /// Removes the constant references of the accelerometers wherever the device is at rest in another orientation by
    /// any of them: an axis along the axis of rotation sees the same gravity.
    fn exclude_other_poses(&mut self, model: &UnitModel) {
        let n_rows = self.still.len();
        let gated = model.axes.iter().zip(&self.reference).map(gated).enumerate();
        let gated: Vec<(usize, AxisParameters<f64>)> =
            gated.filter_map(|(place, parameters)| Some((place, parameters?))).collect();
        if gated.is_empty() {
            return;
        }
        let is_off = |(place, parameters): &(usize, AxisParameters<f64>), stretch: &Range<usize>| {
            let AxisParameters { reference, offset, scale, .. } = parameters;
            let finite = || self.measured[*place][stretch.clone()].iter().filter(|value| value.is_finite());
            let mean = finite().sum::<f64>() / finite().count() as f64;
            (mean - reference - offset).abs() > OTHER_POSE * scale
        };
        let is_other = |stretch: &Range<usize>| gated.iter().any(|axis| is_off(axis, stretch));
        let other: Vec<Range<usize>> = self.still_stretches(0..n_rows).into_iter().filter(is_other).collect();
        if other.is_empty() {
            return;
        }
        for (place, parameters) in gated {
            let mut values = vec![parameters.reference; n_rows];
            other.iter().for_each(|stretch| values[stretch.clone()].fill(f64::NAN));
            self.reference[place] = Reference::Pose(values);
        }
    }

    /// Mean of the measurements of an axis in `rows`, its unit.
    pub fn measured_mean(&self, axis: usize, rows: Range<usize>) -> f64 {
        let n = rows.len() as f64;
        self.measured[axis][rows].iter().sum::<f64>() / n
    }

    /// Number of rows of the recording.
    pub fn n_rows(&self) -> usize {
        self.still.len()
    }

    /// Returns true if the true value is known in this row.
    pub fn is_still(&self, row: usize) -> bool {
        self.still[row]
    }

    /// Returns true if every axis has a value in all of these rows.
    pub fn is_measured(&self, rows: Range<usize>) -> bool {
        let next = self.unmeasured.partition_point(|row| *row < rows.start);
        self.unmeasured.get(next).is_none_or(|row| *row >= rows.end)
    }

    /// Number of logged quantities that the model needs.
    pub(crate) fn n_quantities(&self) -> usize {
        self.quantities.len()
    }

    /// Returns a quantity as a device sees it in this row.
    #[inline]
    pub(crate) fn quantity(&self, number: usize, row: usize) -> f64 {
        self.quantities[number][row]
    }

    /// Returns true if every quantity has had a value since power-on.
    pub fn knows_inputs(&self, row: usize) -> bool {
        self.quantities.iter().all(|values| !values[row].is_nan())
    }

    fn break_before(&self, row: usize) -> Option<Break> {
        let found = self.breaks.binary_search_by_key(&row, |(row, _)| *row).ok()?;
        Some(self.breaks[found].1)
    }

    /// Returns the number of ticks missing just before `row`; 0 if it follows the row before it. A new recording counts
    /// as a number that restarts histories.
    pub fn missing_before(&self, row: usize) -> u32 {
        match self.break_before(row) {
            None => 0,
            Some(Break::Missing(ticks)) => ticks,
            Some(Break::Recording) => UNKNOWN_TICKS as u32,
        }
    }

    /// Advances `predictor` over the interruption before `row`.
    #[inline]
    pub fn catch_up<R: Scalar, const TERMS: usize, const HISTORY: usize>(
        &self,
        predictor: &mut Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
        row: usize,
    ) {
        match self.break_before(row) {
            None => {}
            Some(Break::Missing(ticks)) => {
                let _ = predictor.skip(ticks);
            }
            Some(Break::Recording) => predictor.reset(),
        }
    }

    /// Returns the rows in the scalar of a predictor.
    pub fn feed<R: Scalar>(&self) -> Feed<'_, 'a, R> {
        let gate = |parameters: &AxisParameters<f64>| {
            let device_parameters: AxisParameters<R::Stored> = parameters.convert();
            Gate {
                pose: PoseGate::new(&device_parameters).convert(),
                offset: R::of(device_parameters.offset),
                reference: R::of(device_parameters.reference),
            }
        };
        let gates: Vec<Option<Gate<R>>> =
            self.gated.iter().map(|parameters| parameters.as_ref().map(gate)).collect();
        Feed {
            playback: self,
            is_gated: gates.iter().any(Option::is_some),
            gates,
            measured: vec![R::ZERO; self.measured.len()],
            reference: vec![R::ZERO; self.measured.len()],
            quantities: vec![R::ZERO; self.quantities.len()],
        }
    }

    /// Returns the measured error of an axis, offset included, in its unit: measured − reference; NaN if that is
    /// unknown.
    pub fn error(&self, axis: usize, row: usize) -> f64 {
        self.measured[axis][row] - self.reference[axis].at(row)
    }

    /// Returns the known measured errors of an axis at rest, stretch by stretch.
    pub fn errors_at_rest(&self, axis: usize, rows: Range<usize>) -> Vec<Vec<f64>> {
        let errors = |rows: Range<usize>| rows.map(|row| self.error(axis, row)).collect();
        let known = |stretch| runs(stretch, |row| self.error(axis, row).is_finite());
        self.still_stretches(rows).into_iter().flat_map(known).map(errors).collect()
    }

    /// Returns the stretches of `rows` that are still throughout and have no break inside.
    pub fn still_stretches(&self, rows: Range<usize>) -> Vec<Range<usize>> {
        let mut stretches: Vec<Range<usize>> = Vec::new();
        for row in rows.filter(|row| self.still[*row]) {
            match stretches.last_mut() {
                Some(last) if last.end == row && self.break_before(row).is_none() => last.end += 1,
                _ => stretches.push(row..row + 1),
            }
        }
        stretches
    }
}

/// Rows of a playback, one at a time, in the form of fos-core.
#[derive(Clone)]
pub struct Feed<'p, 'a, R: Scalar> {
    playback: &'p Playback<'a>,
    /// Gate of each axis that a device tracks only in the orientation of its fit.
    gates: Vec<Option<Gate<R>>>,
    is_gated: bool,
    // the values of one row
    measured: Vec<R>,
    reference: Vec<R>,
    quantities: Vec<R>,
}

#[derive(Clone)]
struct Gate<R> {
    pose: PoseGate<R>,
    offset: R,
    reference: R,
}

impl<R: Scalar> Feed<'_, '_, R> {
    /// Returns the row as a device sees it: measured values and quantities.
    #[inline]
    pub fn sample(&mut self, row: usize) -> Sample<'_, R> {
        self.read(row);
        Sample { measured: &self.measured, quantities: &self.quantities }
    }

    #[inline]
    fn read(&mut self, row: usize) {
        for (value, column) in self.measured.iter_mut().zip(&self.playback.measured) {
            *value = R::from_f64(column[row]);
        }
        for (value, column) in self.quantities.iter_mut().zip(&self.playback.quantities) {
            *value = R::from_f64(column[row]);
        }
    }

    /// Processes one row: missing ticks before it are skipped, then it is tracked at rest, else coasted. As on a
    /// device, by the same gate and without looking ahead, an accelerometer is tracked against the model's own
    /// reference only if all of them were in the orientation of the fit in the sample before; the first sample after
    /// power-on decides for itself.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn step<'r, const TERMS: usize, const HISTORY: usize>(
        &mut self,
        predictor: &'r mut Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
        row: usize,
    ) -> &'r [Correction<R>] {
        self.playback.catch_up(predictor, row);
        if !self.playback.still[row] {
            return self.coast(predictor, row);
        }
        self.read(row);
        for (value, reference) in self.reference.iter_mut().zip(&self.playback.reference) {
            *value = R::from_f64(reference.at(row));
        }
        if self.is_gated {
            self.hold_gates(predictor.corrections(), row);
        }
        let sample = Sample { measured: &self.measured, quantities: &self.quantities };
        predictor.track_against(&sample, &self.reference)
    }

    /// Processes one row from the model's own history although it may be at rest, to evaluate a coast.
    #[inline]
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn coast<'r, const TERMS: usize, const HISTORY: usize>(
        &mut self,
        predictor: &'r mut Predictor<R, AXES, INPUTS, TERMS, HISTORY>,
        row: usize,
    ) -> &'r [Correction<R>] {
        predictor.coast(&self.sample(row))
    }

    /// Sets the references of the axes with a gate: the model's own if all of them were in the orientation of the fit,
    /// else none.
    fn hold_gates(&mut self, before: &[Correction<R>], row: usize) {
        let is_first = row == 0 || matches!(self.playback.break_before(row), Some(Break::Recording));
        let mut is_in_pose = true;
        for (axis, gate) in self.gates.iter().enumerate() {
            let Some(gate) = gate else { continue };
            let before = match before.get(axis).filter(|_| !is_first) {
                Some(correction) => correction.corrected,
                None => self.measured[axis] - gate.offset,
            };
            is_in_pose &= gate.pose.is_open_after(before);
        }
        for (reference, gate) in self.reference.iter_mut().zip(&self.gates) {
            if let Some(gate) = gate {
                *reference = if is_in_pose { gate.reference } else { R::NAN };
            }
        }
    }
}

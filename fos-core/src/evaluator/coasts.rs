//! Parallel coasts of one model from different samples, vectorised.

use heapless::Vec;

use super::Evaluator;
use crate::history::{History, Window};
use crate::input::RunningInput;
use crate::running::LowPass;
use crate::{Scalar, Source};

/// Parallel coasts of one model, one in each lane. Each predicts the same bits as
/// [`Predictor::coast`](crate::Predictor::coast) from the same sample on, provided that every axis has a finite measured
/// value. No [`Validity`](crate::Validity) is computed.
///
/// ```
/// use fos_core::{Axis, AxisModel, AxisParameters, Coasts, FittedOn, InnovationStatistics, Model, Predictor, Range, Sample};
/// use fos_core::{Term, y};
///
/// let parameters = AxisParameters {
///     axis: Axis::Gz,
///     reference: 0.0,
///     offset: 0.0,
///     scale: 1.0,
///     constant: 0.0,
///     range: Range::new(-4.0, 4.0),
///     physical_range: Range::new(0.0, 0.0),
///     full_scale: 0.0,
///     stuck_after_repeats: 0,
///     gap_limit_samples: 1,
///     coast_limit_s: 60.0,
///     innovation: InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 },
/// };
/// let axes = [AxisModel { parameters, physical: &[], stochastic: &[Term::new(0.5, &[y(1)])] }];
/// let model = Model { period_s: 0.01, fitted_on: FittedOn::Raw, stillness: None, calibration: None, inputs: &[], quantities: &[], axes: &axes };
/// let mut predictor = Predictor::<f64, 1, 1, 4, 8>::new(&model)?;
/// let _ = predictor.track(&Sample { measured: &[2.0], quantities: &[] });
/// let mut coasts = Coasts::new(&predictor).expect("it begins from measurements");
/// let _ = predictor.track(&Sample { measured: &[4.0], quantities: &[] });
/// assert!(coasts.begin(1, &predictor));
/// assert_eq!(coasts.step(&[]), [[1.0, 2.0]]);
/// assert_eq!(coasts.step(&[]), [[0.5, 1.0]]);
/// # Ok::<(), fos_core::ModelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Coasts<
    R: Scalar,
    const LANES: usize,
    const AXES: usize,
    const INPUTS: usize,
    const TERMS: usize,
    const HISTORY: usize,
> {
    /// The model and the duration of the coasts. Its history and the state of its inputs are not used.
    common: Evaluator<R, AXES, INPUTS, TERMS, HISTORY>,
    inputs: Vec<Lanes<R, LANES>, INPUTS>,
    history: History<[R; LANES], HISTORY>,
    remainders: [[R; LANES]; AXES],
    predicted: [[R; LANES]; AXES],
}

/// An input in every lane.
#[derive(Debug, Clone)]
enum Lanes<R: Scalar, const LANES: usize> {
    /// Low-pass of the remainder of an axis (by index), and its state in every lane.
    Memory(usize, LowPass<R>, [R::Slow; LANES]),
    /// Any other input.
    Each([RunningInput<R>; LANES]),
}

impl<
    R: Scalar,
    const LANES: usize,
    const AXES: usize,
    const INPUTS: usize,
    const TERMS: usize,
    const HISTORY: usize,
> Coasts<R, LANES, AXES, INPUTS, TERMS, HISTORY>
{
    /// Starts a coast in every lane from the state of `evaluator`, with the sample after its last one. `None` if its
    /// history does not consist of measurements only.
    pub fn new(evaluator: &Evaluator<R, AXES, INPUTS, TERMS, HISTORY>) -> Option<Self> {
        let in_lanes = |input: &RunningInput<R>| match (input.source(), input.low_pass()) {
            (Source::Remainder(axis), Some(low_pass)) => {
                Lanes::Memory(usize::from(axis), *low_pass, [low_pass.slow(); LANES])
            }
            _ => Lanes::Each([*input; LANES]),
        };
        let mut coasts = Self {
            common: evaluator.clone(),
            inputs: evaluator.inputs.iter().map(in_lanes).collect(),
            history: History::filled([R::ZERO; LANES]),
            remainders: [[R::ZERO; LANES]; AXES],
            predicted: [[R::ZERO; LANES]; AXES],
        };
        coasts.begin_all(evaluator).then_some(coasts)
    }

    /// Restarts every lane from the state of `evaluator`, which must have the same model. Returns false, and changes
    /// nothing, if its history does not consist of measurements only.
    pub fn begin_all(&mut self, evaluator: &Evaluator<R, AXES, INPUTS, TERMS, HISTORY>) -> bool {
        if !self.can_begin_from(evaluator) {
            return false;
        }
        self.common.axes.clone_from(&evaluator.axes);
        (0..LANES).for_each(|lane| self.copy_state(lane, evaluator));
        true
    }

    /// Restarts one lane from the state of `evaluator`, under the conditions of [`begin_all`](Self::begin_all). Call it
    /// after that and before the first step.
    pub fn begin(&mut self, lane: usize, evaluator: &Evaluator<R, AXES, INPUTS, TERMS, HISTORY>) -> bool {
        let can_begin = lane < LANES && self.can_begin_from(evaluator);
        if can_begin {
            self.copy_state(lane, evaluator);
        }
        can_begin
    }

    /// True if the evaluator has a model of the same size and a history of measurements only.
    fn can_begin_from(&self, evaluator: &Evaluator<R, AXES, INPUTS, TERMS, HISTORY>) -> bool {
        evaluator.axes.len() == self.common.axes.len()
            && evaluator.inputs.len() == self.inputs.len()
            && evaluator.axes.iter().all(|axis| axis.state.is_steady())
    }

    /// Copies the state of an evaluator into a lane: inputs, remainders, and the history as far back as the longest lag.
    fn copy_state(&mut self, lane: usize, evaluator: &Evaluator<R, AXES, INPUTS, TERMS, HISTORY>) {
        for (lanes, input) in self.inputs.iter_mut().zip(&evaluator.inputs) {
            match lanes {
                Lanes::Memory(_, _, slow) => {
                    if let (Some(slow), Some(low_pass)) = (slow.get_mut(lane), input.low_pass()) {
                        *slow = low_pass.slow();
                    }
                }
                Lanes::Each(inputs) => {
                    if let Some(state) = inputs.get_mut(lane) {
                        *state = *input;
                    }
                }
            }
        }
        let ticks =
            evaluator.axes.iter().map(|axis| axis.constants.settling_ticks() as usize).fold(0, usize::max)
                + 1;
        let values = ticks * (evaluator.inputs.len() + evaluator.axes.len());
        let window = evaluator.history.window();
        let places = (1..=values.min(HISTORY)).rev().filter_map(Window::<R, HISTORY>::place);
        self.history.begin_lane(lane, places.map(|place| window.at(place)));
        for (remainder, axis) in self.remainders.iter_mut().zip(&evaluator.axes) {
            if let Some(remainder) = remainder.get_mut(lane) {
                *remainder = axis.state.remainder;
            }
        }
    }

    /// Advances all lanes by one sample. `quantities` holds, for every logged quantity of the model, its value in every
    /// lane. Returns the predicted error of every axis in every lane, offset included, in the axis' unit.
    #[inline(always)]
    pub fn step(&mut self, quantities: &[[R; LANES]]) -> &[[R; LANES]] {
        let Self { common, inputs, history, remainders, predicted } = self;
        for (input, lanes) in common.inputs.iter().zip(inputs) {
            let values = match lanes {
                Lanes::Memory(axis, low_pass, slow) => {
                    let logged = remainders.get(*axis).copied().unwrap_or([R::ZERO; LANES]);
                    input.update_lanes(low_pass, slow, &logged)
                }
                Lanes::Each(each) => {
                    let logged = match input.source() {
                        Source::Clock => None,
                        Source::Quantity(index) => quantities.get(usize::from(index)),
                        Source::Remainder(axis) => remainders.get(usize::from(axis)),
                    };
                    let mut lane = 0;
                    each.each_mut().map(|input| {
                        let value = logged.and_then(|logged| logged.get(lane)).copied();
                        lane += 1;
                        input.update(value).0
                    })
                }
            };
            history.write(core::iter::once(values));
        }
        let window = history.window();
        let mut records = common.program.records();
        let thirds = common.program.thirds();
        let lanes = remainders.iter_mut().zip(predicted.iter_mut());
        for (axis, (remainder, predicted)) in common.axes.iter_mut().zip(lanes) {
            let mut p = [R::ZERO; LANES];
            if !axis.constants.physical.is_empty {
                (p, records) = axis.constants.physical.evaluate_lanes(records, thirds, window);
            }
            (*remainder, records) = axis.constants.stochastic.evaluate_lanes(records, thirds, window);
            *predicted = axis.coast_lanes(p, remainder);
        }
        let n_axes = common.axes.len();
        history.write(remainders.iter().take(n_axes).copied());
        self.predicted.get(..n_axes).unwrap_or(&[])
    }
}

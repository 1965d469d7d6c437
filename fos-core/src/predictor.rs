//! One step per sample: tracks from measurements, coasts on its own output.

use heapless::Vec;

use crate::axis::{AxisProgram, Correction, Reading, RunningAxis};
use crate::history::History;
use crate::input::RunningInput;
use crate::model::{AxisParameters, is_positive};
use crate::program::{Layout, Program};
use crate::{Channel, Input, Model, ModelError, Real, Source, Term, Validity};

/// Everything logged at one instant.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a, R> {
    /// Measured value of every axis of the model, in its order and unit. An absent one counts as missing.
    pub measured: &'a [R],
    /// Every logged quantity of the model, in its order and unit. The last finite value stands in for NaN.
    pub quantities: &'a [R],
}

/// Evaluates a model sample by sample and takes the predicted error out.
///
/// Capacities: `AXES`, `INPUTS` (at most 32), `TERMS` of all axes together, and `HISTORY` values, a power of two:
/// at least (longest lag) × (inputs + axes) + inputs.
///
/// The step cannot fail and cannot panic. Its cost is bounded and does not depend on the data but for a gap, of
/// which at most 256 ticks are coasted.
///
/// ```
/// use fos_core::{Axis, AxisModel, AxisParameters, FittedOn, InnovationStatistics, Model, Predictor, Range, Sample};
/// use fos_core::{Term, y};
///
/// static TERMS: [Term<f32>; 2] = [Term::new(1.2, &[y(1)]), Term::new(-0.3, &[y(2)])];
/// static GYRO_Z: AxisModel<f32> = AxisModel {
///     parameters: AxisParameters {
///         axis: Axis::Gz,
///         reference: 0.0,
///         offset: 0.01,
///         scale: 0.002,
///         constant: 0.0,
///         range: Range::new(-4.0, 4.0),
///         full_scale: 4.36,
///         stuck_after: 50,
///         gap_limit: 20,
///         coast_limit_s: 10.0,
///         innovation: InnovationStatistics { mean: 0.0, variance: 0.2, lag_1_correlation: 0.0 },
///     },
///     physical: &[],
///     stochastic: &TERMS,
/// };
/// let model = Model {
///     period_s: 0.005,
///     fitted_on: FittedOn::Raw,
///     stillness: None,
///     quantities: &[],
///     inputs: &[],
///     axes: &[GYRO_Z],
/// };
/// let mut predictor = Predictor::<f32, 1, 1, 2, 4>::new(&model)?;
/// for measured in [0.012, 0.013, 0.012] {
///     let still = predictor.track(&Sample { measured: &[measured], quantities: &[] });
///     println!("{:?}", still[0].innovation); // None, None, then measured minus predicted
/// }
/// let moving = predictor.coast(&Sample { measured: &[0.5], quantities: &[] });
/// assert!((moving[0].corrected - 0.488).abs() < 0.001);
/// # Ok::<(), fos_core::ModelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Predictor<R, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize> {
    program: Program<R, TERMS>,
    inputs: Vec<RunningInput<R>, INPUTS>,
    axes: Vec<RunningAxis<R>, AXES>,
    history: History<R, HISTORY>,
    corrections: Vec<Correction<R>, AXES>,
    building: Building,
}

/// What is known of a model before its inputs and axes are added.
#[derive(Debug, Clone)]
pub(crate) struct Building {
    pub(crate) period_s: f64,
    pub(crate) n_quantities: usize,
    pub(crate) n_inputs: usize,
    pub(crate) n_axes: usize,
}

impl<R: Real, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>
    Predictor<R, AXES, INPUTS, TERMS, HISTORY>
{
    /// A predictor for `model`, of which it keeps its own compiled copy.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong with the model, or that there is no room for.
    pub fn new(model: &Model<'_, R>) -> Result<Self, ModelError> {
        if let Some(limits) = &model.stillness {
            limits.check()?;
        }
        let mut predictor = Self::begin(Building {
            period_s: model.period_s,
            n_quantities: model.quantities.len(),
            n_inputs: model.inputs.len(),
            n_axes: model.axes.len(),
        })?;
        for input in model.inputs {
            predictor.add_input(input)?;
        }
        for axis in model.axes {
            let (physical, stochastic) = (axis.physical.iter().copied(), axis.stochastic.iter().copied());
            predictor.add_axis(&axis.parameters, physical, stochastic)?;
        }
        Ok(predictor)
    }

    /// A predictor without inputs and axes; all of them must be added before it is used.
    pub(crate) fn begin(building: Building) -> Result<Self, ModelError> {
        const { assert!(INPUTS <= u32::BITS as usize, "at most 32 inputs") };
        if !is_positive(building.period_s) {
            return Err(ModelError::Period);
        }
        if building.n_axes == 0 {
            return Err(ModelError::NoAxis);
        }
        if building.n_axes > AXES {
            return Err(ModelError::TooManyAxes { found: building.n_axes, capacity: AXES });
        }
        if building.n_inputs > INPUTS {
            return Err(ModelError::TooManyInputs { found: building.n_inputs, capacity: INPUTS });
        }
        Ok(Self {
            program: Program::new(),
            inputs: Vec::new(),
            axes: Vec::new(),
            history: History::new(),
            corrections: Vec::new(),
            building,
        })
    }

    pub(crate) fn add_input(&mut self, input: &Input<R>) -> Result<(), ModelError> {
        input.check(self.inputs.len(), self.building.n_quantities, self.building.n_axes)?;
        let too_many = ModelError::TooManyInputs { found: self.building.n_inputs, capacity: INPUTS };
        self.inputs.push(RunningInput::new(input, self.building.period_s)).map_err(|_| too_many)
    }

    pub(crate) fn add_axis(
        &mut self,
        parameters: &AxisParameters<R>,
        physical: impl Iterator<Item = Term<R>> + Clone,
        stochastic: impl Iterator<Item = Term<R>> + Clone,
    ) -> Result<(), ModelError> {
        let axis = self.axes.len();
        parameters.check(axis)?;
        let source = |input: u8| self.inputs.get(usize::from(input)).map(RunningInput::source);
        let (mut depth, mut inputs_used) = (0, 0_u32);
        let tagged =
            physical.clone().map(|term| (true, term)).chain(stochastic.clone().map(|term| (false, term)));
        for (index, (is_physical, term)) in tagged.enumerate() {
            term.check(axis, index, is_physical, source)?;
            for factor in term.factors() {
                depth = depth.max(factor.lag);
                if let Channel::Input(input) = factor.channel {
                    inputs_used |= 1_u32.checked_shl(u32::from(input)).unwrap_or(0);
                }
            }
        }
        self.check_bounded(parameters, physical.clone(), stochastic.clone())?;

        let layout = Layout { n_inputs: self.building.n_inputs, n_axes: self.building.n_axes };
        let (mut physical_degrees, mut stochastic_degrees) = ([0; 3], [0; 3]);
        for (count, degree) in physical_degrees.iter_mut().zip(1..) {
            *count = self.program.append(physical.clone(), degree, axis, layout, HISTORY)?;
        }
        for (count, degree) in stochastic_degrees.iter_mut().zip(1..) {
            *count = self.program.append(stochastic.clone(), degree, axis, layout, HISTORY)?;
        }
        let program =
            AxisProgram { physical: physical_degrees, stochastic: stochastic_degrees, inputs_used, depth };
        let running = RunningAxis::new(parameters, program, self.building.period_s);
        let too_many = ModelError::TooManyAxes { found: self.building.n_axes, capacity: AXES };
        self.axes.push(running).map_err(|_| too_many)
    }

    /// Refuses a model whose sums could overflow, so that the step needs no test for it: every partial product
    /// and sum stays below 10³⁰ as long as inputs and remainder stay within their limits, and the step sees to that.
    fn check_bounded(
        &self,
        parameters: &AxisParameters<R>,
        physical: impl Iterator<Item = Term<R>>,
        stochastic: impl Iterator<Item = Term<R>>,
    ) -> Result<(), ModelError> {
        const BOUND: f64 = 1e30;
        let output = RunningAxis::limits(parameters).magnitude();
        let magnitude = |term: Term<R>| {
            term.factors().iter().fold(term.coefficient.to_f64().abs(), |product, factor| {
                let factor = match factor.channel {
                    Channel::Output => output,
                    Channel::Input(input) => {
                        self.inputs.get(usize::from(input)).map_or(f64::INFINITY, RunningInput::magnitude)
                    }
                };
                product * factor.max(1.0)
            })
        };
        let scaled = output
            + parameters.constant.to_f64().abs()
            + physical.map(magnitude).sum::<f64>()
            + stochastic.map(magnitude).sum::<f64>();
        let scale = parameters.scale.to_f64();
        let in_unit =
            parameters.offset.to_f64().abs() + parameters.reference.to_f64().abs() + scale.max(1.0) * scaled;
        if in_unit < BOUND { Ok(()) } else { Err(ModelError::Unbounded { axis: self.axes.len() }) }
    }

    /// The unit is still: measured error is known against the model's reference, and enters the history.
    ///
    /// Returns one correction per axis.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn track(&mut self, sample: &Sample<'_, R>) -> &[Correction<R>] {
        self.step(sample.quantities, |axis| match sample.measured.get(axis) {
            Some(&measured) => Reading::Still { measured, reference: None },
            None => Reading::Missing,
        })
    }

    /// As [`track`](Self::track), against the true value of every axis, in its unit. Where it is absent the model's
    /// reference stands in.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn track_against(&mut self, sample: &Sample<'_, R>, reference: &[R]) -> &[Correction<R>] {
        self.step(sample.quantities, |axis| match sample.measured.get(axis) {
            Some(&measured) => Reading::Still { measured, reference: reference.get(axis).copied() },
            None => Reading::Missing,
        })
    }

    /// The unit moves: the error is not known, the history holds the model's own output.
    ///
    /// It cannot run away, whatever the coefficients: the remainder is limited to twice the width of its fitted
    /// range, and once coasting has lasted longer than it was validated for, the stochastic part fades to its
    /// mean, 0, at least as fast as with that same time as its time constant (what is fed back fades again at every
    /// lag). The physical part goes on with its inputs.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn coast(&mut self, sample: &Sample<'_, R>) -> &[Correction<R>] {
        self.step(sample.quantities, |axis| match sample.measured.get(axis) {
            Some(&measured) => Reading::Moving { measured },
            None => Reading::Missing,
        })
    }

    /// `ticks` samples are missing. Up to each axis' gap limit they are coasted, beyond it the history restarts;
    /// time goes on for the inputs either way. Takes at most 256 steps.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn skip(&mut self, ticks: u32) -> &[Correction<R>] {
        const STEPS: u32 = u8::MAX as u32 + 1;
        let stepped = ticks.min(STEPS);
        if ticks > stepped {
            // longer than any gap limit: nothing is coasted. The steps come last, so that lagged inputs are as
            // old as they should be.
            self.axes.iter_mut().for_each(RunningAxis::restart);
            for input in &mut self.inputs {
                input.skip(ticks - stepped);
            }
        }
        for _ in 0..stepped {
            self.step(&[], |_| Reading::Missing);
        }
        &self.corrections
    }

    /// As at power-on: history, inputs and clocks start anew.
    pub fn reset(&mut self) {
        self.history = History::new();
        self.inputs.iter_mut().for_each(RunningInput::reset);
        self.axes.iter_mut().for_each(RunningAxis::reset);
    }

    /// How many axes the model has.
    pub fn n_axes(&self) -> usize {
        self.axes.len()
    }

    #[inline]
    fn step(&mut self, quantities: &[R], reading: impl Fn(usize) -> Reading<R>) -> &[Correction<R>] {
        let (mut out_of_range, mut not_finite) = (0_u32, 0_u32);
        let mut bit = 1_u32;
        for input in &mut self.inputs {
            let logged = match input.source() {
                Source::Clock => None,
                Source::Quantity(index) => quantities.get(usize::from(index)).copied(),
                Source::Remainder(axis) => self.axes.get(usize::from(axis)).and_then(|axis| axis.remainder),
            };
            let (value, validity) = input.update(logged);
            if !validity.is_valid() {
                out_of_range |= if validity.contains(Validity::INPUT_OUT_OF_RANGE) { bit } else { 0 };
                not_finite |= if validity.contains(Validity::INPUT_NOT_FINITE) { bit } else { 0 };
            }
            bit <<= 1;
            self.history.write(value);
        }

        self.corrections.clear();
        let mut terms = self.program.terms();
        for (index, axis) in self.axes.iter_mut().enumerate() {
            let physical = terms.sum(R::ZERO, axis.physical, &self.history);
            let stochastic = terms.sum(axis.constant, axis.stochastic, &self.history);
            let mut correction = axis.step(reading(index), physical, stochastic);
            self.history.write(axis.remainder.unwrap_or(R::ZERO));
            correction.validity |=
                Validity::when(axis.inputs_used & out_of_range != 0, Validity::INPUT_OUT_OF_RANGE)
                    | Validity::when(axis.inputs_used & not_finite != 0, Validity::INPUT_NOT_FINITE);
            // there is room: both vectors have capacity AXES
            let _ = self.corrections.push(correction);
        }
        &self.corrections
    }
}

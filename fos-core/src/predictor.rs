//! One step per sample: tracks from measurements, coasts on its own output.

use heapless::Vec;

use crate::axis::{AxisProgram, Correction, RunningAxis};
use crate::history::{History, Window};
use crate::input::RunningInput;
use crate::model::AxisParameters;
use crate::program::{Layout, Program};
use crate::real::is_positive;
use crate::{Channel, Input, Model, ModelError, Real, Source, Term, Validity};

/// Everything logged at one instant.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sample<'a, R> {
    /// Measured value of every axis of the model, in its order and unit. An absent one counts as missing.
    pub measured: &'a [R],
    /// Every logged quantity of the model, in its order and unit. The last finite value stands in for NaN.
    pub quantities: &'a [R],
}

/// Evaluates a model sample by sample and takes the predicted error out.
///
/// Capacities: `AXES`, `INPUTS` (at most 32), `TERMS` of all axes together, and `HISTORY` values, a power of two up
/// to 65536: at least (longest lag) × (inputs + axes) + inputs.
///
/// The step cannot fail and cannot panic. Its cost is bounded and does not depend on the data, but for gaps
/// ([`skip`](Self::skip)).
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
///         physical_range: Range::new(0.0, 0.0),
///         full_scale: 4.36,
///         stuck_after_repeats: 50,
///         gap_limit_samples: 20,
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

/// What the latest sample came to, not the model.
#[cfg(feature = "defmt")]
impl<R: defmt::Format, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>
    defmt::Format for Predictor<R, AXES, INPUTS, TERMS, HISTORY>
{
    fn format(&self, f: defmt::Formatter<'_>) {
        let (inputs, corrections) = (self.inputs.len(), self.corrections.as_slice());
        defmt::write!(f, "Predictor {{ inputs: {=usize}, corrections: {} }}", inputs, corrections);
    }
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
        let mut predictor = Self::empty();
        predictor.load(model)?;
        Ok(predictor)
    }

    /// Takes another model in place, compiled as by [`new`](Self::new); history, inputs and clocks start anew.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new); it is then without a model.
    pub fn load(&mut self, model: &Model<'_, R>) -> Result<(), ModelError> {
        let loaded = self.fill(model);
        if loaded.is_err() {
            self.clear();
        }
        loaded
    }

    fn fill(&mut self, model: &Model<'_, R>) -> Result<(), ModelError> {
        self.begin(Building {
            period_s: model.period_s,
            n_quantities: model.quantities.len(),
            n_inputs: model.inputs.len(),
            n_axes: model.axes.len(),
        })?;
        if let Some(limits) = &model.stillness {
            limits.check()?;
        }
        for input in model.inputs {
            self.add_input(input)?;
        }
        for axis in model.axes {
            let (physical, stochastic) = (axis.physical.iter().copied(), axis.stochastic.iter().copied());
            self.add_axis(&axis.parameters, physical, stochastic)?;
        }
        Ok(())
    }

    /// A predictor without a model, which corrects nothing: what a `static` begins with, before
    /// [`Image::load`](crate::Image::load).
    pub const fn empty() -> Self {
        const { assert!(INPUTS <= u32::BITS as usize, "at most 32 inputs") };
        Self {
            program: Program::new(),
            inputs: Vec::new(),
            axes: Vec::new(),
            history: History::new(),
            corrections: Vec::new(),
            building: Building { period_s: 0.0, n_quantities: 0, n_inputs: 0, n_axes: 0 },
        }
    }

    /// Forgets the model: [`empty`](Self::empty) again, where it stands.
    pub fn clear(&mut self) {
        self.program.clear();
        self.inputs.clear();
        self.axes.clear();
        self.history.clear();
        self.corrections.clear();
    }

    /// Without inputs and axes; all of them must be added before it is used.
    pub(crate) fn begin(&mut self, building: Building) -> Result<(), ModelError> {
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
        self.clear();
        self.building = building;
        Ok(())
    }

    #[inline(never)]
    pub(crate) fn add_input(&mut self, input: &Input<R>) -> Result<(), ModelError> {
        input.check(self.inputs.len(), self.building.n_quantities, self.building.n_axes)?;
        let too_many = ModelError::TooManyInputs { found: self.building.n_inputs, capacity: INPUTS };
        self.inputs.push(RunningInput::new(input, self.building.period_s)).map_err(|_| too_many)
    }

    #[inline(never)]
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
        let physical = self.program.append::<HISTORY>(R::ZERO, physical, axis, layout)?;
        let stochastic = self.program.append::<HISTORY>(parameters.constant, stochastic, axis, layout)?;
        let program = AxisProgram { physical, stochastic, inputs_used, depth };
        let running = RunningAxis::new(parameters, program, self.building.period_s);
        let too_many = ModelError::TooManyAxes { found: self.building.n_axes, capacity: AXES };
        self.axes.push(running).map_err(|_| too_many)
    }

    /// Refuses a model whose sums could overflow, so that the step needs no test for it: every partial product and
    /// sum stays below 10³⁰ as long as inputs, p and remainder stay within their limits, and the step sees to that. The
    /// same for a monitor.
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
        // limited, p may end as far from 0 as its limits begin
        let nearest = parameters.physical_limits().limit(R::ZERO).abs();
        let scaled = output
            + parameters.constant.to_f64().abs()
            + nearest.to_f64()
            + physical.map(magnitude).sum::<f64>()
            + stochastic.map(magnitude).sum::<f64>();
        let scale = parameters.scale.to_f64();
        let in_unit =
            parameters.offset.to_f64().abs() + parameters.reference.to_f64().abs() + scale.max(1.0) * scaled;
        let axis = self.axes.len();
        match in_unit < BOUND {
            true if parameters.innovation.is_bounded(parameters.scale) => Ok(()),
            true => Err(ModelError::Innovation { axis }),
            false => Err(ModelError::Unbounded { axis }),
        }
    }

    /// The unit is still: measured error is known against the model's reference, and enters the history.
    ///
    /// Returns one correction per axis.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn track(&mut self, sample: &Sample<'_, R>) -> &[Correction<R>] {
        self.step(sample, |axis, measured, correction| axis.track(measured, axis.reference, correction))
    }

    /// As [`track`](Self::track), against the true value of every axis, in its unit. Where it is absent the model's
    /// reference stands in; where it is not finite the axis coasts.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn track_against(&mut self, sample: &Sample<'_, R>, reference: &[R]) -> &[Correction<R>] {
        let mut references = reference.iter();
        self.step(sample, |axis, measured, correction| {
            let reference = references.next().copied().unwrap_or(axis.reference);
            // a true value that is not a number is not known
            if reference.is_finite() {
                axis.track(measured, reference, correction);
            } else {
                axis.coast(measured, correction);
            }
        })
    }

    /// As [`track`](Self::track) for the axes whose bit in `tracked` is set, the first axis' bit being the lowest;
    /// the others [coast](Self::coast).
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn track_some(&mut self, sample: &Sample<'_, R>, tracked: u32) -> &[Correction<R>] {
        let mut left = tracked;
        self.step(sample, |axis, measured, correction| {
            if left & 1 == 1 {
                axis.track(measured, axis.reference, correction);
            } else {
                axis.coast(measured, correction);
            }
            left >>= 1;
        })
    }

    /// The unit moves: the error is not known, the history holds the model's own output.
    ///
    /// It cannot run away, whatever the coefficients: the remainder is limited to twice the width of its fitted
    /// range, and once coasting has lasted longer than it was validated for, what is subtracted of it fades to its
    /// mean, 0, with that same time as its time constant. The physical part goes on with its inputs.
    ///
    /// A measured value that is not finite is a sample that is missing: it is coasted over up to the axis' gap limit,
    /// and then the history restarts. To go on without samples is [`forecast`](Self::forecast).
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn coast(&mut self, sample: &Sample<'_, R>) -> &[Correction<R>] {
        self.step(sample, |axis, measured, correction| axis.coast(measured, correction))
    }

    /// The corrections of the latest sample, one per axis; none before the first.
    pub fn corrections(&self) -> &[Correction<R>] {
        &self.corrections
    }

    /// The error as the model expects it one tick on, without a sample: as [`coast`](Self::coast), and for as long as
    /// is asked, whatever the gap limit. What is `corrected` is then the latest measured value less the prediction.
    ///
    /// ```
    /// use fos_core::{Axis, AxisModel, AxisParameters, FittedOn, InnovationStatistics, Model, Predictor, Range, Sample, Term, y};
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
    /// let model = Model { period_s: 0.01, fitted_on: FittedOn::Raw, stillness: None, inputs: &[], quantities: &[], axes: &axes };
    /// let mut predictor = Predictor::<f64, 1, 1, 4, 8>::new(&model)?;
    /// let _ = predictor.track(&Sample { measured: &[2.0], quantities: &[] });
    /// for expected in [1.0, 0.5, 0.25, 0.125] {
    ///     assert_eq!(predictor.forecast(&[])[0].predicted, expected);
    /// }
    /// # Ok::<(), fos_core::ModelError>(())
    /// ```
    #[must_use = "carries whether the predicted values can be trusted"]
    pub fn forecast(&mut self, quantities: &[R]) -> &[Correction<R>] {
        let measured = [R::ZERO; AXES];
        self.step(&Sample { measured: &measured, quantities }, |axis, _, correction| {
            axis.forecast(correction)
        })
    }

    /// `ticks` samples are missing. Up to each axis' gap limit they are coasted, beyond it the history restarts;
    /// time goes on for the inputs either way. Takes one step more than the longest gap limit or lag has ticks,
    /// however many are missing.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn skip(&mut self, ticks: u32) -> &[Correction<R>] {
        // one more than any axis coasts or remembers
        let stepped = ticks.min(self.axes.iter().map(RunningAxis::reach).fold(0, u32::max) + 1);
        if ticks > stepped {
            // longer than any gap limit: nothing is coasted. The steps come last, so that lagged inputs are as
            // old as they should be.
            self.axes.iter_mut().for_each(|axis| axis.restart(ticks - stepped));
            self.pass(ticks - stepped);
        }
        for _ in 0..stepped {
            let _ = self.coast(&Sample { measured: &[], quantities: &[] });
        }
        &self.corrections
    }

    /// Clocks begin `ticks` after power-on: a model that is taken up later finds the sensor as warm as it is. To be
    /// called before the first sample.
    pub fn begin_after(&mut self, ticks: u32) {
        self.pass(ticks);
    }

    /// Time goes on for the inputs. One copy for both who need it: neither is a step.
    #[inline(never)]
    fn pass(&mut self, ticks: u32) {
        for input in &mut self.inputs {
            input.skip(ticks);
        }
    }

    /// Measured values of this magnitude count as saturated on an axis, in its unit, if its model says no less: what
    /// is known of the sensor beside the model.
    pub fn limit_full_scale(&mut self, axis: usize, full_scale: R) {
        if let Some(axis) = self.axes.get_mut(axis) {
            axis.limit_full_scale(full_scale);
        }
    }

    /// As at power-on: history, inputs and clocks start anew.
    pub fn reset(&mut self) {
        self.history.clear();
        self.inputs.iter_mut().for_each(RunningInput::reset);
        self.axes.iter_mut().for_each(RunningAxis::reset);
    }

    /// u(n) of an input, scaled, as of the last sample; `None` if there is no such input.
    pub fn input(&self, index: usize) -> Option<R> {
        if index >= self.inputs.len() {
            return None;
        }
        let back = (self.inputs.len() + self.axes.len()).checked_sub(index)?;
        Window::<R, HISTORY>::place(back).map(|place| self.history.window().at(place))
    }

    /// How many axes the model has.
    pub fn n_axes(&self) -> usize {
        self.axes.len()
    }

    #[inline(always)]
    fn step(
        &mut self,
        sample: &Sample<'_, R>,
        mut take: impl FnMut(&mut RunningAxis<R>, R, &mut Correction<R>),
    ) -> &[Correction<R>] {
        if self.corrections.is_empty() {
            self.make_room();
        }
        let unusable = self.update_inputs(sample.quantities);
        let limited = self.evaluate();
        let mut measured = sample.measured.iter();
        let mut corrections = self.corrections.iter_mut();
        for axis in &mut self.axes {
            let Some(correction) = corrections.next() else { break };
            match measured.next() {
                Some(&measured) => take(axis, measured, correction),
                None => axis.miss(correction),
            }
        }
        self.history.write(self.axes.iter().map(|axis| axis.remainder));
        if unusable.any() || limited {
            self.blame(unusable);
        }
        &self.corrections
    }

    /// Evaluates the physical and the stochastic part of every axis; whether the former was limited anywhere.
    #[inline(never)]
    fn evaluate(&mut self) -> bool {
        let window = self.history.window();
        let mut terms = self.program.terms();
        let mut limited = false;
        for axis in &mut self.axes {
            if !axis.physical.is_empty {
                terms = axis.physical.evaluate(terms, window);
                limited |= axis.limit_physical();
            }
            terms = axis.stochastic.evaluate(terms, window);
        }
        limited
    }

    /// At the first step: a correction for every axis. There is room, both vectors have capacity `AXES`.
    #[cold]
    fn make_room(&mut self) {
        let _ = self.corrections.resize(self.axes.len(), Correction::NONE);
    }

    /// Tells the axes that use them of inputs that cannot be trusted, alone or together.
    #[cold]
    fn blame(&mut self, unusable: Unusable) {
        for (axis, correction) in self.axes.iter_mut().zip(&mut self.corrections) {
            correction.validity |= unusable.of(axis.inputs_used) | axis.take_limited();
        }
    }

    /// One sample into every input, and the inputs into the history.
    #[inline(never)]
    fn update_inputs(&mut self, quantities: &[R]) -> Unusable {
        let mut unusable = Unusable { out_of_range: 0, not_finite: 0 };
        let mut bit = 1_u32;
        for input in &mut self.inputs {
            let logged = match input.source() {
                Source::Clock => None,
                Source::Quantity(index) => quantities.get(usize::from(index)).copied(),
                Source::Remainder(axis) => self.axes.get(usize::from(axis)).and_then(RunningAxis::remainder),
            };
            let (value, validity) = input.update(logged);
            if !validity.is_valid() {
                unusable.out_of_range |=
                    if validity.contains(Validity::INPUT_OUT_OF_RANGE) { bit } else { 0 };
                unusable.not_finite |= if validity.contains(Validity::INPUT_NOT_FINITE) { bit } else { 0 };
            }
            bit <<= 1;
            self.history.write(core::iter::once(value));
        }
        unusable
    }
}

/// The inputs that speak against trusting a sample, one bit each.
#[derive(Debug, Clone, Copy)]
struct Unusable {
    out_of_range: u32,
    not_finite: u32,
}

impl Unusable {
    #[inline]
    fn any(self) -> bool {
        self.out_of_range | self.not_finite != 0
    }

    /// What they say of an axis that uses the inputs `used`.
    fn of(self, used: u32) -> Validity {
        Validity::when(used & self.out_of_range != 0, Validity::INPUT_OUT_OF_RANGE)
            | Validity::when(used & self.not_finite != 0, Validity::INPUT_NOT_FINITE)
    }
}

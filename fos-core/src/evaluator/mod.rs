//! Evaluation of a model: inputs, terms, history and axes, one step per sample.

mod build;
mod building;
#[cfg(feature = "coasts")]
mod coasts;

use heapless::Vec;

use crate::axis::{Correction, RunningAxis};
use crate::history::{History, Window};
use crate::input::RunningInput;
use crate::program::Program;
use crate::{Scalar, Source, Validity};

pub(crate) use building::ModelHeader;
#[cfg(feature = "coasts")]
pub use coasts::Coasts;

/// All values logged at one instant.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sample<'a, R> {
    /// Measured value of every axis, in the order and units of the model. Axes beyond the end count as missing.
    pub measured: &'a [R],
    /// Value of every logged quantity, in the order and units of the model. NaN is replaced by the last finite value.
    pub quantities: &'a [R],
}

/// A [`Predictor`](crate::Predictor) that writes the corrections into memory of the caller, for callers such as a hub that
/// store them anyway. Capacities are those of a predictor.
///
/// Every method with the parameter `corrections` writes one correction per axis into its start, in the order of the model.
/// If `corrections` has fewer entries than the model has axes, the method does nothing. Otherwise the behaviour is that of
/// the predictor.
#[derive(Debug, Clone)]
pub struct Evaluator<
    R: Scalar,
    const AXES: usize,
    const INPUTS: usize,
    const TERMS: usize,
    const HISTORY: usize,
> {
    program: Program<R, TERMS>,
    inputs: Vec<RunningInput<R>, INPUTS>,
    axes: Vec<RunningAxis<R>, AXES>,
    history: History<R, HISTORY>,
    header: ModelHeader,
}

/// Formats the numbers of axes and inputs, not the model.
#[cfg(feature = "defmt")]
impl<R: Scalar, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>
    defmt::Format for Evaluator<R, AXES, INPUTS, TERMS, HISTORY>
{
    fn format(&self, f: defmt::Formatter<'_>) {
        let (axes, inputs) = (self.axes.len(), self.inputs.len());
        defmt::write!(f, "Evaluator {{ axes: {=usize}, inputs: {=usize} }}", axes, inputs);
    }
}

impl<R: Scalar, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>
    Evaluator<R, AXES, INPUTS, TERMS, HISTORY>
{
    /// Number of inputs of the model.
    pub fn n_inputs(&self) -> usize {
        self.inputs.len()
    }

    /// Number of axes of the model.
    pub fn n_axes(&self) -> usize {
        self.axes.len()
    }

    /// True after the first sample since the model was loaded or reset.
    pub(crate) fn has_begun(&self) -> bool {
        !self.history.is_empty()
    }

    /// An evaluator without a model, which corrects nothing: initial value of a `static` before
    /// [`Image::load`](crate::Image::load).
    pub const fn empty() -> Self {
        const { assert!(INPUTS <= u32::BITS as usize && AXES <= u32::BITS as usize, "at most 32 of each") };
        Self {
            program: Program::new(),
            inputs: Vec::new(),
            axes: Vec::new(),
            history: History::new(),
            header: ModelHeader { period_s: 0.0, n_quantities: 0, n_inputs: 0, n_axes: 0 },
        }
    }

    /// Discards the model in place; the evaluator is then [empty](Self::empty).
    // not inlined: one copy for all ways to load a model
    #[inline(never)]
    pub fn clear(&mut self) {
        self.program.clear();
        self.inputs.clear();
        self.axes.clear();
        self.history.clear();
    }

    /// Tracks the axes whose bit in `tracked` is set (the lowest bit is the first axis) and coasts the others. See
    /// [`Predictor::track_some`](crate::Predictor::track_some).
    // not inlined: the only step that a hub runs, with all registers
    #[inline(never)]
    pub fn track_some(&mut self, sample: &Sample<'_, R>, tracked: u32, corrections: &mut [Correction<R>]) {
        let mut left = tracked;
        self.step(sample, corrections, |axis, measured, correction| {
            if left & 1 == 1 {
                axis.track(measured, correction);
            } else {
                axis.coast(measured, correction);
            }
            left >>= 1;
        });
    }

    /// Tracks against the true values in `reference`. See
    /// [`Predictor::track_against`](crate::Predictor::track_against).
    pub fn track_against(
        &mut self,
        sample: &Sample<'_, R>,
        reference: &[R],
        corrections: &mut [Correction<R>],
    ) {
        let mut references = reference.iter();
        self.step(sample, corrections, |axis, measured, correction| {
            let reference = references.next().copied().unwrap_or(axis.constants.reference);
            // a true value that is not finite is unknown
            if reference.is_finite() {
                axis.track_against(measured, reference, correction);
            } else {
                axis.coast(measured, correction);
            }
        });
    }

    /// Predicts the error of the next tick without a sample. See [`Predictor::forecast`](crate::Predictor::forecast).
    pub fn forecast(&mut self, quantities: &[R], corrections: &mut [Correction<R>]) {
        let measured = [R::ZERO; AXES];
        self.step(&Sample { measured: &measured, quantities }, corrections, |axis, _, correction| {
            axis.forecast(correction);
        });
    }

    /// Advances over `ticks` missing samples; 0 changes nothing. See [`Predictor::skip`](crate::Predictor::skip).
    #[cold]
    pub fn skip(&mut self, ticks: u32, corrections: &mut [Correction<R>]) {
        if corrections.len() < self.axes.len() {
            return;
        }
        // one more than the longest gap limit or lag
        let stepped =
            ticks.min(self.axes.iter().map(|axis| axis.constants.settling_ticks()).fold(0, u32::max) + 1);
        if ticks > stepped {
            // longer than any gap limit: the axes restart instead of coasting. The steps come last, so that lagged
            // inputs have the right age.
            self.axes.iter_mut().for_each(|axis| axis.restart(ticks - stepped));
            self.pass(ticks - stepped);
        }
        for _ in 0..stepped {
            self.track_some(&Sample { measured: &[], quantities: &[] }, 0, corrections);
        }
    }

    /// Starts the clocks at `ticks` after power-on, so that a model loaded later has the right phase of the warm-up. Call
    /// it before the first sample.
    pub fn begin_after(&mut self, ticks: u32) {
        self.pass(ticks);
    }

    /// Advances the inputs. Not inlined: one copy for both callers, neither of which is on the hot path.
    #[inline(never)]
    fn pass(&mut self, ticks: u32) {
        for input in &mut self.inputs {
            input.skip(ticks);
        }
    }

    /// Lowers the full scale of an axis to `full_scale`, in its unit, for a sensor that saturates earlier than the model
    /// states. Values that are not positive or not below the present full scale have no effect.
    pub fn limit_full_scale(&mut self, axis: usize, full_scale: R) {
        if let Some(axis) = self.axes.get_mut(axis) {
            axis.constants.limit_full_scale(full_scale);
        }
    }

    /// Returns to the state at power-on: history, inputs and clocks are reset, the model stays.
    pub fn reset(&mut self) {
        self.history.clear();
        self.inputs.iter_mut().for_each(RunningInput::reset);
        self.axes.iter_mut().for_each(RunningAxis::reset);
    }

    /// Value u(n) of an input at the last sample, scaled; `None` if there is no such input.
    pub fn input(&self, index: usize) -> Option<R> {
        if index >= self.inputs.len() {
            return None;
        }
        let back = (self.inputs.len() + self.axes.len()).checked_sub(index)?;
        Window::<R, HISTORY>::place(back).map(|place| self.history.window().at(place))
    }

    #[inline(always)]
    fn step(
        &mut self,
        sample: &Sample<'_, R>,
        corrections: &mut [Correction<R>],
        mut take: impl FnMut(&mut RunningAxis<R>, R, &mut Correction<R>),
    ) {
        if corrections.len() < self.axes.len() {
            return;
        }
        let unusable =
            if self.inputs.is_empty() { Unusable::NONE } else { self.update_inputs(sample.quantities) };
        let window = self.history.window();
        let mut records = self.program.records();
        let mut limited = false;
        let mut measured = sample.measured.iter();
        for (axis, correction) in self.axes.iter_mut().zip(corrections.iter_mut()) {
            if !axis.constants.physical.is_empty {
                (axis.state.p, records) =
                    axis.constants.physical.evaluate(records, self.program.thirds(), window);
                limited |= axis.limit_physical();
            }
            (axis.state.predicted_remainder, records) =
                axis.constants.stochastic.evaluate(records, self.program.thirds(), window);
            match measured.next() {
                Some(&measured) => take(axis, measured, correction),
                None => axis.miss(correction),
            }
        }
        self.history.write(self.axes.iter().map(|axis| axis.state.remainder));
        if unusable.any() || limited {
            self.propagate_input_flags(unusable, corrections);
        }
    }

    /// Flags the corrections of the axes that use an unusable input, or whose physical part was limited.
    #[cold]
    fn propagate_input_flags(&mut self, unusable: Unusable, corrections: &mut [Correction<R>]) {
        for (axis, correction) in self.axes.iter_mut().zip(corrections) {
            correction.validity |= unusable.of(axis.constants.inputs_used) | axis.state.take_limited();
        }
    }

    /// Updates every input with a sample and writes the results into the history.
    #[inline(never)]
    fn update_inputs(&mut self, quantities: &[R]) -> Unusable {
        let mut unusable = Unusable::NONE;
        let mut bit = 1_u32;
        for input in &mut self.inputs {
            let logged = match input.source() {
                Source::Clock => None,
                Source::Quantity(index) => quantities.get(usize::from(index)).copied(),
                Source::Remainder(axis) => {
                    self.axes.get(usize::from(axis)).and_then(|axis| axis.state.remainder())
                }
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

/// Inputs whose value cannot be trusted in this sample, one bit each.
#[derive(Debug, Clone, Copy)]
struct Unusable {
    out_of_range: u32,
    not_finite: u32,
}

impl Unusable {
    const NONE: Self = Self { out_of_range: 0, not_finite: 0 };

    #[inline]
    fn any(self) -> bool {
        self.out_of_range | self.not_finite != 0
    }

    /// Flags for an axis that uses the inputs `used`.
    fn of(self, used: u32) -> Validity {
        Validity::when(used & self.out_of_range != 0, Validity::INPUT_OUT_OF_RANGE)
            | Validity::when(used & self.not_finite != 0, Validity::INPUT_NOT_FINITE)
    }
}

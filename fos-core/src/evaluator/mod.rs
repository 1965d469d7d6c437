//! A model at work: inputs, terms, history and axes, one step per sample.

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

pub(crate) use building::Building;
#[cfg(feature = "coasts")]
pub use coasts::Coasts;

/// Everything logged at one instant.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sample<'a, R> {
    /// Measured value of every axis of the model, in its order and unit. An absent one counts as missing.
    pub measured: &'a [R],
    /// Every logged quantity of the model, in its order and unit. The last finite value stands in for NaN.
    pub quantities: &'a [R],
}

/// A [`Predictor`](crate::Predictor) that leaves the corrections to its caller: for one who keeps them anyway, as a hub
/// does, and has no memory for them twice. Capacities are those of a predictor.
///
/// Every method that takes a sample writes one correction per axis into `corrections`, in the order of the model, and
/// leaves the others as they are; without a place for every axis it does nothing. All else is as the predictor has it.
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
    building: Building,
}

/// How much of what there is, not the model.
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
    /// How many inputs the model has.
    pub fn n_inputs(&self) -> usize {
        self.inputs.len()
    }

    /// How many axes the model has.
    pub fn n_axes(&self) -> usize {
        self.axes.len()
    }
}

impl<R: Scalar, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>
    Evaluator<R, AXES, INPUTS, TERMS, HISTORY>
{
    /// An evaluator without a model, which corrects nothing: what a `static` begins with, before
    /// [`Image::load_evaluator`](crate::Image::load_evaluator).
    pub const fn empty() -> Self {
        const { assert!(INPUTS <= u32::BITS as usize && AXES <= u32::BITS as usize, "at most 32 of each") };
        Self {
            program: Program::new(),
            inputs: Vec::new(),
            axes: Vec::new(),
            history: History::new(),
            building: Building { period_s: 0.0, n_quantities: 0, n_inputs: 0, n_axes: 0 },
        }
    }

    /// Forgets the model: [`empty`](Self::empty) again, where it stands.
    pub fn clear(&mut self) {
        self.program.clear();
        self.inputs.clear();
        self.axes.clear();
        self.history.clear();
    }

    /// As [`Predictor::track_some`](crate::Predictor::track_some): the axes whose bit in `tracked` is set are tracked, the
    /// others coast.
    // the one step that a hub takes: it has the registers to itself
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

    /// As [`Predictor::track_against`](crate::Predictor::track_against).
    pub fn track_against(
        &mut self,
        sample: &Sample<'_, R>,
        reference: &[R],
        corrections: &mut [Correction<R>],
    ) {
        let mut references = reference.iter();
        self.step(sample, corrections, |axis, measured, correction| {
            let reference = references.next().copied().unwrap_or(axis.reference);
            // a true value that is not a number is not known
            if reference.is_finite() {
                axis.track_against(measured, reference, correction);
            } else {
                axis.coast(measured, correction);
            }
        });
    }

    /// As [`Predictor::forecast`](crate::Predictor::forecast).
    pub fn forecast(&mut self, quantities: &[R], corrections: &mut [Correction<R>]) {
        let measured = [R::ZERO; AXES];
        self.step(&Sample { measured: &measured, quantities }, corrections, |axis, _, correction| {
            axis.forecast(correction);
        });
    }

    /// As [`Predictor::skip`](crate::Predictor::skip).
    #[cold]
    pub fn skip(&mut self, ticks: u32, corrections: &mut [Correction<R>]) {
        // one more than any axis coasts or remembers
        let stepped = ticks.min(self.axes.iter().map(RunningAxis::reach).fold(0, u32::max) + 1);
        if ticks > stepped {
            // longer than any gap limit: nothing is coasted. The steps come last, so that lagged inputs are as
            // old as they should be.
            self.axes.iter_mut().for_each(|axis| axis.restart(ticks - stepped));
            self.pass(ticks - stepped);
        }
        for _ in 0..stepped {
            self.track_some(&Sample { measured: &[], quantities: &[] }, 0, corrections);
        }
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
            if !axis.physical.is_empty {
                (axis.p, records) = axis.physical.evaluate(records, self.program.thirds(), window);
                limited |= axis.limit_physical();
            }
            (axis.predicted_remainder, records) =
                axis.stochastic.evaluate(records, self.program.thirds(), window);
            match measured.next() {
                Some(&measured) => take(axis, measured, correction),
                None => axis.miss(correction),
            }
        }
        self.history.write(self.axes.iter().map(|axis| axis.remainder));
        if unusable.any() || limited {
            self.blame(unusable, corrections);
        }
    }

    /// Tells the axes that use them of inputs that cannot be trusted, alone or together.
    #[cold]
    fn blame(&mut self, unusable: Unusable, corrections: &mut [Correction<R>]) {
        for (axis, correction) in self.axes.iter_mut().zip(corrections) {
            correction.validity |= unusable.of(axis.inputs_used) | axis.take_limited();
        }
    }

    /// One sample into every input, and the inputs into the history.
    #[inline(never)]
    fn update_inputs(&mut self, quantities: &[R]) -> Unusable {
        let mut unusable = Unusable::NONE;
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
    const NONE: Self = Self { out_of_range: 0, not_finite: 0 };

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

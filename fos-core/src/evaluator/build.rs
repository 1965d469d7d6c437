//! Loads a model into an evaluator: checks it and compiles it for the step.

use core::borrow::Borrow;

use super::Evaluator;
use super::building::ModelHeader;
use crate::axis::{AxisProgram, RunningAxis};
use crate::input::RunningInput;
use crate::model::AxisParameters;
use crate::program::{DEGREES, Layout, Part};
use crate::real::{is_positive, scalar};
use crate::{Channel, Input, MAX_DEGREE, Model, ModelError, Real, Scalar, Term, Transform};

impl<R: Scalar, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>
    Evaluator<R, AXES, INPUTS, TERMS, HISTORY>
{
    /// Compiles a model in place, and resets history, inputs and clocks.
    ///
    /// # Errors
    ///
    /// The first fault of the model, or the first capacity that it exceeds; the evaluator is then [empty](Self::empty).
    pub fn load(&mut self, model: &Model<'_, R::Stored>) -> Result<(), ModelError> {
        let loaded = self.fill(model);
        if loaded.is_err() {
            self.clear();
        }
        loaded
    }

    fn fill(&mut self, model: &Model<'_, R::Stored>) -> Result<(), ModelError> {
        self.begin(ModelHeader {
            period_s: model.period_s,
            n_quantities: model.quantities.len(),
            n_inputs: model.inputs.len(),
            n_axes: model.axes.len(),
        })?;
        if let Some(calibration) = &model.calibration {
            calibration.check()?;
        }
        if let Some(limits) = &model.stillness {
            limits.check()?;
        }
        for input in model.inputs {
            self.add_input(input)?;
        }
        for axis in model.axes {
            self.add_axis(&axis.parameters, axis.physical.iter(), axis.stochastic.iter())?;
        }
        Ok(())
    }

    /// Starts a model without inputs and axes; add all of them before the first step.
    pub(crate) fn begin(&mut self, header: ModelHeader) -> Result<(), ModelError> {
        if !is_positive(scalar::<_, R::Built>(header.period_s)) {
            return Err(ModelError::Period);
        }
        if header.n_axes == 0 {
            return Err(ModelError::NoAxis);
        }
        if header.n_axes > AXES {
            return Err(ModelError::TooManyAxes { found: header.n_axes, capacity: AXES });
        }
        if header.n_inputs > INPUTS {
            return Err(ModelError::TooManyInputs { found: header.n_inputs, capacity: INPUTS });
        }
        self.clear();
        self.header = header;
        Ok(())
    }

    #[inline(never)]
    pub(crate) fn add_input(&mut self, input: &Input<R::Stored>) -> Result<(), ModelError> {
        if !cfg!(feature = "transforms") && input.transform != Transform::Identity {
            return Err(ModelError::TransformNotBuilt { input: self.inputs.len() });
        }
        input.check(self.inputs.len(), self.header.n_quantities, self.header.n_axes)?;
        if !input.fits::<R>() {
            return Err(ModelError::InputNotInFixedPoint { input: self.inputs.len() });
        }
        let too_many = ModelError::TooManyInputs { found: self.header.n_inputs, capacity: INPUTS };
        self.inputs.push(RunningInput::new(input, self.header.period_s)).map_err(|_| too_many)
    }

    #[inline(never)]
    pub(crate) fn add_axis(
        &mut self,
        parameters: &AxisParameters<R::Stored>,
        physical: impl Iterator<Item: Borrow<Term<R::Stored>>> + Clone,
        stochastic: impl Iterator<Item: Borrow<Term<R::Stored>>> + Clone,
    ) -> Result<(), ModelError> {
        let axis = self.axes.len();
        parameters.check(axis)?;
        let mut bounds = TermBounds::new(parameters);
        let physical = self.add_part(R::ZERO, physical, true, &mut bounds)?;
        let stochastic = self.add_part(R::of(parameters.constant), stochastic, false, &mut bounds)?;
        self.check_bounded(parameters, &bounds)?;
        let TermBounds { depth, inputs_used, .. } = bounds;
        self.push_axis(parameters, AxisProgram { physical, stochastic, inputs_used, depth })
    }

    // a separate function, so that its stack frame and that of the terms do not add up
    #[inline(never)]
    fn push_axis(
        &mut self,
        parameters: &AxisParameters<R::Stored>,
        program: AxisProgram<R>,
    ) -> Result<(), ModelError> {
        // checked first: a failed push returns the axis, and a second one would lie on the stack
        if self.axes.is_full() {
            return Err(ModelError::TooManyAxes { found: self.header.n_axes, capacity: AXES });
        }
        let _ = self.axes.push(RunningAxis::new(parameters, program, self.header.period_s));
        if let Some(axis) = self.axes.last_mut() {
            axis.begin();
        }
        Ok(())
    }

    /// Checks and compiles the terms of a part: those of one factor first, then of two, then of three.
    // not inlined: one copy for both parts
    #[inline(never)]
    fn add_part(
        &mut self,
        start: R,
        terms: impl Iterator<Item: Borrow<Term<R::Stored>>> + Clone,
        physical: bool,
        bounds: &mut TermBounds<R>,
    ) -> Result<Part<R>, ModelError> {
        let axis = self.axes.len();
        let layout = Layout { n_inputs: self.header.n_inputs, n_axes: self.header.n_axes };
        let mut part = self.program.part(start);
        let first = bounds.terms;
        for degree in 1..=MAX_DEGREE {
            for (term, index) in terms.clone().zip(first..) {
                let term = term.borrow();
                if term.factors().len() != degree {
                    continue;
                }
                self.check_term(term, index, physical, bounds)?;
                if degree > DEGREES {
                    return Err(ModelError::ProductNotBuilt { axis, term: index });
                }
                self.program.push::<HISTORY>(&mut part, term, axis, layout)?;
                bounds.terms += 1;
            }
        }
        Ok(part)
    }

    /// Checks a term and updates the bounds of the axis.
    fn check_term(
        &self,
        term: &Term<R::Stored>,
        index: usize,
        physical: bool,
        bounds: &mut TermBounds<R>,
    ) -> Result<(), ModelError> {
        let axis = self.axes.len();
        if !term.coefficient.is_finite() {
            return Err(ModelError::CoefficientNotFinite { axis, term: index });
        }
        let mut magnitude: R::Built = scalar(term.coefficient.abs());
        for factor in term.factors() {
            bounds.depth = bounds.depth.max(factor.lag);
            let (largest, is_output) = match factor.channel {
                Channel::Output => (bounds.output, true),
                Channel::Input(input) => {
                    bounds.inputs_used |= 1_u32.checked_shl(u32::from(input)).unwrap_or(0);
                    let input = self.inputs.get(usize::from(input));
                    let input = input.ok_or(ModelError::UnknownInput { axis, term: index })?;
                    (scalar(input.magnitude()), input.is_of_remainder())
                }
            };
            if physical && is_output {
                return Err(ModelError::OutputInPhysicalPart { axis, term: index });
            }
            magnitude = magnitude * larger(largest, R::Built::ONE);
        }
        bounds.magnitude = bounds.magnitude + magnitude;
        Ok(())
    }

    /// Rejects a model whose sums could overflow, so that the step needs no test for it: every partial product and sum
    /// stays below 10³⁰ while inputs, p and remainder stay within their limits, which the step enforces. Rejects
    /// innovation statistics with which a monitor could overflow, too.
    fn check_bounded(
        &self,
        parameters: &AxisParameters<R::Stored>,
        bounds: &TermBounds<R>,
    ) -> Result<(), ModelError> {
        let built = |value: R::Stored| -> R::Built { scalar(value) };
        // if 0 is outside its limits, p is limited to the end nearest to 0
        let nearest = parameters.physical_limits().limit(R::Stored::ZERO).abs();
        let scaled = bounds.output + built(parameters.constant.abs()) + built(nearest) + bounds.magnitude;
        let scale = built(parameters.scale);
        let axis = self.axes.len();
        let steady = built(parameters.offset.abs()) + built(parameters.reference.abs());
        let fits = R::holds(scaled.to_f64()) && R::holds((steady + scale * scaled).to_f64());
        match steady + larger(scale, R::Built::ONE) * scaled < R::Built::from_f64(BOUND) {
            true if !fits => Err(ModelError::AxisNotInFixedPoint { axis }),
            true if parameters.innovation.is_bounded(parameters.scale) => Ok(()),
            true => Err(ModelError::Innovation { axis }),
            false => Err(ModelError::Unbounded { axis }),
        }
    }
}

/// Bounds over the terms of an axis.
struct TermBounds<R: Scalar> {
    /// Largest magnitude of the remainder.
    output: R::Built,
    /// Terms up to now, physical part first.
    terms: usize,
    /// Longest lag, samples.
    depth: u16,
    /// Bit i is set if a term uses input i.
    inputs_used: u32,
    /// Largest sum of the magnitudes of the terms, with inputs and remainder within their limits.
    magnitude: R::Built,
}

impl<R: Scalar> TermBounds<R> {
    fn new(parameters: &AxisParameters<R::Stored>) -> Self {
        let output = scalar(RunningAxis::<R>::limits(parameters).magnitude());
        Self { output, terms: 0, depth: 0, inputs_used: 0, magnitude: R::Built::ZERO }
    }
}

/// Upper bound on any intermediate sum of an accepted model.
const BOUND: f64 = 1e30;

fn larger<R: Real>(a: R, b: R) -> R {
    if a > b { a } else { b }
}

//! A model into an evaluator: checked, and compiled to what a step needs.

use super::Evaluator;
use super::building::Building;
use crate::axis::{AxisProgram, RunningAxis};
use crate::input::RunningInput;
use crate::model::AxisParameters;
use crate::program::{DEGREES, Layout};
use crate::real::{is_positive, scalar};
use crate::{Channel, Input, Model, ModelError, Real, Scalar, Term, Transform};

impl<R: Scalar, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>
    Evaluator<R, AXES, INPUTS, TERMS, HISTORY>
{
    /// Takes a model in place, of which it keeps its own compiled copy; history, inputs and clocks start anew.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong with the model, or that there is no room for; it is then without a model.
    pub fn load(&mut self, model: &Model<'_, R::Stored>) -> Result<(), ModelError> {
        let loaded = self.fill(model);
        if loaded.is_err() {
            self.clear();
        }
        loaded
    }

    fn fill(&mut self, model: &Model<'_, R::Stored>) -> Result<(), ModelError> {
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

    /// Without inputs and axes; all of them must be added before it is used.
    pub(crate) fn begin(&mut self, building: Building) -> Result<(), ModelError> {
        if !is_positive(scalar::<_, R::Built>(building.period_s)) {
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
    pub(crate) fn add_input(&mut self, input: &Input<R::Stored>) -> Result<(), ModelError> {
        input.check(self.inputs.len(), self.building.n_quantities, self.building.n_axes)?;
        if !cfg!(feature = "transforms") && input.transform != Transform::Identity {
            return Err(ModelError::TransformNotBuilt { input: self.inputs.len() });
        }
        if !input.fits::<R>() {
            return Err(ModelError::InputNotInFixedPoint { input: self.inputs.len() });
        }
        let too_many = ModelError::TooManyInputs { found: self.building.n_inputs, capacity: INPUTS };
        self.inputs.push(RunningInput::new(input, self.building.period_s)).map_err(|_| too_many)
    }

    #[inline(never)]
    pub(crate) fn add_axis(
        &mut self,
        parameters: &AxisParameters<R::Stored>,
        physical: impl Iterator<Item = Term<R::Stored>> + Clone,
        stochastic: impl Iterator<Item = Term<R::Stored>> + Clone,
    ) -> Result<(), ModelError> {
        let axis = self.axes.len();
        parameters.check(axis)?;
        let mut seen = Seen::new(parameters);
        self.look_at(physical.clone(), true, &mut seen)?;
        self.look_at(stochastic.clone(), false, &mut seen)?;
        let Seen { depth, inputs_used, .. } = seen;
        self.check_bounded(parameters, &seen)?;

        let layout = Layout { n_inputs: self.building.n_inputs, n_axes: self.building.n_axes };
        let physical = self.program.append::<HISTORY>(R::ZERO, physical, axis, layout)?;
        let stochastic =
            self.program.append::<HISTORY>(R::of(parameters.constant), stochastic, axis, layout)?;
        self.push_axis(parameters, AxisProgram { physical, stochastic, inputs_used, depth })
    }

    // apart from what its terms need, so that the stack of one is not below the other's
    #[inline(never)]
    fn push_axis(
        &mut self,
        parameters: &AxisParameters<R::Stored>,
        program: AxisProgram<R>,
    ) -> Result<(), ModelError> {
        // asked before: what is not pushed would come back, a second axis on the stack
        if self.axes.is_full() {
            return Err(ModelError::TooManyAxes { found: self.building.n_axes, capacity: AXES });
        }
        let _ = self.axes.push(RunningAxis::new(parameters, program, self.building.period_s));
        if let Some(axis) = self.axes.last_mut() {
            axis.begin();
        }
        Ok(())
    }

    /// Checks the terms of a part, and takes note of what they come to.
    // once in the code, for both parts
    #[inline(never)]
    fn look_at(
        &self,
        terms: impl Iterator<Item = Term<R::Stored>>,
        physical: bool,
        seen: &mut Seen<R>,
    ) -> Result<(), ModelError> {
        let axis = self.axes.len();
        for term in terms {
            let index = seen.terms;
            term.check(axis, index, physical, |input| {
                self.inputs.get(usize::from(input)).map(RunningInput::source)
            })?;
            if term.factors().len() > DEGREES {
                return Err(ModelError::ProductNotBuilt { axis, term: index });
            }
            let mut magnitude: R::Built = scalar(term.coefficient.abs());
            for factor in term.factors() {
                seen.depth = seen.depth.max(factor.lag);
                let largest = match factor.channel {
                    Channel::Output => seen.output,
                    Channel::Input(input) => {
                        seen.inputs_used |= 1_u32.checked_shl(u32::from(input)).unwrap_or(0);
                        let input = self.inputs.get(usize::from(input));
                        input.map_or(R::Built::MAX, |input| scalar(input.magnitude()))
                    }
                };
                magnitude = magnitude * larger(largest, R::Built::ONE);
            }
            seen.magnitude = seen.magnitude + magnitude;
            seen.terms += 1;
        }
        Ok(())
    }

    /// Refuses a model whose sums could overflow, so that the step needs no test for it: every partial product and
    /// sum stays below 10³⁰ as long as inputs, p and remainder stay within their limits, and the step sees to that. The
    /// same for a monitor.
    fn check_bounded(
        &self,
        parameters: &AxisParameters<R::Stored>,
        seen: &Seen<R>,
    ) -> Result<(), ModelError> {
        let built = |value: R::Stored| -> R::Built { scalar(value) };
        // limited, p may end as far from 0 as its limits begin
        let nearest = parameters.physical_limits().limit(R::Stored::ZERO).abs();
        let scaled = seen.output + built(parameters.constant.abs()) + built(nearest) + seen.magnitude;
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

/// What the terms of an axis come to.
struct Seen<R: Scalar> {
    /// Within it the remainder is kept.
    output: R::Built,
    terms: usize,
    /// The longest lag.
    depth: u16,
    /// Bit i: input i is in a term.
    inputs_used: u32,
    /// The largest sum of the magnitudes of the terms, with inputs and remainder within their limits.
    magnitude: R::Built,
}

impl<R: Scalar> Seen<R> {
    fn new(parameters: &AxisParameters<R::Stored>) -> Self {
        let output = scalar(RunningAxis::<R>::limits(parameters).magnitude());
        Self { output, terms: 0, depth: 0, inputs_used: 0, magnitude: R::Built::ZERO }
    }
}

/// No sum of a model that is run gets there.
const BOUND: f64 = 1e30;

fn larger<R: Real>(a: R, b: R) -> R {
    if a > b { a } else { b }
}

//! A model into an evaluator: checked, and compiled to what a step needs.

use super::Evaluator;
use super::building::Building;
use crate::axis::{AxisProgram, RunningAxis};
use crate::input::RunningInput;
use crate::model::AxisParameters;
use crate::program::Layout;
use crate::real::is_positive;
use crate::{Channel, Input, Model, ModelError, Scalar, Term};

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
    pub(crate) fn add_input(&mut self, input: &Input<R::Stored>) -> Result<(), ModelError> {
        input.check(self.inputs.len(), self.building.n_quantities, self.building.n_axes)?;
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
        let stochastic =
            self.program.append::<HISTORY>(R::of(parameters.constant), stochastic, axis, layout)?;
        let program = AxisProgram { physical, stochastic, inputs_used, depth };
        let too_many = ModelError::TooManyAxes { found: self.building.n_axes, capacity: AXES };
        let running = RunningAxis::new(parameters, program, self.building.period_s);
        self.axes.push(running).map_err(|_| too_many)?;
        if let Some(axis) = self.axes.last_mut() {
            axis.begin();
        }
        Ok(())
    }

    /// Refuses a model whose sums could overflow, so that the step needs no test for it: every partial product and
    /// sum stays below 10³⁰ as long as inputs, p and remainder stay within their limits, and the step sees to that. The
    /// same for a monitor.
    fn check_bounded(
        &self,
        parameters: &AxisParameters<R::Stored>,
        physical: impl Iterator<Item = Term<R::Stored>>,
        stochastic: impl Iterator<Item = Term<R::Stored>>,
    ) -> Result<(), ModelError> {
        const BOUND: f64 = 1e30;
        let output = RunningAxis::<R>::limits(parameters).magnitude();
        let magnitude = |term: Term<R::Stored>| {
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
        let nearest = parameters.physical_limits().limit(R::Stored::ZERO).abs();
        let scaled = output
            + parameters.constant.to_f64().abs()
            + nearest.to_f64()
            + physical.map(magnitude).sum::<f64>()
            + stochastic.map(magnitude).sum::<f64>();
        let scale = parameters.scale.to_f64();
        let axis = self.axes.len();
        let steady = parameters.offset.to_f64().abs() + parameters.reference.to_f64().abs();
        let fits = R::holds(scaled) && R::holds(steady + scale * scaled);
        match steady + scale.max(1.0) * scaled < BOUND {
            true if !fits => Err(ModelError::AxisNotInFixedPoint { axis }),
            true if parameters.innovation.is_bounded(parameters.scale) => Ok(()),
            true => Err(ModelError::Innovation { axis }),
            false => Err(ModelError::Unbounded { axis }),
        }
    }
}

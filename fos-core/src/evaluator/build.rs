//! Loads a model into an evaluator: checks it and compiles it for the step.

use core::borrow::Borrow;

use super::Evaluator;
use super::building::ModelHeader;
use crate::axis::{AxisProgram, RunningAxis};
use crate::check::{Series, TermBounds, check_header};
use crate::input::RunningInput;
use crate::model::AxisParameters;
use crate::program::{DEGREES, Layout, Part, Uses};
use crate::real::scalar;
use crate::{AxisModel, Channel, CheckedModel, Input, MAX_DEGREE, Model, ModelError, Scalar, Term};

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
        self.settle(loaded)
    }

    /// Compiles a model that the compiler has checked; otherwise the same as [`load`](Self::load).
    ///
    /// # Errors
    ///
    /// The first capacity that the model exceeds, or that it does not suit fixed point.
    pub fn load_checked(&mut self, model: &CheckedModel<'_>) -> Result<(), ModelError>
    where
        R: Scalar<Stored = f32>,
    {
        let loaded = self.fill_checked(model);
        self.settle(loaded)
    }

    pub(crate) fn settle(&mut self, loaded: Result<(), ModelError>) -> Result<(), ModelError> {
        if loaded.is_err() {
            self.clear();
        }
        loaded
    }

    fn fill(&mut self, model: &Model<'_, R::Stored>) -> Result<(), ModelError> {
        check_header(model.period_s, model.axes.len())?;
        self.begin(ModelHeader::of(model))?;
        if let Some(calibration) = &model.calibration {
            calibration.convert::<f32>().check()?;
        }
        if let Some(limits) = &model.stillness {
            limits.convert::<f32>().check()?;
        }
        for input in model.inputs {
            self.add_input::<true>(&input.convert(), input)?;
        }
        for AxisModel { parameters, physical, stochastic } in model.axes {
            let in_f32 = parameters.convert();
            self.add_axis::<true>(&in_f32, parameters, physical.iter(), stochastic.iter())?;
        }
        Ok(())
    }

    fn fill_checked(&mut self, checked: &CheckedModel<'_>) -> Result<(), ModelError>
    where
        R: Scalar<Stored = f32>,
    {
        checked.fits(R::LIMIT)?;
        let model = checked.model();
        self.begin(ModelHeader::of(model))?;
        for input in model.inputs {
            self.add_input::<false>(input, input)?;
        }
        for AxisModel { parameters, physical, stochastic } in model.axes {
            self.add_axis::<false>(parameters, parameters, physical.iter(), stochastic.iter())?;
        }
        Ok(())
    }

    /// Starts a model without inputs and axes; add all of them before the first step.
    pub(crate) fn begin(&mut self, header: ModelHeader) -> Result<(), ModelError> {
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

    /// Adds an input, with `CHECK` after its check, which computes with the input in f32.
    #[inline(never)]
    pub(crate) fn add_input<const CHECK: bool>(
        &mut self,
        in_f32: &Input<f32>,
        input: &Input<R::Stored>,
    ) -> Result<(), ModelError> {
        if CHECK {
            let ModelHeader { n_quantities, n_axes, .. } = self.header;
            in_f32.check(self.inputs.len(), n_quantities, n_axes, R::LIMIT)?;
        }
        let too_many = ModelError::TooManyInputs { found: self.header.n_inputs, capacity: INPUTS };
        self.inputs.push(RunningInput::new(input, self.header.period_s)).map_err(|_| too_many)
    }

    /// Adds an axis, with `CHECK` after its checks, which compute with the parameters in f32.
    #[inline(never)]
    pub(crate) fn add_axis<const CHECK: bool>(
        &mut self,
        in_f32: &AxisParameters<f32>,
        parameters: &AxisParameters<R::Stored>,
        physical: impl Iterator<Item: Borrow<Term<R::Stored>>> + Clone,
        stochastic: impl Iterator<Item: Borrow<Term<R::Stored>>> + Clone,
    ) -> Result<(), ModelError> {
        let axis = self.axes.len();
        if CHECK {
            in_f32.check(axis)?;
        }
        let (mut bounds, mut uses) = (TermBounds::new(axis, in_f32), Uses::NOTHING);
        let physical = self.add_part::<CHECK>(R::ZERO, physical, true, &mut bounds, &mut uses)?;
        let start = R::of(parameters.constant);
        let stochastic = self.add_part::<CHECK>(start, stochastic, false, &mut bounds, &mut uses)?;
        if CHECK {
            bounds.check(in_f32, R::LIMIT)?;
        }
        self.push_axis(parameters, AxisProgram { physical, stochastic, uses })
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
            axis.constants.update_fast_path_range();
        }
        Ok(())
    }

    /// Compiles the terms of a part, with `CHECK` after their checks: those of one factor first, then of two, then of three.
    // not inlined: one copy for both parts
    #[inline(never)]
    fn add_part<const CHECK: bool>(
        &mut self,
        start: R,
        terms: impl Iterator<Item: Borrow<Term<R::Stored>>> + Clone,
        is_physical: bool,
        bounds: &mut TermBounds,
        uses: &mut Uses,
    ) -> Result<Part<R>, ModelError> {
        let axis = self.axes.len();
        let layout = Layout { n_inputs: self.header.n_inputs, n_axes: self.header.n_axes };
        let mut part = self.program.part(start);
        // the check rejects degrees that are not built
        for degree in 1..=if CHECK { MAX_DEGREE } else { DEGREES } {
            for (index, term) in terms.clone().enumerate() {
                let term = term.borrow();
                if term.factors().len() == degree {
                    if CHECK {
                        self.check_term(term, index, is_physical, bounds)?;
                    }
                    self.program.push::<HISTORY>(&mut part, term, axis, layout, uses)?;
                }
            }
        }
        Ok(part)
    }

    fn check_term(
        &self,
        term: &Term<R::Stored>,
        index: usize,
        is_physical: bool,
        bounds: &mut TermBounds,
    ) -> Result<(), ModelError> {
        bounds.begin(index, scalar(term.coefficient), is_physical)?;
        for factor in term.factors() {
            bounds.factor(match factor.channel {
                Channel::Output => Series::Output,
                Channel::Input(input) => match self.inputs.get(usize::from(input)) {
                    Some(input) => Series::Input {
                        magnitude: scalar(input.magnitude().stored()),
                        is_remainder: input.is_of_remainder(),
                    },
                    None => Series::Unknown,
                },
            })?;
        }
        bounds.end()
    }
}

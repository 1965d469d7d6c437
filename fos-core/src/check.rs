//! Checks of a model. After them no step can fail or overflow.
//!
//! They are constant functions: the compiler checks a model that is compiled in ([`CheckedModel`]), the device one that it
//! loads. They compute in f32, as which models are stored.

use crate::axis::RANGE_MARGIN;
use crate::input::INPUT_MARGIN;
use crate::model::PHYSICAL_MARGIN;
use crate::program::DEGREES;
use crate::{
    AxisModel, AxisParameters, Calibration, Channel, Input, Model, ModelError, Range, Source,
    StillnessLimits, Transform, TriadCalibration,
};

/// Largest magnitude of a scaled quantity. Its square, which the windowed variance computes, stays far from overflow
/// in f32: an infinite sum would stay in the state of the transform for ever.
const MAX_INPUT: f32 = 1e15;

/// Upper bound on any intermediate sum of an accepted model.
const BOUND: f32 = 1e30;

/// Largest magnitude of an element of a calibration's matrix. A sensor in SI units has ones on the diagonal within a few
/// percent.
const MAX_ELEMENT: f32 = 4.0;

/// A compiled-in model that was checked by the compiler: a device that loads it has no code for the checks. A wrong model
/// does not compile.
///
/// ```
/// use fos_core::{Axis, AxisModel, AxisParameters, CheckedModel, FittedOn, InnovationStatistics, Model, Range, Term, y};
///
/// static TERMS: [Term<f32>; 1] = [Term::new(0.8, &[y(1)])];
/// static AXES: [AxisModel<f32>; 1] = [AxisModel {
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
/// }];
/// static MODEL: CheckedModel = CheckedModel::new(Model {
///     period_s: 0.005,
///     fitted_on: FittedOn::Raw,
///     stillness: None,
///     calibration: None,
///     quantities: &[],
///     inputs: &[],
///     axes: &AXES,
/// });
/// ```
///
/// ```compile_fail
/// use fos_core::{CheckedModel, FittedOn, Model};
/// const WITHOUT_AXES: CheckedModel = CheckedModel::new(Model {
///     period_s: 0.005,
///     fitted_on: FittedOn::Raw,
///     stillness: None,
///     calibration: None,
///     quantities: &[],
///     inputs: &[],
///     axes: &[],
/// });
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CheckedModel<'a> {
    model: Model<'a, f32>,
    in_fixed_point: Result<(), ModelError>,
}

impl<'a> CheckedModel<'a> {
    /// Checks a model at compile time.
    ///
    /// # Panics
    ///
    /// At compile time, in a constant: if the model is invalid. [`Evaluator::load`](crate::Evaluator::load) of the same
    /// model returns the reason.
    pub const fn new(model: Model<'a, f32>) -> Self {
        match check(&model, f32::INFINITY) {
            Ok(()) => Self { model, in_fixed_point: check(&model, FIXED_LIMIT) },
            Err(ModelError::TransformNotBuilt { .. }) => {
                panic!("an input has a transform: feature `transforms`")
            }
            Err(ModelError::ProductNotBuilt { .. }) => panic!("a term is a product: feature `products`"),
            Err(_) => panic!("the model is invalid; Evaluator::load returns the reason"),
        }
    }

    /// The model.
    pub const fn model(&self) -> &Model<'a, f32> {
        &self.model
    }

    /// Fault of the model for values below `limit` alone.
    pub(crate) fn fits(&self, limit: f32) -> Result<(), ModelError> {
        if limit < f32::INFINITY { self.in_fixed_point } else { Ok(()) }
    }
}

/// Magnitude that no value of [`Fixed`](crate::Fixed) reaches.
pub(crate) const FIXED_LIMIT: f32 = 256.0;

/// Checks a model whose values must stay below `limit`. Indexing panics at compile time alone: a device checks the models
/// that it loads record by record.
const fn check(model: &Model<'_, f32>, limit: f32) -> Result<(), ModelError> {
    let (n_quantities, n_axes) = (model.quantities.len(), model.axes.len());
    if let Err(error) = check_header(model.period_s, n_axes) {
        return Err(error);
    }
    if let Some(calibration) = &model.calibration
        && let Err(error) = calibration.check()
    {
        return Err(error);
    }
    if let Some(limits) = &model.stillness
        && let Err(error) = limits.check()
    {
        return Err(error);
    }
    let mut input = 0;
    while input < model.inputs.len() {
        if let Err(error) = model.inputs[input].check(input, n_quantities, n_axes, limit) {
            return Err(error);
        }
        input += 1;
    }
    let mut axis = 0;
    while axis < n_axes {
        if let Err(error) = check_axis(axis, &model.axes[axis], model.inputs, limit) {
            return Err(error);
        }
        axis += 1;
    }
    Ok(())
}

const fn check_axis(
    axis: usize,
    model: &AxisModel<'_, f32>,
    inputs: &[Input<f32>],
    limit: f32,
) -> Result<(), ModelError> {
    if let Err(error) = model.parameters.check(axis) {
        return Err(error);
    }
    let (mut bounds, n_physical) = (TermBounds::new(axis, &model.parameters), model.physical.len());
    let mut term = 0;
    while term < n_physical + model.stochastic.len() {
        let is_physical = term < n_physical;
        let index = if is_physical { term } else { term - n_physical };
        let checked = if is_physical { &model.physical[index] } else { &model.stochastic[index] };
        if let Err(error) = bounds.begin(index, checked.coefficient, is_physical) {
            return Err(error);
        }
        let mut factor = 0;
        while factor < checked.degree() {
            if let Err(error) = bounds.factor(series(checked.factor(factor).channel, inputs)) {
                return Err(error);
            }
            factor += 1;
        }
        if let Err(error) = bounds.end() {
            return Err(error);
        }
        term += 1;
    }
    bounds.check(&model.parameters, limit)
}

const fn series(channel: Channel, inputs: &[Input<f32>]) -> Series {
    match channel {
        Channel::Output => Series::Output,
        Channel::Input(input) if (input as usize) < inputs.len() => {
            let Input { range, source, .. } = inputs[input as usize];
            let magnitude = magnitude(widened(range, INPUT_MARGIN as f32));
            Series::Input { magnitude, is_remainder: matches!(source, Source::Remainder(_)) }
        }
        Channel::Input(_) => Series::Unknown,
    }
}

/// Checks the sample period and the number of axes.
pub(crate) const fn check_header(period_s: f64, n_axes: usize) -> Result<(), ModelError> {
    if !is_positive(period_s as f32) {
        return Err(ModelError::Period);
    }
    if n_axes == 0 { Err(ModelError::NoAxis) } else { Ok(()) }
}

impl Input<f32> {
    /// Checks the parameters of the input and its source, for a model of `n_quantities` quantities and `n_axes` axes whose
    /// values must stay below `limit`.
    pub(crate) const fn check(
        &self,
        input: usize,
        n_quantities: usize,
        n_axes: usize,
        limit: f32,
    ) -> Result<(), ModelError> {
        if !cfg!(feature = "transforms") && !matches!(self.transform, Transform::Identity) {
            return Err(ModelError::TransformNotBuilt { input });
        }
        let numbers = self.transform.is_valid()
            && self.centre.is_finite()
            && is_positive(self.scale)
            && is_positive(1.0 / self.scale)
            && self.source_range.is_valid()
            && magnitude(self.source_range) < MAX_INPUT
            && self.range.is_valid();
        if !numbers {
            return Err(ModelError::InputParameter { input });
        }
        let is_clock = self.transform.is_clock();
        let source = match self.source {
            Source::Clock => is_clock,
            Source::Quantity(index) => !is_clock && (index as usize) < n_quantities,
            Source::Remainder(axis) => !is_clock && (axis as usize) < n_axes,
        };
        if !source {
            return Err(ModelError::InputSource { input });
        }
        if self.fits(limit) { Ok(()) } else { Err(ModelError::InputNotInFixedPoint { input }) }
    }

    /// True if every intermediate value of the input, from the logged quantity on, stays below `limit`.
    const fn fits(&self, limit: f32) -> bool {
        let (centre, scale) = (self.centre.abs(), self.scale);
        let x = magnitude(widened(self.source_range, INPUT_MARGIN as f32));
        let logged = match self.source {
            Source::Quantity(_) => centre + scale * x,
            Source::Clock | Source::Remainder(_) => 0.0,
        };
        let own = match self.transform {
            Transform::Backlash { half_width } => x + half_width / scale,
            Transform::Time => centre / scale,
            _ => 0.0,
        };
        let u = magnitude(widened(self.range, INPUT_MARGIN as f32));
        is_below(logged, limit) && is_below(x, limit) && is_below(own, limit) && is_below(u, limit)
    }
}

impl AxisParameters<f32> {
    pub(crate) const fn check(&self, axis: usize) -> Result<(), ModelError> {
        let valid = self.reference.is_finite()
            && self.offset.is_finite()
            && self.constant.is_finite()
            && self.innovation.mean.is_finite()
            && is_positive(self.scale)
            && is_positive(1.0 / self.scale)
            && self.range.is_valid()
            && self.physical_range.is_valid()
            && is_not_negative(self.full_scale)
            && is_not_negative(self.coast_limit_s)
            && is_positive(self.innovation.variance)
            && self.innovation.lag_1_correlation.abs() <= 1.0;
        if valid { Ok(()) } else { Err(ModelError::AxisParameter { axis }) }
    }

    /// True if every value that a [`Monitor`](crate::Monitor) computes from the innovation's statistics is finite, in f32
    /// too: the monitor limits an innovation to 10⁶ standard deviations, so its running variance is at most 4·10¹² times
    /// this one, and its factors are at most 10³⁸.
    const fn is_monitored(&self) -> bool {
        self.innovation.mean.abs() <= 1e15
            && self.innovation.variance >= 1e-38
            && self.innovation.variance <= 1e20
            && self.scale >= 1e-19
    }
}

/// Series that a factor delays.
pub(crate) enum Series {
    Output,
    Input {
        /// Largest magnitude.
        magnitude: f32,
        is_remainder: bool,
    },
    /// An input that the model does not have.
    Unknown,
}

/// Bounds over the terms of an axis.
pub(crate) struct TermBounds {
    axis: usize,
    /// Largest magnitude of the remainder.
    output: f32,
    /// Largest sum of the magnitudes of the terms, with inputs and remainder within their limits.
    sum: f32,
    /// Terms of the physical part.
    n_physical: usize,
    /// The term whose factors are added: its index, part, magnitude and degree.
    term: usize,
    is_physical: bool,
    magnitude: f32,
    degree: usize,
}

impl TermBounds {
    pub(crate) const fn new(axis: usize, parameters: &AxisParameters<f32>) -> Self {
        let output = magnitude(widened(parameters.range, RANGE_MARGIN as f32));
        Self { axis, output, sum: 0.0, n_physical: 0, term: 0, is_physical: false, magnitude: 0.0, degree: 0 }
    }

    /// Begins a term, by its index in its part; add its factors next. The terms of the physical part come first.
    pub(crate) const fn begin(
        &mut self,
        index: usize,
        coefficient: f32,
        is_physical: bool,
    ) -> Result<(), ModelError> {
        let term = if is_physical { index } else { self.n_physical + index };
        self.n_physical += is_physical as usize;
        (self.term, self.is_physical, self.magnitude, self.degree) =
            (term, is_physical, coefficient.abs(), 0);
        if coefficient.is_finite() {
            Ok(())
        } else {
            Err(ModelError::CoefficientNotFinite { axis: self.axis, term })
        }
    }

    pub(crate) const fn factor(&mut self, series: Series) -> Result<(), ModelError> {
        let (axis, term) = (self.axis, self.term);
        let (magnitude, is_output) = match series {
            Series::Output => (self.output, true),
            Series::Input { magnitude, is_remainder } => (magnitude, is_remainder),
            Series::Unknown => return Err(ModelError::UnknownInput { axis, term }),
        };
        if self.is_physical && is_output {
            return Err(ModelError::OutputInPhysicalPart { axis, term });
        }
        self.magnitude *= larger(magnitude, 1.0);
        self.degree += 1;
        Ok(())
    }

    /// Ends a term.
    pub(crate) const fn end(&mut self) -> Result<(), ModelError> {
        self.sum += self.magnitude;
        if self.degree > DEGREES {
            return Err(ModelError::ProductNotBuilt { axis: self.axis, term: self.term });
        }
        Ok(())
    }

    /// Rejects a model whose sums could overflow, so that the step needs no test for it: every partial product and sum
    /// stays below 10³⁰ while inputs, p and remainder stay within their limits, which the step enforces. Rejects
    /// innovation statistics with which a monitor could overflow, and values that do not stay below `limit`, too.
    pub(crate) const fn check(&self, parameters: &AxisParameters<f32>, limit: f32) -> Result<(), ModelError> {
        let axis = self.axis;
        // if 0 is outside its limits, p is limited to the end nearest to 0
        let Range { low, high } = widened(parameters.physical_range, PHYSICAL_MARGIN as f32);
        let nearest = if low > 0.0 {
            low
        } else if high < 0.0 {
            -high
        } else {
            0.0
        };
        let scaled = self.output + parameters.constant.abs() + nearest + self.sum;
        let steady = parameters.offset.abs() + parameters.reference.abs();
        let is_bounded = steady + larger(parameters.scale, 1.0) * scaled < BOUND;
        if !is_bounded {
            Err(ModelError::Unbounded { axis })
        } else if !(is_below(scaled, limit) && is_below(steady + parameters.scale * scaled, limit)) {
            Err(ModelError::AxisNotInFixedPoint { axis })
        } else if parameters.is_monitored() {
            Ok(())
        } else {
            Err(ModelError::Innovation { axis })
        }
    }
}

impl StillnessLimits<f32> {
    pub(crate) const fn check(&self) -> Result<(), ModelError> {
        let [x, y, z] = self.gyro_at_rest;
        let valid = self.window >= 2
            && is_positive(self.accel_variance)
            && is_positive(self.gyro_variance)
            && is_positive(self.gyro_deviation)
            && x.is_finite()
            && y.is_finite()
            && z.is_finite();
        if valid { Ok(()) } else { Err(ModelError::Stillness) }
    }
}

impl Calibration<f32> {
    /// Checks that every number is finite and no element of a matrix too large.
    ///
    /// # Errors
    ///
    /// [`ModelError::Calibration`].
    pub const fn check(&self) -> Result<(), ModelError> {
        if self.accel.is_valid() && self.gyro.is_valid() { Ok(()) } else { Err(ModelError::Calibration) }
    }
}

impl TriadCalibration<f32> {
    // not inlined: one copy for both triads
    #[inline(never)]
    const fn is_valid(&self) -> bool {
        let mut row = 0;
        while row < 3 {
            let [x, y, z] = self.matrix[row];
            let elements = x.abs() <= MAX_ELEMENT && y.abs() <= MAX_ELEMENT && z.abs() <= MAX_ELEMENT;
            if !(elements && self.bias[row].is_finite()) {
                return false;
            }
            row += 1;
        }
        true
    }
}

impl Transform<f32> {
    /// True if the parameter, if there is one, is finite and positive (a half width may be 0).
    pub const fn is_valid(&self) -> bool {
        match *self {
            Self::Identity | Self::Absolute | Self::Time => true,
            Self::LowPass { tau_s }
            | Self::Rate { tau_s }
            | Self::Variance { tau_s }
            | Self::Decay { tau_s } => is_positive(tau_s),
            Self::Backlash { half_width } => is_not_negative(half_width),
            Self::Sine { frequency_hz } | Self::Cosine { frequency_hz } => is_positive(frequency_hz),
        }
    }
}

impl Range<f32> {
    /// True if both ends are finite and `low ≤ high`.
    #[inline(never)]
    pub const fn is_valid(&self) -> bool {
        self.low.is_finite() && self.high.is_finite() && self.low <= self.high
    }
}

/// True if the value is finite and above 0.
// not inlined, as the next: models have many numbers to check
#[inline(never)]
const fn is_positive(value: f32) -> bool {
    value > 0.0 && value <= f32::MAX
}

/// True if the value is finite and not below 0.
#[inline(never)]
const fn is_not_negative(value: f32) -> bool {
    value >= 0.0 && value <= f32::MAX
}

/// True if a magnitude is below a limit of the scalar; floats have none.
const fn is_below(magnitude: f32, limit: f32) -> bool {
    limit == f32::INFINITY || magnitude < limit
}

const fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

const fn magnitude(range: Range<f32>) -> f32 {
    larger(range.low.abs(), range.high.abs())
}

/// The range widened on either side by `share` of its width, as [`Range::widened`].
const fn widened(range: Range<f32>, share: f32) -> Range<f32> {
    let margin = share * (range.high - range.low);
    Range::new(range.low - margin, range.high + margin)
}

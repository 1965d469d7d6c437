//! The predictor: one step per sample. It tracks from measurements and coasts on its own output.

use core::ops::{Deref, DerefMut};

use crate::axis::Correction;
use crate::{Evaluator, Model, ModelError, Sample, Scalar};

/// Evaluates a model sample by sample and subtracts the predicted error.
///
/// Capacities: `AXES`, `INPUTS` (at most 32), `TERMS` over all axes, and `HISTORY` values: a power of two up to 65536,
/// at least (longest lag) × (inputs + axes) + inputs.
///
/// The step cannot fail and cannot panic. Its cost is bounded and, except for gaps ([`skip`](Self::skip)), independent
/// of the data.
///
/// It is an [`Evaluator`] together with memory for the corrections, and has all its methods that return none: to load and
/// discard a model, to reset, to start the clocks.
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
///     calibration: None,
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
pub struct Predictor<
    R: Scalar,
    const AXES: usize,
    const INPUTS: usize,
    const TERMS: usize,
    const HISTORY: usize,
> {
    evaluator: Evaluator<R, AXES, INPUTS, TERMS, HISTORY>,
    corrections: [Correction<R>; AXES],
}

impl<R: Scalar, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize> Deref
    for Predictor<R, AXES, INPUTS, TERMS, HISTORY>
{
    type Target = Evaluator<R, AXES, INPUTS, TERMS, HISTORY>;

    fn deref(&self) -> &Self::Target {
        &self.evaluator
    }
}

impl<R: Scalar, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize> DerefMut
    for Predictor<R, AXES, INPUTS, TERMS, HISTORY>
{
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.evaluator
    }
}

/// Formats the number of inputs and the latest corrections, not the model.
#[cfg(feature = "defmt")]
impl<
    R: Scalar + defmt::Format,
    const AXES: usize,
    const INPUTS: usize,
    const TERMS: usize,
    const HISTORY: usize,
> defmt::Format for Predictor<R, AXES, INPUTS, TERMS, HISTORY>
{
    fn format(&self, f: defmt::Formatter<'_>) {
        let (inputs, corrections) = (self.evaluator.n_inputs(), &self.corrections);
        defmt::write!(f, "Predictor {{ inputs: {=usize}, corrections: {} }}", inputs, corrections);
    }
}

impl<R: Scalar, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>
    Predictor<R, AXES, INPUTS, TERMS, HISTORY>
{
    /// Builds a predictor with a compiled copy of `model`.
    ///
    /// # Errors
    ///
    /// The first fault of the model, or the first capacity that it exceeds.
    pub fn new(model: &Model<'_, R::Stored>) -> Result<Self, ModelError> {
        let mut predictor = Self::empty();
        predictor.load(model)?;
        Ok(predictor)
    }

    /// A predictor without a model, which corrects nothing: initial value of a `static` before
    /// [`Image::load`](crate::Image::load).
    pub const fn empty() -> Self {
        Self { evaluator: Evaluator::empty(), corrections: [Correction::NONE; AXES] }
    }

    /// Processes a sample at rest: the error is measured against the model's reference and enters the history.
    ///
    /// Returns one correction per axis.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn track(&mut self, sample: &Sample<'_, R>) -> &[Correction<R>] {
        self.track_some(sample, u32::MAX)
    }

    /// Same as [`track`](Self::track), with the true value of every axis in `reference`, in the axis' unit. Axes beyond
    /// the end of `reference` use the model's reference; axes whose true value is not finite coast.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn track_against(&mut self, sample: &Sample<'_, R>, reference: &[R]) -> &[Correction<R>] {
        self.evaluator.track_against(sample, reference, &mut self.corrections);
        self.corrections()
    }

    /// [Tracks](Self::track) the axes whose bit in `tracked` is set (the lowest bit is the first axis) and
    /// [coasts](Self::coast) the others.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn track_some(&mut self, sample: &Sample<'_, R>, tracked: u32) -> &[Correction<R>] {
        self.evaluator.track_some(sample, tracked, &mut self.corrections);
        self.corrections()
    }

    /// Processes a sample in motion: the error is not known, so the model's own output enters the history.
    ///
    /// Coasting cannot diverge for any coefficients: the remainder is limited to twice the width of its fitted range. After
    /// the longest validated duration, the subtracted remainder fades to its mean, 0; its time constant is that duration.
    /// The physical part continues with its inputs.
    ///
    /// A measured value that is not finite counts as a missing sample: the axis coasts up to its gap limit, then its
    /// history restarts. To continue without samples, call [`forecast`](Self::forecast).
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn coast(&mut self, sample: &Sample<'_, R>) -> &[Correction<R>] {
        self.track_some(sample, 0)
    }

    /// Corrections of the latest sample, one per axis; empty before the first sample after a load or reset.
    pub fn corrections(&self) -> &[Correction<R>] {
        let n = if self.evaluator.has_begun() { self.evaluator.n_axes() } else { 0 };
        self.corrections.get(..n).unwrap_or(&[])
    }

    /// Predicts the error of the next tick without a sample. Same as [`coast`](Self::coast), but not bounded by the gap
    /// limit. `corrected` is the latest measured value minus the prediction, with the flags of that value if it was not
    /// finite, saturated or stuck. If it was not finite, or there was no sample yet, the last corrected value is repeated and
    /// flagged [`NOT_FINITE`](crate::Validity::NOT_FINITE).
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
    /// let model = Model { period_s: 0.01, fitted_on: FittedOn::Raw, stillness: None, calibration: None, inputs: &[], quantities: &[], axes: &axes };
    /// let mut predictor = Predictor::<f64, 1, 1, 4, 8>::new(&model)?;
    /// let _ = predictor.track(&Sample { measured: &[2.0], quantities: &[] });
    /// for expected in [1.0, 0.5, 0.25, 0.125] {
    ///     assert_eq!(predictor.forecast(&[])[0].predicted, expected);
    /// }
    /// # Ok::<(), fos_core::ModelError>(())
    /// ```
    #[must_use = "carries whether the predicted values can be trusted"]
    pub fn forecast(&mut self, quantities: &[R]) -> &[Correction<R>] {
        self.evaluator.forecast(quantities, &mut self.corrections);
        self.corrections()
    }

    /// Advances over `ticks` missing samples. Each axis coasts up to its gap limit, then its history restarts; time
    /// advances for the inputs either way. Takes at most one step more than the longest gap limit or lag has ticks.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn skip(&mut self, ticks: u32) -> &[Correction<R>] {
        self.evaluator.skip(ticks, &mut self.corrections);
        self.corrections()
    }
}

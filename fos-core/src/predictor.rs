//! One step per sample: tracks from measurements, coasts on its own output.

use crate::axis::Correction;
use crate::{Evaluator, Model, ModelError, Sample, Scalar};

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
pub struct Predictor<
    R: Scalar,
    const AXES: usize,
    const INPUTS: usize,
    const TERMS: usize,
    const HISTORY: usize,
> {
    evaluator: Evaluator<R, AXES, INPUTS, TERMS, HISTORY>,
    corrections: [Correction<R>; AXES],
    /// There has been a sample.
    begun: bool,
}

/// What the latest sample came to, not the model.
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
    /// A predictor for `model`, of which it keeps its own compiled copy.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong with the model, or that there is no room for.
    pub fn new(model: &Model<'_, R::Stored>) -> Result<Self, ModelError> {
        let mut predictor = Self::empty();
        predictor.load(model)?;
        Ok(predictor)
    }

    /// Takes another model in place, compiled as by [`new`](Self::new); history, inputs and clocks start anew.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new); it is then without a model.
    pub fn load(&mut self, model: &Model<'_, R::Stored>) -> Result<(), ModelError> {
        self.begun = false;
        self.evaluator.load(model)
    }

    /// A predictor without a model, which corrects nothing: what a `static` begins with, before
    /// [`Image::load`](crate::Image::load).
    pub const fn empty() -> Self {
        Self { evaluator: Evaluator::empty(), corrections: [Correction::NONE; AXES], begun: false }
    }

    /// Forgets the model: [`empty`](Self::empty) again, where it stands.
    pub fn clear(&mut self) {
        self.evaluator.clear();
        self.begun = false;
    }

    /// The unit is still: measured error is known against the model's reference, and enters the history.
    ///
    /// Returns one correction per axis.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn track(&mut self, sample: &Sample<'_, R>) -> &[Correction<R>] {
        self.track_some(sample, u32::MAX)
    }

    /// As [`track`](Self::track), against the true value of every axis, in its unit. Where it is absent the model's
    /// reference stands in; where it is not finite the axis coasts.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn track_against(&mut self, sample: &Sample<'_, R>, reference: &[R]) -> &[Correction<R>] {
        self.evaluator.track_against(sample, reference, &mut self.corrections);
        self.latest()
    }

    /// As [`track`](Self::track) for the axes whose bit in `tracked` is set, the first axis' bit being the lowest;
    /// the others [coast](Self::coast).
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn track_some(&mut self, sample: &Sample<'_, R>, tracked: u32) -> &[Correction<R>] {
        self.evaluator.track_some(sample, tracked, &mut self.corrections);
        self.latest()
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
        self.track_some(sample, 0)
    }

    /// The corrections of the latest sample, one per axis; none before the first.
    pub fn corrections(&self) -> &[Correction<R>] {
        let n = if self.begun { self.evaluator.n_axes() } else { 0 };
        self.corrections.get(..n).unwrap_or(&[])
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
        self.evaluator.forecast(quantities, &mut self.corrections);
        self.latest()
    }

    /// `ticks` samples are missing. Up to each axis' gap limit they are coasted, beyond it the history restarts;
    /// time goes on for the inputs either way. Takes one step more than the longest gap limit or lag has ticks,
    /// however many are missing.
    #[must_use = "carries whether the corrected values can be trusted"]
    pub fn skip(&mut self, ticks: u32) -> &[Correction<R>] {
        self.evaluator.skip(ticks, &mut self.corrections);
        self.latest()
    }

    /// Clocks begin `ticks` after power-on: a model that is taken up later finds the sensor as warm as it is. To be
    /// called before the first sample.
    pub fn begin_after(&mut self, ticks: u32) {
        self.evaluator.begin_after(ticks);
    }

    /// Measured values of this magnitude count as saturated on an axis, in its unit, if its model says no less: what
    /// is known of the sensor beside the model.
    pub fn limit_full_scale(&mut self, axis: usize, full_scale: R) {
        self.evaluator.limit_full_scale(axis, full_scale);
    }

    /// As at power-on: history, inputs and clocks start anew.
    pub fn reset(&mut self) {
        self.evaluator.reset();
    }

    /// u(n) of an input, scaled, as of the last sample; `None` if there is no such input.
    pub fn input(&self, index: usize) -> Option<R> {
        self.evaluator.input(index)
    }

    /// The evaluator in it.
    #[cfg(feature = "coasts")]
    pub fn evaluator(&self) -> &Evaluator<R, AXES, INPUTS, TERMS, HISTORY> {
        &self.evaluator
    }

    /// How many axes the model has.
    pub fn n_axes(&self) -> usize {
        self.evaluator.n_axes()
    }

    /// For an image: the evaluator that takes it, while nothing is said of a sample.
    pub(crate) fn begin(&mut self) -> &mut Evaluator<R, AXES, INPUTS, TERMS, HISTORY> {
        self.begun = false;
        &mut self.evaluator
    }

    fn latest(&mut self) -> &[Correction<R>] {
        self.begun = true;
        self.corrections()
    }
}

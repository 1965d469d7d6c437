//! The hub: six axes over shared inputs, raw codes in, corrected SI units out.

mod axes;
mod error;
mod gravity;
mod load;
mod output;
mod quantities;
mod quantity_source;
mod rate;
#[cfg_attr(not(feature = "monitor"), path = "watch_nothing.rs")]
mod watch;

use core::hint::cold_path;

#[cfg(feature = "calibration")]
use fos_core::Calibration;
use fos_core::{Axis, Drift, Evaluator, InnovationStatistics, Sample, Scalar, StillnessDetector, Validity};
// the orientation gate is in fos-core, because the host uses it too
pub use fos_core::{GRAVITY_MPS2, OTHER_POSE};
use heapless::Vec;

pub use axes::{AXES, SIX};
use axes::{Gate, at, axis_of, channel_of};
pub use error::HubError;
use gravity::Gravity;
pub use gravity::leads_away;
pub use load::{PERIOD_TOLERANCE, is_near_period};
pub use output::Output;
pub use quantities::MAX_LOGGED;
use quantity_source::QuantitySource;
pub use quantity_source::is_given;
use rate::RateEstimator;
use watch::Watch;

use crate::raw::{Faults, RawSample, Scales, SiSample};

/// Largest relative difference between the true sampling rate and that of the model; beyond it the hub sets
/// [`Faults::RATE`]. At the limit a lag of ten samples is wrong by a tenth of a sample, a spectral line of 10 Hz by 0.1 Hz.
const RATE_TOLERANCE: f32 = 0.01;

/// The hub of the C interface, held by `fos_hub` in fos.h.
pub type CHub = Hub<16, 128, 256>;

/// Motion state of the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Motion {
    /// The device moves: the predictor coasts.
    Moving,
    /// The device is still: the predictor tracks, against the model's own reference.
    Still,
}

/// Six axes over shared inputs: the interface for an application.
///
/// The hub tracks while the device is still and coasts while it moves. Accelerometers also coast at rest in an orientation
/// other than that of the fit. Every corrected value is finite and bounded, and has a validity.
///
/// Capacities: `INPUTS`, which also limits the logged quantities, `TERMS` over all axes, and `HISTORY` values, as for
/// [`Predictor`](fos_core::Predictor). A model that needs more is rejected.
///
/// Arithmetic is in f32, or in fixed point with [`Fixed`](fos_core::Fixed) as the last parameter, for cores without an FPU:
/// same models, same calls. Models with values of 256 or more are then rejected too.
///
/// ```
/// use fos_core::FittedOn;
/// use fos_embedded::hub::Hub;
/// use fos_embedded::raw::{RawSample, Scales};
///
/// let scales = Scales {
///     accel_mps2: 0.001197, // ±4 g
///     gyro_rads: 0.000305,  // ±500 dps
///     temperature_k: 1.0 / 256.0,
///     temperature_zero_c: 25.0,
///     period_s: 0.005,
///     values: FittedOn::Raw,
/// };
/// let mut hub: Hub<8, 60, 128> = Hub::new(scales);
/// // hub.load(image)?; until then nothing is subtracted, and the output is flagged
/// let raw = RawSample { accel: [0, 0, 8192], temperature: Some(256), ..RawSample::default() };
/// let output = hub.update(&raw);
/// assert!((output.accel()[2] - 9.8).abs() < 0.01);
/// assert!(!output.is_valid());
///
/// let mut in_fixed_point: Hub<8, 60, 128, fos_core::Fixed> = Hub::new(scales);
/// assert!((in_fixed_point.update(&raw).accel()[2] - 9.8).abs() < 0.01);
/// ```
#[derive(Debug, Clone)]
pub struct Hub<const INPUTS: usize, const TERMS: usize, const HISTORY: usize, R: Scalar<Stored = f32> = f32> {
    scales: Scales,
    evaluator: Evaluator<R, AXES, INPUTS, TERMS, HISTORY>,
    detector: Option<StillnessDetector<R>>,
    /// Set by the application; `None` leaves it to the detector.
    motion: Option<Motion>,
    /// Index among the six of each axis of the model.
    axes: Vec<u8, AXES>,
    /// Index of the model's first axis, if its axes are consecutive among the six; otherwise `None`.
    first: Option<u8>,
    /// Gates of the accelerometers in the model.
    gates: Vec<Gate<R>, 3>,
    quantities: Vec<R, INPUTS>,
    sources: Vec<QuantitySource, INPUTS>,
    watch: Watch<R>,
    #[cfg(feature = "calibration")]
    calibration: Option<Calibration<R>>,
    /// `None` unless all three accelerometers are in the model.
    gravity: Option<Gravity<R>>,
    rate: RateEstimator,
    model_rate_hz: f32,
    rate_off: bool,
    /// All gates are open.
    in_pose: bool,
    /// Bit i is set if axis i of the model has no gate.
    without_gate: u32,
    /// Ticks since the hub was made; wraps, as telemetry does.
    ticks: u32,
    /// `ticks` has wrapped.
    wrapped: bool,
    output: Output<R>,
}

impl<const INPUTS: usize, const TERMS: usize, const HISTORY: usize, R: Scalar<Stored = f32>>
    Hub<INPUTS, TERMS, HISTORY, R>
{
    /// A hub without a model, for a sensor with these scales; usable in a `static`.
    pub const fn new(scales: Scales) -> Self {
        Self {
            scales,
            // evaluated at compile time: only zeros, set in place and not copied over the stack
            evaluator: const { Evaluator::empty() },
            detector: None,
            motion: None,
            axes: Vec::new(),
            first: Some(0),
            gates: Vec::new(),
            quantities: Vec::new(),
            sources: Vec::new(),
            watch: Watch::NOTHING,
            #[cfg(feature = "calibration")]
            calibration: None,
            gravity: None,
            rate: RateEstimator::new(),
            model_rate_hz: 0.0,
            rate_off: false,
            in_pose: false,
            without_gate: 0,
            ticks: 0,
            wrapped: false,
            output: Output::none(),
        }
    }

    /// Scales of the sensor's codes.
    pub fn scales(&self) -> &Scales {
        &self.scales
    }

    /// Sets the motion state, if the application knows it. `None`, the initial value, leaves it to the stillness limits of
    /// the model; a model without limits then always coasts.
    pub fn set_motion(&mut self, motion: Option<Motion>) {
        // the detector saw no samples meanwhile, so it starts in the moving state
        if motion != self.motion
            && let Some(detector) = &mut self.detector
        {
            detector.disturbed();
        }
        self.motion = motion;
    }

    /// Passes the time of the application's clock, µs since any origin, after all samples up to now were passed. Call it
    /// after every batch; it measures the true sampling rate.
    pub fn clock(&mut self, now_us: u64) {
        let set_back = self.rate.clock(now_us);
        let was_off = self.rate_off;
        let beyond_tolerance = self.rate.rate_hz().is_some_and(|rate_hz| {
            let off = (rate_hz - self.model_rate_hz).abs();
            self.model_rate_hz > 0.0 && off > RATE_TOLERANCE * self.model_rate_hz
        });
        self.rate_off = beyond_tolerance || set_back;
        if set_back {
            warn!("the application's clock was set back");
        } else if beyond_tolerance && !was_off {
            warn!(
                "sample rate off: {} Hz, the model's is {=f32} Hz",
                self.rate.rate_hz(),
                self.model_rate_hz
            );
        }
    }

    /// True sampling rate of the sensor by the application's clock, Hz; `None` before the first 10 s without a fault.
    pub fn rate_hz(&self) -> Option<f32> {
        self.rate.rate_hz()
    }

    /// Processes one sample and the skipped ticks before it.
    pub fn update(&mut self, raw: &RawSample) -> &Output<R> {
        self.output.measured = self.scales.measured_in(raw);
        self.output.temperature_c = self.scales.temperature_in(raw);
        self.take_measured(raw.skipped, raw.faults)
    }

    /// Processes a sample in SI units. Full scale, period and kind of values are those of the hub's [`Scales`]; see
    /// [`Scales::of_full_scale`].
    ///
    /// ```
    /// use fos_core::{FittedOn, Validity};
    /// use fos_embedded::hub::Hub;
    /// use fos_embedded::raw::{Faults, Scales, SiSample};
    ///
    /// let mut hub: Hub<8, 60, 128> =
    ///     Hub::new(Scales::of_full_scale(78.45, 34.9, 1.0 / 208.0, FittedOn::FactoryCorrected));
    /// let sample = SiSample {
    ///     skipped: 0,
    ///     accel: [0.0, 0.1, 9.8],
    ///     gyro: [0.01, -0.02, f32::NAN],
    ///     temperature_c: 31.5,
    ///     faults: Faults::empty(),
    /// };
    /// let output = hub.update_si(&sample);
    /// assert_eq!(output.corrected(), [0.0, 0.1, 9.8, 0.01, -0.02, 0.0]);
    /// assert!(output.validity()[5].contains(Validity::NOT_FINITE));
    /// ```
    pub fn update_si(&mut self, sample: &SiSample) -> &Output<R> {
        let [ax, ay, az] = sample.accel;
        let [gx, gy, gz] = sample.gyro;
        self.output.measured = [ax, ay, az, gx, gy, gz].map(R::of);
        self.output.temperature_c =
            if sample.temperature_c.is_finite() { R::of(sample.temperature_c) } else { R::NAN };
        self.take_measured(sample.skipped, sample.faults)
    }

    /// Processes the measured values in `self.output`.
    // not inlined, so that it has all registers
    #[inline(never)]
    fn take_measured(&mut self, skipped: u32, reported: Faults) -> &Output<R> {
        let mut faults = reported;
        if skipped > 0 || !faults.is_empty() {
            faults = self.disturbed(skipped, reported);
        }
        self.output.tick = self.ticks;
        self.count_ticks(1);
        let stuck = reported.contains(Faults::STUCK);
        let still = !stuck && self.is_still();
        if !self.sources.is_empty() {
            self.update_quantities();
        }
        let tracked = match (still, self.in_pose) {
            (true, true) => u32::MAX,
            (true, false) => self.without_gate,
            (false, _) => 0,
        };
        self.evaluate(tracked);

        let output = &mut self.output;
        (output.still, output.faults) = (still, faults);
        // an accelerometer measures the same gravity after a rotation about its own axis, so all gates must be open
        self.in_pose = self.gates.iter().all(|gate| gate.is_open_after(&output.corrections));
        if self.axes.len() < AXES {
            output.pass_others(&self.axes, &self.scales);
        }
        if let Some(gravity) = &mut self.gravity {
            gravity.update(output);
        }
        if stuck || output.suspect().contains(Validity::SATURATED) {
            output.flag(stuck);
        }
        #[cfg(feature = "calibration")]
        if let Some(calibration) = &self.calibration {
            output.calibrate(calibration);
        }
        if self.rate_off {
            output.faults |= Faults::RATE;
        }
        if let Some(index) = self.watch.update(&self.axes, &output.corrections) {
            let axis = self.axes.get(index).map(|channel| axis_of(*channel));
            warn!("model stopped fitting: {}, {}", axis, self.watch.drift(index));
        }
        output.drift = self.watch.any();
        output
    }

    /// Runs the sample through the model; tracks the axes whose bit in `tracked` is set.
    #[inline(always)]
    fn evaluate(&mut self, tracked: u32) {
        let Some(first) = self.first else { return self.evaluate_reordered(tracked, 0) };
        let (first, n) = (usize::from(first), self.axes.len());
        let measured = self.output.measured.get(first..).and_then(|from_first| from_first.get(..n));
        let corrections = self.output.corrections.get_mut(first..).unwrap_or(&mut []);
        let sample = Sample { measured: measured.unwrap_or(&[]), quantities: &self.quantities };
        self.evaluator.track_some(&sample, tracked, corrections);
    }

    /// Same as [`evaluate`](Self::evaluate), or [`skip`](Self::skip) if any ticks are `skipped`, for a model whose axes are
    /// not consecutive among the six.
    // together, for they need the same copy
    #[cold]
    #[inline(never)]
    fn evaluate_reordered(&mut self, tracked: u32, skipped: u32) {
        let mut corrections = self.output.corrections;
        if skipped > 0 {
            return self.evaluator.skip(skipped, &mut corrections);
        }
        let mut values = [R::ZERO; AXES];
        for (channel, value) in self.axes.iter().zip(&mut values) {
            *value = at(&self.output.measured, *channel);
        }
        let sample =
            Sample { measured: values.get(..self.axes.len()).unwrap_or(&[]), quantities: &self.quantities };
        self.evaluator.track_some(&sample, tracked, &mut corrections);
        for (channel, correction) in self.axes.iter().zip(&corrections) {
            if let Some(place) = self.output.corrections.get_mut(usize::from(*channel)) {
                *place = *correction;
            }
        }
    }

    /// Drift of the model of an axis; `None` if the axis has no model. The axes are monitored in turn, one second each.
    pub fn drift(&self, axis: Axis) -> Option<Drift> {
        self.watch.drift(self.index_of(axis)?)
    }

    /// Running statistics of the innovation of an axis, in the scaled units of the model; `None` if the axis has no model.
    pub fn statistics(&self, axis: Axis) -> Option<InnovationStatistics<f32>> {
        self.watch.statistics(self.index_of(axis)?)
    }

    /// Ratio of the running standard deviation of the innovation to that of the fit; `None` if the axis has no model. It
    /// computes a square root: do not call it for every sample.
    pub fn deviation_ratio(&self, axis: Axis) -> Option<f32> {
        self.watch.deviation_ratio(self.index_of(axis)?)
    }

    /// Clears the drift of all axes and restarts the tests.
    pub fn restart_watch(&mut self) {
        self.watch.restart();
    }

    /// Output of the latest sample.
    pub fn output(&self) -> &Output<R> {
        &self.output
    }

    /// Index of an axis in the model.
    fn index_of(&self, axis: Axis) -> Option<usize> {
        let channel = channel_of(axis)?;
        self.axes.iter().position(|modelled| *modelled == channel)
    }

    #[inline(always)]
    fn count_ticks(&mut self, ticks: u32) {
        let (now, wraps) = self.ticks.overflowing_add(ticks);
        self.ticks = now;
        if wraps {
            cold_path();
            self.wrapped = true;
        }
        self.rate.tick(ticks);
    }

    /// Handles skipped ticks and reported faults; returns all faults of the sample.
    #[cold]
    fn disturbed(&mut self, skipped: u32, reported: Faults) -> Faults {
        if skipped > 0 {
            // with the tick of the sample below 2³²: otherwise the gap would vanish from the counter
            self.count_ticks(skipped.min(u32::MAX - 1));
            if let Some(gravity) = &mut self.gravity {
                gravity.skip(self.ticks, skipped);
            }
            self.skip(skipped);
        }
        // neither a gap nor repeated codes show that the device is still
        if (skipped > 0 || reported.contains(Faults::STUCK))
            && let Some(detector) = &mut self.detector
        {
            detector.disturbed();
        }
        if reported.intersects(Faults::BUS | Faults::OVERRUN | Faults::RESET) {
            self.rate.disturbed();
        }
        if skipped > 0 { reported | Faults::GAP } else { reported }
    }

    /// Advances the model over missing samples; their corrections are overwritten by the next sample.
    fn skip(&mut self, ticks: u32) {
        match self.first.and_then(|first| self.output.corrections.get_mut(usize::from(first)..)) {
            Some(corrections) => self.evaluator.skip(ticks, corrections),
            None => self.evaluate_reordered(0, ticks),
        }
    }

    /// Updates the logged quantities that the sensor itself measures.
    fn update_quantities(&mut self) {
        let Output { temperature_c, measured, .. } = &self.output;
        for (source, value) in self.sources.iter().zip(&mut self.quantities) {
            match source {
                QuantitySource::Thermometer => *value = *temperature_c,
                QuantitySource::Measured(channel) => *value = at(measured, *channel),
                QuantitySource::Application(_) => {}
            }
        }
    }

    fn is_still(&mut self) -> bool {
        match (self.motion, &mut self.detector) {
            (Some(motion), _) => motion == Motion::Still,
            (None, Some(detector)) => detector.update_six(&self.output.measured),
            (None, None) => false,
        }
    }
}

/// Formats the modelled axes and the latest output, not the model.
#[cfg(feature = "defmt")]
impl<const INPUTS: usize, const TERMS: usize, const HISTORY: usize, R: Scalar<Stored = f32>> defmt::Format
    for Hub<INPUTS, TERMS, HISTORY, R>
{
    fn format(&self, f: defmt::Formatter<'_>) {
        let axes: Vec<Axis, AXES> = self.axes.iter().map(|channel| axis_of(*channel)).collect();
        defmt::write!(
            f,
            "Hub {{ axes: {}, still: {=bool}, faults: {}, drift: {=bool} }}",
            axes,
            self.output.still,
            self.output.faults,
            self.output.drift
        );
    }
}

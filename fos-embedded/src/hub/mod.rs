//! The hub: six axes over shared inputs, raw codes in, corrected SI units out.

mod axes;
mod error;
mod gravity;
mod load;
mod output;
mod quantities;
mod quantity_source;
mod rate;
mod watch;

use fos_core::{Axis, Drift, InnovationStatistics, Predictor, Sample, StillnessDetector, Validity};
// the pose gate is fos-core's, for the host too
pub use fos_core::{GRAVITY_MPS2, OTHER_POSE};
use heapless::Vec;

pub use axes::{AXES, SIX};
use axes::{Modelled, at, axis_of, channel_of};
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

use crate::raw::{Faults, RawSample, Scales};

/// A true sample rate further than this from the model's, relative, is a [`Faults::RATE`]: a lag of ten samples is then
/// wrong by a tenth of a sample, a line of 10 Hz by 0.1 Hz.
const RATE_TOLERANCE: f32 = 0.01;

/// The hub behind the C interface: what `fos_hub` of fos.h holds.
pub type CHub = Hub<16, 128, 256>;

/// Whether the unit is still.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Motion {
    /// It moves: the predictor coasts.
    Moving,
    /// It is still: the predictor tracks, against the model's own reference.
    Still,
}

/// Six axes over shared inputs: what an application calls.
///
/// While the unit is still it tracks, while it moves it coasts; an accelerometer coasts too where it lies still in
/// another pose than that of the fit. Everything that comes out is finite and bounded, and says what speaks against
/// it.
///
/// Capacities: `INPUTS` and as many logged quantities, `TERMS` of all axes together, `HISTORY` values, as of
/// [`Predictor`]. A model that needs more is refused.
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
/// // hub.load(image)?; until then nothing is taken out, and the output says so
/// let raw = RawSample { accel: [0, 0, 8192], temperature: Some(256), ..RawSample::default() };
/// let output = hub.update(&raw);
/// assert!((output.accel()[2] - 9.8).abs() < 0.01);
/// assert!(!output.is_valid());
/// ```
#[derive(Debug, Clone)]
pub struct Hub<const INPUTS: usize, const TERMS: usize, const HISTORY: usize> {
    scales: Scales,
    predictor: Predictor<f32, AXES, INPUTS, TERMS, HISTORY>,
    detector: Option<StillnessDetector<f32>>,
    /// As the application says; none if it leaves that to the detector.
    motion: Option<Motion>,
    axes: Vec<Modelled, AXES>,
    /// Axis i of the model is the i-th of the six.
    in_order: bool,
    quantities: Vec<f32, INPUTS>,
    sources: Vec<QuantitySource, INPUTS>,
    watch: Watch,
    /// None if not all three accelerometers are in the model.
    gravity: Option<Gravity>,
    rate: RateEstimator,
    model_rate_hz: f32,
    rate_off: bool,
    /// Bit i: the gate of the model's axis i is open, so that it may be tracked.
    in_pose: u32,
    /// Bit i: the model's axis i has no gate that shuts.
    without_gate: u32,
    ticks: u32,
    output: Output,
}

impl<const INPUTS: usize, const TERMS: usize, const HISTORY: usize> Hub<INPUTS, TERMS, HISTORY> {
    /// A hub without a model, for a sensor with these scales; may be in a `static`.
    pub const fn new(scales: Scales) -> Self {
        Self {
            scales,
            // evaluated when compiling: nothing but zeros, which are set in place and not copied over the stack
            predictor: const { Predictor::empty() },
            detector: None,
            motion: None,
            axes: Vec::new(),
            in_order: true,
            quantities: Vec::new(),
            sources: Vec::new(),
            watch: Watch::NOTHING,
            gravity: None,
            rate: RateEstimator::new(),
            model_rate_hz: 0.0,
            rate_off: false,
            in_pose: 0,
            without_gate: 0,
            ticks: 0,
            output: Output::NONE,
        }
    }

    /// What the codes of the sensor mean.
    pub fn scales(&self) -> &Scales {
        &self.scales
    }

    /// Whether the unit is still, where the application knows; `None`, as at first, leaves that to the model's
    /// limits. A model without limits always coasts.
    pub fn set_motion(&mut self, motion: Option<Motion>) {
        // what was not watched is not known to have been still
        if motion != self.motion
            && let Some(detector) = &mut self.detector
        {
            detector.disturbed();
        }
        self.motion = motion;
    }

    /// What the application's clock shows, µs since whenever, now that all samples up to now were given. From it the
    /// true sample rate is found; call it after every batch.
    pub fn clock(&mut self, now_us: u64) {
        let set_back = self.rate.clock(now_us);
        let was_off = self.rate_off;
        let beyond_tolerance = self.rate.rate_hz().is_some_and(|rate_hz| {
            let off = rate_hz - self.model_rate_hz;
            self.model_rate_hz > 0.0 && off.max(-off) > RATE_TOLERANCE * self.model_rate_hz
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

    /// The sensor's true sample rate by the application's clock, Hz; none before the first 10 s without a fault.
    pub fn rate_hz(&self) -> Option<f32> {
        self.rate.rate_hz()
    }

    /// One sample, and what was skipped before it.
    // a function of its own has the registers to itself
    #[inline(never)]
    pub fn update(&mut self, raw: &RawSample) -> &Output {
        let ticks = raw.skipped.saturating_add(1);
        self.ticks = self.ticks.wrapping_add(ticks);
        self.rate.tick(ticks);
        let mut faults = raw.faults;
        if raw.skipped > 0 || !faults.is_empty() {
            faults = self.disturbed(raw);
        }
        let measured = self.scales.measured(raw);
        let stuck = raw.faults.contains(Faults::STUCK);
        let still = !stuck && self.is_still(&measured);
        let temperature_c = self.scales.temperature_c(raw);
        if !self.sources.is_empty() {
            self.update_quantities(temperature_c, &measured);
        }

        let mut values = measured;
        if !self.in_order {
            for (axis, value) in self.axes.iter().zip(&mut values) {
                *value = at(&measured, axis.channel);
            }
        }
        let sample =
            Sample { measured: values.get(..self.axes.len()).unwrap_or(&[]), quantities: &self.quantities };
        let tracked = if still { self.in_pose } else { 0 };
        let corrections = self.predictor.track_some(&sample, tracked);

        let output = &mut self.output;
        (output.tick, output.still, output.faults) = (self.ticks.wrapping_sub(1), still, faults);
        (output.measured, output.temperature_c) = (measured, temperature_c);
        let (mut in_pose, mut bit, mut suspect) = (0, 1_u32, Validity::VALID);
        for (axis, correction) in self.axes.iter().zip(corrections) {
            if axis.gate.is_open_after(correction.corrected) {
                in_pose |= bit;
            }
            bit <<= 1;
            suspect |= correction.validity;
            output.set(axis.channel, correction);
        }
        // turned about one of them an accelerometer feels the same gravity: the pose is that of all
        if in_pose != bit.wrapping_sub(1) {
            in_pose &= self.without_gate;
        }
        self.in_pose = in_pose;
        if self.axes.len() < AXES {
            output.pass_others(&self.axes, self.scales.full_scale());
        }
        if let Some(gravity) = &mut self.gravity {
            gravity.look_at(output);
        }
        if stuck || suspect.contains(Validity::SATURATED) {
            output.flag(stuck);
        }
        if self.rate_off {
            output.faults |= Faults::RATE;
        }
        if let Some(index) = self.watch.update(corrections) {
            let axis = self.axes.get(index).map(|axis| axis_of(axis.channel));
            warn!("model stopped fitting: {}, {}", axis, self.watch.drift(index));
        }
        output.drift = self.watch.any();
        output
    }

    /// Whether the model of an axis has stopped fitting; none if it has no model. All are watched in turn, a second
    /// each.
    pub fn drift(&self, axis: Axis) -> Option<Drift> {
        self.watch.drift(self.index_of(axis)?)
    }

    /// The running statistics of the innovation of an axis, in the model's scaled units; none if it has no model.
    pub fn statistics(&self, axis: Axis) -> Option<InnovationStatistics<f32>> {
        self.watch.statistics(self.index_of(axis)?)
    }

    /// Running standard deviation of the innovation of an axis over that of the fit: 1 as fitted. None if it has no
    /// model. It takes a square root: ask now and then, not every sample.
    pub fn deviation_ratio(&self, axis: Axis) -> Option<f32> {
        self.watch.deviation_ratio(self.index_of(axis)?)
    }

    /// Forgets that the model has stopped fitting, and tests anew.
    pub fn restart_watch(&mut self) {
        self.watch.restart();
    }

    /// What the latest sample came to.
    pub fn output(&self) -> &Output {
        &self.output
    }

    /// Place of an axis in the model.
    fn index_of(&self, axis: Axis) -> Option<usize> {
        let channel = channel_of(axis)?;
        self.axes.iter().position(|modelled| modelled.channel == channel)
    }

    /// Something is missing, or something went wrong; what.
    #[cold]
    fn disturbed(&mut self, raw: &RawSample) -> Faults {
        if raw.skipped > 0 {
            let _ = self.predictor.skip(raw.skipped);
        }
        // neither a gap nor codes that stand still say whether the unit does
        if (raw.skipped > 0 || raw.faults.contains(Faults::STUCK))
            && let Some(detector) = &mut self.detector
        {
            detector.disturbed();
        }
        if raw.faults.intersects(Faults::BUS | Faults::OVERRUN | Faults::RESET) {
            self.rate.disturbed();
        }
        if raw.skipped > 0 { raw.faults | Faults::GAP } else { raw.faults }
    }

    /// What the sensor itself measures of the logged quantities.
    fn update_quantities(&mut self, temperature_c: f32, measured: &[f32; AXES]) {
        for (source, value) in self.sources.iter().zip(&mut self.quantities) {
            match source {
                QuantitySource::Thermometer => *value = temperature_c,
                QuantitySource::Measured(channel) => *value = at(measured, *channel),
                QuantitySource::Application(_) => {}
            }
        }
    }

    fn is_still(&mut self, measured: &[f32; AXES]) -> bool {
        match (self.motion, &mut self.detector) {
            (Some(motion), _) => motion == Motion::Still,
            (None, Some(detector)) => {
                let [ax, ay, az, gx, gy, gz] = *measured;
                detector.update([ax, ay, az], [gx, gy, gz])
            }
            (None, None) => false,
        }
    }
}

/// Which axes are modelled, and what the latest sample came to; not the model.
#[cfg(feature = "defmt")]
impl<const INPUTS: usize, const TERMS: usize, const HISTORY: usize> defmt::Format
    for Hub<INPUTS, TERMS, HISTORY>
{
    fn format(&self, f: defmt::Formatter<'_>) {
        let axes: Vec<Axis, AXES> = self.axes.iter().map(|axis| axis_of(axis.channel)).collect();
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

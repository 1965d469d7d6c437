//! A model into the hub: which of the sensor's axes and quantities it has.

use fos_core::{
    AxisParameters, FittedOn, Image, Model, PoseGate, Quantity, Scalar, StillnessDetector, StillnessLimits,
};

use super::axes::{Gate, at, channel_of};
use super::gravity::Gravity;
use super::quantity_source::QuantitySource;
use super::{Hub, HubError, Output};

/// A model is refused if its sample period is further than this from what the sensor is set to, relative: the clocks
/// of such sensors are up to 5 % off, on either side of the fit.
pub const PERIOD_TOLERANCE: f32 = 0.1;

/// Whether a model with this sample period, s, runs on samples that come in that one: within [`PERIOD_TOLERANCE`]. A
/// period that is not a number is near none.
pub fn is_near_period(model_s: f64, sensor_s: f64) -> bool {
    // in 32 bits, of which it takes three
    let (model_s, sensor_s) = (model_s as f32, sensor_s as f32);
    let off = model_s - sensor_s;
    off.max(-off) <= PERIOD_TOLERANCE * sensor_s
}

impl<const INPUTS: usize, const TERMS: usize, const HISTORY: usize, R: Scalar<Stored = f32>>
    Hub<INPUTS, TERMS, HISTORY, R>
{
    /// Takes a model image; history and inputs start anew, clocks go on from when the hub was made. The image is not
    /// needed afterwards.
    ///
    /// # Errors
    ///
    /// Damaged, of another version, too large, or not for this sensor: then the hub has no model, and the output says
    /// so.
    pub fn load(&mut self, image: &[u8]) -> Result<(), HubError> {
        self.unload();
        // where it lies: an image is many words of stack
        let loaded = match &Image::parse(image) {
            Ok(image) => self.take(image),
            Err(error) => Err(HubError::Image(*error)),
        };
        self.settle(loaded)
    }

    /// As [`load`](Self::load), for a model that was compiled in: what `fos export --rust` writes.
    ///
    /// # Errors
    ///
    /// Too large, or not for this sensor: then the hub has no model, and the output says so.
    pub fn load_model(&mut self, model: &Model<'_, f32>) -> Result<(), HubError> {
        self.unload();
        let loaded = self.take_model(model);
        self.settle(loaded)
    }

    /// Leaves nothing of a model that was refused; sets the clocks of one that was taken.
    fn settle(&mut self, loaded: Result<(), HubError>) -> Result<(), HubError> {
        if let Err(error) = &loaded {
            warn!("model refused: {}", *error);
            self.unload();
        } else {
            // what a sensor does after power-on it has done
            self.evaluator.begin_after(self.ticks);
            info!("model loaded: {=usize} axes, {=usize} quantities", self.axes.len(), self.sources.len());
        }
        loaded
    }

    fn unload(&mut self) {
        self.evaluator.clear();
        self.axes.clear();
        self.gates.clear();
        self.first = Some(0);
        self.sources.clear();
        self.quantities.clear();
        self.detector = None;
        self.watch.clear();
        self.gravity = None;
        (self.model_rate_hz, self.rate_off) = (0.0, false);
        (self.in_pose, self.without_gate) = (false, 0);
        self.output = Output::NONE;
    }

    fn take(&mut self, image: &Image<'_>) -> Result<(), HubError> {
        self.check_fitted_on(image.fitted_on())?;
        image.load_evaluator(&mut self.evaluator).map_err(HubError::Image)?;
        let axes = image.axes().map(|axis| axis.parameters);
        self.connect(image.period_s(), axes, image.quantities(), image.stillness())
    }

    fn take_model(&mut self, model: &Model<'_, f32>) -> Result<(), HubError> {
        self.check_fitted_on(model.fitted_on)?;
        self.evaluator.load(model).map_err(|error| HubError::Image(error.into()))?;
        let axes = model.axes.iter().map(|axis| axis.parameters);
        self.connect(model.period_s, axes, model.quantities.iter().copied(), model.stillness)
    }

    fn check_fitted_on(&self, model: FittedOn) -> Result<(), HubError> {
        if model == self.scales.values {
            Ok(())
        } else {
            Err(HubError::FittedOn { model, sensor: self.scales.values })
        }
    }

    /// Which of the sensor's axes and quantities are the model's that the predictor has taken.
    // apart from decoding, so that the stack of one is not below the other's
    #[inline(never)]
    fn connect(
        &mut self,
        model: f64,
        axes: impl Iterator<Item = AxisParameters<f32>>,
        quantities: impl Iterator<Item = Quantity>,
        stillness: Option<StillnessLimits<f32>>,
    ) -> Result<(), HubError> {
        let sensor = self.scales.period_s;
        if !is_near_period(model, sensor) {
            return Err(HubError::Period { model_s: model as f32, sensor_s: sensor as f32 });
        }
        self.model_rate_hz = 1.0 / model as f32;
        for (index, parameters) in axes.enumerate() {
            self.connect_axis(index, &parameters).ok_or(HubError::Axis(index))?;
            self.watch.add(&parameters, model);
        }
        self.in_pose = self.gates.is_empty();
        self.gravity = self.gates.is_full().then_some(Gravity::NEW);
        for (index, quantity) in quantities.enumerate() {
            let source = match quantity {
                Quantity::Temperature => QuantitySource::Thermometer,
                Quantity::Measured(axis) => {
                    QuantitySource::Measured(channel_of(axis).ok_or(HubError::Quantity(index))?)
                }
                given => QuantitySource::Application(given),
            };
            self.sources.push(source).map_err(|_| HubError::Quantity(index))?;
            self.quantities.push(R::NAN).map_err(|_| HubError::Quantity(index))?;
        }
        self.detect_stillness(stillness);
        Ok(())
    }

    // as above
    #[inline(never)]
    fn detect_stillness(&mut self, limits: Option<StillnessLimits<f32>>) {
        self.detector = limits.and_then(|limits| StillnessDetector::new(limits).ok());
    }

    /// Which of the six an axis of the model is; none if it is none of them, or one that the model has twice.
    // as above
    #[inline(never)]
    fn connect_axis(&mut self, index: usize, parameters: &AxisParameters<f32>) -> Option<()> {
        let channel = channel_of(parameters.axis)?;
        if self.axes.contains(&channel) {
            return None;
        }
        if index == 0 {
            self.first = Some(channel);
        }
        self.first = self.first.filter(|first| usize::from(*first) + index == usize::from(channel));
        self.axes.push(channel).ok()?;
        let pose = PoseGate::new(parameters);
        if pose.is_open_at_first() {
            self.without_gate |= 1_u32.checked_shl(index as u32).unwrap_or(0);
        } else {
            self.gates.push(Gate { channel, pose: pose.convert() }).ok()?;
        }
        let full_scale = at(&self.scales.full_scale(), channel);
        self.evaluator.limit_full_scale(index, R::of(full_scale));
        Some(())
    }
}

//! Loads a model into the hub: maps its axes and quantities to those of the sensor.

use core::borrow::Borrow;

use fos_core::{
    AxisParameters, Calibration, CheckedModel, Evaluator, FittedOn, Image, Model, ModelError, PoseGate,
    Quantity, Scalar, StillnessDetector, StillnessLimits,
};

use super::axes::{AXES, Gate, channel_of, is_modelled};
use super::gravity::Gravity;
use super::quantity_source::QuantitySource;
use super::{Hub, HubError};

/// Largest relative difference between the sample periods of model and sensor; beyond it a model is rejected. Sensor clocks
/// are up to 5 % off, both in the log of the fit and on the device.
pub const PERIOD_TOLERANCE: f32 = 0.1;

/// True if a model with the sample period `model_s` runs on samples with the period `sensor_s` (both s), that is, within
/// [`PERIOD_TOLERANCE`]. False for NaN.
pub fn is_near_period(model_s: f64, sensor_s: f64) -> bool {
    // f32 suffices
    let (model_s, sensor_s) = (model_s as f32, sensor_s as f32);
    (model_s - sensor_s).abs() <= PERIOD_TOLERANCE * sensor_s
}

impl<const INPUTS: usize, const TERMS: usize, const HISTORY: usize, R: Scalar<Stored = f32>>
    Hub<INPUTS, TERMS, HISTORY, R>
{
    /// Loads a model image. History and inputs are reset; the clocks of the inputs continue from the creation of the hub, up
    /// to 2³² ticks (248 days at 200 Hz). The image is not needed afterwards.
    ///
    /// # Errors
    ///
    /// The image is damaged, of another version, too large, or not for this sensor. The hub then has no model, and its
    /// output is flagged [`NOT_MODELLED`](fos_core::Validity::NOT_MODELLED).
    pub fn load(&mut self, image: &[u8]) -> Result<(), HubError> {
        self.unload();
        // by reference: an image takes many words of stack
        let loaded = match &Image::parse(image) {
            Ok(image) => self.take(image),
            Err(error) => Err(HubError::Image(*error)),
        };
        self.settle(loaded)
    }

    /// Loads a model that is not an image; otherwise the same as [`load`](Self::load).
    ///
    /// # Errors
    ///
    /// The model is invalid, too large, or not for this sensor. The hub then has no model, as after [`load`](Self::load).
    pub fn load_model(&mut self, model: &Model<'_, f32>) -> Result<(), HubError> {
        self.unload();
        let loaded = self.take_model(model, |evaluator| evaluator.load(model));
        self.settle(loaded)
    }

    /// Loads a compiled-in model, as written by `fos export --rust`: the compiler has checked it. Otherwise the same as
    /// [`load`](Self::load).
    ///
    /// # Errors
    ///
    /// The model is too large, or not for this sensor. The hub then has no model, as after [`load`](Self::load).
    pub fn load_checked(&mut self, model: &CheckedModel<'_>) -> Result<(), HubError> {
        self.unload();
        let loaded = self.take_model(model.model(), |evaluator| evaluator.load_checked(model));
        self.settle(loaded)
    }

    /// Removes a rejected model; sets the clocks of an accepted one.
    fn settle(&mut self, loaded: Result<(), HubError>) -> Result<(), HubError> {
        if let Err(error) = &loaded {
            warn!("model refused: {}", *error);
            self.unload();
        } else {
            // effects since power-on (warm-up) continue where the sensor is
            self.evaluator.begin_after(if self.wrapped { u32::MAX } else { self.ticks });
            info!("model loaded: {=usize} axes, {=usize} quantities", self.axes.len(), self.sources.len());
        }
        loaded
    }

    // not inlined: one copy for both callers
    #[inline(never)]
    fn unload(&mut self) {
        self.evaluator.clear();
        self.axes.clear();
        self.gates.clear();
        self.first = Some(0);
        self.sources.clear();
        self.quantities.clear();
        self.detector = None;
        self.watch.clear();
        #[cfg(feature = "calibration")]
        {
            self.calibration = None;
        }
        self.gravity = None;
        (self.model_rate_hz, self.rate_off) = (0.0, false);
        (self.in_pose, self.without_gate) = (false, 0);
        self.output.clear();
    }

    fn take(&mut self, image: &Image<'_>) -> Result<(), HubError> {
        self.check_fitted_on(image.fitted_on())?;
        image.load(&mut self.evaluator).map_err(HubError::Image)?;
        self.take_calibration(|| image.calibration())?;
        let axes = image.axes().map(|axis| axis.parameters);
        self.connect(image.period_s(), axes, image.quantities(), image.stillness())
    }

    fn take_model(
        &mut self,
        model: &Model<'_, f32>,
        load: impl FnOnce(&mut Evaluator<R, AXES, INPUTS, TERMS, HISTORY>) -> Result<(), ModelError>,
    ) -> Result<(), HubError> {
        self.check_fitted_on(model.fitted_on)?;
        load(&mut self.evaluator).map_err(|error| HubError::Image(error.into()))?;
        self.take_calibration(|| model.calibration)?;
        let axes = model.axes.iter().map(|axis| &axis.parameters);
        self.connect(model.period_s, axes, model.quantities.iter().copied(), model.stillness)
    }

    #[cfg(feature = "calibration")]
    // as `connect`
    #[inline(never)]
    fn take_calibration(&mut self, of: impl FnOnce() -> Option<Calibration<f32>>) -> Result<(), HubError> {
        self.calibration = of().map(|calibration| calibration.convert());
        Ok(())
    }

    #[cfg(not(feature = "calibration"))]
    fn take_calibration(&mut self, of: impl FnOnce() -> Option<Calibration<f32>>) -> Result<(), HubError> {
        of().map_or(Ok(()), |_| Err(HubError::CalibrationNotBuilt))
    }

    fn check_fitted_on(&self, model: FittedOn) -> Result<(), HubError> {
        if model == self.scales.values {
            Ok(())
        } else {
            Err(HubError::FittedOn { model, sensor: self.scales.values })
        }
    }

    /// Maps the axes and quantities of the loaded model to those of the sensor.
    // a separate function, so that its stack frame and that of the decoding do not add up
    #[inline(never)]
    fn connect(
        &mut self,
        model: f64,
        axes: impl Iterator<Item: Borrow<AxisParameters<f32>>>,
        quantities: impl Iterator<Item = Quantity>,
        stillness: Option<StillnessLimits<f32>>,
    ) -> Result<(), HubError> {
        let sensor = self.scales.period_s;
        if !is_near_period(model, sensor) {
            return Err(HubError::Period { model_s: model as f32, sensor_s: sensor as f32 });
        }
        self.model_rate_hz = 1.0 / model as f32;
        for (index, parameters) in axes.enumerate() {
            let parameters = parameters.borrow();
            self.connect_axis(index, parameters).ok_or(HubError::Axis(index))?;
            self.watch.add(parameters, model);
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
        self.detector = limits.map(StillnessDetector::of_loaded);
    }

    /// Maps an axis of the model to one of the six; `None` if there is no such axis, or the model has it twice.
    // as above
    #[inline(never)]
    fn connect_axis(&mut self, index: usize, parameters: &AxisParameters<f32>) -> Option<()> {
        let channel = channel_of(parameters.axis)?;
        if is_modelled(&self.axes, channel) {
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
        self.evaluator.limit_full_scale(index, R::of(self.scales.full_scale(channel)));
        Some(())
    }
}

//! What a hub says of one sample.

use fos_core::{Correction, Validity};

use super::axes::{AXES, Modelled};
use crate::raw::Faults;

/// One corrected sample. Units: m/s² for accelerometers, rad/s for gyros. Everything is finite but what is absent: an
/// innovation, a temperature.
#[must_use = "carries whether the corrected values can be trusted"]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Output {
    /// Ticks since the hub was made; wraps.
    pub tick: u32,
    /// The unit counts as still.
    pub still: bool,
    /// As the sensor gave it.
    pub measured: [f32; AXES],
    /// Temperature of the sensor, °C; NaN where it is not known.
    pub temperature_c: f32,
    /// With the predicted error taken out.
    pub corrected: [f32; AXES],
    /// Measured minus predicted error; NaN where the true value is not known.
    pub innovation: [f32; AXES],
    /// What speaks against trusting each axis.
    pub validity: [Validity; AXES],
    /// What went wrong on the way from the sensor, and with its clock.
    pub faults: Faults,
    /// The model has stopped fitting on at least one axis.
    pub drift: bool,
}

impl Output {
    pub(super) const NONE: Self = Self {
        tick: 0,
        still: false,
        measured: [0.0; AXES],
        temperature_c: f32::NAN,
        corrected: [0.0; AXES],
        innovation: [f32::NAN; AXES],
        validity: [Validity::NOT_MODELLED; AXES],
        faults: Faults::empty(),
        drift: false,
    };

    /// Corrected specific force x, y, z, m/s².
    pub fn accel(&self) -> [f32; 3] {
        let [ax, ay, az, ..] = self.corrected;
        [ax, ay, az]
    }

    /// Corrected rate x, y, z, rad/s.
    pub fn gyro(&self) -> [f32; 3] {
        let [.., gx, gy, gz] = self.corrected;
        [gx, gy, gz]
    }

    /// Nothing speaks against any axis, and nothing went wrong.
    pub fn is_valid(&self) -> bool {
        self.faults.is_empty() && !self.drift && self.validity.iter().all(|validity| validity.is_valid())
    }

    /// What the model says of an axis.
    #[inline(always)]
    pub(super) fn set(&mut self, channel: u8, correction: &Correction<f32>) {
        let channel = usize::from(channel);
        let places = (
            self.corrected.get_mut(channel),
            self.innovation.get_mut(channel),
            self.validity.get_mut(channel),
        );
        if let (Some(corrected), Some(innovation), Some(validity)) = places {
            *corrected = correction.corrected;
            *innovation = correction.innovation.unwrap_or(f32::NAN);
            *validity = correction.validity;
        }
    }

    /// Axes that the model does not have: as measured.
    pub(super) fn pass_others(&mut self, axes: &[Modelled], full_scale: [f32; AXES]) {
        let places = self.corrected.iter_mut().zip(&mut self.validity).zip(self.measured).zip(full_scale);
        for (channel, (((corrected, validity), measured), full_scale)) in (0..).zip(places) {
            if axes.iter().all(|axis| axis.channel != channel) {
                let saturated = measured.abs() >= full_scale;
                *corrected = measured;
                *validity = Validity::NOT_MODELLED;
                if saturated {
                    *validity |= Validity::SATURATED;
                    self.faults |= Faults::SATURATED;
                }
            }
        }
    }

    #[cold]
    pub(super) fn flag(&mut self, stuck: bool) {
        for validity in &mut self.validity {
            if validity.contains(Validity::SATURATED) {
                self.faults |= Faults::SATURATED;
            }
            if stuck {
                *validity |= Validity::STUCK;
            }
        }
    }
}

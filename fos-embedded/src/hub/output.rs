//! What a hub says of one sample.

use fos_core::{Correction, Scalar, Validity};

use super::axes::AXES;
use crate::raw::Faults;

/// One corrected sample. Units: m/s² for accelerometers, rad/s for gyros. Everything is finite but what is absent: an
/// innovation, a temperature, and what was measured where the source gave no number.
#[must_use = "carries whether the corrected values can be trusted"]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output<R = f32> {
    /// Ticks since the hub was made; wraps.
    pub tick: u32,
    /// The unit counts as still.
    pub still: bool,
    /// As the sensor gave it.
    pub measured: [R; AXES],
    /// Temperature of the sensor, °C; NaN where it is not known.
    pub temperature_c: R,
    /// What the model says of each axis.
    pub corrections: [Correction<R>; AXES],
    /// What went wrong on the way from the sensor, and with its clock.
    pub faults: Faults,
    /// The model has stopped fitting on at least one axis.
    pub drift: bool,
}

impl<R: Scalar<Stored = f32>> Output<R> {
    pub(super) const NONE: Self = Self {
        tick: 0,
        still: false,
        measured: [R::ZERO; AXES],
        temperature_c: R::NAN,
        corrections: [Correction { validity: Validity::NOT_MODELLED, ..Correction::NONE }; AXES],
        faults: Faults::empty(),
        drift: false,
    };

    /// With the predicted error taken out.
    pub fn corrected(&self) -> [f32; AXES] {
        self.each(|axis| axis.corrected.stored())
    }

    /// The predicted error: the bias, offset included. 0 where the model does not have the axis.
    pub fn predicted(&self) -> [f32; AXES] {
        self.each(|axis| axis.predicted.stored())
    }

    /// Measured minus predicted error; NaN where the true value is not known.
    pub fn innovation(&self) -> [f32; AXES] {
        self.each(|axis| axis.innovation.map_or(f32::NAN, R::stored))
    }

    /// What speaks against trusting each axis.
    pub fn validity(&self) -> [Validity; AXES] {
        self.each(|axis| axis.validity)
    }

    /// Corrected specific force x, y, z, m/s².
    pub fn accel(&self) -> [f32; 3] {
        let [ax, ay, az, ..] = self.corrected();
        [ax, ay, az]
    }

    /// Corrected rate x, y, z, rad/s.
    pub fn gyro(&self) -> [f32; 3] {
        let [.., gx, gy, gz] = self.corrected();
        [gx, gy, gz]
    }

    /// Nothing speaks against any axis, and nothing went wrong.
    pub fn is_valid(&self) -> bool {
        self.faults.is_empty() && !self.drift && self.suspect().is_valid()
    }

    #[inline(always)]
    fn each<T>(&self, of: impl Fn(&Correction<R>) -> T) -> [T; AXES] {
        let [ax, ay, az, gx, gy, gz] = &self.corrections;
        [of(ax), of(ay), of(az), of(gx), of(gy), of(gz)]
    }

    /// All that speaks against any axis.
    // axis after axis, not a loop: it runs with every sample
    #[inline(always)]
    pub(super) fn suspect(&self) -> Validity {
        let [ax, ay, az, gx, gy, gz] = &self.corrections;
        ax.validity | ay.validity | az.validity | gx.validity | gy.validity | gz.validity
    }

    /// Axes that the model does not have: as measured, or as last measured where there is no number.
    #[inline(never)]
    pub(super) fn pass_others(&mut self, axes: &[u8], full_scale: [f32; AXES]) {
        let places = self.corrections.iter_mut().zip(self.measured).zip(full_scale);
        for (channel, ((correction, measured), full_scale)) in (0..).zip(places) {
            if axes.contains(&channel) {
                continue;
            }
            correction.validity = Validity::NOT_MODELLED;
            if measured.is_finite() {
                correction.corrected = measured;
            } else {
                correction.validity |= Validity::NOT_FINITE;
            }
            if measured.abs() >= R::of(full_scale) {
                correction.validity |= Validity::SATURATED;
            }
        }
    }

    #[cold]
    pub(super) fn flag(&mut self, stuck: bool) {
        for correction in &mut self.corrections {
            if correction.validity.contains(Validity::SATURATED) {
                self.faults |= Faults::SATURATED;
            }
            if stuck {
                correction.validity |= Validity::STUCK;
            }
        }
    }
}

/// Value by value, not axis by axis: so they are compared.
#[cfg(feature = "defmt")]
impl<R: Scalar<Stored = f32>> defmt::Format for Output<R> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "Output {{ tick: {=u32}, still: {=bool}, measured: {}, temperature_c: {=f32}, corrected: {}, innovation: {}, \
             validity: {}, faults: {}, drift: {=bool} }}",
            self.tick,
            self.still,
            self.measured.map(R::stored),
            self.temperature_c.stored(),
            self.corrected(),
            self.innovation(),
            self.validity(),
            self.faults,
            self.drift
        );
    }
}

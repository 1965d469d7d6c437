//! Output of a hub for one sample.

#[cfg(feature = "calibration")]
use fos_core::Calibration;
use fos_core::{Correction, Scalar, Validity};

use super::axes::{AXES, is_modelled};
use crate::raw::{Faults, Scales};

/// One corrected sample. Units: m/s² for accelerometers, rad/s for gyros. Every corrected and predicted value
/// is finite. NaN stands for an absent innovation or temperature, and for a measured value that the source did not give.
#[must_use = "carries whether the corrected values can be trusted"]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output<R = f32> {
    /// Ticks since the hub was made; wraps.
    pub tick: u32,
    /// The device counts as still.
    pub still: bool,
    /// Measured values of the sensor.
    pub measured: [R; AXES],
    /// Temperature of the sensor, °C; NaN where it is not known.
    pub temperature_c: R,
    /// Correction of each axis, before the calibration of the model.
    pub corrections: [Correction<R>; AXES],
    /// Corrected values after the calibration of the model, if it has one.
    #[cfg(feature = "calibration")]
    calibrated: Option<[R; AXES]>,
    /// Faults on the way from the sensor, and of its clock.
    pub faults: Faults,
    /// The model no longer fits on at least one axis.
    pub drift: bool,
}

impl<R: Scalar<Stored = f32>> Output<R> {
    const NOT_MODELLED: Correction<R> = Correction { validity: Validity::NOT_MODELLED, ..Correction::NONE };

    /// Output before the first sample.
    // not a constant, which would be copied from 156 bytes of flash
    pub(super) const fn none() -> Self {
        Self {
            tick: 0,
            still: false,
            measured: [R::ZERO; AXES],
            temperature_c: R::NAN,
            corrections: [Self::NOT_MODELLED; AXES],
            #[cfg(feature = "calibration")]
            calibrated: None,
            faults: Faults::empty(),
            drift: false,
        }
    }

    /// Returns to the output before the first sample, in place: another one would take much stack.
    pub(super) fn clear(&mut self) {
        let Self { tick, still, measured, temperature_c, corrections, faults, drift, .. } = self;
        (*tick, *still, *faults, *drift) = (0, false, Faults::empty(), false);
        (*measured, *temperature_c) = ([R::ZERO; AXES], R::NAN);
        corrections.fill(Self::NOT_MODELLED);
        #[cfg(feature = "calibration")]
        {
            self.calibrated = None;
        }
    }

    /// Corrected values: measured minus predicted error, calibrated if the model has a calibration.
    pub fn corrected(&self) -> [f32; AXES] {
        #[cfg(feature = "calibration")]
        if let Some(calibrated) = self.calibrated {
            return calibrated.map(R::stored);
        }
        self.each(|axis| axis.corrected.stored())
    }

    /// Predicted error, that is, the bias, offset included; 0 for axes without a model.
    pub fn predicted(&self) -> [f32; AXES] {
        self.each(|axis| axis.predicted.stored())
    }

    /// Innovation: measured minus predicted error; NaN if the true value is not known.
    pub fn innovation(&self) -> [f32; AXES] {
        self.each(|axis| axis.innovation.map_or(f32::NAN, R::stored))
    }

    /// Reasons not to trust each axis.
    pub fn validity(&self) -> [Validity; AXES] {
        self.each(|axis| axis.validity)
    }

    /// Corrected specific force x, y, z, m/s².
    pub fn accel(&self) -> [f32; 3] {
        let [ax, ay, az, ..] = self.corrected();
        [ax, ay, az]
    }

    /// Corrected angular rate x, y, z, rad/s.
    pub fn gyro(&self) -> [f32; 3] {
        let [.., gx, gy, gz] = self.corrected();
        [gx, gy, gz]
    }

    /// True if every axis is valid, there is no fault and no drift.
    pub fn is_valid(&self) -> bool {
        self.faults.is_empty() && !self.drift && self.suspect().is_valid()
    }

    #[inline(always)]
    fn each<T>(&self, of: impl Fn(&Correction<R>) -> T) -> [T; AXES] {
        let [ax, ay, az, gx, gy, gz] = &self.corrections;
        [of(ax), of(ay), of(az), of(gx), of(gy), of(gz)]
    }

    /// Union of the validities of all axes.
    // unrolled: it runs for every sample
    #[inline(always)]
    pub(super) fn suspect(&self) -> Validity {
        let [ax, ay, az, gx, gy, gz] = &self.corrections;
        ax.validity | ay.validity | az.validity | gx.validity | gy.validity | gz.validity
    }

    /// Fills in the axes without a model: the measured value, or the last finite one.
    #[inline(never)]
    pub(super) fn pass_others(&mut self, axes: &[u8], scales: &Scales) {
        for (channel, (correction, measured)) in (0..).zip(self.corrections.iter_mut().zip(&self.measured)) {
            if is_modelled(axes, channel) {
                continue;
            }
            correction.validity = Validity::NOT_MODELLED;
            if measured.is_finite() {
                correction.corrected = *measured;
            } else {
                correction.validity |= Validity::NOT_FINITE;
            }
            if measured.abs() >= R::of(scales.full_scale(channel)) {
                correction.validity |= Validity::SATURATED;
            }
        }
    }

    /// Calibrates the corrected values. A value that is missing or wrong in one axis makes the others of its triad wrong.
    #[cfg(feature = "calibration")]
    #[inline(never)]
    pub(super) fn calibrate(&mut self, calibration: &Calibration<R>) {
        self.calibrated = Some(calibration.apply(&self.corrections.each_ref().map(|axis| axis.corrected)));
        for triad in self.corrections.chunks_exact_mut(3) {
            let validity = triad.iter().fold(Validity::VALID, |all, axis| all | axis.validity);
            let shared =
                validity & (Validity::NOT_FINITE | Validity::SATURATED | Validity::STUCK | Validity::MISSING);
            triad.iter_mut().for_each(|axis| axis.validity |= shared);
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

/// Grouped by quantity, not by axis, which is easier to compare.
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

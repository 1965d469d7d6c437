//! Raw codes of a six-axis sensor, and what they mean.

use bitflags::bitflags;
use fos_core::{FittedOn, Scalar};

/// Codes of this magnitude and beyond are full scale: 16-bit sensors clip there.
const FULL_SCALE: f32 = 32_767.0;

bitflags! {
    /// What went wrong on the way from the sensor to a sample. It speaks of everything since the sample before.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct Faults: u16 {
        /// A transfer over the bus failed, and was repeated or given up.
        const BUS = 1;
        /// The sensor's FIFO ran over: samples are lost.
        const OVERRUN = 1 << 1;
        /// Samples are missing: [`RawSample::skipped`] says how many. The hub sets it itself where that is more than
        /// none.
        const GAP = 1 << 2;
        /// The sensor had been reset, was set up anew, or the clock of its stamps was set back.
        const RESET = 1 << 3;
        /// It does not say that it is the part it should be.
        const WRONG_PART = 1 << 4;
        /// All axes have repeated the same codes for longer than noise allows.
        const STUCK = 1 << 5;
        /// At least one axis is at full scale.
        const SATURATED = 1 << 6;
        /// The thermometer says that it has nothing to say.
        const TEMPERATURE = 1 << 7;
        /// The sensor's true sample rate is not the model's, or cannot be told: the application's clock was set back.
        const RATE = 1 << 8;
    }
}

/// As `Debug` has it.
#[cfg(feature = "defmt")]
impl defmt::Format for Faults {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Faults(");
        let (mut separator, mut names) = ("", self.iter_names());
        for (name, _) in &mut names {
            // as text: derived formats around this one ask for quotes
            defmt::write!(f, "{=str:a}{=str:a}", separator, name);
            separator = " | ";
        }
        // bits without a name, or none at all
        let unnamed = names.remaining().bits();
        if unnamed != 0 || self.is_empty() {
            defmt::write!(f, "{=str:a}{=u16:#x}", separator, unnamed);
        }
        defmt::write!(f, ")");
    }
}

/// What a sensor gave at one instant, axes x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RawSample {
    /// Ticks without a sample before this one.
    pub skipped: u32,
    /// Codes of the accelerometers.
    pub accel: [i16; 3],
    /// Codes of the gyros.
    pub gyro: [i16; 3],
    /// Code of the thermometer; none where it is invalid.
    pub temperature: Option<i16>,
    /// What went wrong since the sample before.
    pub faults: Faults,
}

/// The same in SI units: of a source that gives values, or codes of more than 16 bits. What it does not know, or gives as
/// NaN or infinite, is missing: the output says so.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SiSample {
    /// Ticks without a sample before this one.
    pub skipped: u32,
    /// Specific force, m/s².
    pub accel: [f32; 3],
    /// Rate, rad/s.
    pub gyro: [f32; 3],
    /// Temperature of the sensor, °C; NaN where it is not known.
    pub temperature_c: f32,
    /// What went wrong since the sample before.
    pub faults: Faults,
}

/// What the codes of a sensor mean, as it is set up.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scales {
    /// Of an accelerometer's code, m/s².
    pub accel_mps2: f32,
    /// Of a gyro's code, rad/s.
    pub gyro_rads: f32,
    /// Of the thermometer's code, K.
    pub temperature_k: f32,
    /// What the thermometer's code 0 stands for, °C.
    pub temperature_zero_c: f32,
    /// Sample period that the sensor is set to, s.
    pub period_s: f64,
    /// Whether the codes are as the sensor gives them, or after a correction of the factory's or the driver's.
    pub values: FittedOn,
}

impl Scales {
    /// Of a source that gives values: where its axes are at full scale (accelerometers m/s², gyros rad/s), its sample
    /// period in seconds, and what its values are. What is not known to have a full scale has `f32::MAX`.
    pub fn of_full_scale(accel_mps2: f32, gyro_rads: f32, period_s: f64, values: FittedOn) -> Self {
        Self {
            accel_mps2: code_of_full_scale(accel_mps2),
            gyro_rads: code_of_full_scale(gyro_rads),
            temperature_k: 0.0,
            temperature_zero_c: 0.0,
            period_s,
            values,
        }
    }

    /// Specific force x, y, z in m/s², then rate x, y, z in rad/s.
    #[inline]
    pub fn measured(&self, raw: &RawSample) -> [f32; 6] {
        self.measured_in(raw)
    }

    /// The same in the scalar of a hub.
    #[inline]
    pub(crate) fn measured_in<R: Scalar<Stored = f32>>(&self, raw: &RawSample) -> [R; 6] {
        // axis after axis, not a loop: it runs with every sample
        let [ax, ay, az] = raw.accel;
        let [gx, gy, gz] = raw.gyro;
        let (accel, gyro) = (self.accel_mps2, self.gyro_rads);
        [
            R::of_code(ax, accel),
            R::of_code(ay, accel),
            R::of_code(az, accel),
            R::of_code(gx, gyro),
            R::of_code(gy, gyro),
            R::of_code(gz, gyro),
        ]
    }

    /// Measured values of this magnitude are at full scale: of accelerometers in m/s², of gyros in rad/s.
    pub(crate) fn full_scale(&self) -> [f32; 6] {
        let (accel, gyro) = (FULL_SCALE * self.accel_mps2, FULL_SCALE * self.gyro_rads);
        [accel, accel, accel, gyro, gyro, gyro]
    }

    /// Temperature in °C; NaN where there is none.
    #[inline]
    pub fn temperature_c(&self, raw: &RawSample) -> f32 {
        self.temperature_in(raw)
    }

    /// The same in the scalar of a hub.
    #[inline]
    pub(crate) fn temperature_in<R: Scalar<Stored = f32>>(&self, raw: &RawSample) -> R {
        raw.temperature
            .map_or(R::NAN, |code| R::of_code(code, self.temperature_k) + R::of(self.temperature_zero_c))
    }
}

/// What a code stands for if the largest stands for `full_scale`; rounded down, so that a value at full scale is there.
fn code_of_full_scale(full_scale: f32) -> f32 {
    let code = full_scale / FULL_SCALE;
    if code * FULL_SCALE > full_scale { code.next_down() } else { code }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_at_full_scale_is_at_full_scale() {
        for full_scale in [39.226_6, 78.453_2, 156.906_4, 4.363_323, 34.906_585, 1.0, f32::MAX, 1e-30] {
            let scales = Scales::of_full_scale(full_scale, full_scale, 0.005, FittedOn::Raw);
            for found in scales.full_scale() {
                assert!(
                    found <= full_scale && f64::from(found) > f64::from(full_scale) * (1.0 - 3e-7),
                    "{full_scale} {found}"
                );
            }
        }
    }
}

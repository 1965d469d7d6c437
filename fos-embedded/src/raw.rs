//! Raw codes of a six-axis sensor and their scales.

use bitflags::bitflags;
use fos_core::{FittedOn, Scalar};

/// Magnitude from which a code is at full scale: 16-bit sensors clip there.
const FULL_SCALE: f32 = 32_767.0;

bitflags! {
    /// Faults on the way from the sensor to a sample, since the previous sample.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct Faults: u16 {
        /// A bus transfer failed, and was repeated or abandoned.
        const BUS = 1;
        /// The FIFO of the sensor overran: samples were lost.
        const OVERRUN = 1 << 1;
        /// Samples are missing; [`RawSample::skipped`] holds their number. The hub sets this flag itself if that is above 0.
        const GAP = 1 << 2;
        /// The sensor was reset or set up again, or the clock of its timestamps was set back.
        const RESET = 1 << 3;
        /// The identity register does not match the expected part.
        const WRONG_PART = 1 << 4;
        /// All axes have repeated the same codes for longer than noise allows.
        const STUCK = 1 << 5;
        /// At least one axis is at full scale.
        const SATURATED = 1 << 6;
        /// The thermometer reports an invalid value.
        const TEMPERATURE = 1 << 7;
        /// The true sampling rate of the sensor differs from that of the model, or is unknown because the application's
        /// clock was set back.
        const RATE = 1 << 8;
    }
}

/// Same text as `Debug`.
#[cfg(feature = "defmt")]
impl defmt::Format for Faults {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Faults(");
        let (mut separator, mut names) = ("", self.iter_names());
        for (name, _) in &mut names {
            // as text: derived formats around this one would add quotes
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

/// Codes of a sensor at one instant; axes x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RawSample {
    /// Ticks without a sample before this one.
    pub skipped: u32,
    /// Codes of the accelerometers.
    pub accel: [i16; 3],
    /// Codes of the gyros.
    pub gyro: [i16; 3],
    /// Code of the thermometer; `None` if invalid.
    pub temperature: Option<i16>,
    /// Faults since the previous sample.
    pub faults: Faults,
}

/// A sample in SI units, for sources that give values or codes of more than 16 bits. NaN and infinite values count as
/// missing and are flagged in the output.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SiSample {
    /// Ticks without a sample before this one.
    pub skipped: u32,
    /// Specific force, m/s².
    pub accel: [f32; 3],
    /// Angular rate, rad/s.
    pub gyro: [f32; 3],
    /// Temperature of the sensor, °C; NaN if not known.
    pub temperature_c: f32,
    /// Faults since the previous sample.
    pub faults: Faults,
}

/// Scales of the codes of a sensor as configured, its sample period and kind of values.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scales {
    /// Size of one code of the accelerometers, m/s².
    pub accel_mps2: f32,
    /// Size of one code of the gyros, rad/s.
    pub gyro_rads: f32,
    /// Size of one code of the thermometer, K.
    pub temperature_k: f32,
    /// Temperature at code 0 of the thermometer, °C.
    pub temperature_zero_c: f32,
    /// Sample period that the sensor is set to, s.
    pub period_s: f64,
    /// Kind of values: raw, or corrected by the factory calibration or the driver.
    pub values: FittedOn,
}

impl Scales {
    /// Scales of a source that gives values in SI units, from the full scale of the accelerometers, m/s², and gyros, rad/s,
    /// the sample period, s, and the kind of values. Use `f32::MAX` for an unknown full scale.
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

    /// Specific force x, y, z in m/s², then angular rate x, y, z in rad/s.
    #[inline]
    pub fn measured(&self, raw: &RawSample) -> [f32; 6] {
        self.measured_in(raw)
    }

    /// Same as [`measured`](Self::measured), in the scalar of a hub.
    #[inline]
    pub(crate) fn measured_in<R: Scalar<Stored = f32>>(&self, raw: &RawSample) -> [R; 6] {
        // unrolled: it runs for every sample
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

    /// Full scale of one of the six axes, by index: accelerometers in m/s², gyros in rad/s.
    pub(crate) fn full_scale(&self, channel: u8) -> f32 {
        FULL_SCALE * if channel < 3 { self.accel_mps2 } else { self.gyro_rads }
    }

    /// Temperature in °C; NaN if there is none.
    #[inline]
    pub fn temperature_c(&self, raw: &RawSample) -> f32 {
        self.temperature_in(raw)
    }

    /// Same as [`temperature_c`](Self::temperature_c), in the scalar of a hub.
    #[inline]
    pub(crate) fn temperature_in<R: Scalar<Stored = f32>>(&self, raw: &RawSample) -> R {
        raw.temperature
            .map_or(R::NAN, |code| R::of_code(code, self.temperature_k) + R::of(self.temperature_zero_c))
    }
}

/// Size of one code if the largest code is `full_scale`; rounded down, so that a value at full scale counts as such.
fn code_of_full_scale(full_scale: f32) -> f32 {
    let code = full_scale / FULL_SCALE;
    if code * FULL_SCALE > full_scale { code.next_down() } else { code }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_scale_is_never_rounded_up() {
        for full_scale in [39.226_6, 78.453_2, 156.906_4, 4.363_323, 34.906_585, 1.0, f32::MAX, 1e-30] {
            let scales = Scales::of_full_scale(full_scale, full_scale, 0.005, FittedOn::Raw);
            for found in (0..6).map(|channel| scales.full_scale(channel)) {
                assert!(
                    found <= full_scale && f64::from(found) > f64::from(full_scale) * (1.0 - 3e-7),
                    "{full_scale} {found}"
                );
            }
        }
    }
}

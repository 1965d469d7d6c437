//! Structures and numbers of the interface.

use core::ffi::{CStr, c_char};

use fos_core::Validity;

use crate::hub::AXES;
use crate::raw::Faults;

/// Version of this interface, incremented with every addition. Existing declarations never change, so a program compiled
/// with this header links and runs with every library whose fos_api_version() is this or higher.
pub const FOS_API_VERSION: u32 = 1;

/// Number of axes of a sensor, in the order of every array of six: accelerometer x, y, z, then gyro x, y, z.
pub const FOS_AXES: usize = 6;
/// Accelerometer x.
pub const FOS_AX: usize = 0;
/// Accelerometer y.
pub const FOS_AY: usize = 1;
/// Accelerometer z.
pub const FOS_AZ: usize = 2;
/// Gyro x.
pub const FOS_GX: usize = 3;
/// Gyro y.
pub const FOS_GY: usize = 4;
/// Gyro z.
pub const FOS_GZ: usize = 5;

/// Largest number of inputs, and of logged quantities, of a model.
pub const FOS_MAX_INPUTS: usize = 16;
/// Largest number of terms of a model, over all axes.
pub const FOS_MAX_TERMS: usize = 128;
/// Values in the history of a hub; a model needs (longest lag) x (inputs + axes) + inputs.
pub const FOS_MAX_HISTORY: usize = 256;

/// Validity: no reason against the value.
pub const FOS_VALIDITY_VALID: u16 = 0;
/// Validity: the history is not full yet; only the part of the error that inputs explain is subtracted.
pub const FOS_VALIDITY_WARMING_UP: u16 = 1;
/// Validity: part of the history is the model's own prediction; normal in motion and for a few samples after it.
pub const FOS_VALIDITY_OWN_HISTORY: u16 = 2;
/// Validity: the motion has lasted longer than the model was validated for; the predicted part fades out.
pub const FOS_VALIDITY_COASTING_TOO_LONG: u16 = 4;
/// Validity: the error is far outside its fitted range; it was limited.
pub const FOS_VALIDITY_OUTPUT_OUT_OF_RANGE: u16 = 8;
/// Validity: an input, or the part that inputs explain, is outside its fitted range; the edge of the range was used.
pub const FOS_VALIDITY_INPUT_OUT_OF_RANGE: u16 = 16;
/// Validity: the measured value is not finite; the previous corrected value is repeated.
pub const FOS_VALIDITY_NOT_FINITE: u16 = 32;
/// Validity: a logged quantity is not finite or was never given; its last finite value was used.
pub const FOS_VALIDITY_INPUT_NOT_FINITE: u16 = 64;
/// Validity: the measured value is at full scale.
pub const FOS_VALIDITY_SATURATED: u16 = 128;
/// Validity: the measured value has repeated for longer than noise allows.
pub const FOS_VALIDITY_STUCK: u16 = 256;
/// Validity: there was no sample.
pub const FOS_VALIDITY_MISSING: u16 = 512;
/// Validity: the model does not have this axis, or there is no model; nothing was subtracted.
pub const FOS_VALIDITY_NOT_MODELLED: u16 = 1024;
/// Validity: at rest, the corrected vector of the three accelerometers was further from gravity than the measured one: the
/// model was fitted to other data. Persists until a rest of a few seconds passes the check.
pub const FOS_VALIDITY_AWAY_FROM_GRAVITY: u16 = 2048;

/// Fault (all faults refer to the time since the previous sample): a bus transfer failed.
pub const FOS_FAULT_BUS: u16 = 1;
/// Fault: the FIFO of the sensor overran; samples were lost.
pub const FOS_FAULT_OVERRUN: u16 = 2;
/// Fault: samples are missing; fos_raw_sample.skipped holds their number. The hub sets it itself if that is above 0.
pub const FOS_FAULT_GAP: u16 = 4;
/// Fault: the sensor was reset or set up again, or the clock of its timestamps was set back.
pub const FOS_FAULT_RESET: u16 = 8;
/// Fault: the identity of the sensor does not match the expected part.
pub const FOS_FAULT_WRONG_PART: u16 = 16;
/// Fault: all axes have repeated the same codes for longer than noise allows.
pub const FOS_FAULT_STUCK: u16 = 32;
/// Fault: at least one axis is at full scale. The hub sets it itself.
pub const FOS_FAULT_SATURATED: u16 = 64;
/// Fault: the thermometer reports an invalid value.
pub const FOS_FAULT_TEMPERATURE: u16 = 128;
/// Fault: the true sampling rate of the sensor differs from that of the model by more than 1 %, or the application's clock
/// was set back. The hub sets it itself.
pub const FOS_FAULT_RATE: u16 = 256;

/// Kind of values: raw sensor output.
pub const FOS_VALUES_RAW: u8 = 0;
/// Kind of values: corrected by the factory calibration or the driver.
pub const FOS_VALUES_FACTORY_CORRECTED: u8 = 1;

/// Motion state of the device: FOS_MOTION_DETECT, FOS_MOTION_MOVING or FOS_MOTION_STILL.
pub type fos_motion = u8;
/// Motion: detected by the hub with the limits in the model; without limits the device counts as moving.
pub const FOS_MOTION_DETECT: fos_motion = 0;
/// Motion: the device moves; the model coasts on its own prediction.
pub const FOS_MOTION_MOVING: fos_motion = 1;
/// Motion: the device is still; the model tracks the measured error.
pub const FOS_MOTION_STILL: fos_motion = 2;

/// A logged quantity that the application gives: FOS_QUANTITY_...
pub type fos_quantity = u8;
/// Supply voltage, V.
pub const FOS_QUANTITY_SUPPLY_V: fos_quantity = 0;
/// Processor load, %.
pub const FOS_QUANTITY_LOAD_PCT: fos_quantity = 1;
/// Magnetic field x, uT.
pub const FOS_QUANTITY_MAGNETIC_X_UT: fos_quantity = 2;
/// Magnetic field y, uT.
pub const FOS_QUANTITY_MAGNETIC_Y_UT: fos_quantity = 3;
/// Magnetic field z, uT.
pub const FOS_QUANTITY_MAGNETIC_Z_UT: fos_quantity = 4;
/// True value of an axis, m/s^2 or rad/s; FOS_QUANTITY_REFERENCE + i for axis i.
pub const FOS_QUANTITY_REFERENCE: fos_quantity = 16;

/// Drift: the mean of the innovation has shifted.
pub const FOS_DRIFT_MEAN: u8 = 1;
/// Drift: the variance of the innovation has increased.
pub const FOS_DRIFT_VARIANCE: u8 = 2;

/// Scales of the codes of a sensor as configured, its sample period and kind of values.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_scales {
    /// Size of one code of the accelerometers, m/s^2; positive.
    pub accel_mps2: f32,
    /// Size of one code of the gyros, rad/s; positive.
    pub gyro_rads: f32,
    /// Size of one code of the thermometer, K; 0 if there is none.
    pub temperature_k: f32,
    /// Temperature at code 0 of the thermometer, degrees Celsius.
    pub temperature_zero_c: f32,
    /// Sample period that the sensor is set to, s; positive.
    pub period_s: f64,
    /// FOS_VALUES_RAW or FOS_VALUES_FACTORY_CORRECTED.
    pub values: u8,
}

/// Codes of a sensor at one instant.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_raw_sample {
    /// Number of sample periods without a sample before this one.
    pub skipped: u32,
    /// Codes of the accelerometers x, y, z; full scale from a magnitude of 32767.
    pub accel: [i16; 3],
    /// Codes of the gyros x, y, z; full scale from a magnitude of 32767.
    pub gyro: [i16; 3],
    /// Code of the thermometer.
    pub temperature: i16,
    /// FOS_FAULT_... since the previous sample; other bits are ignored.
    pub faults: u16,
    /// 0 if the code of the thermometer is invalid, any other value if it is valid.
    pub has_temperature: u8,
}

/// A sample in SI units, for sources that give values or codes of more than 16 bits. NaN and infinite values count as
/// missing and are flagged in the output.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_si_sample {
    /// Number of sample periods without a sample before this one.
    pub skipped: u32,
    /// Specific force x, y, z, m/s^2.
    pub accel: [f32; 3],
    /// Angular rate x, y, z, rad/s.
    pub gyro: [f32; 3],
    /// Temperature of the sensor, degrees Celsius; NaN if not known.
    pub temperature_c: f32,
    /// FOS_FAULT_... since the previous sample; other bits are ignored.
    pub faults: u16,
}

/// One corrected sample. Corrected values are always finite. NaN stands for an unknown innovation or temperature, and for a
/// measured value that the source did not give. Units: m/s^2 for accelerometers, rad/s for gyros. Arrays of six are in the
/// order FOS_AX to FOS_GZ.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_output {
    /// Number of sample periods since fos_hub_init(); wraps.
    pub tick: u32,
    /// Measured values, m/s^2, rad/s; after fos_hub_update_si() NaN or infinite if the sample was.
    pub measured: [f32; 6],
    /// Measured values minus predicted error, m/s^2, rad/s.
    pub corrected: [f32; 6],
    /// Measured error minus predicted error, m/s^2, rad/s; NaN if the true value is not known.
    pub innovation: [f32; 6],
    /// Temperature of the sensor, degrees Celsius; NaN if not known.
    pub temperature_c: f32,
    /// Reasons not to trust each axis: FOS_VALIDITY_...; 0 if there is none.
    pub validity: [u16; 6],
    /// Faults on the way from the sensor, and of its clock: FOS_FAULT_...; 0 if there is none.
    pub faults: u16,
    /// 1 if the device counts as still, else 0.
    pub still: u8,
    /// 1 if the model no longer fits on at least one axis (see fos_hub_drift()), else 0.
    pub drift: u8,
}

/// One corrected sample with the predicted error.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_si_output {
    /// Output as from fos_hub_update().
    pub output: fos_output,
    /// Predicted error, offset included, m/s^2, rad/s: the bias that a phone's framework requests. 0 on axes without a
    /// model.
    pub predicted: [f32; 6],
}

const _: () = {
    // c/layout.c has the same numbers, and those of the fields
    assert!(size_of::<fos_scales>() == 32 && align_of::<fos_scales>() == 8);
    assert!(size_of::<fos_raw_sample>() == 24 && align_of::<fos_raw_sample>() == 4);
    assert!(size_of::<fos_output>() == 96 && align_of::<fos_output>() == 4);
    assert!(size_of::<fos_si_sample>() == 36 && align_of::<fos_si_sample>() == 4);
    assert!(size_of::<fos_si_output>() == 120 && align_of::<fos_si_output>() == 4);
    assert!(FOS_AXES == AXES);
    assert!(FOS_VALIDITY_VALID == Validity::VALID.bits());
    assert!(FOS_VALIDITY_WARMING_UP == Validity::WARMING_UP.bits());
    assert!(FOS_VALIDITY_OWN_HISTORY == Validity::OWN_HISTORY.bits());
    assert!(FOS_VALIDITY_COASTING_TOO_LONG == Validity::COASTING_TOO_LONG.bits());
    assert!(FOS_VALIDITY_OUTPUT_OUT_OF_RANGE == Validity::OUTPUT_OUT_OF_RANGE.bits());
    assert!(FOS_VALIDITY_INPUT_OUT_OF_RANGE == Validity::INPUT_OUT_OF_RANGE.bits());
    assert!(FOS_VALIDITY_NOT_FINITE == Validity::NOT_FINITE.bits());
    assert!(FOS_VALIDITY_INPUT_NOT_FINITE == Validity::INPUT_NOT_FINITE.bits());
    assert!(FOS_VALIDITY_SATURATED == Validity::SATURATED.bits());
    assert!(FOS_VALIDITY_STUCK == Validity::STUCK.bits());
    assert!(FOS_VALIDITY_MISSING == Validity::MISSING.bits());
    assert!(FOS_VALIDITY_NOT_MODELLED == Validity::NOT_MODELLED.bits());
    assert!(FOS_VALIDITY_AWAY_FROM_GRAVITY == Validity::AWAY_FROM_GRAVITY.bits());
    assert!(FOS_FAULT_BUS == Faults::BUS.bits());
    assert!(FOS_FAULT_OVERRUN == Faults::OVERRUN.bits());
    assert!(FOS_FAULT_GAP == Faults::GAP.bits());
    assert!(FOS_FAULT_RESET == Faults::RESET.bits());
    assert!(FOS_FAULT_WRONG_PART == Faults::WRONG_PART.bits());
    assert!(FOS_FAULT_STUCK == Faults::STUCK.bits());
    assert!(FOS_FAULT_SATURATED == Faults::SATURATED.bits());
    assert!(FOS_FAULT_TEMPERATURE == Faults::TEMPERATURE.bits());
    assert!(FOS_FAULT_RATE == Faults::RATE.bits());
    // fails to compile if a fault is added in Rust but not here
    assert!(Faults::all().bits() == 2 * FOS_FAULT_RATE - 1);
};

/// Text of one FOS_VALIDITY_..., for a log: "valid" for 0, "unknown validity" for anything but exactly one of them. Never
/// NULL; the text is static.
#[unsafe(no_mangle)]
pub extern "C" fn fos_validity_text(bit: u16) -> *const c_char {
    validity_text(bit).as_ptr()
}

fn validity_text(bit: u16) -> &'static CStr {
    match bit {
        FOS_VALIDITY_VALID => c"valid",
        FOS_VALIDITY_WARMING_UP => c"warming up",
        FOS_VALIDITY_OWN_HISTORY => c"own history",
        FOS_VALIDITY_COASTING_TOO_LONG => c"coasting too long",
        FOS_VALIDITY_OUTPUT_OUT_OF_RANGE => c"output out of range",
        FOS_VALIDITY_INPUT_OUT_OF_RANGE => c"input out of range",
        FOS_VALIDITY_NOT_FINITE => c"not finite",
        FOS_VALIDITY_INPUT_NOT_FINITE => c"input not finite",
        FOS_VALIDITY_SATURATED => c"saturated",
        FOS_VALIDITY_STUCK => c"stuck",
        FOS_VALIDITY_MISSING => c"missing",
        FOS_VALIDITY_NOT_MODELLED => c"not modelled",
        FOS_VALIDITY_AWAY_FROM_GRAVITY => c"away from gravity",
        _ => c"unknown validity",
    }
}

//! The structures and numbers of the interface.

use core::ffi::{CStr, c_char};

use fos_core::Validity;

use crate::hub::AXES;
use crate::raw::Faults;

/// Version of this interface: raised with what is added. What a header before declares stays as it is, so that a program
/// compiled with it links and runs unchanged: with a library whose fos_api_version() is this or more.
pub const FOS_API_VERSION: u32 = 1;

/// Axes of a sensor, at these places of every array of six: accelerometer x, y, z, then gyro x, y, z.
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

/// A hub takes models of at most so many inputs, and as many logged quantities.
pub const FOS_MAX_INPUTS: usize = 16;
/// A hub takes models of at most so many terms, all axes together.
pub const FOS_MAX_TERMS: usize = 128;
/// A hub holds so many values of history: at least (longest lag) x (inputs + axes) + inputs of a model.
pub const FOS_MAX_HISTORY: usize = 256;

/// Validity: nothing speaks against the value.
pub const FOS_VALIDITY_VALID: u16 = 0;
/// Validity: the history is not full yet; only the part of the error that inputs explain is taken out.
pub const FOS_VALIDITY_WARMING_UP: u16 = 1;
/// Validity: some of the history is the model's own prediction; normal in motion and for a few samples after it.
pub const FOS_VALIDITY_OWN_HISTORY: u16 = 2;
/// Validity: in motion for longer than the model was validated for; the predicted part fades out.
pub const FOS_VALIDITY_COASTING_TOO_LONG: u16 = 4;
/// Validity: the error is far outside what was seen while fitting; it was limited.
pub const FOS_VALIDITY_OUTPUT_OUT_OF_RANGE: u16 = 8;
/// Validity: an input, or the inputs together, are outside what was seen while fitting; the edge of that range was used.
pub const FOS_VALIDITY_INPUT_OUT_OF_RANGE: u16 = 16;
/// Validity: the measured value is not finite; the corrected value before is repeated.
pub const FOS_VALIDITY_NOT_FINITE: u16 = 32;
/// Validity: a logged quantity is not finite or was never given; its last finite value was used.
pub const FOS_VALIDITY_INPUT_NOT_FINITE: u16 = 64;
/// Validity: the measured value is at full scale.
pub const FOS_VALIDITY_SATURATED: u16 = 128;
/// Validity: the measured value has repeated for longer than noise allows.
pub const FOS_VALIDITY_STUCK: u16 = 256;
/// Validity: there was no sample.
pub const FOS_VALIDITY_MISSING: u16 = 512;
/// Validity: the model does not have this axis, or there is no model; nothing was taken out.
pub const FOS_VALIDITY_NOT_MODELLED: u16 = 1024;
/// Validity: at rest the three accelerometers together, corrected, were further from gravity than as measured: the
/// model was fitted to something else. It stays until a rest of some seconds shows otherwise.
pub const FOS_VALIDITY_AWAY_FROM_GRAVITY: u16 = 2048;

/// Fault, as all of them since the sample before: a transfer over the bus failed.
pub const FOS_FAULT_BUS: u16 = 1;
/// Fault: the sensor's FIFO ran over; samples are lost.
pub const FOS_FAULT_OVERRUN: u16 = 2;
/// Fault: samples are missing; fos_raw_sample.skipped says how many. The hub sets it itself where that is more than
/// none.
pub const FOS_FAULT_GAP: u16 = 4;
/// Fault: the sensor had been reset, was set up anew, or the clock of its stamps was set back.
pub const FOS_FAULT_RESET: u16 = 8;
/// Fault: the sensor does not say that it is the part it should be.
pub const FOS_FAULT_WRONG_PART: u16 = 16;
/// Fault: all axes have repeated the same codes for longer than noise allows.
pub const FOS_FAULT_STUCK: u16 = 32;
/// Fault: at least one axis is at full scale. The hub sets it itself.
pub const FOS_FAULT_SATURATED: u16 = 64;
/// Fault: the thermometer says that it has nothing to say.
pub const FOS_FAULT_TEMPERATURE: u16 = 128;
/// Fault: the sensor's true sample rate is further than 1 % from the model's, or the clock that tells was set back.
/// The hub sets it itself.
pub const FOS_FAULT_RATE: u16 = 256;

/// The codes are as the sensor gives them.
pub const FOS_VALUES_RAW: u8 = 0;
/// The codes are after a correction by the factory or the driver.
pub const FOS_VALUES_FACTORY_CORRECTED: u8 = 1;

/// Whether the unit is still: one of FOS_MOTION_DETECT, FOS_MOTION_MOVING, FOS_MOTION_STILL.
pub type fos_motion = u8;
/// The hub finds out, by the limits in the model; a model without limits takes the unit to move always.
pub const FOS_MOTION_DETECT: fos_motion = 0;
/// It moves: the model coasts on its own prediction.
pub const FOS_MOTION_MOVING: fos_motion = 1;
/// It is still: the model follows the measured error.
pub const FOS_MOTION_STILL: fos_motion = 2;

/// A quantity that the application gives: one of the numbers that follow.
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
/// True value of axis i is FOS_QUANTITY_REFERENCE + i, m/s^2 or rad/s.
pub const FOS_QUANTITY_REFERENCE: fos_quantity = 16;

/// Drift: the mean of the innovation has shifted.
pub const FOS_DRIFT_MEAN: u8 = 1;
/// Drift: the variance of the innovation has grown.
pub const FOS_DRIFT_VARIANCE: u8 = 2;

/// What the codes of a sensor mean, as it is set up.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_scales {
    /// Of an accelerometer's code, m/s^2; positive.
    pub accel_mps2: f32,
    /// Of a gyro's code, rad/s; positive.
    pub gyro_rads: f32,
    /// Of the thermometer's code, K; 0 if there is none.
    pub temperature_k: f32,
    /// What the thermometer's code 0 stands for, degrees Celsius.
    pub temperature_zero_c: f32,
    /// Sample period that the sensor is set to, s; positive.
    pub period_s: f64,
    /// FOS_VALUES_RAW or FOS_VALUES_FACTORY_CORRECTED.
    pub values: u8,
}

/// What a sensor gave at one instant.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_raw_sample {
    /// Sample periods without a sample before this one.
    pub skipped: u32,
    /// Codes of the accelerometers x, y, z. A magnitude of 32767 and more is full scale.
    pub accel: [i16; 3],
    /// Codes of the gyros x, y, z. A magnitude of 32767 and more is full scale.
    pub gyro: [i16; 3],
    /// Code of the thermometer.
    pub temperature: i16,
    /// FOS_FAULT_... since the sample before; other bits are ignored.
    pub faults: u16,
    /// 0 if the code of the thermometer is not valid, anything else if it is.
    pub has_temperature: u8,
}

/// The same in SI units: of a source that gives values, or codes of more than 16 bits. A value that is NaN or infinite is
/// missing: the output says so.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_si_sample {
    /// Sample periods without a sample before this one.
    pub skipped: u32,
    /// Specific force x, y, z, m/s^2.
    pub accel: [f32; 3],
    /// Rate x, y, z, rad/s.
    pub gyro: [f32; 3],
    /// Temperature of the sensor, degrees Celsius; NaN where it is not known.
    pub temperature_c: f32,
    /// FOS_FAULT_... since the sample before; other bits are ignored.
    pub faults: u16,
}

/// One corrected sample. Every number in it is finite but what is not known: an innovation, a temperature, and what was
/// measured where the source gave no number. That is NaN. Units: m/s^2 for accelerometers, rad/s for gyros. Arrays of
/// six are in the order FOS_AX to FOS_GZ.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_output {
    /// Sample periods since the hub took its scales; wraps.
    pub tick: u32,
    /// As the sensor gave it, m/s^2, rad/s; of fos_hub_update_si() NaN or infinite where the sample was.
    pub measured: [f32; 6],
    /// With the predicted error taken out, m/s^2, rad/s.
    pub corrected: [f32; 6],
    /// Measured minus predicted error, m/s^2, rad/s; NaN where the true value is not known.
    pub innovation: [f32; 6],
    /// Temperature of the sensor, degrees Celsius; NaN where it is not known.
    pub temperature_c: f32,
    /// What speaks against trusting each axis: FOS_VALIDITY_...; 0 if nothing does.
    pub validity: [u16; 6],
    /// What went wrong on the way from the sensor, and with its clock: FOS_FAULT_...; 0 if nothing did.
    pub faults: u16,
    /// 1 if the unit counts as still, else 0.
    pub still: u8,
    /// 1 if the model has stopped fitting on at least one axis (fos_hub_drift says which), else 0.
    pub drift: u8,
}

/// One corrected sample, and what was taken out of it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct fos_si_output {
    /// As of fos_hub_update().
    pub output: fos_output,
    /// The error that was predicted, offset included, m/s^2, rad/s: the bias that a phone's framework asks for. 0 on an
    /// axis that the model does not have.
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
    // a fault that is added there and not here does not compile
    assert!(Faults::all().bits() == 2 * FOS_FAULT_RATE - 1);
};

/// One FOS_VALIDITY_... in words, for a log: "valid" for 0, "unknown validity" for what is not exactly one of them.
/// Never NULL; the text is static.
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

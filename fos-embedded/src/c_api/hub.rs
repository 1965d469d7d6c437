//! The hub: memory, model, samples.

use core::ffi::{c_char, c_void};

use super::convert::{axis_of, motion_of, quantity_of};
use super::place::{Place, bytes, exclusive, make_in, shared};
use super::{
    FOS_API_VERSION, FOS_DRIFT_MEAN, FOS_DRIFT_VARIANCE, FOS_MAX_HISTORY, FOS_MAX_INPUTS, FOS_MAX_TERMS,
    fos_motion, fos_output, fos_quantity, fos_raw_sample, fos_scales, fos_si_output, fos_si_sample,
    fos_status,
};
use crate::hub::{CHub, Hub};

/// Bytes that are enough for a hub on every target: for memory that is reserved when compiling.
pub const FOS_HUB_BYTES: usize = 7168;
/// An alignment that is enough for a hub on every target, in bytes.
pub const FOS_HUB_ALIGN: usize = 8;

/// One sensor of six axes and its model. It lives in memory of the caller's, from fos_hub_init() until the caller uses
/// that memory for something else; there is nothing to free. It must not be copied or moved.
pub struct fos_hub {
    pub(super) hub: CHub,
}

/// The header's numbers are those of the hub: else this has two types.
const _: fn(Hub<FOS_MAX_INPUTS, FOS_MAX_TERMS, FOS_MAX_HISTORY>) -> CHub = |hub| hub;

#[cfg(feature = "defmt")]
impl defmt::Format for fos_hub {
    fn format(&self, f: defmt::Formatter<'_>) {
        self.hub.format(f);
    }
}

const _: () = assert!(size_of::<fos_hub>() <= FOS_HUB_BYTES && align_of::<fos_hub>() <= FOS_HUB_ALIGN);

/// Version of the library's interface: FOS_API_VERSION of the header that belongs to it.
#[unsafe(no_mangle)]
pub extern "C" fn fos_api_version() -> u32 {
    FOS_API_VERSION
}

/// Version of the library, as "0.1.0". Never NULL; the text is static.
#[unsafe(no_mangle)]
pub extern "C" fn fos_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}

/// Bytes that a hub takes, at most FOS_HUB_BYTES.
#[unsafe(no_mangle)]
pub extern "C" fn fos_hub_size() -> usize {
    size_of::<fos_hub>()
}

/// Alignment that a hub takes, in bytes, at most FOS_HUB_ALIGN.
#[unsafe(no_mangle)]
pub extern "C" fn fos_hub_align() -> usize {
    align_of::<fos_hub>()
}

/// The scales of a source that gives values, for fos_hub_init(): the accelerometers are at full scale at `accel_mps2`,
/// m/s^2, the gyros at `gyro_rads`, rad/s, where there is none at FLT_MAX; one sample every `period_s` seconds. `values` is
/// FOS_VALUES_RAW or FOS_VALUES_FACTORY_CORRECTED.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `out`.
/// - FOS_STATUS_ARGUMENT: a full scale or the period is not finite, 0 or negative, or too small to be divided into 32767
///   codes, or `values` stands for nothing. `*out` is as before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_scales_of_full_scale(
    accel_mps2: f32,
    gyro_rads: f32,
    period_s: f64,
    values: u8,
    out: *mut fos_scales,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: `out` leads to memory for scales, as the header asks
        let out = unsafe { Place::new(out) }?;
        out.put(fos_scales::of_full_scale(accel_mps2, gyro_rads, period_s, values)?);
        Ok(())
    })())
}

/// Makes a hub without a model, for a sensor with these scales, in `memory` of `size` bytes; what was there before
/// does not matter. `*out` is then the hub, at the start of `memory`. `scales` is copied.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `memory`, `scales` or `out`.
/// - FOS_STATUS_NO_ROOM: `size` is less than fos_hub_size().
/// - FOS_STATUS_ARGUMENT: a scale or the period is not finite or has the wrong sign, `values` stands for nothing, or no
///   memory at `memory` can have `size` bytes.
///
/// After any other status than FOS_STATUS_OK `*out` is NULL, where `out` itself can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_init(
    memory: *mut c_void,
    size: usize,
    scales: *const fos_scales,
    out: *mut *mut fos_hub,
) -> fos_status {
    // SAFETY: `out` leads to a pointer and `memory` to `size` bytes, as the header asks
    unsafe {
        make_in(memory, size, out, |place| {
            // SAFETY: `scales` leads to scales that are not being changed, as the header asks
            let scales = shared(scales)?.to_scales()?;
            place.put(fos_hub { hub: Hub::new(scales) });
            Ok(())
        })
    }
}

/// Takes a model image of exactly `length` bytes; history and inputs start anew, clocks go on from fos_hub_init. The
/// image need not be aligned, and is not needed afterwards.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL: `hub` or `image`. FOS_STATUS_MISALIGNED: `hub`. FOS_STATUS_ARGUMENT: no memory at `image` can
///   have `length` bytes. The hub is then as before.
/// - FOS_STATUS_TRUNCATED to FOS_STATUS_OTHER_QUANTITY, as said there. The hub then has no model, also if it had one
///   before: it corrects nothing, and every output says so.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_load(hub: *mut fos_hub, image: *const u8, length: usize) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header asks
        let hub = unsafe { exclusive(hub) }?;
        // SAFETY: `image` leads to `length` bytes that are not being changed, as the header asks
        let image = unsafe { bytes(image, length) }?;
        Ok(hub.hub.load(image)?)
    })())
}

/// Corrects one sample; in the order of time, every one exactly once. `*raw` is read before `*output` is written.
///
/// - FOS_STATUS_OK: with or without a model. It says nothing of the values: look at `validity` and `faults` of the
///   output.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`, `raw` or `output`. The sample counts as not given, `*output` is as
///   before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_update(
    hub: *mut fos_hub,
    raw: *const fos_raw_sample,
    output: *mut fos_output,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header asks
        let hub = unsafe { exclusive(hub) }?;
        // SAFETY: a sample that is not being changed, as the header asks; it is copied at once
        let raw = unsafe { shared(raw) }?.to_sample();
        // SAFETY: `output` leads to memory for an output, as the header asks
        let output = unsafe { Place::new(output) }?;
        output.put(fos_output::from(hub.hub.update(&raw)));
        Ok(())
    })())
}

/// As fos_hub_update(), of a sample in SI units; full scale, period and what the values are stay those of the hub's
/// scales: fos_scales_of_full_scale(). A hub may be given both in turn. `*sample` is read before `*output` is written.
///
/// - FOS_STATUS_OK: with or without a model. It says nothing of the values: look at `validity` and `faults` of the
///   output. An axis without a number says FOS_VALIDITY_NOT_FINITE, a model that uses a temperature without one
///   FOS_VALIDITY_INPUT_NOT_FINITE.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`, `sample` or `output`. The sample counts as not given, `*output` is as
///   before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_update_si(
    hub: *mut fos_hub,
    sample: *const fos_si_sample,
    output: *mut fos_si_output,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header asks
        let hub = unsafe { exclusive(hub) }?;
        // SAFETY: a sample that is not being changed, as the header asks; it is copied at once
        let sample = unsafe { shared(sample) }?.to_sample();
        // SAFETY: `output` leads to memory for an output, as the header asks
        let place = unsafe { Place::new(output) }?;
        let output = hub.hub.update_si(&sample);
        place.put(fos_si_output { output: fos_output::from(output), predicted: output.predicted() });
        Ok(())
    })())
}

/// What a logged quantity is from now on, in its unit; to be called before the sample that it belongs to. Temperature
/// and the six axes are not given: the sensor measures them. Until a quantity is given, and while it is NaN or
/// infinite, the axes that use it say FOS_VALIDITY_INPUT_NOT_FINITE. Loading a model forgets it.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_IN_MODEL: the model does not use it. That does no harm.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
/// - FOS_STATUS_ARGUMENT: `quantity` stands for nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_give(hub: *mut fos_hub, quantity: fos_quantity, value: f32) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header asks
        let hub = unsafe { exclusive(hub) }?;
        in_model(hub.hub.give(quantity_of(quantity)?, value))
    })())
}

/// As fos_hub_give(), for the `k`-th of those quantities of the model that the application gives, from 0, in the
/// model's order: for one that has only a name. Those that the sensor measures (temperature, the six axes) are not
/// counted.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_IN_MODEL: the model has no such quantity.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_give_application(hub: *mut fos_hub, k: usize, value: f32) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header asks
        let hub = unsafe { exclusive(hub) }?;
        in_model(hub.hub.give_application(k, value))
    })())
}

/// Whether the unit is still, from the next sample on, where the application knows; FOS_MOTION_DETECT, as at first,
/// leaves that to the hub.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
/// - FOS_STATUS_ARGUMENT: `motion` stands for nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_set_motion(hub: *mut fos_hub, motion: fos_motion) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header asks
        let hub = unsafe { exclusive(hub) }?;
        hub.hub.set_motion(motion_of(motion)?);
        Ok(())
    })())
}

/// What the application's clock shows, us since whenever, now that all samples up to now were given. From it the
/// sensor's true sample rate is found; to be called after every batch of samples. A clock that goes back starts the
/// measurement anew.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_clock(hub: *mut fos_hub, now_us: u64) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header asks
        unsafe { exclusive(hub) }?.hub.clock(now_us);
        Ok(())
    })())
}

/// The sensor's true sample rate by the application's clock, in Hz.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_KNOWN: the first 10 s without a fault are not over; `*rate_hz` is NaN.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub` or `rate_hz`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_rate_hz(hub: *const fos_hub, rate_hz: *mut f32) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header asks
        let hub = unsafe { shared(hub) }?;
        // SAFETY: `rate_hz` leads to memory for a float, as the header asks
        let place = unsafe { Place::new(rate_hz) }?;
        let found = hub.hub.rate_hz();
        place.put(found.unwrap_or(f32::NAN));
        found.map(|_| ()).ok_or(fos_status::NotKnown)
    })())
}

/// Whether the model of an axis, FOS_AX to FOS_GZ, has stopped fitting: `*drift` is 0, or FOS_DRIFT_MEAN,
/// FOS_DRIFT_VARIANCE or both. Axes are watched in turn, 200 samples each, while their innovation is known. What was
/// found stays until fos_hub_restart_watch() or fos_hub_load().
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_IN_MODEL: the model does not have the axis; `*drift` is 0.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub` or `drift`.
/// - FOS_STATUS_ARGUMENT: `axis` is not less than FOS_AXES.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_drift(hub: *const fos_hub, axis: usize, drift: *mut u8) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header asks
        let hub = unsafe { shared(hub) }?;
        // SAFETY: `drift` leads to a byte, as the header asks
        let place = unsafe { Place::new(drift) }?;
        let found = hub.hub.drift(axis_of(axis)?);
        let bit = |set: bool, bit: u8| if set { bit } else { 0 };
        place
            .put(found.map_or(0, |drift| {
                bit(drift.mean, FOS_DRIFT_MEAN) | bit(drift.variance, FOS_DRIFT_VARIANCE)
            }));
        in_model(found.is_some())
    })())
}

/// Forgets that the model has stopped fitting, and tests anew.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_restart_watch(hub: *mut fos_hub) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header asks
        unsafe { exclusive(hub) }?.hub.restart_watch();
        Ok(())
    })())
}

fn in_model(there: bool) -> Result<(), fos_status> {
    if there { Ok(()) } else { Err(fos_status::NotInModel) }
}

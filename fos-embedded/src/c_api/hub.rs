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

/// Bytes that suffice for a hub on every target, for memory reserved at compile time.
pub const FOS_HUB_BYTES: usize = 7168;
/// Alignment that suffices for a hub on every target, in bytes.
pub const FOS_HUB_ALIGN: usize = 8;

/// One six-axis sensor and its model. The hub lives in memory of the caller, from fos_hub_init() until the caller reuses
/// that memory; there is nothing to free. It must not be copied or moved.
pub struct fos_hub {
    pub(super) hub: CHub,
}

/// Compiles only if the capacities in the header are those of the hub.
const _: fn(Hub<FOS_MAX_INPUTS, FOS_MAX_TERMS, FOS_MAX_HISTORY>) -> CHub = |hub| hub;

#[cfg(feature = "defmt")]
impl defmt::Format for fos_hub {
    fn format(&self, f: defmt::Formatter<'_>) {
        self.hub.format(f);
    }
}

const _: () = assert!(size_of::<fos_hub>() <= FOS_HUB_BYTES && align_of::<fos_hub>() <= FOS_HUB_ALIGN);

/// Version of the library's interface: FOS_API_VERSION of the matching header.
#[unsafe(no_mangle)]
pub extern "C" fn fos_api_version() -> u32 {
    FOS_API_VERSION
}

/// Version of the library, for example "0.1.0". Never NULL; the text is static.
#[unsafe(no_mangle)]
pub extern "C" fn fos_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}

/// Size of a hub in bytes, at most FOS_HUB_BYTES.
#[unsafe(no_mangle)]
pub extern "C" fn fos_hub_size() -> usize {
    size_of::<fos_hub>()
}

/// Alignment of a hub in bytes, at most FOS_HUB_ALIGN.
#[unsafe(no_mangle)]
pub extern "C" fn fos_hub_align() -> usize {
    align_of::<fos_hub>()
}

/// Computes the scales of a source that gives values in SI units, for fos_hub_init(). `accel_mps2` is the full scale of the
/// accelerometers in m/s^2, `gyro_rads` that of the gyros in rad/s, FLT_MAX if there is none; `period_s` is the sample
/// period in seconds; `values` is FOS_VALUES_RAW or FOS_VALUES_FACTORY_CORRECTED.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `out`.
/// - FOS_STATUS_ARGUMENT: a full scale or the period is not finite, 0 or negative, or too small to be divided into 32767
///   codes, or `values` is invalid. `*out` is unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_scales_of_full_scale(
    accel_mps2: f32,
    gyro_rads: f32,
    period_s: f64,
    values: u8,
    out: *mut fos_scales,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: `out` points to memory for scales, as the header requires
        let out = unsafe { Place::new(out) }?;
        out.put(fos_scales::of_full_scale(accel_mps2, gyro_rads, period_s, values)?);
        Ok(())
    })())
}

/// Creates a hub without a model, for a sensor with these scales, in `memory` of `size` bytes, whose contents are
/// overwritten. `*out` then points to the hub, at the start of `memory`. `scales` is copied.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `memory`, `scales` or `out`.
/// - FOS_STATUS_NO_ROOM: `size` is less than fos_hub_size().
/// - FOS_STATUS_ARGUMENT: a scale or the period is not finite or has the wrong sign, `values` is invalid, or `size` is
///   impossible at that address.
///
/// After any status other than FOS_STATUS_OK `*out` is NULL, if `out` itself is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_init(
    memory: *mut c_void,
    size: usize,
    scales: *const fos_scales,
    out: *mut *mut fos_hub,
) -> fos_status {
    // SAFETY: `out` points to a pointer and `memory` to `size` bytes, as the header requires
    unsafe {
        make_in(memory, size, out, |place| {
            // SAFETY: `scales` points to scales that are not modified meanwhile, as the header requires
            let scales = shared(scales)?.to_scales()?;
            place.put(fos_hub { hub: Hub::new(scales) });
            Ok(())
        })
    }
}

/// Loads a model image of exactly `length` bytes. History and inputs are reset; the clocks of the inputs continue from
/// fos_hub_init(). The image need not be aligned and is not needed afterwards.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL: `hub` or `image`. FOS_STATUS_MISALIGNED: `hub`. FOS_STATUS_ARGUMENT: `length` is impossible at that
///   address. The hub is then unchanged.
/// - FOS_STATUS_TRUNCATED to FOS_STATUS_OTHER_QUANTITY: see there. The hub then has no model, even if it had one before: it
///   corrects nothing and flags every output with FOS_VALIDITY_NOT_MODELLED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_load(hub: *mut fos_hub, image: *const u8, length: usize) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header requires
        let hub = unsafe { exclusive(hub) }?;
        // SAFETY: `image` points to `length` bytes that are not modified meanwhile, as the header requires
        let image = unsafe { bytes(image, length) }?;
        Ok(hub.hub.load(image)?)
    })())
}

/// Corrects one sample. Pass every sample exactly once, in the order of time. `*raw` is read before `*output` is written.
///
/// - FOS_STATUS_OK: with or without a model. It does not validate the values: check `validity` and `faults` of the output.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`, `raw` or `output`. The sample is not processed and `*output` is
///   unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_update(
    hub: *mut fos_hub,
    raw: *const fos_raw_sample,
    output: *mut fos_output,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header requires
        let hub = unsafe { exclusive(hub) }?;
        // SAFETY: a sample that is not modified meanwhile, as the header requires; it is copied at once
        let raw = unsafe { shared(raw) }?.to_sample();
        // SAFETY: `output` points to memory for an output, as the header requires
        let output = unsafe { Place::new(output) }?;
        output.put(fos_output::from(hub.hub.update(&raw)));
        Ok(())
    })())
}

/// Corrects one sample in SI units; otherwise the same as fos_hub_update(). Full scale, period and kind of values are those
/// of the hub's scales, see fos_scales_of_full_scale(). Both functions may be used with the same hub. `*sample` is read
/// before `*output` is written.
///
/// - FOS_STATUS_OK: with or without a model. It does not validate the values: check `validity` and `faults` of the output.
///   An axis without a finite value has FOS_VALIDITY_NOT_FINITE; without a temperature, axes whose model uses it have
///   FOS_VALIDITY_INPUT_NOT_FINITE.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`, `sample` or `output`. The sample is not processed and `*output` is
///   unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_update_si(
    hub: *mut fos_hub,
    sample: *const fos_si_sample,
    output: *mut fos_si_output,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header requires
        let hub = unsafe { exclusive(hub) }?;
        // SAFETY: a sample that is not modified meanwhile, as the header requires; it is copied at once
        let sample = unsafe { shared(sample) }?.to_sample();
        // SAFETY: `output` points to memory for an output, as the header requires
        let place = unsafe { Place::new(output) }?;
        let output = hub.hub.update_si(&sample);
        place.put(fos_si_output { output: fos_output::from(output), predicted: output.predicted() });
        Ok(())
    })())
}

/// Sets a logged quantity from now on, in its unit; call it before the sample that the value belongs to. Temperature and the
/// six axes come from the sensor. Until a quantity is set, and while it is NaN or infinite, the axes that use it have
/// FOS_VALIDITY_INPUT_NOT_FINITE. Loading a model resets it.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_IN_MODEL: the model does not use it; the value is ignored.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
/// - FOS_STATUS_ARGUMENT: `quantity` is invalid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_give(hub: *mut fos_hub, quantity: fos_quantity, value: f32) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header requires
        let hub = unsafe { exclusive(hub) }?;
        in_model(hub.hub.give(quantity_of(quantity)?, value))
    })())
}

/// Sets the `k`-th quantity, from 0, of those that the application gives, in the model's order; for quantities that have
/// only a name. Quantities that the sensor measures (temperature, the six axes) are not counted. Otherwise the same as
/// fos_hub_give().
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_IN_MODEL: the model has no such quantity.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_give_application(hub: *mut fos_hub, k: usize, value: f32) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header requires
        let hub = unsafe { exclusive(hub) }?;
        in_model(hub.hub.give_application(k, value))
    })())
}

/// Sets the motion state from the next sample on, if the application knows it. FOS_MOTION_DETECT, the initial value, leaves
/// it to the hub.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
/// - FOS_STATUS_ARGUMENT: `motion` is invalid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_set_motion(hub: *mut fos_hub, motion: fos_motion) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header requires
        let hub = unsafe { exclusive(hub) }?;
        hub.hub.set_motion(motion_of(motion)?);
        Ok(())
    })())
}

/// Passes the time of the application's clock, in us since any origin, after all samples up to now were passed. Call it
/// after every batch of samples; it measures the true sampling rate of the sensor. A clock that is set back restarts the
/// measurement.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_clock(hub: *mut fos_hub, now_us: u64) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header requires
        unsafe { exclusive(hub) }?.hub.clock(now_us);
        Ok(())
    })())
}

/// True sampling rate of the sensor by the application's clock, in Hz.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_KNOWN: fewer than 10 s without a fault have passed; `*rate_hz` is NaN.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub` or `rate_hz`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_rate_hz(hub: *const fos_hub, rate_hz: *mut f32) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header requires
        let hub = unsafe { shared(hub) }?;
        // SAFETY: `rate_hz` points to memory for a float, as the header requires
        let place = unsafe { Place::new(rate_hz) }?;
        let found = hub.hub.rate_hz();
        place.put(found.unwrap_or(f32::NAN));
        found.map(|_| ()).ok_or(fos_status::NotKnown)
    })())
}

/// Drift of the model of an axis, FOS_AX to FOS_GZ: `*drift` is 0 while the model fits, otherwise FOS_DRIFT_MEAN,
/// FOS_DRIFT_VARIANCE or both. The axes are monitored in turn, 200 samples each, while their innovation is known. A detected
/// drift persists until fos_hub_restart_watch() or fos_hub_load().
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NOT_IN_MODEL: the model does not have the axis; `*drift` is 0.
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub` or `drift`.
/// - FOS_STATUS_ARGUMENT: `axis` is not less than FOS_AXES.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_drift(hub: *const fos_hub, axis: usize, drift: *mut u8) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header requires
        let hub = unsafe { shared(hub) }?;
        // SAFETY: `drift` points to a byte, as the header requires
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

/// Clears the drift of all axes and restarts the tests.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_hub_restart_watch(hub: *mut fos_hub) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a hub that is in no other call, as the header requires
        unsafe { exclusive(hub) }?.hub.restart_watch();
        Ok(())
    })())
}

fn in_model(there: bool) -> Result<(), fos_status> {
    if there { Ok(()) } else { Err(fos_status::NotInModel) }
}

//! Telemetry: frames for `fos record`, in a buffer of the caller.

use fos_core::Image;

use super::place::{Room, bytes, count_in, shared};
use super::{fos_hub, fos_status};
use crate::hub::MAX_LOGGED;
use crate::telemetry::{Borrowed, Frame, HUB_AXES, Snapshot, StartFrame, VERSION, encode};

/// Bytes that suffice for every telemetry frame.
pub const FOS_TELEMETRY_BYTES: usize = 512;

/// Longest total length of the names of the logged quantities, bytes.
const NAMES: usize = 400;

// variant, version, period, two texts with their lengths (the second takes two bytes), checksum, two bytes of COBS,
// delimiter
const _: () = {
    let longest = 1 + 1 + 4 + 1 + HUB_AXES.len() + 2 + NAMES + 4 + 2 + 1;
    assert!(longest <= FOS_TELEMETRY_BYTES);
};

/// Writes the start frame, which describes the samples: `*used` bytes of `buffer`, to be sent unchanged before the first
/// sample, and again about once per minute for receivers that join late. `image` is the image loaded by the hub, which has
/// the names of the quantities. Without a model, `image` may be NULL and `length` 0.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NO_ROOM: the frame does not fit into `capacity` bytes, or the names of the quantities take more than
///   400.
/// - FOS_STATUS_NULL: `hub`, `buffer`, `used`, or `image` where `length` is not 0. FOS_STATUS_MISALIGNED: `hub` or
///   `used`.
/// - FOS_STATUS_ARGUMENT: `length` or `capacity` is impossible at that address.
/// - FOS_STATUS_TRUNCATED to FOS_STATUS_UNUSABLE: `image` is invalid, as for fos_hub_load().
///
/// After any status other than FOS_STATUS_OK `*used` is 0, if `used` itself is valid, and `buffer` must not be sent.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_telemetry_start(
    hub: *const fos_hub,
    image: *const u8,
    length: usize,
    buffer: *mut u8,
    capacity: usize,
    used: *mut usize,
) -> fos_status {
    let frame = |room: &mut Room| {
        // SAFETY: a hub that is in no other call, as the header requires
        let hub = unsafe { shared(hub) }?;
        let info = if image.is_null() && length == 0 {
            fos_core::Info::default()
        } else {
            // SAFETY: `image` points to `length` bytes that are not modified meanwhile, as the header requires
            Image::parse(unsafe { bytes(image, length) }?)?.info()
        };
        let names = hub.hub.columns::<NAMES>(&info).ok_or(fos_status::NoRoom)?;
        let period_s = hub.hub.scales().period_s as f32;
        let start = StartFrame { version: VERSION, period_s, axes: HUB_AXES, quantities: names.as_str() };
        write(&Frame::Start(start), room)
    };
    // SAFETY: `used`, `buffer` and `capacity` are as the header requires
    unsafe { write_into(buffer, capacity, used, frame) }
}

/// Writes the frame of the latest sample: `*used` bytes of `buffer`, to be sent unchanged.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NO_ROOM: the frame does not fit into `capacity` bytes.
/// - FOS_STATUS_NULL: `hub`, `buffer` or `used`. FOS_STATUS_MISALIGNED: `hub` or `used`.
/// - FOS_STATUS_ARGUMENT: `capacity` is impossible at that address.
///
/// After any status other than FOS_STATUS_OK `*used` is 0, if `used` itself is valid, and `buffer` must not be sent.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_telemetry_sample(
    hub: *const fos_hub,
    buffer: *mut u8,
    capacity: usize,
    used: *mut usize,
) -> fos_status {
    let frame = |room: &mut Room| {
        // SAFETY: a hub that is in no other call, as the header requires
        let hub = &unsafe { shared(hub) }?.hub;
        let snapshot: Snapshot<MAX_LOGGED> = Snapshot::new(hub.output(), &hub.logged());
        write(&Frame::Sample(snapshot.frame()), room)
    };
    // SAFETY: `used`, `buffer` and `capacity` are as the header requires
    unsafe { write_into(buffer, capacity, used, frame) }
}

/// Writes a frame into a buffer of the caller, and the number of bytes to `used`, 0 after any error.
///
/// # Safety
///
/// `buffer` and `capacity` satisfy the conditions of [`Room::new`], and `used` those of
/// [`Place::new`](super::place::Place::new).
unsafe fn write_into(
    buffer: *mut u8,
    capacity: usize,
    used: *mut usize,
    frame: impl FnOnce(&mut Room) -> Result<usize, fos_status>,
) -> fos_status {
    let write = || {
        // SAFETY: guaranteed by the caller
        let mut room = unsafe { Room::new(buffer, capacity) }?;
        frame(&mut room)
    };
    // SAFETY: guaranteed by the caller
    unsafe { count_in(used, write) }
}

fn write(frame: &Borrowed<'_>, room: &mut Room) -> Result<usize, fos_status> {
    encode(frame, room.zeroed()).map(<[u8]>::len).ok_or(fos_status::NoRoom)
}

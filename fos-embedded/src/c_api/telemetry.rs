//! Telemetry: frames for `fos record`, into a buffer of the caller's.

use fos_core::Image;

use super::place::{Room, bytes, count_in, shared};
use super::{fos_hub, fos_status};
use crate::hub::MAX_LOGGED;
use crate::telemetry::{Borrowed, Frame, HUB_AXES, Snapshot, StartFrame, VERSION, encode};

/// Bytes that every frame of telemetry fits.
pub const FOS_TELEMETRY_BYTES: usize = 512;

/// The names of the logged quantities together are at most so long.
const NAMES: usize = 400;

// variant, version, period, two texts with their lengths (the second takes two bytes), checksum, two bytes of COBS,
// delimiter
const _: () = {
    let longest = 1 + 1 + 4 + 1 + HUB_AXES.len() + 2 + NAMES + 4 + 2 + 1;
    assert!(longest <= FOS_TELEMETRY_BYTES);
};

/// Writes the frame that says what the samples hold: `*used` bytes of `buffer`, to be sent as they are, before the
/// first sample and again every minute or so for those who join late. `image` is the image that the hub has loaded:
/// it has the names of the quantities. Without a model `image` may be NULL and `length` 0.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NO_ROOM: the frame does not fit into `capacity` bytes, or the names of the quantities take more than
///   400.
/// - FOS_STATUS_NULL: `hub`, `buffer`, `used`, or `image` where `length` is not 0. FOS_STATUS_MISALIGNED: `hub` or
///   `used`.
/// - FOS_STATUS_ARGUMENT: no memory there can have `length` or `capacity` bytes.
/// - FOS_STATUS_TRUNCATED to FOS_STATUS_UNUSABLE: `image`, as for fos_hub_load().
///
/// After any other status than FOS_STATUS_OK `*used` is 0, where `used` itself can be written to, and what is in
/// `buffer` is not to be sent.
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
        // SAFETY: a hub that is in no other call, as the header asks
        let hub = unsafe { shared(hub) }?;
        let info = if image.is_null() && length == 0 {
            fos_core::Info::default()
        } else {
            // SAFETY: `image` leads to `length` bytes that are not being changed, as the header asks
            Image::parse(unsafe { bytes(image, length) }?)?.info()
        };
        let names = hub.hub.columns::<NAMES>(&info).ok_or(fos_status::NoRoom)?;
        let period_s = hub.hub.scales().period_s as f32;
        let start = StartFrame { version: VERSION, period_s, axes: HUB_AXES, quantities: names.as_str() };
        write(&Frame::Start(start), room)
    };
    // SAFETY: `used`, `buffer` and `capacity` are what the header asks
    unsafe { write_into(buffer, capacity, used, frame) }
}

/// Writes the frame of the latest sample: `*used` bytes of `buffer`, to be sent as they are.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NO_ROOM: the frame does not fit into `capacity` bytes.
/// - FOS_STATUS_NULL: `hub`, `buffer` or `used`. FOS_STATUS_MISALIGNED: `hub` or `used`.
/// - FOS_STATUS_ARGUMENT: no memory there can have `capacity` bytes.
///
/// After any other status than FOS_STATUS_OK `*used` is 0, where `used` itself can be written to, and what is in
/// `buffer` is not to be sent.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_telemetry_sample(
    hub: *const fos_hub,
    buffer: *mut u8,
    capacity: usize,
    used: *mut usize,
) -> fos_status {
    let frame = |room: &mut Room| {
        // SAFETY: a hub that is in no other call, as the header asks
        let hub = &unsafe { shared(hub) }?.hub;
        let snapshot: Snapshot<MAX_LOGGED> = Snapshot::new(hub.output(), &hub.logged());
        write(&Frame::Sample(snapshot.frame()), room)
    };
    // SAFETY: `used`, `buffer` and `capacity` are what the header asks
    unsafe { write_into(buffer, capacity, used, frame) }
}

/// Has `frame` written into a buffer of the caller's, and says how much of it was used: nothing after any error.
///
/// # Safety
///
/// As of [`Room::new`] and [`Place::new`].
unsafe fn write_into(
    buffer: *mut u8,
    capacity: usize,
    used: *mut usize,
    frame: impl FnOnce(&mut Room) -> Result<usize, fos_status>,
) -> fos_status {
    let write = || {
        // SAFETY: the caller's promise
        let mut room = unsafe { Room::new(buffer, capacity) }?;
        frame(&mut room)
    };
    // SAFETY: the caller's promise
    unsafe { count_in(used, write) }
}

fn write(frame: &Borrowed<'_>, room: &mut Room) -> Result<usize, fos_status> {
    encode(frame, room.zeroed()).map(<[u8]>::len).ok_or(fos_status::NoRoom)
}

//! Model images in flash: memory, save, load.

use core::ffi::c_void;

use super::flash::{FlashError, Pages, fos_flash};
use super::fos_status;
use super::place::{Room, bytes, count_in, exclusive, make_in, shared};
use crate::blocking::poll_once;
use crate::store::{ModelStore, StoreError};

/// Longest image in a store of six or more pages, bytes: one page minus the overhead of the store. A store of four or five
/// pages holds images of up to half a page, 2027 bytes.
pub const FOS_STORE_IMAGE_BYTES: usize = 4067;
/// Bytes that suffice for a store on every target, for memory reserved at compile time.
pub const FOS_STORE_BYTES: usize = 4224;
/// Alignment that suffices for a store on every target, in bytes.
pub const FOS_STORE_ALIGN: usize = 8;

/// Buffer length, bytes: the image, its number (4) and its key (1), rounded up to words of 8.
const BUFFER: usize = 4072;

const _: () = assert!(FOS_STORE_IMAGE_BYTES + 4 + 1 == BUFFER && BUFFER.is_multiple_of(8));

/// Model images in flash: two slots, of which the newest valid one is used. A save is written to the slot that is not in use
/// and read back. It survives power loss: the previous or the new image remains valid, and after a save the previous one
/// is still available for a rollback. The store lives in memory of the caller, like a hub; the images stay in the flash.
pub struct fos_store {
    store: ModelStore<Pages, BUFFER>,
}

#[cfg(feature = "defmt")]
impl defmt::Format for fos_store {
    fn format(&self, f: defmt::Formatter<'_>) {
        self.store.format(f);
    }
}

const _: () =
    assert!(size_of::<fos_store>() <= FOS_STORE_BYTES && align_of::<fos_store>() <= FOS_STORE_ALIGN);

/// Size of a store in bytes, at most FOS_STORE_BYTES.
#[unsafe(no_mangle)]
pub extern "C" fn fos_store_size() -> usize {
    size_of::<fos_store>()
}

/// Alignment of a store in bytes, at most FOS_STORE_ALIGN.
#[unsafe(no_mangle)]
pub extern "C" fn fos_store_align() -> usize {
    align_of::<fos_store>()
}

/// Creates a store in `memory` of `size` bytes, for the images in the flash, which is not accessed yet. `*out` then points to
/// the start of `memory`. `flash` is copied.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `memory`, `flash` or `out`; FOS_STATUS_NULL also for a function in `flash`.
/// - FOS_STATUS_NO_ROOM: `size` is less than fos_store_size().
/// - FOS_STATUS_ARGUMENT: the range does not consist of whole pages from the start of a sector, has fewer than four, or
///   exceeds the address space; the sector size neither divides 4096 nor is a larger multiple of 8; or `size` is impossible
///   at that address.
///
/// After any status other than FOS_STATUS_OK `*out` is NULL, if `out` itself is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_store_init(
    memory: *mut c_void,
    size: usize,
    flash: *const fos_flash,
    out: *mut *mut fos_store,
) -> fos_status {
    // SAFETY: `out` points to a pointer and `memory` to `size` bytes, as the header requires
    unsafe {
        make_in(memory, size, out, |place| {
            // SAFETY: `flash` points to a description whose functions may be called, as the header requires
            let pages = Pages::new(shared(flash)?)?;
            let end = pages.end();
            place.put(fos_store { store: ModelStore::new(pages, 0..end)? });
            Ok(())
        })
    }
}

/// Stores an image of exactly `length` bytes as the newest. It takes the time of a few writes and sometimes of an erase.
/// `image` must not overlap the store.
///
/// - FOS_STATUS_OK: the image was written and read back.
/// - FOS_STATUS_NULL: `store` or `image`. FOS_STATUS_MISALIGNED: `store`. FOS_STATUS_ARGUMENT: `length` is impossible at that
///   address.
/// - FOS_STATUS_TRUNCATED to FOS_STATUS_UNUSABLE: the image is invalid, as for fos_hub_load(). Nothing was written.
/// - FOS_STATUS_NO_ROOM: the image is longer than FOS_STORE_IMAGE_BYTES, or than 2027 bytes in a store of four or five
///   pages. Nothing was written.
/// - FOS_STATUS_FLASH, FOS_STATUS_VERIFY_FAILED: the previous image is still the newest; the call may be repeated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_store_save(
    store: *mut fos_store,
    image: *const u8,
    length: usize,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a store that is in no other call, as the header requires
        let store = unsafe { exclusive(store) }?;
        // SAFETY: `image` points to `length` bytes that are not modified meanwhile, as the header requires
        let image = unsafe { bytes(image, length) }?;
        // over blocking functions the future completes at the first poll
        Ok(poll_once(store.store.store(image)).ok_or(fos_status::Flash)??)
    })())
}

/// Copies the newest valid image into `buffer`: `*used` bytes, for fos_hub_load().
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NO_MODEL: there is none. Damaged images, and those of a version that this library does not run, do not count.
/// - FOS_STATUS_NO_ROOM: the image is longer than `capacity`; FOS_STORE_IMAGE_BYTES always suffice.
/// - FOS_STATUS_FLASH: a function of the flash failed.
/// - FOS_STATUS_NULL: `store`, `buffer` or `used`. FOS_STATUS_MISALIGNED: `store` or `used`. FOS_STATUS_ARGUMENT:
///   `capacity` is impossible at that address.
///
/// After any status other than FOS_STATUS_OK `*used` is 0, if `used` itself is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_store_load(
    store: *mut fos_store,
    buffer: *mut u8,
    capacity: usize,
    used: *mut usize,
) -> fos_status {
    // SAFETY: the header requires the conditions of `load`
    unsafe {
        load(store, buffer, capacity, used, |store, room| {
            copied(poll_once(store.load()).ok_or(fos_status::Flash)??, room)
        })
    }
}

/// Copies the image before the newest into `buffer`, for a rollback after a bad update; otherwise the same as
/// fos_store_load(). To make the rollback permanent, save the image: it is then the newest.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NO_MODEL: there is no previous image, or it is damaged.
/// - All others: as for fos_store_load().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_store_load_previous(
    store: *mut fos_store,
    buffer: *mut u8,
    capacity: usize,
    used: *mut usize,
) -> fos_status {
    // SAFETY: the header requires the conditions of `load`
    unsafe {
        load(store, buffer, capacity, used, |store, room| {
            copied(poll_once(store.load_previous()).ok_or(fos_status::Flash)??, room)
        })
    }
}

impl From<StoreError<FlashError>> for fos_status {
    fn from(error: StoreError<FlashError>) -> Self {
        match error {
            StoreError::Range => Self::Argument,
            StoreError::Image(error) => error.into(),
            StoreError::TooLong(_) => Self::NoRoom,
            StoreError::VerifyFailed => Self::VerifyFailed,
            StoreError::Flash(_) => Self::Flash,
        }
    }
}

fn copied(image: Option<&[u8]>, room: &mut Room) -> Result<usize, fos_status> {
    let image = image.ok_or(fos_status::NoModel)?;
    let place = room.zeroed().get_mut(..image.len()).ok_or(fos_status::NoRoom)?;
    place.copy_from_slice(image);
    Ok(image.len())
}

/// # Safety
///
/// `store` satisfies the conditions of [`exclusive`], `buffer` and `capacity` those of [`Room::new`], and `used` those of
/// [`Place::new`](super::place::Place::new).
unsafe fn load(
    store: *mut fos_store,
    buffer: *mut u8,
    capacity: usize,
    used: *mut usize,
    load: impl FnOnce(&mut ModelStore<Pages, BUFFER>, &mut Room) -> Result<usize, fos_status>,
) -> fos_status {
    let copy = || {
        // SAFETY: guaranteed by the caller
        let store = unsafe { exclusive(store) }?;
        // SAFETY: guaranteed by the caller
        let mut room = unsafe { Room::new(buffer, capacity) }?;
        load(&mut store.store, &mut room)
    };
    // SAFETY: guaranteed by the caller
    unsafe { count_in(used, copy) }
}

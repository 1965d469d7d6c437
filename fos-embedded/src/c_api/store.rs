//! Model images in flash: memory, save, load.

use core::ffi::c_void;

use super::flash::{FlashError, Pages, fos_flash};
use super::fos_status;
use super::place::{Room, bytes, count_in, exclusive, make_in, shared};
use crate::blocking::poll_once;
use crate::store::{ModelStore, StoreError};

/// The longest image that a store of six pages and more takes, bytes: it fits a page with what the store puts before it. A
/// store of four or five pages takes half a page, 2027 bytes.
pub const FOS_STORE_IMAGE_BYTES: usize = 4067;
/// Bytes that are enough for a store on every target: for memory that is reserved when compiling.
pub const FOS_STORE_BYTES: usize = 4224;
/// An alignment that is enough for a store on every target, in bytes.
pub const FOS_STORE_ALIGN: usize = 8;

/// The image with its number, 4 bytes, and its key, 1, in words of 8.
const BUFFER: usize = 4072;

const _: () = assert!(FOS_STORE_IMAGE_BYTES + 4 + 1 == BUFFER && BUFFER.is_multiple_of(8));

/// Model images in flash: two slots, the newest valid one wins. A save goes into the slot that is not in use and is read
/// back; whatever happens to the power meanwhile, the image before or the new one is there, and after it the one before
/// can still be returned to. It lives in memory of the caller's, as a hub does; what is in the flash stays there.
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

/// Bytes that a store takes, at most FOS_STORE_BYTES.
#[unsafe(no_mangle)]
pub extern "C" fn fos_store_size() -> usize {
    size_of::<fos_store>()
}

/// Alignment that a store takes, in bytes, at most FOS_STORE_ALIGN.
#[unsafe(no_mangle)]
pub extern "C" fn fos_store_align() -> usize {
    align_of::<fos_store>()
}

/// Makes a store in `memory` of `size` bytes, over the images that are in the flash, which is not yet looked at. `*out` is
/// then at the start of `memory`. `flash` is copied.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `memory`, `flash` or `out`; NULL: one of the functions in `flash` too.
/// - FOS_STATUS_NO_ROOM: `size` is less than fos_store_size().
/// - FOS_STATUS_ARGUMENT: the range is not whole pages from the start of a sector, fewer than four or beyond the
///   addresses; a sector neither divides 4096 nor is a larger multiple of 8; or no memory at `memory` can have `size`
///   bytes.
///
/// After any other status than FOS_STATUS_OK `*out` is NULL, where `out` itself can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_store_init(
    memory: *mut c_void,
    size: usize,
    flash: *const fos_flash,
    out: *mut *mut fos_store,
) -> fos_status {
    // SAFETY: `out` leads to a pointer and `memory` to `size` bytes, as the header asks
    unsafe {
        make_in(memory, size, out, |place| {
            // SAFETY: `flash` leads to a description whose functions may be called, as the header asks
            let pages = Pages::new(shared(flash)?)?;
            let end = pages.end();
            place.put(fos_store { store: ModelStore::new(pages, 0..end)? });
            Ok(())
        })
    }
}

/// Stores an image of exactly `length` bytes; from then on it is the newest. It takes the time of some writes, and now and
/// then of an erase. `image` does not overlap the store.
///
/// - FOS_STATUS_OK: it is in the flash and was read back.
/// - FOS_STATUS_NULL: `store` or `image`. FOS_STATUS_MISALIGNED: `store`. FOS_STATUS_ARGUMENT: no memory at `image` can
///   have `length` bytes.
/// - FOS_STATUS_TRUNCATED to FOS_STATUS_UNUSABLE: it is no image, as for fos_hub_load(). Nothing was written.
/// - FOS_STATUS_NO_ROOM: it is longer than FOS_STORE_IMAGE_BYTES, or half a page where that is all. Nothing was written.
/// - FOS_STATUS_FLASH, FOS_STATUS_NOT_KEPT: the image before is still the newest; it may be tried again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_store_save(
    store: *mut fos_store,
    image: *const u8,
    length: usize,
) -> fos_status {
    fos_status::of((|| {
        // SAFETY: a store that is in no other call, as the header asks
        let store = unsafe { exclusive(store) }?;
        // SAFETY: `image` leads to `length` bytes that are not being changed, as the header asks
        let image = unsafe { bytes(image, length) }?;
        // over functions that wait a future is done at once
        Ok(poll_once(store.store.store(image)).ok_or(fos_status::Flash)??)
    })())
}

/// Copies the newest valid image into `buffer`: `*used` bytes, for fos_hub_load().
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NO_MODEL: there is none. What is damaged, or of a version that this library does not run, is none.
/// - FOS_STATUS_NO_ROOM: it is longer than `capacity`; FOS_STORE_IMAGE_BYTES are always enough.
/// - FOS_STATUS_FLASH
/// - FOS_STATUS_NULL: `store`, `buffer` or `used`. FOS_STATUS_MISALIGNED: `store` or `used`. FOS_STATUS_ARGUMENT: no memory
///   at `buffer` can have `capacity` bytes.
///
/// After any other status than FOS_STATUS_OK `*used` is 0, where `used` itself can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_store_load(
    store: *mut fos_store,
    buffer: *mut u8,
    capacity: usize,
    used: *mut usize,
) -> fos_status {
    // SAFETY: what `load` asks is what the header asks
    unsafe {
        load(store, buffer, capacity, used, |store, room| {
            copied(poll_once(store.load()).ok_or(fos_status::Flash)??, room)
        })
    }
}

/// As fos_store_load(), of the image before the newest: what to return to if an update proves wrong. To stay with it, save
/// it: it is then the newest.
///
/// - FOS_STATUS_OK
/// - FOS_STATUS_NO_MODEL: there is none, or it is damaged.
/// - All others as of fos_store_load().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_store_load_previous(
    store: *mut fos_store,
    buffer: *mut u8,
    capacity: usize,
    used: *mut usize,
) -> fos_status {
    // SAFETY: what `load` asks is what the header asks
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
            StoreError::NotKept => Self::NotKept,
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
/// As of [`exclusive`] for `store`, and as of [`Room::new`] and [`Place::new`].
unsafe fn load(
    store: *mut fos_store,
    buffer: *mut u8,
    capacity: usize,
    used: *mut usize,
    load: impl FnOnce(&mut ModelStore<Pages, BUFFER>, &mut Room) -> Result<usize, fos_status>,
) -> fos_status {
    let copy = || {
        // SAFETY: the caller's promise
        let store = unsafe { exclusive(store) }?;
        // SAFETY: the caller's promise
        let mut room = unsafe { Room::new(buffer, capacity) }?;
        load(&mut store.store, &mut room)
    };
    // SAFETY: the caller's promise
    unsafe { count_in(used, copy) }
}

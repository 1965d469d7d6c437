//! Pointers from C, checked as far as they can be.

use core::ffi::c_void;

use super::fos_status;

/// What `pointer` leads to, which C only reads.
///
/// # Safety
///
/// If it is neither NULL nor misaligned, it leads to a `T` that nobody changes during `'a`.
pub(super) unsafe fn shared<'a, T>(pointer: *const T) -> Result<&'a T, fos_status> {
    check(pointer)?;
    // SAFETY: not NULL and aligned by the check; the rest is the caller's promise
    Ok(unsafe { &*pointer })
}

/// What `pointer` leads to, which this call alone changes.
///
/// # Safety
///
/// If it is neither NULL nor misaligned, it leads to a `T` that nobody else reads or changes during `'a`.
pub(super) unsafe fn exclusive<'a, T>(pointer: *mut T) -> Result<&'a mut T, fos_status> {
    check(pointer)?;
    // SAFETY: not NULL and aligned by the check; the rest is the caller's promise
    Ok(unsafe { &mut *pointer })
}

/// Bytes that C only reads.
///
/// # Safety
///
/// If it is not NULL, `pointer` leads to `length` bytes that nobody changes during `'a`.
pub(super) unsafe fn bytes<'a>(pointer: *const u8, length: usize) -> Result<&'a [u8], fos_status> {
    check_extent(pointer.cast(), length)?;
    // SAFETY: not NULL and an extent that memory can have by the check; the rest is the caller's promise
    Ok(unsafe { core::slice::from_raw_parts(pointer, length) })
}

/// A place of C's for one `T`, which need not hold one yet.
pub(super) struct Place<T>(*mut T);

impl<T> Place<T> {
    /// # Safety
    ///
    /// If it is neither NULL nor misaligned, `pointer` leads to memory for a `T` that nobody else uses until
    /// [`put`](Self::put).
    pub(super) unsafe fn new(pointer: *mut T) -> Result<Self, fos_status> {
        check(pointer)?;
        Ok(Self(pointer))
    }

    /// Leaves a value there; what was there before is forgotten.
    pub(super) fn put(self, value: T) {
        // SAFETY: `new` checked the pointer and was promised the memory behind it
        unsafe { self.0.write(value) };
    }
}

/// Has `make` put a `T` at the start of `size` bytes of C's, and leaves there where it is, or NULL if it could not.
///
/// # Safety
///
/// If they are neither NULL nor misaligned, `out` leads to a pointer, and `memory` to `size` bytes that nobody else uses.
#[inline(always)]
pub(super) unsafe fn make_in<T>(
    memory: *mut c_void,
    size: usize,
    out: *mut *mut T,
    make: impl FnOnce(Place<T>) -> Result<(), fos_status>,
) -> fos_status {
    // SAFETY: the caller's promise
    let out = match unsafe { Place::new(out) } {
        Ok(out) => out,
        Err(status) => return status,
    };
    let made = (|| {
        check_extent(memory, size)?;
        if size < size_of::<T>() {
            return Err(fos_status::NoRoom);
        }
        // SAFETY: the caller's promise, and the bytes are enough
        make(unsafe { Place::new(memory.cast::<T>()) }?)
    })();
    out.put(if made.is_ok() { memory.cast() } else { core::ptr::null_mut() });
    fos_status::of(made)
}

/// Leaves in `used` how many bytes `fill` has written: 0 after any error.
///
/// # Safety
///
/// As of [`Place::new`].
pub(super) unsafe fn count_in(
    used: *mut usize,
    fill: impl FnOnce() -> Result<usize, fos_status>,
) -> fos_status {
    // SAFETY: the caller's promise
    let used = match unsafe { Place::new(used) } {
        Ok(used) => used,
        Err(status) => return status,
    };
    let filled = fill();
    used.put(filled.unwrap_or(0));
    fos_status::of(filled.map(|_| ()))
}

/// A buffer of C's to write into, which need not hold anything yet.
pub(super) struct Room {
    start: *mut u8,
    capacity: usize,
}

impl Room {
    /// # Safety
    ///
    /// If it is not NULL, `start` leads to `capacity` bytes that nobody else uses during the life of the room.
    pub(super) unsafe fn new(start: *mut u8, capacity: usize) -> Result<Self, fos_status> {
        check_extent(start.cast_const().cast(), capacity)?;
        Ok(Self { start, capacity })
    }

    /// The bytes, all zero at first.
    pub(super) fn zeroed(&mut self) -> &mut [u8] {
        // SAFETY: `new` checked the extent and was promised the memory; written first, for it may never have been
        unsafe {
            self.start.write_bytes(0, self.capacity);
            core::slice::from_raw_parts_mut(self.start, self.capacity)
        }
    }
}

fn check<T>(pointer: *const T) -> Result<(), fos_status> {
    if pointer.is_null() {
        return Err(fos_status::Null);
    }
    if pointer.is_aligned() { Ok(()) } else { Err(fos_status::Misaligned) }
}

/// No object is larger than half the address space, and none wraps around its end.
fn check_extent(start: *const c_void, length: usize) -> Result<(), fos_status> {
    if start.is_null() {
        return Err(fos_status::Null);
    }
    let ends = start.addr().checked_add(length).is_some();
    if ends && isize::try_from(length).is_ok() { Ok(()) } else { Err(fos_status::Argument) }
}

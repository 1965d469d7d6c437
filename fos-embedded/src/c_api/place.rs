//! Pointers from C, checked as far as possible.

use core::ffi::c_void;

use super::fos_status;

/// Shared reference to the target of `pointer`, which C only reads.
///
/// # Safety
///
/// If `pointer` is neither NULL nor misaligned, it points to a `T` that is not modified during `'a`.
pub(super) unsafe fn shared<'a, T>(pointer: *const T) -> Result<&'a T, fos_status> {
    check(pointer)?;
    // SAFETY: not NULL and aligned by the check; the rest is guaranteed by the caller
    Ok(unsafe { &*pointer })
}

/// Exclusive reference to the target of `pointer`, which only this call accesses.
///
/// # Safety
///
/// If `pointer` is neither NULL nor misaligned, it points to a `T` that nothing else reads or modifies during `'a`.
pub(super) unsafe fn exclusive<'a, T>(pointer: *mut T) -> Result<&'a mut T, fos_status> {
    check(pointer)?;
    // SAFETY: not NULL and aligned by the check; the rest is guaranteed by the caller
    Ok(unsafe { &mut *pointer })
}

/// Bytes that C only reads.
///
/// # Safety
///
/// If `pointer` is not NULL, it points to `length` bytes that are not modified during `'a`.
pub(super) unsafe fn bytes<'a>(pointer: *const u8, length: usize) -> Result<&'a [u8], fos_status> {
    check_extent(pointer.cast(), length)?;
    // SAFETY: not NULL and a possible extent by the check; the rest is guaranteed by the caller
    Ok(unsafe { core::slice::from_raw_parts(pointer, length) })
}

/// Memory of the caller for one `T`, possibly uninitialised.
pub(super) struct Place<T>(*mut T);

impl<T> Place<T> {
    /// # Safety
    ///
    /// If `pointer` is neither NULL nor misaligned, it points to memory for a `T` that nothing else uses until
    /// [`put`](Self::put).
    pub(super) unsafe fn new(pointer: *mut T) -> Result<Self, fos_status> {
        check(pointer)?;
        Ok(Self(pointer))
    }

    /// Writes a value without dropping the previous contents.
    pub(super) fn put(self, value: T) {
        // SAFETY: `new` checked the pointer, and its caller guarantees the memory
        unsafe { self.0.write(value) };
    }
}

/// Lets `make` write a `T` at the start of `size` bytes of the caller. Writes its address to `out`, or NULL on failure.
///
/// # Safety
///
/// If they are neither NULL nor misaligned, `out` points to a pointer, and `memory` to `size` bytes that nothing else uses.
#[inline(always)]
pub(super) unsafe fn make_in<T>(
    memory: *mut c_void,
    size: usize,
    out: *mut *mut T,
    make: impl FnOnce(Place<T>) -> Result<(), fos_status>,
) -> fos_status {
    // SAFETY: guaranteed by the caller
    let out = match unsafe { Place::new(out) } {
        Ok(out) => out,
        Err(status) => return status,
    };
    let made = (|| {
        check_extent(memory, size)?;
        if size < size_of::<T>() {
            return Err(fos_status::NoRoom);
        }
        // SAFETY: guaranteed by the caller, and the bytes suffice
        make(unsafe { Place::new(memory.cast::<T>()) }?)
    })();
    out.put(if made.is_ok() { memory.cast() } else { core::ptr::null_mut() });
    fos_status::of(made)
}

/// Writes to `used` the number of bytes that `fill` has written, 0 after any error.
///
/// # Safety
///
/// `used` satisfies the conditions of [`Place::new`].
pub(super) unsafe fn count_in(
    used: *mut usize,
    fill: impl FnOnce() -> Result<usize, fos_status>,
) -> fos_status {
    // SAFETY: guaranteed by the caller
    let used = match unsafe { Place::new(used) } {
        Ok(used) => used,
        Err(status) => return status,
    };
    let filled = fill();
    used.put(filled.unwrap_or(0));
    fos_status::of(filled.map(|_| ()))
}

/// Output buffer of the caller, possibly uninitialised.
pub(super) struct Room {
    start: *mut u8,
    capacity: usize,
}

impl Room {
    /// # Safety
    ///
    /// If `start` is not NULL, it points to `capacity` bytes that nothing else uses during the life of the room.
    pub(super) unsafe fn new(start: *mut u8, capacity: usize) -> Result<Self, fos_status> {
        check_extent(start.cast_const().cast(), capacity)?;
        Ok(Self { start, capacity })
    }

    /// Fills the buffer with zeros and returns it.
    pub(super) fn zeroed(&mut self) -> &mut [u8] {
        // SAFETY: `new` checked the extent, and its caller guarantees the memory; initialised here before the reference
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

// no object is larger than half the address space, and none wraps around its end
fn check_extent(start: *const c_void, length: usize) -> Result<(), fos_status> {
    if start.is_null() {
        return Err(fos_status::Null);
    }
    let ends = start.addr().checked_add(length).is_some();
    if ends && isize::try_from(length).is_ok() { Ok(()) } else { Err(fos_status::Argument) }
}

//! Flash behind three C functions, presented as pages for the store.

use core::ffi::c_void;

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

use super::fos_status;

/// Erase size of the store, bytes.
pub(super) const PAGE: u32 = 4096;

/// Read and write size of the store, bytes; a multiple of that of most parts.
const WORD: usize = 8;

/// Flash for a store: a range, and functions of the application that access it. The functions return 0 on success and any
/// other value on failure; they must not call the store. `context` is passed to them unchanged.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct fos_flash {
    /// Passed to the following functions; may be NULL.
    pub context: *mut c_void,
    /// Reads `length` bytes at `address`, both multiples of 8.
    pub read: Option<
        unsafe extern "C" fn(context: *mut c_void, address: u32, bytes: *mut u8, length: usize) -> i32,
    >,
    /// Writes `length` bytes at `address`, both multiples of 8, at most once after every erase. Parts with write words of
    /// 16 bytes or more are not supported.
    pub write: Option<
        unsafe extern "C" fn(context: *mut c_void, address: u32, bytes: *const u8, length: usize) -> i32,
    >,
    /// Erases `length` bytes at `address` to 0xff: 4096 bytes, or one sector if sectors are larger.
    pub erase: Option<unsafe extern "C" fn(context: *mut c_void, address: u32, length: u32) -> i32>,
    /// Start address of the range; the start of a sector.
    pub address: u32,
    /// Length of the range, bytes: whole pages, at least four; at least six for images of more than 2027 bytes. A page is
    /// 4096 bytes, or one sector if sectors are larger.
    pub capacity: u32,
    /// Size of a sector, the smallest unit of erasing, bytes: a divisor of 4096, or a larger multiple of 8.
    pub erase_size: u32,
}

const _: () = {
    // c/layout.c has the same numbers
    let pointer = size_of::<*mut c_void>();
    assert!(core::mem::offset_of!(fos_flash, address) == 4 * pointer);
    assert!(core::mem::offset_of!(fos_flash, erase_size) == 4 * pointer + 8);
};

/// Formats the range; the addresses of the functions are of no use in a log.
#[cfg(feature = "defmt")]
impl defmt::Format for fos_flash {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "fos_flash {{ address: {=u32:#x}, capacity: {=u32}, erase_size: {=u32} }}",
            self.address,
            self.capacity,
            self.erase_size
        );
    }
}

/// A function of the application reported a failure.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct FlashError;

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// The flash as consecutive pages of 4096 bytes from 0; the rest of larger sectors is not used.
pub(super) struct Pages(fos_flash);

impl Pages {
    /// # Safety
    ///
    /// While the pages exist, the functions may be called with the context as documented at [`fos_flash`].
    pub(super) unsafe fn new(flash: &fos_flash) -> Result<Self, fos_status> {
        if flash.read.is_none() || flash.write.is_none() || flash.erase.is_none() {
            return Err(fos_status::Null);
        }
        let pages = Self(*flash);
        let (sector, stride) = (flash.erase_size, pages.stride());
        let divides = |length: u32, by: u32| length.checked_rem(by) == Some(0);
        let valid = divides(stride, sector)
            && divides(stride, WORD as u32)
            && divides(flash.address, WORD as u32)
            && divides(flash.address, sector)
            && divides(flash.capacity, stride)
            && flash.capacity / stride >= 4
            && flash.address.checked_add(flash.capacity - 1).is_some();
        if valid { Ok(pages) } else { Err(fos_status::Argument) }
    }

    /// Distance of consecutive pages in the flash, bytes.
    fn stride(&self) -> u32 {
        self.0.erase_size.max(PAGE)
    }

    /// End of the pages in the addresses of the store.
    pub(super) fn end(&self) -> u32 {
        (self.0.capacity / self.stride()).saturating_mul(PAGE)
    }

    /// Flash address of `length` bytes within one page.
    fn address(&self, offset: u32, length: usize) -> Result<u32, FlashError> {
        let (page, within) = (offset / PAGE, offset % PAGE);
        let beyond = usize::try_from(within).ok().and_then(|within| within.checked_add(length));
        if offset >= self.end() || beyond.is_none_or(|beyond| beyond > PAGE as usize) {
            return Err(FlashError);
        }
        Ok(self.0.address.wrapping_add(page.wrapping_mul(self.stride())).wrapping_add(within))
    }
}

fn done(status: i32) -> Result<(), FlashError> {
    if status == 0 { Ok(()) } else { Err(FlashError) }
}

impl ErrorType for Pages {
    type Error = FlashError;
}

impl ReadNorFlash for Pages {
    const READ_SIZE: usize = WORD;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let address = self.address(offset, bytes.len())?;
        let read = self.0.read.ok_or(FlashError)?;
        // SAFETY: the promise of `new`; the bytes are there
        done(unsafe { read(self.0.context, address, bytes.as_mut_ptr(), bytes.len()) })
    }

    fn capacity(&self) -> usize {
        usize::try_from(self.end()).unwrap_or(usize::MAX)
    }
}

impl NorFlash for Pages {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE as usize;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let erase = self.0.erase.ok_or(FlashError)?;
        for page in from / PAGE..to / PAGE {
            let address = self.address(page.wrapping_mul(PAGE), PAGE as usize)?;
            // SAFETY: the promise of `new`
            done(unsafe { erase(self.0.context, address, self.stride()) })?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let address = self.address(offset, bytes.len())?;
        let write = self.0.write.ok_or(FlashError)?;
        // SAFETY: the promise of `new`; the bytes are there
        done(unsafe { write(self.0.context, address, bytes.as_ptr(), bytes.len()) })
    }
}

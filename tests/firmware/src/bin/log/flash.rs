//! A flash in RAM.

use core::convert::Infallible;
use core::ops::Range;

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

pub(crate) const PAGE: usize = 512;

pub(crate) struct RamFlash([u8; 4 * PAGE]);

impl RamFlash {
    pub(crate) const fn new() -> Self {
        Self([0xff; 4 * PAGE])
    }

    /// Clears bits everywhere, unlike any write.
    pub(crate) fn corrupt(&mut self, bytes: Range<usize>) {
        for byte in &mut self.0[bytes] {
            *byte &= 0x55;
        }
    }
}

impl ErrorType for RamFlash {
    type Error = Infallible;
}

impl ReadNorFlash for RamFlash {
    const READ_SIZE: usize = 4;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
        bytes.copy_from_slice(&self.0[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for RamFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Infallible> {
        self.0[from as usize..to as usize].fill(0xff);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Infallible> {
        for (held, byte) in self.0[offset as usize..].iter_mut().zip(bytes) {
            *held &= byte;
        }
        Ok(())
    }
}

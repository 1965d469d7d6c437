//! A simulated NOR flash: its power can be cut in the middle of an operation, and its bits wear out.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

/// Size of an erase unit, bytes.
pub const PAGE: usize = 4096;
/// Number of pages.
pub const PAGES: usize = 6;

/// NOR flash: a write only clears bits, an erase sets those of whole pages.
#[derive(Clone)]
pub struct Flash {
    /// Stored bytes.
    pub bytes: Vec<u8>,
    /// Number of operations until the power fails, and number of halves of the last one that are completed.
    pub power: Option<(usize, usize)>,
    /// Number of writes and erases so far.
    pub operations: usize,
    /// Worn bits, which stay 0 after an erase: (byte, mask).
    pub worn: Vec<(usize, u8)>,
    /// Number of erases of each page so far.
    pub erased: [u32; PAGES],
}

/// Error of a flash operation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// The power failed before the operation was complete.
    PowerCut,
    /// A write that is unaligned, out of range, or would set a bit.
    Misuse,
}

impl NorFlashError for Fault {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl Flash {
    /// A fully erased flash without worn bits.
    pub fn new() -> Self {
        Self {
            bytes: vec![0xff; PAGES * PAGE],
            power: None,
            operations: 0,
            worn: Vec::new(),
            erased: [0; PAGES],
        }
    }

    /// Number of bytes of an operation of `length` bytes that are completed.
    fn powered(&mut self, length: usize) -> Result<(usize, Result<(), Fault>), Fault> {
        match &mut self.power {
            Some((0, _)) => Err(Fault::PowerCut),
            Some((left, halves)) => {
                *left -= 1;
                self.operations += 1;
                let cut = *left == 0;
                Ok(if cut { (length * *halves / 2, Err(Fault::PowerCut)) } else { (length, Ok(())) })
            }
            None => {
                self.operations += 1;
                Ok((length, Ok(())))
            }
        }
    }

    /// Resets worn bits to 0.
    pub fn wear(&mut self) {
        for (place, mask) in &self.worn {
            self.bytes[*place] &= !mask;
        }
    }
}

impl Default for Flash {
    fn default() -> Self {
        Self::new()
    }
}

impl ErrorType for Flash {
    type Error = Fault;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 4;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        if matches!(self.power, Some((0, _))) {
            return Err(Fault::PowerCut);
        }
        let offset = offset as usize;
        bytes.copy_from_slice(self.bytes.get(offset..offset + bytes.len()).ok_or(Fault::Misuse)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        let (from, to) = (from as usize, to as usize);
        if !from.is_multiple_of(PAGE) || !to.is_multiple_of(PAGE) || to > self.bytes.len() {
            return Err(Fault::Misuse);
        }
        let (done, result) = self.powered(to - from)?;
        self.bytes[from..from + done].fill(0xff);
        self.erased[from / PAGE..to / PAGE].iter_mut().for_each(|erased| *erased += 1);
        self.wear();
        result
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        let offset = offset as usize;
        if !offset.is_multiple_of(4)
            || !bytes.len().is_multiple_of(4)
            || offset + bytes.len() > self.bytes.len()
        {
            return Err(Fault::Misuse);
        }
        let (done, result) = self.powered(bytes.len())?;
        for (place, byte) in bytes.iter().take(done).enumerate() {
            self.bytes[offset + place] &= byte;
        }
        self.wear();
        result
    }
}

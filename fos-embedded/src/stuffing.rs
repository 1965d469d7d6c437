//! COBS (consistent overhead byte stuffing, Cheshire and Baker 1999) as postcard writes it, into a slice.
//!
//! The same bytes as postcard's own `Cobs<Slice>`. That finds its way back to the length of a block by an index which
//! it asserts, and although the assertion always holds the compiler cannot see it: an image with telemetry would keep
//! a panic (`.ci/c device`).

use postcard::ser_flavors::Flavor;
use postcard::{Error, Result};

/// A block has at most so many bytes, its length among them.
const LONGEST: u8 = 0xff;

/// Frames into a slice: blocks that begin with their length and have no zero in them, then a zero.
pub(crate) struct Stuffing<'b> {
    buffer: &'b mut [u8],
    written: usize,
    /// Where the length of the block under way goes, and what it is.
    block: usize,
    length: u8,
}

impl<'b> Stuffing<'b> {
    pub(crate) fn new(buffer: &'b mut [u8]) -> Result<Self> {
        let mut stuffing = Self { buffer, written: 0, block: 0, length: 0 };
        stuffing.begin()?;
        Ok(stuffing)
    }

    fn put(&mut self, byte: u8) -> Result<()> {
        *self.buffer.get_mut(self.written).ok_or(Error::SerializeBufferFull)? = byte;
        self.written += 1;
        Ok(())
    }

    fn begin(&mut self) -> Result<()> {
        (self.block, self.length) = (self.written, 1);
        self.put(0)
    }

    fn end(&mut self) -> Result<()> {
        *self.buffer.get_mut(self.block).ok_or(Error::SerializeBufferFull)? = self.length;
        Ok(())
    }
}

impl<'b> Flavor for Stuffing<'b> {
    type Output = &'b mut [u8];

    fn try_push(&mut self, byte: u8) -> Result<()> {
        if byte != 0 {
            self.put(byte)?;
            self.length += 1;
        }
        if byte == 0 || self.length == LONGEST {
            self.end()?;
            self.begin()?;
        }
        Ok(())
    }

    fn finalize(mut self) -> Result<Self::Output> {
        self.end()?;
        self.put(0)?;
        self.buffer.get_mut(..self.written).ok_or(Error::SerializeBufferFull)
    }
}

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use postcard::ser_flavors::{Cobs, Slice};

    use super::*;

    fn stuffed<F: Flavor>(flavor: Result<F>, data: &[u8]) -> Result<F::Output> {
        let mut flavor = flavor?;
        for byte in data {
            flavor.try_push(*byte)?;
        }
        flavor.finalize()
    }

    #[test]
    fn writes_what_postcard_writes_and_stops_where_it_stops() {
        let mut random = 1_u32;
        for length in (0..20).chain(250..260).chain(500..515) {
            for zero_in in [1, 3, 200, u32::MAX] {
                let data: Vec<u8> = (0..length)
                    .map(|_| {
                        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                        if (random >> 8).is_multiple_of(zero_in) { 0 } else { (random >> 24) as u8 | 1 }
                    })
                    .collect();
                let mut room = vec![0; 600];
                let expected = stuffed(Cobs::try_new(Slice::new(&mut room)), &data).expect("room").to_vec();
                for capacity in 0..expected.len() + 2 {
                    let mut buffer = vec![0xa5; capacity];
                    let found = stuffed(Stuffing::new(&mut buffer), &data).ok();
                    assert_eq!(found.as_deref(), (capacity >= expected.len()).then_some(&expected[..]));
                }
                let mut decoded = expected;
                let length = cobs::decode_in_place(&mut decoded).expect("decodes");
                assert_eq!(decoded[..length], data);
            }
        }
    }
}

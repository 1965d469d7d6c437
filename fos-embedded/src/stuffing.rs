//! COBS (consistent overhead byte stuffing, Cheshire and Baker 1999) as postcard writes it, into a slice.
//!
//! The output equals that of postcard's own `Cobs<Slice>`. That asserts the index of the length of a block; the assertion
//! always holds, but the compiler cannot prove it, so firmware with telemetry would contain a panic (`.ci/c device`).

use postcard::ser_flavors::Flavor;
use postcard::{Error, Result};

/// Longest block, bytes, its length byte included.
const LONGEST: u8 = 0xff;

/// Encodes a frame into a slice: blocks without zeros that begin with their length, then a zero.
pub(crate) struct CobsEncoder<'b> {
    buffer: &'b mut [u8],
    written: usize,
    /// Index of the length byte of the current block; `length` is its value.
    block: usize,
    length: u8,
}

impl<'b> CobsEncoder<'b> {
    pub(crate) fn new(buffer: &'b mut [u8]) -> Result<Self> {
        let mut encoder = Self { buffer, written: 0, block: 0, length: 0 };
        encoder.begin()?;
        Ok(encoder)
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

impl<'b> Flavor for CobsEncoder<'b> {
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

    fn encode<F: Flavor>(flavor: Result<F>, data: &[u8]) -> Result<F::Output> {
        let mut flavor = flavor?;
        for byte in data {
            flavor.try_push(*byte)?;
        }
        flavor.finalize()
    }

    #[test]
    fn output_equals_postcard_for_every_capacity() {
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
                let expected = encode(Cobs::try_new(Slice::new(&mut room)), &data).expect("room").to_vec();
                for capacity in 0..expected.len() + 2 {
                    let mut buffer = vec![0xa5; capacity];
                    let found = encode(CobsEncoder::new(&mut buffer), &data).ok();
                    assert_eq!(found.as_deref(), (capacity >= expected.len()).then_some(&expected[..]));
                }
                let mut decoded = expected;
                let length = cobs::decode_in_place(&mut decoded).expect("decodes");
                assert_eq!(decoded[..length], data);
            }
        }
    }
}

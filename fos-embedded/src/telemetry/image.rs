//! Model images over the link of the telemetry, in the other direction.
//!
//! A frame is an image, followed by its CRC-32, both in COBS, then a zero: the framing of telemetry. The sender puts a zero in
//! front of it too, which ends whatever noise came before.

use heapless::Vec;

use super::{CRC, TelemetryError};
use crate::stuffing::CobsEncoder;

/// Receives images byte by byte. `BYTES` is the length of the longest frame: the image plus one byte in 254, plus 6.
///
/// ```
/// use fos_embedded::telemetry::{ImageReceiver, encode_image};
///
/// let mut frame = [0; 32];
/// let length = encode_image(b"an image", &mut frame).expect("32 bytes are enough").len();
/// let mut receiver: ImageReceiver<32> = ImageReceiver::new();
/// let mut received = Vec::new();
/// for byte in b"noise\0".iter().chain(&frame[..length]) {
///     if let Some(Ok(image)) = receiver.push(*byte) {
///         received.push(image.to_vec());
///     }
/// }
/// assert_eq!(received, [b"an image"]);
/// ```
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ImageReceiver<const BYTES: usize> {
    frame: Vec<u8, BYTES>,
    too_long: bool,
    /// The bytes of `frame` were returned, and the next byte begins a new one.
    complete: bool,
}

impl<const BYTES: usize> ImageReceiver<BYTES> {
    /// Creates a receiver.
    pub const fn new() -> Self {
        Self { frame: Vec::new(), too_long: false, complete: false }
    }

    /// Takes a byte of the stream; returns the bytes of an image when its frame is complete. The checksum has been verified,
    /// the image itself has not: a store and a hub do that.
    ///
    /// # Errors
    ///
    /// [`TelemetryError::Damaged`] or [`TelemetryError::TooLong`], once for every such frame.
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], TelemetryError<core::convert::Infallible>>> {
        if core::mem::take(&mut self.complete) {
            self.frame.clear();
        }
        if byte != 0 {
            self.too_long |= self.frame.push(byte).is_err();
            return None;
        }
        self.complete = true;
        if core::mem::take(&mut self.too_long) {
            return Some(Err(TelemetryError::TooLong));
        }
        if self.frame.is_empty() {
            return None;
        }
        Some(self.content().ok_or(TelemetryError::Damaged))
    }

    /// Decodes the frame in place and checks its checksum.
    fn content(&mut self) -> Option<&[u8]> {
        let length = cobs::decode_in_place(&mut self.frame).ok()?;
        let (content, checksum) = self.frame.get(..length)?.split_last_chunk()?;
        (CRC.checksum(content) == u32::from_le_bytes(*checksum)).then_some(content)
    }
}

/// Writes the frame of an image, with checksum and delimiter, into `buffer`; `None` if it does not fit.
pub fn encode_image<'b>(image: &[u8], buffer: &'b mut [u8]) -> Option<&'b [u8]> {
    use postcard::ser_flavors::Flavor as _;

    let mut encoder = CobsEncoder::new(buffer).ok()?;
    for byte in image.iter().chain(&CRC.checksum(image).to_le_bytes()) {
        encoder.try_push(*byte).ok()?;
    }
    let frame: &'b [u8] = encoder.finalize().ok()?;
    Some(frame)
}

#[cfg(test)]
mod tests {
    use std::vec::Vec as Bytes;

    use super::*;

    fn frame(image: &[u8]) -> Bytes<u8> {
        encode_image(image, &mut [0; 1024]).expect("room").to_vec()
    }

    /// Images received from a stream, and the number of errors.
    fn receive<const BYTES: usize>(stream: &[u8]) -> (Bytes<Bytes<u8>>, usize) {
        let mut receiver: ImageReceiver<BYTES> = ImageReceiver::new();
        let (mut images, mut errors) = (Bytes::new(), 0);
        for byte in stream {
            match receiver.push(*byte) {
                Some(Ok(image)) => images.push(image.to_vec()),
                Some(Err(_)) => errors += 1,
                None => {}
            }
        }
        (images, errors)
    }

    #[test]
    fn receives_every_length_twice() {
        for length in 1..600 {
            let image: Bytes<u8> = (0..length).map(|n| (n * 7 % 11) as u8).collect();
            let stream = [frame(&image), frame(&image)].concat();
            assert_eq!(receive::<1024>(&stream), (std::vec![image.clone(), image], 0), "{length}");
        }
    }

    #[test]
    fn rejects_every_changed_and_every_lost_byte_and_resumes() {
        let image = *b"\0model\0image\0";
        let whole = frame(&image);
        for place in 0..whole.len() - 1 {
            for bit in 0..8 {
                let mut changed = whole.clone();
                changed[place] ^= 1 << bit;
                let (images, errors) = receive::<64>(&[changed, whole.clone()].concat());
                assert_eq!(images, [image], "byte {place}, bit {bit}");
                assert!(errors > 0, "byte {place}, bit {bit}");
            }
            let mut short = whole.clone();
            short.remove(place);
            assert_eq!(receive::<64>(&[short, whole.clone()].concat()), (std::vec![image.to_vec()], 1));
        }
        // a lost delimiter costs the next frame too
        let (images, errors) = receive::<64>(&[&whole[..whole.len() - 1], &whole, &whole].concat());
        assert_eq!((images.len(), errors), (1, 1));
    }

    #[test]
    fn rejects_what_is_too_long_and_resumes() {
        let stream = [frame(&[1; 100]), frame(&[2; 20])].concat();
        assert_eq!(receive::<32>(&stream), (std::vec![std::vec![2; 20]], 1));
        assert!(encode_image(&[1; 100], &mut [0; 104]).is_none());
    }
}

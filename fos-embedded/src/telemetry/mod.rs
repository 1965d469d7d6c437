//! Telemetry: measured values, innovations and validity as frames over any byte stream.
//!
//! A frame is a [`Frame`] in postcard, followed by its CRC-32 (as in Ethernet and zip, little-endian), both in COBS, then a
//! zero. A zero never occurs inside a frame, so a receiver that joins late or loses bytes resumes after the next zero.
//! Every frame of a sample carries its tick, so that lost frames are counted and become gaps in a log.
//!
//! ```
//! use fos_embedded::telemetry::{Frame, StartFrame, VERSION, decode, encode};
//!
//! let start = StartFrame { version: VERSION, period_s: 0.005, axes: "gx_rads\ngy_rads", quantities: "temp_c" };
//! let mut buffer = [0; 64];
//! let length = encode(&Frame::Start(start), &mut buffer).expect("64 bytes are enough").len();
//! assert_eq!(buffer[length - 1], 0, "the delimiter");
//! let decoded: Frame<&str, (), ()> = decode(&mut buffer[..length])?;
//! assert_eq!(decoded, Frame::Start(start));
//! # Ok::<(), fos_embedded::telemetry::TelemetryError<core::convert::Infallible>>(())
//! ```

mod alarm;
mod image;
mod snapshot;

use core::fmt;

pub use alarm::AlarmRecorder;
use crc::{CRC_32_ISO_HDLC, Crc, Table};
use fos_core::Validity;
pub use image::{ImageReceiver, encode_image};
use postcard::ser_flavors::crc::CrcModifier;
use serde::{Deserialize, Serialize};
pub use snapshot::Snapshot;

use crate::stuffing::CobsEncoder;

/// Version of the frames that this crate writes; it reads no other.
pub const VERSION: u16 = 1;

/// Column names of a hub's six axes in the log format, one per line.
pub const HUB_AXES: &str = "ax_mps2\nay_mps2\naz_mps2\ngx_rads\ngy_rads\ngz_rads";

/// Samples after which the start frame is repeated, for receivers that join late: one minute at 200 Hz.
const START_EVERY: u32 = 12_000;

static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// One frame. `T` is a text, `V` and `B` hold values and bits: borrowed on the device, owned on the host, with the same
/// encoding.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Frame<T, V, B> {
    /// Description of the following samples.
    Start(StartFrame<T>),
    /// One sample with its innovations and validity.
    Sample(SampleFrame<V, B>),
}

/// Description of the following samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StartFrame<T> {
    /// [`VERSION`] of the sender; frames of another version are rejected.
    pub version: u16,
    /// Sample period, s.
    pub period_s: f32,
    /// Column names of the axes, one per line.
    pub axes: T,
    /// Column names of the logged quantities, one per line.
    pub quantities: T,
}

/// One sample: measured values, logged quantities, innovations and validity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SampleFrame<V, B> {
    /// Ticks of the sample period since the start; wraps.
    pub tick: u32,
    /// True if the device was still.
    pub still: bool,
    /// Measured value of every axis, in the order of the start frame.
    pub measured: V,
    /// Every logged quantity, in the order of the start frame.
    pub quantities: V,
    /// Innovation of every axis; NaN if there is none.
    pub innovations: V,
    /// Bits of the [`Validity`] of every axis, as u16.
    pub validity: B,
}

/// A frame on the device, with borrowed contents.
pub type Borrowed<'a> = Frame<&'a str, &'a [f32], &'a [Validity]>;

/// Reason why a frame was not sent or not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TelemetryError<E> {
    /// The frame does not fit the buffer.
    TooLong,
    /// The frame is damaged: a byte was lost or changed.
    Damaged,
    /// Start frame of another version, which this version cannot read.
    OtherVersion(u16),
    /// The stream accepts no more bytes.
    Closed,
    /// The stream failed with this error.
    Stream(E),
}

impl<E: fmt::Display> fmt::Display for TelemetryError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong => f.write_str("the frame does not fit the buffer"),
            Self::Damaged => f.write_str("the frame is damaged"),
            Self::OtherVersion(version) => {
                write!(f, "telemetry version {version}; this program reads version {VERSION}")
            }
            Self::Closed => f.write_str("the stream takes nothing more"),
            Self::Stream(error) => write!(f, "the stream failed: {error}"),
        }
    }
}

impl<E: fmt::Debug + fmt::Display> core::error::Error for TelemetryError<E> {}

/// Sends frames over a stream. `BYTES` is the length of the longest frame: 4 for every value, 2 for every validity, plus 24,
/// plus the names in a start frame.
#[derive(Debug)]
pub struct Recorder<W, const BYTES: usize> {
    stream: W,
    until_start: u32,
    /// Number of frames that were not sent completely.
    failed: u32,
}

impl<W: embedded_io::Write, const BYTES: usize> Recorder<W, BYTES> {
    /// Creates a recorder that owns `stream`.
    pub const fn new(stream: W) -> Self {
        Self { stream, until_start: 0, failed: 0 }
    }

    /// Sends a sample; before the first one and every 12,000 samples also `start`.
    ///
    /// # Errors
    ///
    /// The frame is too long, or the stream fails. An incomplete frame ends at the delimiter of the next one, and the
    /// receiver counts it as damaged.
    pub fn sample(
        &mut self,
        start: &StartFrame<&str>,
        frame: SampleFrame<&[f32], &[Validity]>,
    ) -> Result<(), TelemetryError<W::Error>> {
        let mut started = Ok(());
        if self.until_start == 0 {
            started = self.send(&Frame::Start(*start));
            self.until_start = if started.is_ok() { START_EVERY } else { 1 };
        }
        self.until_start -= 1;
        let sent = self.send(&Frame::Sample(frame));
        started.and(sent)
    }

    /// Sends the start frame with the next sample too, because the names in it have changed.
    pub fn begin(&mut self) {
        self.until_start = 0;
    }

    /// Sends a frame.
    ///
    /// # Errors
    ///
    /// The frame is too long, or the stream fails.
    pub fn send(&mut self, frame: &Borrowed<'_>) -> Result<(), TelemetryError<W::Error>> {
        let mut buffer = [0; BYTES];
        let sent = match encode(frame, &mut buffer) {
            Some(bytes) => write_all(&mut self.stream, bytes),
            None => Err(TelemetryError::TooLong),
        };
        if sent.is_err() {
            self.failed = self.failed.saturating_add(1);
        }
        sent
    }

    /// Number of frames that were not sent completely.
    pub fn failed(&self) -> u32 {
        self.failed
    }

    /// Returns the stream, without flushing it.
    pub fn release(self) -> W {
        self.stream
    }
}

/// Replaces `write_all` of embedded-io, which panics if a stream accepts nothing or claims to have taken too much.
fn write_all<W: embedded_io::Write>(stream: &mut W, bytes: &[u8]) -> Result<(), TelemetryError<W::Error>> {
    let mut left = bytes;
    while !left.is_empty() {
        left = match stream.write(left) {
            Ok(0) => return Err(TelemetryError::Closed),
            Ok(taken) => left.get(taken..).unwrap_or(&[]),
            Err(error) => return Err(TelemetryError::Stream(error)),
        };
    }
    Ok(())
}

#[cfg(feature = "defmt")]
impl<W, const BYTES: usize> defmt::Format for Recorder<W, BYTES> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Recorder {{ failed: {=u32} }}", self.failed);
    }
}

/// Writes a frame with checksum and delimiter into `buffer`; `None` if it does not fit.
pub fn encode<'b>(frame: &Borrowed<'_>, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
    let encoder = CobsEncoder::new(buffer).ok()?;
    let written = postcard::serialize_with_flavor(frame, CrcModifier::new(encoder, CRC.digest())).ok()?;
    Some(written)
}

/// Reads a frame from its bytes, decoding them in place. The delimiter may be included; bytes after it are ignored.
///
/// # Errors
///
/// [`TelemetryError::Damaged`], or [`TelemetryError::OtherVersion`] for a complete start frame of another version.
pub fn decode<'b, F: Deserialize<'b>>(
    bytes: &'b mut [u8],
) -> Result<F, TelemetryError<core::convert::Infallible>> {
    let length = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    let frame = bytes.get_mut(..length).ok_or(TelemetryError::Damaged)?;
    let decoded = cobs::decode_in_place(frame).map_err(|_| TelemetryError::Damaged)?;
    let decoded: &'b [u8] = frame.get(..decoded).ok_or(TelemetryError::Damaged)?;
    postcard::from_bytes_crc32(decoded, CRC.digest())
        .map_err(|_| other_version(decoded).map_or(TelemetryError::Damaged, TelemetryError::OtherVersion))
}

/// Version of a complete start frame of another version. In every version a frame begins with its kind, a start frame
/// continues with its version, and the checksum comes last, so that this much can be read without knowing the rest.
fn other_version(frame: &[u8]) -> Option<u16> {
    let (content, checksum) = frame.split_last_chunk()?;
    let (kind, version): (u8, u16) = postcard::from_bytes(content).ok()?;
    let is_start = kind == 0 && CRC.checksum(content) == u32::from_le_bytes(*checksum);
    (is_start && version != VERSION).then_some(version)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame that a later version may send.
    fn later_version(kind: u8, version: u16) -> ([u8; 64], usize) {
        let mut buffer = [0; 64];
        let frame = (kind, version, "a field more", 0.005_f64);
        let encoder = CobsEncoder::new(&mut buffer).expect("room");
        let length = postcard::serialize_with_flavor(&frame, CrcModifier::new(encoder, CRC.digest()))
            .expect("room")
            .len();
        (buffer, length)
    }

    fn decode_error(bytes: &mut [u8]) -> Option<TelemetryError<core::convert::Infallible>> {
        decode::<Frame<&str, (), ()>>(bytes).err()
    }

    #[test]
    fn distinguishes_other_versions_from_damage() {
        let (mut frame, length) = later_version(0, 300);
        let whole = frame;
        assert_eq!(decode_error(&mut frame[..length]), Some(TelemetryError::OtherVersion(300)));
        for place in 0..length - 1 {
            let mut damaged = whole;
            damaged[place] ^= 1;
            assert_eq!(decode_error(&mut damaged[..length]), Some(TelemetryError::Damaged), "at {place}");
        }
        let (mut no_start, length) = later_version(7, 300);
        assert_eq!(decode_error(&mut no_start[..length]), Some(TelemetryError::Damaged));
    }
}

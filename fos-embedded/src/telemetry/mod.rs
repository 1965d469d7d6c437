//! Telemetry: what the sensor measured and what the model made of it, as frames over any byte stream.
//!
//! A frame is a [`Frame`] in postcard, CRC-32 of it (as in Ethernet and zip, little-endian) behind it, both in COBS,
//! then a zero. A zero never occurs inside a frame: whoever joins the stream late, or loses a part of it, goes on at
//! the next. Every frame of a sample carries its tick, so that lost frames are counted and become gaps in a log.
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
mod snapshot;

use core::fmt;

pub use alarm::AlarmRecorder;
use crc::{CRC_32_ISO_HDLC, Crc, Table};
use fos_core::Validity;
use postcard::ser_flavors::crc::CrcModifier;
use serde::{Deserialize, Serialize};
pub use snapshot::Snapshot;

use crate::stuffing::Stuffing;

/// The version that this crate writes, and the only one it reads.
pub const VERSION: u16 = 1;

/// Columns of a hub's six axes, as in the log format, one a line.
pub const HUB_AXES: &str = "ax_mps2\nay_mps2\naz_mps2\ngx_rads\ngy_rads\ngz_rads";

/// A start frame is sent again after so many samples: a minute at 200 Hz, for those who join late.
const START_EVERY: u32 = 12_000;

static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// One frame. `T` is a text, `V` and `B` hold values and bits: borrowed on the device, owned on the host, the same
/// bytes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Frame<T, V, B> {
    /// What the samples that follow hold.
    Start(StartFrame<T>),
    /// One sample, and what the model made of it.
    Sample(SampleFrame<V, B>),
}

/// What the samples that follow hold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StartFrame<T> {
    /// [`VERSION`] of what sends; another is not read on.
    pub version: u16,
    /// Sample period, s.
    pub period_s: f32,
    /// Columns of the axes, one a line.
    pub axes: T,
    /// Columns of the logged quantities, one a line.
    pub quantities: T,
}

/// One sample: what was measured, what the model says, and what speaks against it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SampleFrame<V, B> {
    /// Ticks of the sample period since start; wraps.
    pub tick: u32,
    /// Whether the unit was still.
    pub still: bool,
    /// Measured value of every axis.
    pub measured: V,
    /// Every logged quantity, in the order of the start frame.
    pub quantities: V,
    /// Innovation of every axis; NaN where there is none.
    pub innovations: V,
    /// [`Validity`] of every axis: its bits, as u16.
    pub validity: B,
}

/// A frame of the device: everything borrowed.
pub type Borrowed<'a> = Frame<&'a str, &'a [f32], &'a [Validity]>;

/// Why a frame was not sent or not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TelemetryError<E> {
    /// It does not fit the buffer.
    TooLong,
    /// It is damaged: a byte was lost or changed.
    Damaged,
    /// A start frame of another version, which this one cannot read on.
    OtherVersion(u16),
    /// The stream takes nothing more.
    Closed,
    /// The stream failed, and says why.
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

/// Sends frames over a stream. `BYTES` is the length of the longest frame: 4 for every value, 2 for every validity,
/// 24 more, and the names of a start frame.
#[derive(Debug)]
pub struct Recorder<W, const BYTES: usize> {
    stream: W,
    until_start: u32,
    /// Frames that were not sent whole.
    failed: u32,
}

impl<W: embedded_io::Write, const BYTES: usize> Recorder<W, BYTES> {
    /// Over this stream, which it keeps.
    pub const fn new(stream: W) -> Self {
        Self { stream, until_start: 0, failed: 0 }
    }

    /// Sends a sample and what the model made of it; before the first, and every minute or so, `start` too.
    ///
    /// # Errors
    ///
    /// It is too long, or the stream fails. A frame that was cut off is ended by the next one's delimiter and counts
    /// as damaged there.
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

    /// The next sample comes with its start frame.
    pub(super) fn begin(&mut self) {
        self.until_start = 0;
    }

    /// Sends a frame.
    ///
    /// # Errors
    ///
    /// It is too long, or the stream fails.
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

    /// Frames that were not sent whole.
    pub fn failed(&self) -> u32 {
        self.failed
    }

    /// The stream; nothing is flushed.
    pub fn release(self) -> W {
        self.stream
    }
}

/// embedded-io's own panics where a stream takes nothing, or says that it took more than there was.
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

/// Writes a frame with its checksum and its delimiter into `buffer`; `None` if it does not fit.
pub fn encode<'b>(frame: &Borrowed<'_>, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
    let stuffing = Stuffing::new(buffer).ok()?;
    let written = postcard::serialize_with_flavor(frame, CrcModifier::new(stuffing, CRC.digest())).ok()?;
    Some(written)
}

/// Reads a frame from the bytes up to its delimiter, which may be among them; they are decoded in place.
///
/// # Errors
///
/// [`TelemetryError::Damaged`]; [`TelemetryError::OtherVersion`] of a start frame that is whole but goes on in
/// another way.
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

/// The version of a whole start frame of another one. In every version a frame begins with its kind, a start frame
/// goes on with its version, and the checksum ends it: so much can be said of a frame whose content is not known.
fn other_version(frame: &[u8]) -> Option<u16> {
    let (content, checksum) = frame.split_last_chunk()?;
    let (kind, version): (u8, u16) = postcard::from_bytes(content).ok()?;
    let is_start = kind == 0 && CRC.checksum(content) == u32::from_le_bytes(*checksum);
    (is_start && version != VERSION).then_some(version)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a later version may send.
    fn later(kind: u8, version: u16) -> ([u8; 64], usize) {
        let mut buffer = [0; 64];
        let frame = (kind, version, "a field more", 0.005_f64);
        let stuffing = Stuffing::new(&mut buffer).expect("room");
        let length = postcard::serialize_with_flavor(&frame, CrcModifier::new(stuffing, CRC.digest()))
            .expect("room")
            .len();
        (buffer, length)
    }

    fn said(bytes: &mut [u8]) -> Option<TelemetryError<core::convert::Infallible>> {
        decode::<Frame<&str, (), ()>>(bytes).err()
    }

    #[test]
    fn a_start_frame_of_another_version_is_told_from_damage() {
        let (mut frame, length) = later(0, 300);
        let whole = frame;
        assert_eq!(said(&mut frame[..length]), Some(TelemetryError::OtherVersion(300)));
        for place in 0..length - 1 {
            let mut damaged = whole;
            damaged[place] ^= 1;
            assert_eq!(said(&mut damaged[..length]), Some(TelemetryError::Damaged), "at {place}");
        }
        let (mut no_start, length) = later(7, 300);
        assert_eq!(said(&mut no_start[..length]), Some(TelemetryError::Damaged));
    }
}

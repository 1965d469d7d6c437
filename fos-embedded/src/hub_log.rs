//! Hub log: raw samples as firmware reads them from a file, through a hub, into a digest that host and target share.
//!
//! Little-endian throughout: a header, then records of one fixed length up to the end of the file.
//!
//! | header | type | |
//! |---|---|---|
//! | magic | 4 bytes | `FOSH` |
//! | version | u16 | 1 |
//! | n_given | u8 | quantities that the application gives with every record |
//! | values | u8 | 0 as the sensor gives them, 1 factory-corrected |
//! | accel_mps2, gyro_rads, temperature_k, temperature_zero_c | f32 each | the [`Scales`] |
//! | period_s | f64 | |
//!
//! | record | type | |
//! |---|---|---|
//! | skipped | u32 | ticks without a sample before this one |
//! | faults | u16 | bits of [`Faults`] |
//! | motion | u8 | 0 left to the detector, 1 moving, 2 still |
//! | has_temperature | u8 | 0 or 1 |
//! | clock_us | u64 | what the application's clock shows after this sample; 0: it does not look |
//! | accel, gyro | i16 × 6 | codes |
//! | temperature | i16 | code |
//! | reserved | u16 | 0 |
//! | given | f32 × n_given | in the model's order |
//!
//! ```
//! use fos_core::FittedOn;
//! use fos_embedded::hub_log::{HEADER_LENGTH, Header, Record};
//! use fos_embedded::raw::{RawSample, Scales};
//!
//! let scales = Scales {
//!     accel_mps2: 0.0012,
//!     gyro_rads: 0.0003,
//!     temperature_k: 0.004,
//!     temperature_zero_c: 25.0,
//!     period_s: 0.005,
//!     values: FittedOn::Raw,
//! };
//! let header = Header { scales, n_given: 0 };
//! let raw = RawSample { gyro: [1, 2, 3], ..RawSample::default() };
//! let record = Record { raw, motion: None, clock_us: 0, given: &[] };
//! let log: Vec<u8> = header.encode().into_iter().chain(record.encode()).collect();
//!
//! assert_eq!(Header::decode(&log)?, header);
//! assert_eq!(Record::decode(&log[HEADER_LENGTH..], &mut [])?, record);
//! # Ok::<(), fos_embedded::hub_log::HubLogError>(())
//! ```

use core::fmt;

use crc::Table;
use fos_core::FittedOn;

use crate::hub::{Hub, Motion, Output};
use crate::raw::{Faults, RawSample, Scales};
use crate::replay::{ABSENT, CRC};

/// The first four bytes of a log.
pub const MAGIC: [u8; 4] = *b"FOSH";

/// The version that this crate writes, and the only one it reads.
pub const VERSION: u16 = 1;

/// Bytes before the first record.
pub const HEADER_LENGTH: usize = 32;

/// Bytes of a record before what the application gives.
const RECORD_LENGTH: usize = 32;

/// What the codes of a log mean.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Header {
    /// Of the codes.
    pub scales: Scales,
    /// Quantities that the application gives with every record.
    pub n_given: u8,
}

/// One sample of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Record<'a> {
    /// What the sensor gave.
    pub raw: RawSample,
    /// Whether the unit was still; none if that is left to the detector.
    pub motion: Option<Motion>,
    /// What the application's clock shows after this sample, µs; 0: it does not look.
    pub clock_us: u64,
    /// What the application gives, in the model's order.
    pub given: &'a [f32],
}

/// Why a log cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum HubLogError {
    /// The log ends within its header or within a record.
    Truncated {
        /// Bytes needed.
        needed: usize,
        /// Bytes there.
        found: usize,
    },
    /// It does not start with [`MAGIC`]: not a hub log.
    Magic,
    /// A version that this program does not know.
    UnknownVersion(u16),
    /// A field has a value that it cannot have; its name.
    Field(&'static str),
}

impl fmt::Display for HubLogError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Truncated { needed, found } => write!(f, "truncated: {found} of {needed} bytes"),
            Self::Magic => write!(f, "not a hub log: it does not start with FOSH"),
            Self::UnknownVersion(version) => {
                write!(f, "hub log version {version}; this program reads version {VERSION}")
            }
            Self::Field(name) => write!(f, "{name} has a value that it cannot have"),
        }
    }
}

impl core::error::Error for HubLogError {}

impl Header {
    /// Reads the header at the start of `log`.
    ///
    /// # Errors
    ///
    /// It is none, ends early, or has a value that it cannot have.
    pub fn decode(log: &[u8]) -> Result<Self, HubLogError> {
        let mut fields = Fields { rest: log, needed: HEADER_LENGTH, found: log.len() };
        if fields.bytes()? != MAGIC {
            return Err(HubLogError::Magic);
        }
        let version = u16::from_le_bytes(fields.bytes()?);
        if version != VERSION {
            return Err(HubLogError::UnknownVersion(version));
        }
        let [n_given] = fields.bytes()?;
        let values = match fields.bytes()? {
            [0] => FittedOn::Raw,
            [1] => FittedOn::FactoryCorrected,
            _ => return Err(HubLogError::Field("values")),
        };
        let scales = Scales {
            accel_mps2: f32::from_le_bytes(fields.bytes()?),
            gyro_rads: f32::from_le_bytes(fields.bytes()?),
            temperature_k: f32::from_le_bytes(fields.bytes()?),
            temperature_zero_c: f32::from_le_bytes(fields.bytes()?),
            period_s: f64::from_le_bytes(fields.bytes()?),
            values,
        };
        Ok(Self { scales, n_given })
    }

    /// The header's bytes.
    pub fn encode(&self) -> [u8; HEADER_LENGTH] {
        let scales = &self.scales;
        let values = match scales.values {
            FittedOn::Raw => 0,
            FittedOn::FactoryCorrected => 1,
        };
        let floats = [scales.accel_mps2, scales.gyro_rads, scales.temperature_k, scales.temperature_zero_c];
        let fields = MAGIC
            .into_iter()
            .chain(VERSION.to_le_bytes())
            .chain([self.n_given, values])
            .chain(floats.into_iter().flat_map(f32::to_le_bytes))
            .chain(scales.period_s.to_le_bytes());
        let mut header = [0; HEADER_LENGTH];
        for (byte, field) in header.iter_mut().zip(fields) {
            *byte = field;
        }
        header
    }

    /// Bytes of a record.
    pub fn record_length(&self) -> usize {
        RECORD_LENGTH + 4 * usize::from(self.n_given)
    }
}

impl<'a> Record<'a> {
    /// Reads the record at the start of `bytes`; what the application gives is decoded into `given`, which has its length.
    ///
    /// # Errors
    ///
    /// It ends early, or has a value that it cannot have.
    pub fn decode(bytes: &[u8], given: &'a mut [f32]) -> Result<Self, HubLogError> {
        let needed = RECORD_LENGTH + 4 * given.len();
        let mut fields = Fields { rest: bytes, needed, found: bytes.len() };
        let skipped = u32::from_le_bytes(fields.bytes()?);
        let faults = Faults::from_bits(u16::from_le_bytes(fields.bytes()?));
        let faults = faults.ok_or(HubLogError::Field("faults"))?;
        let motion = match fields.bytes()? {
            [0] => None,
            [1] => Some(Motion::Moving),
            [2] => Some(Motion::Still),
            _ => return Err(HubLogError::Field("motion")),
        };
        let [has_temperature] = fields.bytes()?;
        let clock_us = u64::from_le_bytes(fields.bytes()?);
        let (accel, gyro) = (fields.codes()?, fields.codes()?);
        let temperature = i16::from_le_bytes(fields.bytes()?);
        let temperature = match has_temperature {
            0 => None,
            1 => Some(temperature),
            _ => return Err(HubLogError::Field("has_temperature")),
        };
        if fields.bytes()? != [0, 0] {
            return Err(HubLogError::Field("reserved"));
        }
        for value in given.iter_mut() {
            *value = f32::from_le_bytes(fields.bytes()?);
        }
        let raw = RawSample { skipped, accel, gyro, temperature, faults };
        Ok(Self { raw, motion, clock_us, given })
    }

    /// The record's bytes, in their order.
    pub fn encode(&self) -> impl Iterator<Item = u8> + '_ {
        let raw = &self.raw;
        let motion = match self.motion {
            None => 0,
            Some(Motion::Moving) => 1,
            Some(Motion::Still) => 2,
        };
        let codes = raw.accel.into_iter().chain(raw.gyro).chain([raw.temperature.unwrap_or(0), 0]);
        raw.skipped
            .to_le_bytes()
            .into_iter()
            .chain(raw.faults.bits().to_le_bytes())
            .chain([motion, u8::from(raw.temperature.is_some())])
            .chain(self.clock_us.to_le_bytes())
            .chain(codes.flat_map(i16::to_le_bytes))
            .chain(self.given.iter().flat_map(|value| value.to_le_bytes()))
    }
}

/// Bytes that have not been read.
struct Fields<'a> {
    rest: &'a [u8],
    needed: usize,
    found: usize,
}

impl Fields<'_> {
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], HubLogError> {
        let truncated = HubLogError::Truncated { needed: self.needed, found: self.found };
        let (bytes, rest) = self.rest.split_first_chunk().ok_or(truncated)?;
        self.rest = rest;
        Ok(*bytes)
    }

    fn codes(&mut self) -> Result<[i16; 3], HubLogError> {
        let [a, b, c, d, e, f] = self.bytes()?;
        Ok([[a, b], [c, d], [e, f]].map(i16::from_le_bytes))
    }
}

/// One record through the hub, in the order in which an application calls it.
pub fn step<'h, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>(
    hub: &'h mut Hub<INPUTS, TERMS, HISTORY>,
    record: &Record<'_>,
) -> &'h Output {
    for (index, value) in record.given.iter().enumerate() {
        hub.give_application(index, *value);
    }
    hub.set_motion(record.motion);
    let _ = hub.update(&record.raw);
    if record.clock_us != 0 {
        hub.clock(record.clock_us);
    }
    hub.output()
}

/// Digest (CRC-64/XZ) of what a hub said, to compare two machines to the last bit.
///
/// Of every sample, little-endian: of each axis the corrected value and the innovation as f32 (0x7FC00000 where there is none)
/// and the validity as u16; then still (u8), faults (u16), drift (u8).
#[derive(Clone)]
pub struct Digest(crc::Digest<'static, u64, Table<1>>);

impl Default for Digest {
    fn default() -> Self {
        Self(CRC.digest())
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Digest {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Digest({=u64:016x})", self.value());
    }
}

impl Digest {
    /// Takes what was said of one sample.
    pub fn update(&mut self, output: &Output) {
        let bits = |value: f32| if value.is_nan() { ABSENT } else { value.to_bits() }.to_le_bytes();
        for ((corrected, innovation), validity) in
            output.corrected.into_iter().zip(output.innovation).zip(output.validity)
        {
            self.0.update(&bits(corrected));
            self.0.update(&bits(innovation));
            self.0.update(&validity.bits().to_le_bytes());
        }
        let [low, high] = output.faults.bits().to_le_bytes();
        self.0.update(&[u8::from(output.still), low, high, u8::from(output.drift)]);
    }

    /// Of everything up to now.
    pub fn value(&self) -> u64 {
        self.0.clone().finalize()
    }
}

impl fmt::Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.value())
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    const HEADER: Header = Header {
        scales: Scales {
            accel_mps2: 1.0,
            gyro_rads: -0.5,
            temperature_k: 0.25,
            temperature_zero_c: 2.0,
            period_s: 0.005,
            values: FittedOn::FactoryCorrected,
        },
        n_given: 2,
    };
    const RECORD: Record<'_> = Record {
        raw: RawSample {
            skipped: 7,
            accel: [1, -2, 3],
            gyro: [-32_768, 0, 32_767],
            temperature: Some(-1),
            faults: Faults::OVERRUN.union(Faults::RATE),
        },
        motion: Some(Motion::Still),
        clock_us: 0x0102_0304_0506_0708,
        given: &[1.5, -0.0],
    };

    #[test]
    fn a_log_is_these_bytes() {
        let header = HEADER.encode();
        assert_eq!(header[..8], *b"FOSH\x01\x00\x02\x01");
        assert_eq!(header[8..12], 1.0_f32.to_le_bytes());
        assert_eq!(header[24..], 0.005_f64.to_le_bytes());
        let bytes: Vec<u8> = RECORD.encode().collect();
        assert_eq!(bytes.len(), HEADER.record_length());
        let expected: &[&[u8]] = &[
            &[7, 0, 0, 0, 0x02, 0x01, 2, 1],
            &[8, 7, 6, 5, 4, 3, 2, 1],
            &[1, 0, 0xfe, 0xff, 3, 0, 0x00, 0x80, 0, 0, 0xff, 0x7f],
            &[0xff, 0xff, 0, 0],
            &[0, 0, 0xc0, 0x3f, 0, 0, 0, 0x80],
        ];
        assert_eq!(bytes, expected.concat());
    }

    #[test]
    fn what_was_encoded_is_decoded_even_with_more_bytes_after_it() {
        assert_eq!(Header::decode(&HEADER.encode()), Ok(HEADER));
        let mut bytes: Vec<u8> = RECORD.encode().collect();
        bytes.extend([0xff; 3]);
        assert_eq!(Record::decode(&bytes, &mut [0.0; 2]), Ok(RECORD));
        let raw = RawSample { temperature: None, faults: Faults::empty(), ..RECORD.raw };
        let plain = Record { raw, motion: None, clock_us: 0, given: &[] };
        let bytes: Vec<u8> = plain.encode().collect();
        assert_eq!(Record::decode(&bytes, &mut []), Ok(plain));
    }

    #[test]
    fn refuses_what_is_not_a_log() {
        let bytes = HEADER.encode();
        for length in 4..HEADER_LENGTH {
            let error = HubLogError::Truncated { needed: HEADER_LENGTH, found: length };
            assert_eq!(Header::decode(&bytes[..length]), Err(error));
        }
        for (place, error) in
            [(0, HubLogError::Magic), (4, HubLogError::UnknownVersion(3)), (7, HubLogError::Field("values"))]
        {
            let mut wrong = bytes;
            wrong[place] ^= 2;
            assert_eq!(Header::decode(&wrong), Err(error));
        }
    }

    #[test]
    fn refuses_a_record_that_ends_early_or_has_impossible_values() {
        let bytes: Vec<u8> = RECORD.encode().collect();
        for length in 0..bytes.len() {
            let error = HubLogError::Truncated { needed: bytes.len(), found: length };
            assert_eq!(Record::decode(&bytes[..length], &mut [0.0; 2]), Err(error));
        }
        for (place, name) in [(5, "faults"), (6, "motion"), (7, "has_temperature"), (31, "reserved")] {
            let mut wrong = bytes.clone();
            wrong[place] = 0x80;
            assert_eq!(Record::decode(&wrong, &mut [0.0; 2]), Err(HubLogError::Field(name)));
        }
    }
}

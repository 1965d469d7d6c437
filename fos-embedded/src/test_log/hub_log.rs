//! `FOSH`: a log of raw codes for a hub.
//!
//! | header | type | |
//! |---|---|---|
//! | magic | 4 bytes | `FOSH` |
//! | version | u16 | 1 |
//! | n_given | u8 | quantities that the application gives with every record |
//! | values | u8 | 0 raw, 1 factory-corrected |
//! | accel_mps2, gyro_rads, temperature_k, temperature_zero_c | f32 each | the [`Scales`] |
//! | period_s | f64 | |
//!
//! | record | type | |
//! |---|---|---|
//! | skipped | u32 | ticks without a sample before this one |
//! | faults | u16 | bits of [`Faults`] |
//! | motion | u8 | 0 left to the detector, 1 moving, 2 still |
//! | has_temperature | u8 | 0 or 1 |
//! | clock_us | u64 | time of the application's clock after this sample; 0: not read |
//! | accel, gyro | i16 × 6 | codes |
//! | temperature | i16 | code |
//! | reserved | u16 | 0 |
//! | given | f32 × n_given | in the model's order |
//!
//! ```
//! use fos_core::FittedOn;
//! use fos_embedded::raw::{RawSample, Scales};
//! use fos_embedded::test_log::{HubLogHeader, HubLogRecord};
//!
//! let scales = Scales {
//!     accel_mps2: 0.0012,
//!     gyro_rads: 0.0003,
//!     temperature_k: 0.004,
//!     temperature_zero_c: 25.0,
//!     period_s: 0.005,
//!     values: FittedOn::Raw,
//! };
//! let header = HubLogHeader { scales, n_given: 0 };
//! let raw = RawSample { gyro: [1, 2, 3], ..RawSample::default() };
//! let record = HubLogRecord { raw, motion: None, clock_us: 0, given: &[] };
//! let log: Vec<u8> = header.encode().into_iter().chain(record.encode()).collect();
//!
//! assert_eq!(HubLogHeader::decode(&log)?, header);
//! assert_eq!(HubLogRecord::decode(&log[HubLogHeader::LENGTH..], &mut [])?, record);
//! # Ok::<(), fos_embedded::test_log::TestLogError>(())
//! ```

use fos_core::{FittedOn, Scalar};

use super::TestLogError;
use super::fields::{Fields, bytes_of};
use crate::hub::{Hub, Motion, Output};
use crate::raw::{Faults, RawSample, Scales};

/// Length of a record without the quantities given by the application, bytes.
const RECORD_LENGTH: usize = 32;

/// Header of a log: the scales of its codes and the length of its records.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HubLogHeader {
    /// Scales of the codes, for the hub.
    pub scales: Scales,
    /// Number of quantities that the application gives with every record.
    pub n_given: u8,
}

/// One sample of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HubLogRecord<'a> {
    /// Sample of the sensor.
    pub raw: RawSample,
    /// Motion state; `None` leaves it to the detector.
    pub motion: Option<Motion>,
    /// Time of the application's clock after this sample, µs; 0 if it is not read.
    pub clock_us: u64,
    /// Quantities given by the application, in the model's order and units.
    pub given: &'a [f32],
}

impl HubLogHeader {
    /// The first four bytes of a log.
    pub const MAGIC: &'static str = "FOSH";

    /// Version of the log that this crate writes; it reads no other.
    pub const VERSION: u16 = 1;

    /// Length of the header, bytes.
    pub const LENGTH: usize = 32;

    /// Reads the header at the start of `log`.
    ///
    /// # Errors
    ///
    /// The magic or version is wrong, the header is truncated, or a field is invalid.
    pub fn decode(log: &[u8]) -> Result<Self, TestLogError> {
        let mut fields = Fields::of_header(log, Self::LENGTH, Self::MAGIC, Self::VERSION)?;
        let n_given = fields.u8()?;
        let values = match fields.u8()? {
            0 => FittedOn::Raw,
            1 => FittedOn::FactoryCorrected,
            _ => return Err(TestLogError::Field("values")),
        };
        let scales = Scales {
            accel_mps2: fields.f32()?,
            gyro_rads: fields.f32()?,
            temperature_k: fields.f32()?,
            temperature_zero_c: fields.f32()?,
            period_s: fields.f64()?,
            values,
        };
        Ok(Self { scales, n_given })
    }

    /// Bytes of the header.
    pub fn encode(&self) -> [u8; Self::LENGTH] {
        let scales = &self.scales;
        let values = match scales.values {
            FittedOn::Raw => 0,
            FittedOn::FactoryCorrected => 1,
        };
        let floats = [scales.accel_mps2, scales.gyro_rads, scales.temperature_k, scales.temperature_zero_c];
        let fields = Self::MAGIC
            .bytes()
            .chain(Self::VERSION.to_le_bytes())
            .chain([self.n_given, values])
            .chain(bytes_of(&floats))
            .chain(scales.period_s.to_le_bytes());
        let mut header = [0; Self::LENGTH];
        for (byte, field) in header.iter_mut().zip(fields) {
            *byte = field;
        }
        header
    }

    /// Length of a record, bytes.
    pub fn record_length(&self) -> usize {
        RECORD_LENGTH + 4 * usize::from(self.n_given)
    }
}

impl<'a> HubLogRecord<'a> {
    /// Reads the record at the start of `bytes`. The quantities given by the application are decoded into `given`, whose
    /// length is [`HubLogHeader::n_given`].
    ///
    /// # Errors
    ///
    /// The record is truncated, or a field is invalid.
    pub fn decode(bytes: &[u8], given: &'a mut [f32]) -> Result<Self, TestLogError> {
        let mut fields = Fields::of(bytes, RECORD_LENGTH + 4 * given.len());
        let skipped = fields.u32()?;
        let faults = Faults::from_bits(fields.u16()?).ok_or(TestLogError::Field("faults"))?;
        let motion = match fields.u8()? {
            0 => None,
            1 => Some(Motion::Moving),
            2 => Some(Motion::Still),
            _ => return Err(TestLogError::Field("motion")),
        };
        let has_temperature = fields.u8()?;
        let clock_us = fields.u64()?;
        let (accel, gyro) = (fields.codes()?, fields.codes()?);
        let code = fields.code()?;
        let temperature = match has_temperature {
            0 => None,
            1 => Some(code),
            _ => return Err(TestLogError::Field("has_temperature")),
        };
        if fields.u16()? != 0 {
            return Err(TestLogError::Field("reserved"));
        }
        fields.values(given)?;
        let raw = RawSample { skipped, accel, gyro, temperature, faults };
        Ok(Self { raw, motion, clock_us, given })
    }

    /// Bytes of the record.
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
            .chain(bytes_of(self.given))
    }

    /// Passes the record to the hub, with the calls in the order of an application.
    pub fn step<
        'h,
        const INPUTS: usize,
        const TERMS: usize,
        const HISTORY: usize,
        R: Scalar<Stored = f32>,
    >(
        &self,
        hub: &'h mut Hub<INPUTS, TERMS, HISTORY, R>,
    ) -> &'h Output<R> {
        for (index, value) in self.given.iter().enumerate() {
            hub.give_application(index, *value);
        }
        hub.set_motion(self.motion);
        let _ = hub.update(&self.raw);
        if self.clock_us != 0 {
            hub.clock(self.clock_us);
        }
        hub.output()
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    const HEADER: HubLogHeader = HubLogHeader {
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
    const RECORD: HubLogRecord<'_> = HubLogRecord {
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
    fn decodes_encoded_records_with_trailing_bytes() {
        assert_eq!(HubLogHeader::decode(&HEADER.encode()), Ok(HEADER));
        let mut bytes: Vec<u8> = RECORD.encode().collect();
        bytes.extend([0xff; 3]);
        assert_eq!(HubLogRecord::decode(&bytes, &mut [0.0; 2]), Ok(RECORD));
        let raw = RawSample { temperature: None, faults: Faults::empty(), ..RECORD.raw };
        let plain = HubLogRecord { raw, motion: None, clock_us: 0, given: &[] };
        let bytes: Vec<u8> = plain.encode().collect();
        assert_eq!(HubLogRecord::decode(&bytes, &mut []), Ok(plain));
    }

    #[test]
    fn rejects_invalid_headers() {
        let bytes = HEADER.encode();
        for length in 4..HubLogHeader::LENGTH {
            let error = TestLogError::Truncated { needed: HubLogHeader::LENGTH, found: length };
            assert_eq!(HubLogHeader::decode(&bytes[..length]), Err(error));
        }
        for (place, error) in [
            (0, TestLogError::Magic("FOSH")),
            (4, TestLogError::UnknownVersion { found: 3, read: 1 }),
            (7, TestLogError::Field("values")),
        ] {
            let mut wrong = bytes;
            wrong[place] ^= 2;
            assert_eq!(HubLogHeader::decode(&wrong), Err(error));
        }
    }

    #[test]
    fn rejects_truncated_and_invalid_records() {
        let bytes: Vec<u8> = RECORD.encode().collect();
        for length in 0..bytes.len() {
            let error = TestLogError::Truncated { needed: bytes.len(), found: length };
            assert_eq!(HubLogRecord::decode(&bytes[..length], &mut [0.0; 2]), Err(error));
        }
        for (place, name) in [(5, "faults"), (6, "motion"), (7, "has_temperature"), (31, "reserved")] {
            let mut wrong = bytes.clone();
            wrong[place] = 0x80;
            assert_eq!(HubLogRecord::decode(&wrong, &mut [0.0; 2]), Err(TestLogError::Field(name)));
        }
    }
}

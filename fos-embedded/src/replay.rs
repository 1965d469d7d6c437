//! Replay: a recorded log as firmware reads it, through the predictor, into a digest that host and target share.
//!
//! A log is little-endian throughout: a header, then records of one fixed length up to the end of the file.
//!
//! | header | type | |
//! |---|---|---|
//! | magic | 4 bytes | `FOSR` |
//! | version | u16 | 1 |
//! | n_axes | u8 | measured values of a record |
//! | n_quantities | u8 | logged quantities of a record |
//!
//! | record | type | |
//! |---|---|---|
//! | skipped | u32 | ticks without a sample before this one |
//! | motion | u32 | 0 moving, 1 still |
//! | measured | f32 × n_axes | in the unit and order of the model's axes; NaN where there is none |
//! | quantities | f32 × n_quantities | in the unit and order of the model's quantities; NaN where there is none |
//!
//! ```
//! use fos_embedded::replay::{Decoder, HEADER_LENGTH, Header, Motion, Record};
//!
//! let header = Header { n_axes: 1, n_quantities: 1 };
//! let record = Record { skipped: 0, motion: Motion::Still, measured: &[0.012], quantities: &[21.5] };
//! let log: Vec<u8> = header.encode().into_iter().chain(record.encode()).collect();
//!
//! let mut decoder = Decoder::new(Header::decode(&log)?)?;
//! assert_eq!(decoder.record(&log[HEADER_LENGTH..])?, record);
//! # Ok::<(), fos_embedded::replay::ReplayError>(())
//! ```

use core::fmt;

use crc::{CRC_64_XZ, Crc, Table};
use fos_core::{Correction, Predictor, Sample};

pub use crate::hub::Motion;

/// The first four bytes of a log.
pub const MAGIC: [u8; 4] = *b"FOSR";

/// The version that this crate writes, and the only one it reads.
pub const VERSION: u16 = 1;

/// Bytes before the first record.
pub const HEADER_LENGTH: usize = 8;

/// At most so many axes and quantities together.
pub const MAX_VALUES: usize = 64;

/// The longest record, in bytes.
pub const MAX_RECORD_LENGTH: usize = 8 + 4 * MAX_VALUES;

/// What the records of a log hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Header {
    /// Measured values of a record.
    pub n_axes: u8,
    /// Logged quantities of a record.
    pub n_quantities: u8,
}

/// One sample of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Record<'a> {
    /// Ticks without a sample before this one.
    pub skipped: u32,
    /// Whether the unit was still.
    pub motion: Motion,
    /// Measured value of every axis.
    pub measured: &'a [f32],
    /// Every logged quantity.
    pub quantities: &'a [f32],
}

/// Why a log cannot be read or does not fit a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ReplayError {
    /// The log ends within its header or within a record.
    Truncated {
        /// Bytes needed.
        needed: usize,
        /// Bytes there.
        found: usize,
    },
    /// It does not start with [`MAGIC`]: not a log for replay.
    Magic,
    /// A version that this program does not know.
    UnknownVersion(u16),
    /// More axes and quantities than [`MAX_VALUES`].
    TooManyValues(usize),
    /// A record's motion is neither 0 nor 1.
    Motion(u32),
    /// The log has other axes or quantities than the model.
    Mismatch {
        /// In the log.
        log: Header,
        /// In the model.
        model: Header,
    },
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Truncated { needed, found } => write!(f, "truncated: {found} of {needed} bytes"),
            Self::Magic => write!(f, "not a log for replay: it does not start with FOSR"),
            Self::UnknownVersion(version) => {
                write!(f, "log version {version}; this program reads version {VERSION}")
            }
            Self::TooManyValues(values) => write!(f, "{values} values a record, room for {MAX_VALUES}"),
            Self::Motion(motion) => write!(f, "a record's motion is {motion}, not 0 (moving) or 1 (still)"),
            Self::Mismatch { log, model } => write!(
                f,
                "the log has {} axes and {} quantities, the model {} and {}",
                log.n_axes, log.n_quantities, model.n_axes, model.n_quantities
            ),
        }
    }
}

impl core::error::Error for ReplayError {}

impl Header {
    /// Reads the header at the start of `log`.
    ///
    /// # Errors
    ///
    /// [`ReplayError::Truncated`], [`ReplayError::Magic`] or [`ReplayError::UnknownVersion`].
    pub fn decode(log: &[u8]) -> Result<Self, ReplayError> {
        let truncated = ReplayError::Truncated { needed: HEADER_LENGTH, found: log.len() };
        let Some(&[a, b, c, d, version_low, version_high, n_axes, n_quantities]) = log.first_chunk() else {
            return Err(truncated);
        };
        if [a, b, c, d] != MAGIC {
            return Err(ReplayError::Magic);
        }
        let version = u16::from_le_bytes([version_low, version_high]);
        if version != VERSION {
            return Err(ReplayError::UnknownVersion(version));
        }
        Ok(Self { n_axes, n_quantities })
    }

    /// The header's bytes.
    pub fn encode(&self) -> [u8; HEADER_LENGTH] {
        let [a, b, c, d] = MAGIC;
        let [version_low, version_high] = VERSION.to_le_bytes();
        [a, b, c, d, version_low, version_high, self.n_axes, self.n_quantities]
    }

    /// Bytes of a record.
    pub fn record_length(&self) -> usize {
        8 + 4 * self.n_values()
    }

    /// Refuses a log that does not have what `model` needs.
    ///
    /// # Errors
    ///
    /// [`ReplayError::Mismatch`].
    pub fn check(&self, model: Header) -> Result<(), ReplayError> {
        if *self == model { Ok(()) } else { Err(ReplayError::Mismatch { log: *self, model }) }
    }

    fn n_values(&self) -> usize {
        usize::from(self.n_axes) + usize::from(self.n_quantities)
    }
}

impl Record<'_> {
    /// The record's bytes, in their order.
    pub fn encode(&self) -> impl Iterator<Item = u8> + '_ {
        let motion: u32 = match self.motion {
            Motion::Moving => 0,
            Motion::Still => 1,
        };
        let values = self.measured.iter().chain(self.quantities).flat_map(|value| value.to_le_bytes());
        self.skipped.to_le_bytes().into_iter().chain(motion.to_le_bytes()).chain(values)
    }
}

/// Reads records, one after the other, without a heap.
#[derive(Debug, Clone)]
pub struct Decoder {
    header: Header,
    values: [f32; MAX_VALUES],
}

#[cfg(feature = "defmt")]
impl defmt::Format for Decoder {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Decoder {{ header: {} }}", self.header);
    }
}

impl Decoder {
    /// A decoder of a log with this header.
    ///
    /// # Errors
    ///
    /// [`ReplayError::TooManyValues`].
    pub fn new(header: Header) -> Result<Self, ReplayError> {
        let values = header.n_values();
        if values > MAX_VALUES {
            return Err(ReplayError::TooManyValues(values));
        }
        Ok(Self { header, values: [0.0; MAX_VALUES] })
    }

    /// Reads the record at the start of `bytes`; the next one is [`Header::record_length`] further on.
    ///
    /// # Errors
    ///
    /// [`ReplayError::Truncated`] or [`ReplayError::Motion`].
    pub fn record(&mut self, bytes: &[u8]) -> Result<Record<'_>, ReplayError> {
        let needed = self.header.record_length();
        let truncated = ReplayError::Truncated { needed, found: bytes.len() };
        let (skipped, rest) = bytes.split_first_chunk().ok_or(truncated)?;
        let (motion, rest) = rest.split_first_chunk().ok_or(truncated)?;
        let motion = match u32::from_le_bytes(*motion) {
            0 => Motion::Moving,
            1 => Motion::Still,
            other => return Err(ReplayError::Motion(other)),
        };
        let (encoded, _) = rest.as_chunks();
        let encoded = encoded.get(..self.header.n_values()).ok_or(truncated)?;
        for (value, encoded) in self.values.iter_mut().zip(encoded) {
            *value = f32::from_le_bytes(*encoded);
        }
        let (measured, rest) =
            self.values.split_at_checked(usize::from(self.header.n_axes)).ok_or(truncated)?;
        let quantities = rest.get(..usize::from(self.header.n_quantities)).ok_or(truncated)?;
        Ok(Record { skipped: u32::from_le_bytes(*skipped), motion, measured, quantities })
    }
}

/// One record through the predictor: what is missing is skipped, then it tracks or coasts. One correction per axis.
#[must_use = "carries whether the corrected values can be trusted"]
pub fn step<'p, const AXES: usize, const INPUTS: usize, const TERMS: usize, const HISTORY: usize>(
    predictor: &'p mut Predictor<f32, AXES, INPUTS, TERMS, HISTORY>,
    record: &Record<'_>,
) -> &'p [Correction<f32>] {
    if record.skipped > 0 {
        let _ = predictor.skip(record.skipped);
    }
    let sample = Sample { measured: record.measured, quantities: record.quantities };
    match record.motion {
        Motion::Still => predictor.track(&sample),
        Motion::Moving => predictor.coast(&sample),
    }
}

// the 2 KiB of a table make a byte eight times as fast as without
pub(crate) static CRC: Crc<u64, Table<1>> = Crc::<u64, Table<1>>::new(&CRC_64_XZ);

/// Stands for a number that is not there.
pub(crate) const ABSENT: u32 = 0x7fc0_0000;

/// Digests (CRC-64/XZ) of what a predictor said, to compare two machines to the last bit.
///
/// Of every sample and every axis, in their order and little-endian: the innovation as f32 (0x7FC00000 where there is
/// none), the corrected value as f32, the validity bits as u16. A second digest takes the innovations alone.
#[derive(Clone)]
pub struct Digest {
    corrections: crc::Digest<'static, u64, Table<1>>,
    innovations: crc::Digest<'static, u64, Table<1>>,
}

impl Default for Digest {
    fn default() -> Self {
        Self { corrections: CRC.digest(), innovations: CRC.digest() }
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Digest {
    fn format(&self, f: defmt::Formatter<'_>) {
        let (corrections, innovations) = (self.corrections(), self.innovations());
        defmt::write!(
            f,
            "Digest {{ corrections: {=u64:016x}, innovations: {=u64:016x} }}",
            corrections,
            innovations
        );
    }
}

impl Digest {
    /// Takes the corrections of one sample.
    pub fn update(&mut self, corrections: &[Correction<f32>]) {
        for correction in corrections {
            let innovation = correction.innovation.map_or(ABSENT, f32::to_bits).to_le_bytes();
            let [a, b, c, d] = innovation;
            let [e, f, g, h] = correction.corrected.to_le_bytes();
            let [low, high] = correction.validity.bits().to_le_bytes();
            self.corrections.update(&[a, b, c, d, e, f, g, h, low, high]);
            self.innovations.update(&innovation);
        }
    }

    /// Of everything.
    pub fn corrections(&self) -> u64 {
        self.corrections.clone().finalize()
    }

    /// Of the innovations alone.
    pub fn innovations(&self) -> u64 {
        self.innovations.clone().finalize()
    }
}

impl fmt::Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x} {:016x}", self.corrections(), self.innovations())
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use fos_core::{
        Axis, AxisModel, AxisParameters, FittedOn, InnovationStatistics, Model, Quantity, Range, Term, y,
    };

    use super::*;

    const HEADER: Header = Header { n_axes: 2, n_quantities: 1 };
    const RECORD: Record<'_> =
        Record { skipped: 7, motion: Motion::Still, measured: &[1.5, -0.0], quantities: &[-3.25e-7] };

    #[test]
    fn a_log_is_these_bytes() {
        assert_eq!(HEADER.encode(), *b"FOSR\x01\x00\x02\x01");
        let bytes: Vec<u8> = RECORD.encode().collect();
        assert_eq!(bytes.len(), HEADER.record_length());
        let expected = [
            [7, 0, 0, 0],
            [1, 0, 0, 0],
            [0, 0, 0xc0, 0x3f],
            [0, 0, 0, 0x80],
            (-3.25e-7_f32).to_bits().to_le_bytes(),
        ];
        assert_eq!(bytes, expected.concat());
    }

    #[test]
    fn what_was_encoded_is_decoded_even_with_more_bytes_after_it() {
        assert_eq!(Header::decode(&HEADER.encode()), Ok(HEADER));
        let mut bytes: Vec<u8> = RECORD.encode().collect();
        bytes.extend([0xff; 3]);
        let mut decoder = Decoder::new(HEADER).unwrap();
        let decoded = decoder.record(&bytes).unwrap();
        assert_eq!(decoded, RECORD);
        assert!(decoded.measured[1].is_sign_negative());
    }

    #[test]
    fn refuses_what_is_not_a_log() {
        let bytes = HEADER.encode();
        for length in 0..HEADER_LENGTH {
            let error = ReplayError::Truncated { needed: HEADER_LENGTH, found: length };
            assert_eq!(Header::decode(&bytes[..length]), Err(error));
        }
        let mut wrong = bytes;
        wrong[0] ^= 1;
        assert_eq!(Header::decode(&wrong), Err(ReplayError::Magic));
        let mut newer = bytes;
        newer[4] = 2;
        assert_eq!(Header::decode(&newer), Err(ReplayError::UnknownVersion(2)));
        let wide = Decoder::new(Header { n_axes: 60, n_quantities: 5 });
        assert_eq!(wide.err(), Some(ReplayError::TooManyValues(65)));
    }

    #[test]
    fn refuses_a_record_that_ends_early_or_has_no_motion() {
        let mut bytes: Vec<u8> = RECORD.encode().collect();
        let mut decoder = Decoder::new(HEADER).unwrap();
        for length in 0..bytes.len() {
            let error = ReplayError::Truncated { needed: bytes.len(), found: length };
            assert_eq!(decoder.record(&bytes[..length]), Err(error));
        }
        bytes[4] = 2;
        assert_eq!(decoder.record(&bytes), Err(ReplayError::Motion(2)));
    }

    #[test]
    fn refuses_a_log_of_another_model() {
        let model = Header { n_axes: 2, n_quantities: 2 };
        assert_eq!(HEADER.check(HEADER), Ok(()));
        assert_eq!(HEADER.check(model), Err(ReplayError::Mismatch { log: HEADER, model }));
    }

    const TERMS: [Term<f32>; 1] = [Term::new(0.5, &[y(1)])];
    const AXIS: AxisModel<'_, f32> = AxisModel {
        parameters: AxisParameters {
            axis: Axis::Gx,
            reference: 0.0,
            offset: 0.0,
            scale: 1.0,
            constant: 0.0,
            range: Range::new(-4.0, 4.0),
            full_scale: 0.0,
            stuck_after_repeats: 0,
            gap_limit_samples: 3,
            coast_limit_s: 1.0,
            innovation: InnovationStatistics { mean: 0.0, variance: 1.0, lag_1_correlation: 0.0 },
        },
        physical: &[],
        stochastic: &TERMS,
    };
    const MODEL: Model<'_, f32> = Model {
        period_s: 0.005,
        fitted_on: FittedOn::Raw,
        stillness: None,
        quantities: &[Quantity::Temperature],
        inputs: &[],
        axes: &[AXIS],
    };

    #[test]
    fn a_record_is_skipped_then_tracked_or_coasted() {
        let mut replayed = Predictor::<f32, 1, 1, 1, 2>::new(&MODEL).unwrap();
        let mut direct = replayed.clone();
        for (skipped, motion, value) in [
            (0, Motion::Still, 1.0),
            (0, Motion::Still, 0.5),
            (2, Motion::Still, 0.25),
            (0, Motion::Moving, 3.0),
            (9, Motion::Moving, 2.0),
        ] {
            let record = Record { skipped, motion, measured: &[value], quantities: &[20.0] };
            let sample = Sample { measured: &[value], quantities: &[20.0] };
            let _ = direct.skip(skipped);
            let expected = match motion {
                Motion::Still => direct.track(&sample),
                Motion::Moving => direct.coast(&sample),
            };
            assert_eq!(step(&mut replayed, &record), expected);
        }
    }

    #[test]
    fn a_digest_is_the_crc_of_the_documented_bytes() {
        let mut predictor = Predictor::<f32, 1, 1, 1, 2>::new(&MODEL).unwrap();
        let mut digest = Digest::default();
        let (mut all, mut innovations) = (Vec::new(), Vec::new());
        for value in [1.0, 0.5, f32::NAN, 7.0] {
            let record =
                Record { skipped: 0, motion: Motion::Still, measured: &[value], quantities: &[20.0] };
            let corrections = step(&mut predictor, &record);
            digest.update(corrections);
            let innovation = corrections[0].innovation.map_or([0, 0, 0xc0, 0x7f], f32::to_le_bytes);
            innovations.extend(innovation);
            all.extend(innovation);
            all.extend(corrections[0].corrected.to_le_bytes());
            all.extend(corrections[0].validity.bits().to_le_bytes());
        }
        // bit by bit: CRC-64/XZ is reflected ECMA-182, starting at and finished with all ones
        let crc = |bytes: &[u8]| {
            !bytes.iter().fold(!0_u64, |crc, &byte| {
                (0..8).fold(crc ^ u64::from(byte), |crc, _| {
                    (crc >> 1) ^ if crc & 1 == 1 { 0xc96c_5795_d787_0f42 } else { 0 }
                })
            })
        };
        assert_eq!(crc(b"123456789"), 0x995d_c9bb_df19_39fa);
        assert_eq!(digest.corrections(), crc(&all));
        assert_eq!(digest.innovations(), crc(&innovations));
    }

    #[test]
    fn a_digest_changes_with_the_last_bit() {
        let (mut a, mut b) = (Digest::default(), Digest::default());
        let mut predictor = Predictor::<f32, 1, 1, 1, 2>::new(&MODEL).unwrap();
        let record = Record { skipped: 0, motion: Motion::Still, measured: &[1.0], quantities: &[20.0] };
        let _ = step(&mut predictor, &record);
        let mut corrections: Vec<_> = step(&mut predictor, &record).to_vec();
        a.update(&corrections);
        corrections[0].corrected = f32::from_bits(corrections[0].corrected.to_bits() ^ 1);
        b.update(&corrections);
        assert_ne!(a.corrections(), b.corrections());
        assert_eq!(a.innovations(), b.innovations());
    }
}

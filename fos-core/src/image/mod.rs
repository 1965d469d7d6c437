//! The stored model: header, checksum, postcard body, and a block of names that the device does not read.
//!
//! docs/MODEL_FORMAT.md describes every byte.

mod read;
mod records;
mod unit;
mod write;

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use serde::{Deserialize, Serialize};

use crate::{AxisParameters, FittedOn, ModelError, StillnessLimits};

pub use read::{AxisImage, Image, Terms};
pub use unit::{UNIT_HEADER_LENGTH, UNIT_MAGIC, UNIT_VERSION, UnitError, UnitRecord, encode_unit, for_unit};
pub use write::encode;

/// The first four bytes of an image.
pub const MAGIC: [u8; 4] = *b"FOSM";

/// Format version that this crate writes; it reads no other.
pub const VERSION: u16 = 1;

/// Flag of an image with a calibration.
const CALIBRATED: u16 = 1;

/// Bytes before the body: magic, version, flags, length of the body, length of the information, checksum.
pub const HEADER_LENGTH: usize = 20;

/// Offset of the checksum in the header; it covers every byte of the image except its own four.
const CHECKSUM_AT: usize = 16;

/// Information about a model for people; the device does not need it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Info<'a> {
    /// Name of the sensor, given by the user.
    pub sensor: &'a str,
    /// Name and unit of every quantity, one per line, in the order of the model.
    pub quantities: &'a str,
    /// Identifiers of the effects in the physical part, one per line.
    pub effects: &'a str,
    /// Provenance of the model: data, digest, settings, program.
    pub provenance: &'a str,
}

/// The start of the body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(Deserialize))]
struct Head {
    period_s: f64,
    fitted_on: FittedOn,
    stillness: Option<StillnessLimits<f32>>,
    n_quantities: u8,
    n_inputs: u8,
    n_axes: u8,
}

/// The start of an axis in the body; its terms follow.
#[derive(Serialize)]
struct AxisHead {
    parameters: AxisParameters<f32>,
    n_physical: u8,
    n_stochastic: u8,
}

/// Reason why an image cannot be read or written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ImageError {
    /// Fewer bytes than a header has, or than the header states.
    Truncated {
        /// Length of a header, or of the image according to its header, bytes.
        needed: usize,
        /// Length of the input, bytes.
        found: usize,
    },
    /// The bytes do not start with [`MAGIC`]: not an image.
    Magic,
    /// Unknown format version.
    UnknownVersion(u16),
    /// Unknown flags.
    UnknownFlags(u16),
    /// Bytes after the end of the image, its body or its information.
    TrailingBytes {
        /// Number of excess bytes.
        count: usize,
    },
    /// The checksum does not match: the image was damaged.
    Checksum {
        /// CRC-32 in the header.
        stored: u32,
        /// CRC-32 of the bytes.
        computed: u32,
    },
    /// The checksum is correct but the body violates the format.
    Malformed,
    /// A term has no factor, more than three, or an output at lag 0.
    Term {
        /// Index of the axis in the image, from 0.
        axis: usize,
        /// Index of the term, physical part first.
        term: usize,
    },
    /// The model in the image is rejected.
    Model(ModelError),
    /// Writing: the buffer is too small, or there are more than 255 quantities, inputs, axes or terms of a part.
    TooLarge,
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Truncated { needed, found } => write!(f, "truncated: {found} of {needed} bytes"),
            Self::Magic => write!(f, "not a model image: it does not start with FOSM"),
            Self::UnknownVersion(version) => {
                write!(f, "format version {version}; this program reads version {VERSION}")
            }
            Self::UnknownFlags(flags) => write!(f, "unknown flags {flags:#06x}"),
            Self::TrailingBytes { count } => write!(f, "{count} bytes too many"),
            Self::Checksum { stored, computed } => {
                write!(f, "damaged: checksum {computed:08x}, stored {stored:08x}")
            }
            Self::Malformed => write!(f, "the body is not a model"),
            Self::Term { axis, term } => {
                write!(f, "axis {axis}, term {term}: it needs 1 to 3 factors and no output at lag 0")
            }
            Self::Model(error) => write!(f, "{error}"),
            Self::TooLarge => {
                write!(f, "the model does not fit: a larger buffer, or fewer than 256 of everything")
            }
        }
    }
}

impl core::error::Error for ImageError {}

impl From<ModelError> for ImageError {
    fn from(error: ModelError) -> Self {
        Self::Model(error)
    }
}

/// CRC-32 (ISO-HDLC) of everything but the checksum itself.
fn checksum(image: &[u8]) -> u32 {
    // without a table: an image is read once, and a table would take a kilobyte of flash
    let crc = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    digest.update(image.get(..CHECKSUM_AT).unwrap_or(&[]));
    digest.update(image.get(HEADER_LENGTH..).unwrap_or(&[]));
    digest.finalize()
}

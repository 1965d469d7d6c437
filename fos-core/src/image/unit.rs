//! One image for a part, and a short record for each unit: what differs between units of a part is the offset and the
//! coefficients of the physical part.
//!
//! Every value has the same place in the images of all units, and the same length. So the image of a unit is that of
//! its part with other values in these places and a checksum of its own: [`for_unit`]. From there on it is an image
//! like any other. docs/MODEL_FORMAT.md describes every byte.

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

use super::{AxisHead, CHECKSUM_AT, Image, ImageError, checksum};
use crate::{Axis, Input, Quantity};

/// The first four bytes of a record.
pub const UNIT_MAGIC: [u8; 4] = *b"FOSU";

/// The version of records that this crate writes, and the only one it reads.
pub const UNIT_VERSION: u16 = 1;

/// Bytes before the name: magic, version, length of the name, checksum of the part's image, checksum.
pub const UNIT_HEADER_LENGTH: usize = 16;

/// Where the checksum stands in the header; it covers every byte of the record but its own four.
const UNIT_CHECKSUM_AT: usize = 12;

/// Bytes of a value, an `f32`.
const VALUE: usize = 4;

/// A record whose form and checksum have been checked. It borrows the bytes and copies nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct UnitRecord<'a> {
    part: u32,
    name: &'a str,
    values: &'a [u8],
}

/// Why there is no image of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum UnitError {
    /// The image of the part cannot be read.
    Part(ImageError),
    /// The record has fewer bytes than its header says, or ends within a value.
    Truncated,
    /// It does not start with [`UNIT_MAGIC`]: no record of a unit.
    Magic,
    /// A version that this program does not know.
    UnknownVersion(u16),
    /// The checksum does not match: the record was damaged.
    Checksum {
        /// What the header says, CRC-32.
        stored: u32,
        /// What the bytes come to.
        computed: u32,
    },
    /// Its name is not text.
    Name,
    /// The record belongs to another image than that of this part.
    OtherPart {
        /// The checksum of the image that it belongs to.
        recorded: u32,
        /// That of the image that was given.
        given: u32,
    },
    /// The image has another number of values than the record.
    Count {
        /// Values in the image.
        needed: usize,
        /// Values in the record.
        found: usize,
    },
    /// The buffer has no room.
    TooSmall {
        /// Bytes that it needs.
        needed: usize,
    },
}

impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Part(error) => write!(f, "the image of the part: {error}"),
            Self::Truncated => write!(f, "the record of the unit is truncated"),
            Self::Magic => write!(f, "no record of a unit: it does not start with FOSU"),
            Self::UnknownVersion(version) => {
                write!(f, "a record of version {version}; this program reads version {UNIT_VERSION}")
            }
            Self::Checksum { stored, computed } => {
                write!(f, "the record is damaged: checksum {computed:08x}, stored {stored:08x}")
            }
            Self::Name => write!(f, "the name in the record is not UTF-8"),
            Self::OtherPart { recorded, given } => {
                write!(f, "a record for the image {recorded:08x} of a part; this is {given:08x}")
            }
            Self::Count { needed, found } => {
                write!(f, "{found} values in the record, {needed} in the image of the part")
            }
            Self::TooSmall { needed } => write!(f, "the buffer is too small: {needed} bytes are needed"),
        }
    }
}

impl core::error::Error for UnitError {}

impl<'a> UnitRecord<'a> {
    /// Reads a record.
    ///
    /// # Errors
    ///
    /// Each thing that can be wrong has its own error.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, UnitError> {
        let (header, rest) = bytes.split_first_chunk::<UNIT_HEADER_LENGTH>().ok_or(UnitError::Truncated)?;
        let [m0, m1, m2, m3, v0, v1, l0, l1, p0, p1, p2, p3, c0, c1, c2, c3] = *header;
        if [m0, m1, m2, m3] != UNIT_MAGIC {
            return Err(UnitError::Magic);
        }
        let version = u16::from_le_bytes([v0, v1]);
        if version != UNIT_VERSION {
            return Err(UnitError::UnknownVersion(version));
        }
        let (stored, computed) = (u32::from_le_bytes([c0, c1, c2, c3]), record_checksum(bytes));
        if stored != computed {
            return Err(UnitError::Checksum { stored, computed });
        }
        let length = usize::from(u16::from_le_bytes([l0, l1]));
        let (name, values) = rest.split_at_checked(length).ok_or(UnitError::Truncated)?;
        if values.len() % VALUE != 0 {
            return Err(UnitError::Truncated);
        }
        let name = core::str::from_utf8(name).map_err(|_| UnitError::Name)?;
        Ok(Self { part: u32::from_le_bytes([p0, p1, p2, p3]), name, values })
    }

    /// The unit, as its user named it.
    pub fn name(&self) -> &'a str {
        self.name
    }

    /// The checksum of the image of its part.
    pub fn part(&self) -> u32 {
        self.part
    }

    /// Axis by axis its offset, in the axis' unit, and the coefficients of its physical part, scaled: in the order of
    /// the image.
    pub fn values(&self) -> impl Iterator<Item = f32> + 'a {
        self.values.as_chunks::<VALUE>().0.iter().map(|bytes| f32::from_le_bytes(*bytes))
    }
}

/// The image of a unit, in `buffer`: that of its part with the values of its record. `buffer` has room for the image of
/// the part, and what comes out is as long. Whether the model can be used is found when it is loaded.
///
/// # Errors
///
/// Image or record are damaged, do not belong together, or the buffer has no room.
///
/// ```
/// use fos_core::image::{UnitError, for_unit};
///
/// let mut buffer = [0; 2048];
/// let (part, record) = (&[][..], &[][..]); // from flash
/// match for_unit(part, record, &mut buffer) {
///     Ok(image) => { /* hub.load(image) */ }
///     Err(UnitError::OtherPart { .. }) => { /* the part's own image serves until the unit's record is there */ }
///     Err(_) => {}
/// }
/// ```
pub fn for_unit<'b>(part: &[u8], record: &[u8], buffer: &'b mut [u8]) -> Result<&'b [u8], UnitError> {
    let image = Image::parse(part).map_err(UnitError::Part)?;
    let record = UnitRecord::parse(record)?;
    let given = u32::from_le_bytes(stored_checksum(part));
    if record.part != given {
        return Err(UnitError::OtherPart { recorded: record.part, given });
    }
    let needed = part.len();
    let buffer = buffer.get_mut(..needed).ok_or(UnitError::TooSmall { needed })?;
    buffer.copy_from_slice(part);
    let (mut needed, found) = (0, record.values.len() / VALUE);
    let mut values = record.values.as_chunks::<VALUE>().0.iter();
    for place in image.unit_places(part.len()) {
        needed += 1;
        if let Some(value) = values.next() {
            overwrite(buffer, place, *value);
        }
    }
    if needed != found {
        return Err(UnitError::Count { needed, found });
    }
    let checksum = checksum(buffer);
    overwrite(buffer, CHECKSUM_AT, checksum.to_le_bytes());
    Ok(buffer)
}

/// Writes the record of a unit into `buffer`: for the image `part`, and with `values` as [`UnitRecord::values`] gives them;
/// the part of it that was used.
///
/// # Errors
///
/// `part` cannot be read, it has another number of values, or the buffer has no room.
pub fn encode_unit<'b>(
    part: &[u8],
    name: &str,
    values: impl ExactSizeIterator<Item = f32>,
    buffer: &'b mut [u8],
) -> Result<&'b [u8], UnitError> {
    let image = Image::parse(part).map_err(UnitError::Part)?;
    let (count, found) = (image.unit_places(part.len()).count(), values.len());
    if count != found {
        return Err(UnitError::Count { needed: count, found });
    }
    let length = u16::try_from(name.len()).map_err(|_| UnitError::Name)?;
    let needed = UNIT_HEADER_LENGTH + name.len() + VALUE * count;
    let record = buffer.get_mut(..needed).ok_or(UnitError::TooSmall { needed })?;
    let fields = UNIT_MAGIC
        .into_iter()
        .chain(UNIT_VERSION.to_le_bytes())
        .chain(length.to_le_bytes())
        .chain(stored_checksum(part))
        .chain([0; 4])
        .chain(name.bytes())
        .chain(values.flat_map(f32::to_le_bytes));
    for (byte, field) in record.iter_mut().zip(fields) {
        *byte = field;
    }
    let checksum = record_checksum(record);
    overwrite(record, UNIT_CHECKSUM_AT, checksum.to_le_bytes());
    Ok(record)
}

impl Image<'_> {
    /// Where the values of a unit stand in the bytes of the image, `length` of them: axis by axis its offset, then the
    /// coefficients of its physical part.
    fn unit_places(&self, length: usize) -> impl Iterator<Item = usize> {
        // all of it was read before, and nothing of it can fail
        let end = length.saturating_sub(self.information.len());
        let mut records = self.records;
        for _ in 0..self.head.n_quantities {
            let _ = records.take::<Quantity>();
        }
        for _ in 0..self.head.n_inputs {
            let _ = records.take::<Input<f32>>();
        }
        (0..self.head.n_axes).flat_map(move |_| {
            let mut before_offset = records;
            // its axis and its reference
            let _ = before_offset.take::<(Axis, f32)>();
            let head = records.take::<AxisHead>().ok();
            let mut terms = records;
            let [n_physical, n_stochastic] = head.map_or([0; 2], |head| [head.n_physical, head.n_stochastic]);
            for _ in 0..u16::from(n_physical) + u16::from(n_stochastic) {
                let _ = records.term();
            }
            let physical = (0..n_physical).map(move |_| {
                // the coefficient comes first
                let place = end.saturating_sub(terms.left());
                let _ = terms.term();
                place
            });
            core::iter::once(end.saturating_sub(before_offset.left())).chain(physical)
        })
    }
}

/// The checksum in the header of an image.
fn stored_checksum(image: &[u8]) -> [u8; VALUE] {
    image.get(CHECKSUM_AT..).and_then(<[u8]>::first_chunk).copied().unwrap_or_default()
}

/// CRC-32 (ISO-HDLC) of a record but for the checksum itself.
fn record_checksum(record: &[u8]) -> u32 {
    let crc = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    digest.update(record.get(..UNIT_CHECKSUM_AT).unwrap_or(&[]));
    digest.update(record.get(UNIT_HEADER_LENGTH..).unwrap_or(&[]));
    digest.finalize()
}

fn overwrite(bytes: &mut [u8], place: usize, with: [u8; VALUE]) {
    if let Some(bytes) = bytes.get_mut(place..).and_then(<[u8]>::first_chunk_mut) {
        *bytes = with;
    }
}

//! One image for a part, and a short record for each unit. The units of a part differ in the offset and in the
//! coefficients of the physical part.
//!
//! Every value has the same offset and length in the images of all units. So [`for_unit`] makes the image of a unit from
//! that of its part: it replaces these values and the checksum. docs/MODEL_FORMAT.md describes every byte.

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

use super::records::Records;
use super::{CHECKSUM_AT, Image, ImageError, checksum};
use crate::{Axis, AxisParameters};

/// The first four bytes of a record.
pub const UNIT_MAGIC: [u8; 4] = *b"FOSU";

/// Version of the records that this crate writes; it reads no other.
pub const UNIT_VERSION: u16 = 1;

/// Bytes before the name: magic, version, length of the name, checksum of the part's image, checksum.
pub const UNIT_HEADER_LENGTH: usize = 16;

/// Offset of the checksum in the header; it covers every byte of the record except its own four.
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

/// Reason why the image of a unit cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum UnitError {
    /// The image of the part cannot be read.
    Part(ImageError),
    /// The record has fewer bytes than its header states, or ends within a value.
    Truncated,
    /// The bytes do not start with [`UNIT_MAGIC`]: not the record of a unit.
    Magic,
    /// Unknown version of the record.
    UnknownVersion(u16),
    /// The checksum does not match: the record was damaged.
    Checksum {
        /// CRC-32 in the header.
        stored: u32,
        /// CRC-32 of the bytes.
        computed: u32,
    },
    /// The name is not UTF-8, or longer than 65535 bytes.
    Name,
    /// The record belongs to the image of another part.
    OtherPart {
        /// Checksum of the image that the record belongs to.
        recorded: u32,
        /// Checksum of the image passed in.
        given: u32,
    },
    /// Image and record have different numbers of values.
    Count {
        /// Values in the image.
        needed: usize,
        /// Values in the record.
        found: usize,
    },
    /// The buffer is too small.
    TooSmall {
        /// Required length, bytes.
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
    /// The first fault found; each kind has its own error.
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

    /// Name of the unit, given by the user.
    pub fn name(&self) -> &'a str {
        self.name
    }

    /// Checksum of the image of the part.
    pub fn part(&self) -> u32 {
        self.part
    }

    /// Values in the order of the image: for each axis the offset, in the axis' unit, then the coefficients of its physical
    /// part, scaled.
    pub fn values(&self) -> impl Iterator<Item = f32> + 'a {
        self.values.as_chunks::<VALUE>().0.iter().map(|bytes| f32::from_le_bytes(*bytes))
    }
}

/// Writes the image of a unit into `buffer`: the image `part` with the values of `record`. The result has the length of
/// `part`, which `buffer` must hold. The model itself is checked when the image is loaded.
///
/// # Errors
///
/// Image or record is damaged, they do not belong together, or the buffer is too small.
///
/// ```
/// use fos_core::image::{UnitError, for_unit};
///
/// let mut buffer = [0; 2048];
/// let (part, record) = (&[][..], &[][..]); // from flash
/// match for_unit(part, record, &mut buffer) {
///     Ok(image) => { /* hub.load(image) */ }
///     Err(UnitError::OtherPart { .. }) => { /* use the image of the part until the record of the unit arrives */ }
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

/// Writes the record of a unit for the image `part` into `buffer`, with `values` in the order of [`UnitRecord::values`].
/// Returns the part of the buffer that was used.
///
/// # Errors
///
/// `part` cannot be read or has another number of values, `name` is longer than 65535 bytes, or the buffer is too small.
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
    /// Offsets of the values of a unit in the image of `length` bytes: for each axis the offset, then the coefficients of
    /// the physical part.
    fn unit_places(&self, length: usize) -> impl Iterator<Item = usize> {
        // every record was read once by `parse`, so no read can fail
        let end = length.saturating_sub(self.information.len());
        let place = move |records: Records<'_>| end.saturating_sub(records.left().unwrap_or(0));
        let mut records = self.axis_records();
        (0..self.head.n_axes).flat_map(move |_| {
            let mut before_offset = records;
            // axis and reference come before the offset
            before_offset.skip::<Axis>(1);
            before_offset.skip::<f32>(1);
            records.skip::<AxisParameters<f32>>(1);
            let [n_physical, n_stochastic]: [u8; 2] = records.take();
            let mut terms = records;
            for _ in 0..u16::from(n_physical) + u16::from(n_stochastic) {
                let _ = records.term();
            }
            let physical = (0..n_physical).map(move |_| {
                // the coefficient comes first
                let coefficient = place(terms);
                let _ = terms.term();
                coefficient
            });
            core::iter::once(place(before_offset)).chain(physical)
        })
    }
}

/// Checksum in the header of an image.
fn stored_checksum(image: &[u8]) -> [u8; VALUE] {
    image.get(CHECKSUM_AT..).and_then(<[u8]>::first_chunk).copied().unwrap_or_default()
}

/// CRC-32 (ISO-HDLC) of a record except the checksum itself.
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

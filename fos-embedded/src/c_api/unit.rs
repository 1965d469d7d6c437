//! One image for a part and a record for each unit.

use fos_core::image::{UnitError, for_unit};

use super::fos_status;
use super::place::{Room, bytes, count_in};

/// Makes the image of a unit from the image of its part and the record of the unit, as written by `fos fleet export`: `*used`
/// bytes in `buffer`, as many as the image of the part has, for fos_hub_load() and fos_store_save(). Neither must overlap
/// `buffer`. Until the record is available, use the image of the part.
///
/// - FOS_STATUS_OK: the model itself is checked when the image is loaded.
/// - FOS_STATUS_TRUNCATED to FOS_STATUS_UNUSABLE: image or record is damaged, or the record has another number of values.
/// - FOS_STATUS_OTHER_PART: the record belongs to another image.
/// - FOS_STATUS_NO_ROOM: `capacity` is less than `part_length`.
/// - FOS_STATUS_NULL: `part`, `record`, `buffer` or `used`. FOS_STATUS_MISALIGNED: `used`.
///   FOS_STATUS_ARGUMENT: a length is impossible at its address.
///
/// After any status other than FOS_STATUS_OK `*used` is 0, if `used` itself is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fos_image_for_unit(
    part: *const u8,
    part_length: usize,
    record: *const u8,
    record_length: usize,
    buffer: *mut u8,
    capacity: usize,
    used: *mut usize,
) -> fos_status {
    let make = || {
        // SAFETY: `part` points to `part_length` bytes that are not modified meanwhile, as the header requires
        let part = unsafe { bytes(part, part_length) }?;
        // SAFETY: `record` points to `record_length` bytes that are not modified meanwhile, as the header requires
        let record = unsafe { bytes(record, record_length) }?;
        // SAFETY: `buffer` points to `capacity` bytes that nothing else uses, as the header requires
        let mut room = unsafe { Room::new(buffer, capacity) }?;
        Ok(for_unit(part, record, room.zeroed())?.len())
    };
    // SAFETY: `used` points to a number that nothing else uses, as the header requires
    unsafe { count_in(used, make) }
}

impl From<UnitError> for fos_status {
    fn from(error: UnitError) -> Self {
        match error {
            UnitError::Part(error) => error.into(),
            UnitError::Truncated => Self::Truncated,
            UnitError::Magic => Self::NotAnImage,
            UnitError::UnknownVersion(_) => Self::OtherVersion,
            UnitError::Checksum { .. } => Self::Damaged,
            UnitError::OtherPart { .. } => Self::OtherPart,
            UnitError::TooSmall { .. } => Self::NoRoom,
            _ => Self::Unusable,
        }
    }
}

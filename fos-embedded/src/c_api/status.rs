//! Status codes.

use core::ffi::{CStr, c_char};

use fos_core::{ImageError, ModelError};

use super::FOS_MAX_INPUTS;
use crate::hub::HubError;

/// Result of a call. Every function lists the values that it returns, with their meaning.
#[repr(i32)]
#[must_use]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum fos_status {
    /// Success.
    Ok = 0,
    /// A required pointer is NULL.
    Null = 1,
    /// A pointer is not aligned for its type.
    Misaligned = 2,
    /// A number is invalid or not finite, or describes an impossible memory range.
    Argument = 3,
    /// The memory or buffer passed in is too small.
    NoRoom = 4,
    /// The loaded model has no such quantity or axis.
    NotInModel = 5,
    /// The value is not known yet.
    NotKnown = 6,
    /// Loading: fewer bytes than the image has.
    Truncated = 7,
    /// Loading: the bytes do not start like a model image.
    NotAnImage = 8,
    /// Loading: the format version or a flag of the image is unknown to this library.
    OtherVersion = 9,
    /// Loading: more bytes than the image, or a part of it, should have.
    TrailingBytes = 10,
    /// Loading: the checksum does not match.
    Damaged = 11,
    /// Loading: the checksum is correct, but the contents are not a usable model.
    Unusable = 12,
    /// Loading: the model needs more than FOS_MAX_INPUTS, FOS_MAX_TERMS or FOS_MAX_HISTORY.
    TooLarge = 13,
    /// Loading: the model was fitted on raw values and the sensor gives corrected ones, or the reverse: a correction would
    /// be applied twice, or not at all.
    OtherValues = 14,
    /// Loading: the sample period of the model differs from that of the sensor by more than 10 %.
    OtherPeriod = 15,
    /// Loading: an axis of the model is not one of the sensor's six, or occurs twice.
    OtherAxis = 16,
    /// Loading: a quantity of the model is measured by an axis that is not one of the sensor's six.
    OtherQuantity = 17,
    /// Streams: the timestamp does not increase, or a value is not finite.
    NotTaken = 18,
    /// Store: a function of the flash failed, or the contents cannot be repaired.
    Flash = 19,
    /// Store: the image was written but did not read back: worn flash.
    VerifyFailed = 20,
    /// Store: there is no valid image.
    NoModel = 21,
    /// Unit: the record belongs to the image of another part.
    OtherPart = 22,
}

// c/layout.c has the same number
const _: () = assert!(size_of::<fos_status>() == 4);

/// All values, in the order of their numbers.
const ALL: [fos_status; 23] = [
    fos_status::Ok,
    fos_status::Null,
    fos_status::Misaligned,
    fos_status::Argument,
    fos_status::NoRoom,
    fos_status::NotInModel,
    fos_status::NotKnown,
    fos_status::Truncated,
    fos_status::NotAnImage,
    fos_status::OtherVersion,
    fos_status::TrailingBytes,
    fos_status::Damaged,
    fos_status::Unusable,
    fos_status::TooLarge,
    fos_status::OtherValues,
    fos_status::OtherPeriod,
    fos_status::OtherAxis,
    fos_status::OtherQuantity,
    fos_status::NotTaken,
    fos_status::Flash,
    fos_status::VerifyFailed,
    fos_status::NoModel,
    fos_status::OtherPart,
];

impl fos_status {
    pub(super) fn of(result: Result<(), Self>) -> Self {
        match result {
            Ok(()) => Self::Ok,
            Err(status) => status,
        }
    }

    fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"done",
            Self::Null => c"a pointer is NULL",
            Self::Misaligned => c"a pointer is misaligned",
            Self::Argument => c"an argument stands for nothing",
            Self::NoRoom => c"the memory handed in is too small",
            Self::NotInModel => c"the model has no such quantity or axis",
            Self::NotKnown => c"not known yet",
            Self::Truncated => c"the image is truncated",
            Self::NotAnImage => c"not a model image",
            Self::OtherVersion => c"an image of an unknown version",
            Self::TrailingBytes => c"bytes behind the end of the image",
            Self::Damaged => c"the image is damaged",
            Self::Unusable => c"the model cannot be run",
            Self::TooLarge => c"the model is too large",
            Self::OtherValues => c"the model was fitted on other values than the sensor gives",
            Self::OtherPeriod => c"the model was fitted at another sample period",
            Self::OtherAxis => c"an axis of the model is none of the sensor's",
            Self::OtherQuantity => c"a quantity of the model is none of the sensor's",
            Self::NotTaken => c"the sample was not taken",
            Self::Flash => c"the flash failed",
            Self::VerifyFailed => c"the flash did not keep the image",
            Self::NoModel => c"no model is stored",
            Self::OtherPart => c"a record for the image of another part",
        }
    }
}

impl From<HubError> for fos_status {
    fn from(error: HubError) -> Self {
        match error {
            HubError::Image(error) => error.into(),
            HubError::CalibrationNotBuilt => Self::Unusable,
            HubError::FittedOn { .. } => Self::OtherValues,
            HubError::Period { .. } => Self::OtherPeriod,
            HubError::Axis(_) => Self::OtherAxis,
            // the capacity for quantities is that for inputs
            HubError::Quantity(index) if index >= FOS_MAX_INPUTS => Self::TooLarge,
            HubError::Quantity(_) => Self::OtherQuantity,
        }
    }
}

impl From<ImageError> for fos_status {
    fn from(error: ImageError) -> Self {
        match error {
            ImageError::Truncated { .. } => Self::Truncated,
            ImageError::Magic => Self::NotAnImage,
            ImageError::UnknownVersion(_) | ImageError::UnknownFlags(_) => Self::OtherVersion,
            ImageError::TrailingBytes { .. } => Self::TrailingBytes,
            ImageError::Checksum { .. } => Self::Damaged,
            ImageError::TooLarge
            | ImageError::Model(
                ModelError::TooManyAxes { .. }
                | ModelError::TooManyInputs { .. }
                | ModelError::TooManyTerms { .. }
                | ModelError::LagTooDeep { .. },
            ) => Self::TooLarge,
            _ => Self::Unusable,
        }
    }
}

/// Text of a status, for a log; "unknown status" for other numbers. Never NULL; the text is static.
#[unsafe(no_mangle)]
pub extern "C" fn fos_status_text(status: i32) -> *const c_char {
    let status = ALL.iter().find(|known| **known as i32 == status);
    status.map_or(c"unknown status", |status| status.text()).as_ptr()
}

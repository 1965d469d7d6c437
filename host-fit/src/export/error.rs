//! Why a model cannot be exported.

use fos_fit::export::UnusableImage;

use super::Refusal;

/// A model that a device does not take.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// There is no image of it.
    #[error(transparent)]
    Image(#[from] UnusableImage),
    /// The hub that the source is for refuses it.
    #[error("{0}")]
    Refused(Refusal),
    /// A name that is none in C.
    #[error(
        "{0:?} gives no name to use in C\nhelp: a file name that begins with a letter and is not fos.h, such as gyro_unit.h"
    )]
    Name(String),
}

//! Errors of the export of a model.

use fos_fit::export::UnusableImage;

use super::Refusal;

/// The model cannot be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The model has no image.
    #[error(transparent)]
    Image(#[from] UnusableImage),
    /// The hub for this source refuses the model.
    #[error("{0}")]
    Refused(Refusal),
    /// The name is unusable in C.
    #[error(
        "{0:?} gives no name to use in C\nhelp: a file name that begins with a letter and is not fos.h, such as gyro_unit.h"
    )]
    Name(String),
}

//! Errors of the export of a model.

use fos_fit::export::UnusableImage;

use super::Refusal;

/// The model cannot be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    #[error(transparent)]
    Image(#[from] UnusableImage),
    #[error("{0}")]
    Refused(Refusal),
    #[error(
        "{0:?} gives no name to use in C\nhelp: a file name that begins with a letter and is not fos.h, such as gyro_unit.h"
    )]
    Name(String),
}

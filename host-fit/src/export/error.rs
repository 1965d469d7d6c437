//! Why a model cannot be exported.

use fos_embedded::hub::HubError;
use fos_fit::export::UnusableImage;

/// A model that a device does not take.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// There is no image of it.
    #[error(transparent)]
    Image(#[from] UnusableImage),
    /// No hub takes it: it has an axis or a quantity that a six-axis sensor does not measure.
    #[error("a hub does not take the model: {0}")]
    Hub(HubError),
    /// A name that is none in C.
    #[error(
        "{0:?} gives no name to use in C\nhelp: a file name that begins with a letter and is not fos.h, such as gyro_unit.h"
    )]
    Name(String),
}

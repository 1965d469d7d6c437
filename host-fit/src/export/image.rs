//! The model image: docs/MODEL_FORMAT.md.

use fos_core::image::encode;
use fos_core::{Image, ImageError, Info};

use crate::model::{HostPredictor, UnitModel, unit_of};

/// The largest image that is written, bytes; a model of 6 axes with 20 terms each takes about 2000.
const LARGEST: usize = 1 << 16;

/// Why a model cannot be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The image cannot be written, or cannot be read back.
    #[error("the model makes no usable image: {0}")]
    Image(ImageError),
}

/// The image of `model`, read back and tried before it is returned.
///
/// # Errors
///
/// The model has more than 255 of something, or does not fit fos-core after rounding to f32.
pub fn image(model: &UnitModel, sensor: &str, provenance: &str) -> Result<Vec<u8>, ExportError> {
    let quantities: Vec<String> = model
        .quantities
        .iter()
        .map(|logged| format!("{} {}", logged.column, unit_of(&logged.column)).trim_end().to_owned())
        .collect();
    let quantities = quantities.join("\n");
    let info = Info { sensor, quantities: &quantities, effects: "", provenance };
    let mut buffer = vec![0; LARGEST];
    let bytes = model
        .with::<f32, _>(|model| encode(model, &info, &mut buffer).map(<[u8]>::to_vec))
        .map_err(ExportError::Image)?;
    let read_back = Image::parse(&bytes).map_err(ExportError::Image)?;
    let _: HostPredictor<f32> = read_back.predictor().map_err(ExportError::Image)?;
    Ok(bytes)
}

//! Writes the image of a model.

use serde::Serialize;

use super::{
    AxisHead, CALIBRATED, CHECKSUM_AT, HEADER_LENGTH, Head, ImageError, Info, MAGIC, VERSION, checksum,
};
use crate::Model;

/// Writes the image of `model` into `buffer`. Returns the part of the buffer that was used.
///
/// # Errors
///
/// [`ImageError::TooLarge`] if the buffer is too small, or there are more than 255 quantities, inputs, axes or terms of a
/// part. The model itself is checked when the image is loaded.
pub fn encode<'b>(
    model: &Model<'_, f32>,
    info: &Info<'_>,
    buffer: &'b mut [u8],
) -> Result<&'b [u8], ImageError> {
    let (header, rest) = buffer.split_at_mut_checked(HEADER_LENGTH).ok_or(ImageError::TooLarge)?;
    let capacity = rest.len();
    let mut writer = Writer { rest };
    writer.put(&Head {
        period_s: model.period_s,
        fitted_on: model.fitted_on,
        stillness: model.stillness,
        n_quantities: count(model.quantities)?,
        n_inputs: count(model.inputs)?,
        n_axes: count(model.axes)?,
    })?;
    if let Some(calibration) = &model.calibration {
        writer.put(calibration)?;
    }
    for quantity in model.quantities {
        writer.put(quantity)?;
    }
    for input in model.inputs {
        writer.put(input)?;
    }
    for axis in model.axes {
        writer.put(&AxisHead {
            parameters: axis.parameters,
            n_physical: count(axis.physical)?,
            n_stochastic: count(axis.stochastic)?,
        })?;
        for term in axis.physical.iter().chain(axis.stochastic) {
            writer.put(&term.coefficient)?;
            writer.put(&count(term.factors())?)?;
            for factor in term.factors() {
                writer.put(factor)?;
            }
        }
    }
    let body = capacity - writer.rest.len();
    writer.put(info)?;
    let total = HEADER_LENGTH + capacity - writer.rest.len();
    let information = total - HEADER_LENGTH - body;

    let flags = if model.calibration.is_some() { CALIBRATED } else { 0 };
    let length = |bytes: usize| u32::try_from(bytes).map_err(|_| ImageError::TooLarge);
    let fields = MAGIC
        .into_iter()
        .chain(VERSION.to_le_bytes())
        .chain(flags.to_le_bytes())
        .chain(length(body)?.to_le_bytes())
        .chain(length(information)?.to_le_bytes())
        .chain([0; 4]);
    for (byte, field) in header.iter_mut().zip(fields) {
        *byte = field;
    }
    let image = buffer.get_mut(..total).ok_or(ImageError::TooLarge)?;
    let stored = checksum(image).to_le_bytes();
    for (byte, stored) in image.iter_mut().skip(CHECKSUM_AT).zip(stored) {
        *byte = stored;
    }
    Ok(image)
}

fn count<T>(things: &[T]) -> Result<u8, ImageError> {
    u8::try_from(things.len()).map_err(|_| ImageError::TooLarge)
}

struct Writer<'b> {
    rest: &'b mut [u8],
}

impl Writer<'_> {
    fn put<T: Serialize>(&mut self, record: &T) -> Result<(), ImageError> {
        let rest = core::mem::take(&mut self.rest);
        let used = postcard::to_slice(record, rest).map_err(|_| ImageError::TooLarge)?.len();
        self.rest = rest.get_mut(used..).ok_or(ImageError::TooLarge)?;
        Ok(())
    }
}

//! Images of earlier versions as images of today's: docs/MODEL_FORMAT.md, "Versions".

use std::borrow::Cow;

use crc::{CRC_32_ISO_HDLC, Crc};
use fos_core::image::{HEADER_LENGTH, MAGIC, VERSION};
use fos_core::{
    Axis, Factor, FittedOn, ImageError, InnovationStatistics, Input, Quantity, Range, StillnessLimits,
};
use serde::Deserialize;

/// Bytes of the header before the checksum, and of a record's range of two f32.
const CHECKSUM_AT: usize = 16;
const RANGE: usize = 8;

/// The start of the body.
type Head = (f64, FittedOn, Option<StillnessLimits<f32>>, u8, u8, u8);
/// Of an axis: what it is, reference, offset, scale, constant, range.
type AxisStart = (Axis, f32, f32, f32, f32, Range<f32>);
/// Then full scale, repetitions, gap limit, coast limit, innovation, and how many terms each part has.
type AxisEnd = (f32, u16, u8, f32, InnovationStatistics<f32>, u8, u8);

/// The version that an image says it has; none where there are too few bytes for one.
pub fn version(image: &[u8]) -> Option<u16> {
    let version = image.strip_prefix(&MAGIC)?.first_chunk()?;
    Some(u16::from_le_bytes(*version))
}

/// The image as today's: itself, or of version 1 the same model, whose p nothing limits but the ranges of its inputs.
/// What has any other version stays as it is; reading says what is wrong with it.
///
/// # Errors
///
/// An image of version 1 that is damaged.
pub fn current(image: &[u8]) -> Result<Cow<'_, [u8]>, ImageError> {
    match version(image) {
        Some(1) => of_version_1(image).map(Cow::Owned),
        _ => Ok(Cow::Borrowed(image)),
    }
}

/// Version 2 has the range of p behind that of the remainder, in every axis.
fn of_version_1(image: &[u8]) -> Result<Vec<u8>, ImageError> {
    let header = image.first_chunk::<HEADER_LENGTH>();
    let header = header.ok_or(ImageError::Truncated { needed: HEADER_LENGTH, found: image.len() })?;
    let word = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
    let flags = u16::from_le_bytes([header[6], header[7]]);
    if flags != 0 {
        return Err(ImageError::UnknownFlags(flags));
    }
    let (body, information) = (word(8) as usize, word(12) as usize);
    let needed = HEADER_LENGTH.saturating_add(body).saturating_add(information);
    if image.len() < needed {
        return Err(ImageError::Truncated { needed, found: image.len() });
    }
    if image.len() > needed {
        return Err(ImageError::TrailingBytes { count: image.len() - needed });
    }
    let (stored, computed) = (word(CHECKSUM_AT), checksum(image));
    if stored != computed {
        return Err(ImageError::Checksum { stored, computed });
    }
    let (body, information) = image[HEADER_LENGTH..].split_at(body);
    let body = with_ranges(body)?;
    let length = u32::try_from(body.len()).map_err(|_| ImageError::TooLarge)?;
    let mut today = header.to_vec();
    today[4..6].copy_from_slice(&VERSION.to_le_bytes());
    today[8..12].copy_from_slice(&length.to_le_bytes());
    today.extend(body);
    today.extend(information);
    let checksum = checksum(&today);
    today[CHECKSUM_AT..HEADER_LENGTH].copy_from_slice(&checksum.to_le_bytes());
    Ok(today)
}

fn checksum(image: &[u8]) -> u32 {
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    digest.update(&image[..CHECKSUM_AT]);
    digest.update(&image[HEADER_LENGTH..]);
    digest.finalize()
}

/// The body with a range that limits nothing in every axis.
fn with_ranges(body: &[u8]) -> Result<Vec<u8>, ImageError> {
    let any = Range::<f32>::unlimited();
    let mut records = Records(body);
    let (_, _, _, n_quantities, n_inputs, n_axes): Head = records.take()?;
    for _ in 0..n_quantities {
        records.take::<Quantity>()?;
    }
    for _ in 0..n_inputs {
        records.take::<Input<f32>>()?;
    }
    let mut today = Vec::with_capacity(body.len() + RANGE * usize::from(n_axes));
    let mut copied = 0;
    for _ in 0..n_axes {
        records.take::<AxisStart>()?;
        let here = body.len() - records.0.len();
        today.extend(&body[copied..here]);
        today.extend(any.low.to_le_bytes());
        today.extend(any.high.to_le_bytes());
        copied = here;
        let (.., n_physical, n_stochastic): AxisEnd = records.take()?;
        for _ in 0..u16::from(n_physical) + u16::from(n_stochastic) {
            let (_, degree): (f32, u8) = records.take()?;
            for _ in 0..degree {
                records.take::<Factor>()?;
            }
        }
    }
    today.extend(&body[copied..]);
    Ok(today)
}

/// Bytes that have not been read.
struct Records<'a>(&'a [u8]);

impl<'a> Records<'a> {
    fn take<T: Deserialize<'a>>(&mut self) -> Result<T, ImageError> {
        let (record, rest) = postcard::take_from_bytes(self.0).map_err(|_| ImageError::Malformed)?;
        self.0 = rest;
        Ok(record)
    }
}

//! Common parts of the fuzz targets.

use crc::{CRC_32_ISO_HDLC, Crc};
use fos_core::image::{HEADER_LENGTH, MAGIC, VERSION};
use fos_embedded::c_api::{FOS_VALUES_RAW, fos_scales};

#[path = "../../fos-core/tests/evaluator/align/twin.rs"]
pub mod align_twin;
pub mod drawn;
#[path = "../../fos-core/tests/evaluator/prediction/twin.rs"]
pub mod twin;

#[cfg(feature = "logs")]
pub mod log;

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Scales of a sensor, as described by a C caller.
pub const C_SCALES: fos_scales = fos_scales {
    accel_mps2: 0.001,
    gyro_rads: 0.001,
    temperature_k: 0.01,
    temperature_zero_c: 25.0,
    period_s: 0.005,
    values: FOS_VALUES_RAW,
};

/// Wraps a body and information from the fuzzer into an image with a valid header and checksum, so that the code behind
/// these checks is reached.
pub fn sealed_image(body: &[u8], information: &[u8]) -> Vec<u8> {
    let mut image = Vec::with_capacity(HEADER_LENGTH + body.len() + information.len());
    image.extend(MAGIC);
    image.extend(VERSION.to_le_bytes());
    image.extend([0; 2]);
    for part in [body, information] {
        image.extend((part.len() as u32).to_le_bytes());
    }
    let mut digest = CRC.digest();
    digest.update(&image);
    digest.update(body);
    digest.update(information);
    image.extend(digest.finalize().to_le_bytes());
    image.extend(body);
    image.extend(information);
    image
}

/// Wraps bytes from the fuzzer into a telemetry frame with valid checksum, stuffing and delimiter.
pub fn sealed_frame(payload: &[u8]) -> Vec<u8> {
    let mut frame = payload.to_vec();
    frame.extend(CRC.checksum(payload).to_le_bytes());
    let mut stuffed = cobs::encode_vec(&frame);
    stuffed.push(0);
    stuffed
}

/// Splits at the first zero byte, which is dropped.
pub fn split(bytes: &[u8]) -> (&[u8], &[u8]) {
    let at = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    (&bytes[..at], bytes.get(at + 1..).unwrap_or(&[]))
}

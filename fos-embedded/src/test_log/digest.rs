//! Digests of the output, to compare two machines bit for bit.

use core::fmt;

use crc::{CRC_64_XZ, Crc, Table};
use fos_core::{Correction, Scalar};

use crate::hub::Output;

// the table of 2 KiB makes the CRC eight times as fast
static CRC: Crc<u64, Table<1>> = Crc::<u64, Table<1>>::new(&CRC_64_XZ);

/// Bits of an absent number, independent of the NaN of the machine.
const ABSENT: u32 = 0x7fc0_0000;

fn bytes_of(value: f32) -> [u8; 4] {
    if value.is_nan() { ABSENT } else { value.to_bits() }.to_le_bytes()
}

/// Digest of the output of a hub.
///
/// For every sample, little-endian: for each axis the corrected value and the innovation as f32 (0x7FC00000 if absent) and
/// the validity as u16; then still (u8), faults (u16), drift (u8).
#[derive(Clone)]
pub struct HubDigest(crc::Digest<'static, u64, Table<1>>);

impl Default for HubDigest {
    fn default() -> Self {
        Self(CRC.digest())
    }
}

impl HubDigest {
    /// Adds the output of one sample.
    pub fn update<R: Scalar<Stored = f32>>(&mut self, output: &Output<R>) {
        for (axis, corrected) in output.corrections.iter().map(Correction::stored).zip(output.corrected()) {
            self.0.update(&bytes_of(corrected));
            self.0.update(&bytes_of(axis.innovation.unwrap_or(f32::NAN)));
            self.0.update(&axis.validity.bits().to_le_bytes());
        }
        let [low, high] = output.faults.bits().to_le_bytes();
        self.0.update(&[u8::from(output.still), low, high, u8::from(output.drift)]);
    }

    /// Digest of all outputs up to now.
    pub fn outputs(&self) -> u64 {
        self.0.clone().finalize()
    }
}

impl fmt::Debug for HubDigest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.outputs())
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for HubDigest {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u64:016x}", self.outputs());
    }
}

/// Digest of the output of a predictor.
///
/// For every sample and every axis, in order and little-endian: the innovation as f32 (0x7FC00000 if absent), the corrected
/// value as f32, the validity as u16. A second digest is over the innovations alone.
#[derive(Clone)]
pub struct PredictorDigest {
    corrections: crc::Digest<'static, u64, Table<1>>,
    innovations: crc::Digest<'static, u64, Table<1>>,
}

impl Default for PredictorDigest {
    fn default() -> Self {
        Self { corrections: CRC.digest(), innovations: CRC.digest() }
    }
}

impl PredictorDigest {
    /// Adds the corrections of one sample.
    pub fn update(&mut self, corrections: &[Correction<f32>]) {
        for correction in corrections {
            let innovation = bytes_of(correction.innovation.unwrap_or(f32::NAN));
            let [a, b, c, d] = innovation;
            let [e, f, g, h] = bytes_of(correction.corrected);
            let [low, high] = correction.validity.bits().to_le_bytes();
            self.corrections.update(&[a, b, c, d, e, f, g, h, low, high]);
            self.innovations.update(&innovation);
        }
    }

    /// Digest of all corrections up to now.
    pub fn corrections(&self) -> u64 {
        self.corrections.clone().finalize()
    }

    /// Digest of the innovations up to now.
    pub fn innovations(&self) -> u64 {
        self.innovations.clone().finalize()
    }
}

impl fmt::Debug for PredictorDigest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x} {:016x}", self.corrections(), self.innovations())
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for PredictorDigest {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u64:016x} {=u64:016x}", self.corrections(), self.innovations());
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use fos_core::{FittedOn, Validity};

    use super::*;
    use crate::hub::Hub;
    use crate::raw::{Faults, RawSample, Scales};

    const FIRST: Correction<f32> =
        Correction { predicted: 0.5, innovation: Some(-0.25), corrected: 1.0, validity: Validity::VALID };
    const SECOND: Correction<f32> =
        Correction { predicted: 0.5, innovation: None, corrected: -0.0, validity: Validity::STUCK };

    /// CRC computed bit by bit: CRC-64/XZ is reflected ECMA-182, starting at and finished with all ones.
    fn crc(bytes: &[u8]) -> u64 {
        !bytes.iter().fold(!0_u64, |crc, &byte| {
            (0..8).fold(crc ^ u64::from(byte), |crc, _| {
                (crc >> 1) ^ if crc & 1 == 1 { 0xc96c_5795_d787_0f42 } else { 0 }
            })
        })
    }

    #[test]
    fn predictor_digest_is_the_crc_of_the_documented_bytes() {
        assert_eq!(crc(b"123456789"), 0x995d_c9bb_df19_39fa);
        let mut digest = PredictorDigest::default();
        digest.update(&[FIRST]);
        digest.update(&[SECOND]);
        let innovations = [[0, 0, 0x80, 0xbe], [0, 0, 0xc0, 0x7f]];
        let rest = [&[0, 0, 0x80, 0x3f, 0, 0][..], &[0, 0, 0, 0x80, 0, 1]];
        let all: Vec<u8> =
            innovations.iter().zip(rest).flat_map(|(innovation, rest)| [innovation, rest].concat()).collect();
        assert_eq!(digest.corrections(), crc(&all));
        assert_eq!(digest.innovations(), crc(&innovations.concat()));
    }

    #[test]
    fn hub_digest_is_the_crc_of_the_documented_bytes() {
        let scales = Scales {
            accel_mps2: 1.0,
            gyro_rads: 0.5,
            temperature_k: 1.0,
            temperature_zero_c: 25.0,
            period_s: 0.005,
            values: FittedOn::Raw,
        };
        let mut hub: Hub<0, 0, 8> = Hub::new(scales);
        let raw =
            RawSample { accel: [1, 2, 3], gyro: [4, 5, -6], faults: Faults::BUS, ..RawSample::default() };
        let mut digest = HubDigest::default();
        digest.update(hub.update(&raw));
        let mut bytes = Vec::new();
        for corrected in [1.0_f32, 2.0, 3.0, 2.0, 2.5, -3.0] {
            bytes.extend(corrected.to_le_bytes());
            bytes.extend([0, 0, 0xc0, 0x7f]);
            bytes.extend(Validity::NOT_MODELLED.bits().to_le_bytes());
        }
        bytes.extend([0, 1, 0, 0]);
        assert_eq!(digest.outputs(), crc(&bytes));
    }

    #[test]
    fn digest_changes_with_the_last_bit() {
        let (mut a, mut b) = (PredictorDigest::default(), PredictorDigest::default());
        a.update(&[FIRST]);
        b.update(&[Correction { corrected: f32::from_bits(1.0_f32.to_bits() ^ 1), ..FIRST }]);
        assert_ne!(a.corrections(), b.corrections());
        assert_eq!(a.innovations(), b.innovations());
    }
}

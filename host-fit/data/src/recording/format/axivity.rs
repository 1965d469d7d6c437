//! Logs of Axivity AX3 and AX6 (`.cwa`): a header of 1024 bytes, then blocks of 512 bytes, each with its time, its
//! temperature, a checksum, and 40 to 120 samples ("Open Movement AX Device: Technical Documentation").

use std::io::BufRead;
use std::path::Path;

use super::super::error::RecordingError;
use super::super::load_options::LoadOptions;
use super::super::provenance::{Frame, Provenance, Values};
use super::Format;
use super::opened::Opened;
use super::wearable::{Blocks, is_rate, ns_since_1970};
use crate::file::{FileError, read_up_to};
use crate::interrupt;
use crate::unit::STANDARD_GRAVITY_MPS2;

/// First bytes of a file: `MD` and the length of the header.
pub(super) const SIGNATURE: &[u8] = b"MD\xfc\x03";

const HEADER: usize = 1024;
const BLOCK: usize = 512;

/// Byte range of the samples in a block.
const SAMPLES: std::ops::Range<usize> = 30..510;

pub(super) fn read(
    path: &Path,
    mut input: impl BufRead,
    options: &LoadOptions,
) -> Result<Opened, RecordingError> {
    let mut header = [0; HEADER];
    let mut blocks = Blocks::default();
    let mut device = "AX3";
    let mut other_axes = 0_u64;
    let mut fill = |bytes: &mut [u8]| read_up_to(&mut input, bytes).map_err(FileError::reading(path));
    if fill(&mut header)? == HEADER {
        if header[4] == 0x64 {
            device = "AX6";
        }
        let mut block = [0; BLOCK];
        loop {
            match fill(&mut block)? {
                0 => break,
                BLOCK => {}
                _ => {
                    blocks.damaged += 1;
                    break;
                }
            }
            interrupt::check();
            match take(&block, &mut blocks) {
                // the device has not written blank blocks yet
                Taken::Samples | Taken::Nothing => {}
                Taken::OtherAxes => other_axes += 1,
                Taken::Damaged => blocks.damaged += 1,
            }
        }
    }
    let others = match other_axes {
        0 => String::new(),
        n => format!("; {n} blocks with other axes than the first are not read"),
    };
    let assumed = format!(
        "Axivity {device}, by the scales in its blocks, in g with gravity and °/s; its clock shows local time{others}"
    );
    blocks.opened(path, Format::Axivity, options, &assumed, Provenance::of_both(Values::Raw, Frame::Sensor))
}

enum Taken {
    Samples,
    Nothing,
    OtherAxes,
    Damaged,
}

/// Storage format of the samples of a block.
#[derive(Clone, Copy)]
enum Layout {
    /// Three numbers of 10 bits and a common exponent of two in 32 bits.
    Packed,
    /// Three numbers of 16 bits.
    Force,
    /// Six numbers of 16 bits, the gyro first; three more of a magnetometer may follow.
    RateAndForce { numbers: usize },
}

impl Layout {
    fn of(axes_and_format: u8) -> Option<Self> {
        match axes_and_format {
            0x30 => Some(Self::Packed),
            0x32 => Some(Self::Force),
            0x62 => Some(Self::RateAndForce { numbers: 6 }),
            0x92 => Some(Self::RateAndForce { numbers: 9 }),
            _ => None,
        }
    }

    fn bytes(self) -> usize {
        match self {
            Self::Packed => 4,
            Self::Force => 6,
            Self::RateAndForce { numbers } => 2 * numbers,
        }
    }
}

fn take(block: &[u8; BLOCK], blocks: &mut Blocks) -> Taken {
    let u16_at = |at: usize| u16::from_le_bytes([block[at], block[at + 1]]);
    if !block.starts_with(b"AX") {
        let is_blank = block.iter().all(|byte| *byte == 0xff) || block.iter().all(|byte| *byte == 0);
        return if is_blank { Taken::Nothing } else { Taken::Damaged };
    }
    let sum = (0..BLOCK).step_by(2).fold(0_u16, |sum, at| sum.wrapping_add(u16_at(at)));
    let samples = usize::from(u16_at(28));
    let (Some(layout), Some((start_ns, rate_hz))) = (Layout::of(block[25]), start(block)) else {
        return Taken::Damaged;
    };
    if sum != 0 || samples * layout.bytes() > SAMPLES.len() {
        return Taken::Damaged;
    }
    if samples == 0 {
        return Taken::Nothing;
    }
    let has_gyro = matches!(layout, Layout::RateAndForce { .. });
    if blocks.has_gyro().is_some_and(|had| had != has_gyro) {
        return Taken::OtherAxes;
    }
    let scales = u16_at(18);
    // AX3: 1/256 g, which the three bits of zero state as well
    let mps2 = STANDARD_GRAVITY_MPS2 / f64::from(1_u32 << (8 + (scales >> 13)));
    let full_scale_dps = 8000.0 / f64::from(1_u32 << ((scales >> 10) & 7));
    let rads = full_scale_dps.to_radians() / 32_768.0;
    let triad = |sample: &[u8], scale: f64| {
        [0, 2, 4].map(|at| f64::from(i16::from_le_bytes([sample[at], sample[at + 1]])) * scale)
    };
    for sample in block[SAMPLES].chunks_exact(layout.bytes()).take(samples) {
        match layout {
            Layout::Packed => {
                let packed = u32::from_le_bytes([sample[0], sample[1], sample[2], sample[3]]);
                let exponent = packed >> 30;
                let axis = |shift: u32| {
                    // the top ten bits of a 16-bit number, which preserves their sign
                    let number = (((packed >> shift) << 6) as u16 as i16) >> 6;
                    f64::from(i32::from(number) << exponent) * STANDARD_GRAVITY_MPS2 / 256.0
                };
                blocks.push(Some([0, 10, 20].map(axis)), None);
            }
            Layout::Force => blocks.push(Some(triad(sample, mps2)), None),
            Layout::RateAndForce { .. } => {
                blocks.push(Some(triad(&sample[6..], mps2)), Some(triad(sample, rads)));
            }
        }
    }
    let raw = u16_at(20) & 0x3ff;
    // an MCP9700 (10 mV/K, 0.5 V at 0 °C) at 3 V over 1024 counts, as the maker documents; older software has another line
    let celsius = if raw == 0 { f64::NAN } else { f64::from(raw) * 75.0 / 256.0 - 50.0 };
    blocks.end(start_ns, rate_hz, samples, celsius);
    Taken::Samples
}

/// Time of the first sample of a block, ns since 1970, and the sampling rate, Hz.
fn start(block: &[u8; BLOCK]) -> Option<(i64, f64)> {
    let packed = u32::from_le_bytes([block[14], block[15], block[16], block[17]]);
    let field = |shift: u32, bits: u32| i64::from((packed >> shift) & ((1 << bits) - 1));
    let date = [2000 + field(26, 6), field(22, 4), field(17, 5)];
    let whole_s = ns_since_1970(date, [field(12, 5), field(6, 6), field(0, 6)])?;
    let offset = i16::from_le_bytes([block[26], block[27]]);
    // the first devices store the rate itself where later ones have the sample of the timestamp
    let (rate_hz, mut offset) = match block[24] {
        0 => (f64::from(offset), 0.0),
        code => (3200.0 / f64::from(1_u32 << (15 - (code & 15))), f64::from(offset)),
    };
    if !is_rate(rate_hz) {
        return None;
    }
    let fractional = u16::from_le_bytes([block[4], block[5]]);
    let mut fraction = 0.0;
    if fractional & 0x8000 != 0 {
        fraction = f64::from(fractional & 0x7fff) / 32_768.0;
        // the offset was reduced by the whole samples of the fraction, for readers that do not support it
        offset += (fraction * rate_hz).floor();
    }
    let ns = (fraction - offset / rate_hz) * 1e9;
    Some((whole_s.saturating_add(ns.round() as i64), rate_hz))
}

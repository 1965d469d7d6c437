//! LSM6DSO (STMicroelectronics) over I2C. Registers: data sheet DS12140, chapter 9.

use super::SensorClock;
use super::registers::Setting;
use super::st::{St, StPart};

/// Code of 208 Hz in CTRL1_XL, CTRL2_G and FIFO_CTRL3, the rate nearest to 200 Hz.
const RATE: u8 = 5;

const FUNC_CFG_ACCESS: u8 = 0x01;
const CTRL3_C: u8 = 0x12;

/// An LSM6DSO on an I2C bus of at most 400 kHz: ±4 g, ±500 dps, 208 Hz in high-performance mode.
///
/// One second of samples takes 4.5 kB on the bus, a tenth of the time at 400 kHz.
pub type Lsm6dso<B, D> = St<Lsm6dsoRegisters, B, D>;

/// Registers of the LSM6DSO.
#[derive(Debug)]
pub enum Lsm6dsoRegisters {}

impl StPart for Lsm6dsoRegisters {
    const NAME: &'static str = "LSM6DSO";
    /// TIMESTAMP0 …: 25 µs per count. The nominal rate is 6667/32 Hz, 192 counts per sample.
    const CLOCK: SensorClock = SensorClock { bits: 32, count_ps: 25_000_000, period_ns: 4_800_000 };
    const IDENTITY: u8 = 0x6c;
    // IF_INC stays set, SW_RESET
    const RESET: &'static [Setting] = &[(FUNC_CFG_ACCESS, 0), (CTRL3_C, 1 << 2 | 1 << 0)];
    // the boot after power-on takes 10 ms
    const BOOT_MS: u32 = 20;
    const CONFIGURATION: &'static [Setting] = &[
        (FUNC_CFG_ACCESS, 0),
        // BDU, IF_INC
        (CTRL3_C, 1 << 6 | 1 << 2),
        // CTRL4_C: DRDY_MASK
        (0x13, 1 << 3),
        // CTRL6_C, CTRL7_G, CTRL8_XL: high-performance mode; no offset of the host, no filter
        (0x15, 0),
        (0x16, 0),
        (0x17, 0),
        // CTRL9_XL: I3C off, its other bits as after a reset
        (0x18, 0xe0 | 1 << 1),
        // CTRL10_C: TIMESTAMP_EN
        (0x19, 1 << 5),
        // FIFO_CTRL2: no stop at the watermark, no compression
        (0x08, 0),
        // FIFO_CTRL3: both batched at their rate
        (0x09, RATE << 4 | RATE),
        // CTRL1_XL: ±4 g
        (0x10, RATE << 4 | 2 << 2),
        // CTRL2_G: ±500 dps
        (0x11, RATE << 4 | 1 << 2),
        // FIFO_CTRL4: a timestamp with every sample, a temperature 12.5 times per second; new words overwrite old ones
        (0x0a, 1 << 6 | 2 << 4 | 6),
    ];
    const FIFO_STATUS1: u8 = 0x3a;
    const HIGH_LEVEL: u8 = 3;
}

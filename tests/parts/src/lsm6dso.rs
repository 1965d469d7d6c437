//! LSM6DSO (STMicroelectronics). Registers: its data sheet, DS12140, chapter 9.

use crate::st::{CTRL1, CTRL2, CTRL3, Setting, Variant};

const PIN_CTRL: usize = 0x02;
const CTRL9_XL: usize = 0x18;
const CTRL10_C: usize = 0x19;

/// The LSM6DSO.
#[derive(Debug)]
pub(crate) struct Lsm6dso;

/// Period of a rate, ns, by its code in CTRL1_XL, CTRL2_G or FIFO_CTRL3: 6.667 kHz divided by a power of two, 12.5 Hz
/// (code 1) to 6.667 kHz (code 10). At "208 Hz" it is 192 counts of the timestamp.
fn period_ns(code: u8) -> Option<u64> {
    (1..=10).contains(&code).then(|| 76_800_000 >> (code - 1))
}

impl Variant for Lsm6dso {
    const IDENTITY: u8 = 0x6c;
    const RESET: &'static [(usize, u8)] = &[(PIN_CTRL, 0x3f), (CTRL3, 0x04), (CTRL9_XL, 0xe0)];
    const POWER_ON_RESET: u8 = 0;
    const TICK_NS: u64 = 4_800_000;
    /// 3 kB
    const FIFO_WORDS: usize = 512;
    const FIFO_STATUS1: usize = 0x3a;
    const HIGH_WATERMARK: u8 = 1;
    const HIGH_LEVEL: u8 = 3;
    const TIMESTAMP_PS: u64 = 25_000_000;
    const TIMESTAMP_ENABLE: (usize, u8) = (CTRL10_C, 1 << 5);
    const ACTIVE_LOW: (usize, u8) = (CTRL3, 1 << 5);
    const TAG_PARITY: bool = true;
    /// 52 Hz
    const THERMOMETER_NS: u64 = 19_200_000;
    /// 1.6, 12.5 and 52 Hz
    const TEMPERATURE_BATCH_NS: [u64; 4] = [0, 614_400_000, 76_800_000, 19_200_000];
    const ACCEL_START_NS: u64 = 10_000_000;
    /// From power-down
    const GYRO_START_NS: u64 = 70_000_000;

    fn accel(registers: &[u8; 128]) -> Option<Setting> {
        // ±2, 16, 4, 8 g
        let ratio = [2.0, 0.25, 1.0, 0.5][usize::from(registers[CTRL1] >> 2 & 3)];
        Some(Setting { period_ns: period_ns(registers[CTRL1] >> 4)?, ratio })
    }

    fn gyro(registers: &[u8; 128]) -> Option<Setting> {
        let control = registers[CTRL2];
        // ±125 °/s, or ±250, 500, 1000, 2000 °/s
        let ratio = if control & 2 != 0 { 4.0 } else { 2.0 / f64::from(1 << (control >> 2 & 3)) };
        Some(Setting { period_ns: period_ns(control >> 4)?, ratio })
    }

    fn batch_ns(_: &[u8; 128], code: u8) -> Option<u64> {
        period_ns(code)
    }
}

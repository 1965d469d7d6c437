//! LSM6DSV16X (STMicroelectronics). Registers: data sheet DS13510, chapter 9.

use crate::st::{CTRL1, CTRL2, CTRL3, Setting, Variant};

const PIN_CTRL: usize = 0x02;
const IF_CFG: usize = 0x03;
const CTRL6: usize = 0x15;
const CTRL8: usize = 0x17;
const FUNCTIONS_ENABLE: usize = 0x50;
const HAODR_CFG: usize = 0x62;

/// The LSM6DSV16X.
#[derive(Debug)]
pub(crate) struct Lsm6dsv16x;

/// Operating mode of high-accuracy rates in CTRL1 and CTRL2.
const HIGH_ACCURACY: u8 = 1;

/// Period of a rate, ns, by its code in CTRL1, CTRL2 or FIFO_CTRL3.
fn period_ns(registers: &[u8; 128], mode: u8, code: u8) -> Option<u64> {
    // 7.5 Hz, 15.625 Hz and 12.5 Hz, doubled with every code
    let (lowest_ns, lowest) = match (mode, registers[HAODR_CFG] & 3) {
        (HIGH_ACCURACY, 1) => (64_000_000, 3),
        (HIGH_ACCURACY, 2) => (80_000_000, 3),
        _ => (133_333_333, 2),
    };
    match code {
        // 1.875 Hz, in low-power mode
        1 if lowest == 2 => Some(533_333_333),
        _ if (lowest..=12).contains(&code) => Some(lowest_ns >> (code - lowest)),
        _ => None,
    }
}

impl Variant for Lsm6dsv16x {
    const IDENTITY: u8 = 0x70;
    const RESET: &'static [(usize, u8)] = &[(PIN_CTRL, 0x23), (CTRL3, 0x44)];
    const POWER_ON_RESET: u8 = 1 << 2;
    const TICK_NS: u64 = 5_000_000;
    const FIFO_WORDS: usize = 256;
    const FIFO_STATUS1: usize = 0x1b;
    const HIGH_WATERMARK: u8 = 0;
    const HIGH_LEVEL: u8 = 1;
    /// 1/46 080 s
    const TIMESTAMP_PS: u64 = 21_701_389;
    const TIMESTAMP_ENABLE: (usize, u8) = (FUNCTIONS_ENABLE, 1 << 6);
    const ACTIVE_LOW: (usize, u8) = (IF_CFG, 1 << 4);
    const TAG_PARITY: bool = false;
    /// 60 Hz
    const THERMOMETER_NS: u64 = 16_666_667;
    /// 1.875, 15 and 60 Hz
    const TEMPERATURE_BATCH_NS: [u64; 4] = [0, 533_333_333, 66_666_667, 16_666_667];
    const ACCEL_START_NS: u64 = 10_000_000;
    /// From power-down
    const GYRO_START_NS: u64 = 30_000_000;

    fn accel(registers: &[u8; 128]) -> Option<Setting> {
        let control = registers[CTRL1];
        let period_ns = period_ns(registers, control >> 4 & 7, control & 0x0f)?;
        // ±2, 4, 8, 16 g
        Some(Setting { period_ns, ratio: 2.0 / f64::from(1 << (registers[CTRL8] & 3)) })
    }

    fn gyro(registers: &[u8; 128]) -> Option<Setting> {
        let control = registers[CTRL2];
        let period_ns = period_ns(registers, control >> 4 & 7, control & 0x0f)?;
        // ±125, 250, 500, 1000, 2000 °/s, and 4000 °/s with code 12
        let range = match registers[CTRL6] & 0x0f {
            12 => 5,
            code => code.min(4),
        };
        Some(Setting { period_ns, ratio: 4.0 / f64::from(1 << range) })
    }

    fn batch_ns(registers: &[u8; 128], code: u8) -> Option<u64> {
        // with high-accuracy rates the codes mean the same set of rates
        period_ns(registers, registers[CTRL2] >> 4 & 7, code)
    }
}

//! LSM6DSV16X (STMicroelectronics) over I2C. Registers: data sheet DS13510, chapter 9; their bits from the maker's driver.

use lsm6dsv16x_rs::asynchronous::prelude::{
    Ctrl1, Ctrl2, Ctrl3, Ctrl4, Ctrl6, Ctrl8, Ctrl9, FifoBatch, FifoCtrl2, FifoCtrl3, FifoCtrl4, FifoMode,
    FifoTempBatch, FifoTimestampBatch, FuncCfgAccess, FunctionsEnable, GyFullScale, GyMode, HaodrCfg, ID,
    Odr, Reg, XlFullScale, XlMode,
};

use super::SensorClock;
use super::registers::Setting;
use super::st::{St, StPart};

/// ±4 g and ±500 dps.
const ACCEL_RANGE: u8 = XlFullScale::_4g as u8;
const GYRO_RANGE: u8 = GyFullScale::_500dps as u8;

/// 200 Hz, which only the high-accuracy mode has. Low half: rate; high half: set of rates.
const RATE: u8 = Odr::Ha02_200hz as u8 & 0x0f;
const RATE_SET: u8 = Odr::Ha02_200hz as u8 >> 4;

const BATCH: u8 = FifoBatch::_240hz as u8;

/// New words overwrite old ones; a timestamp with every sample, a temperature 15 times per second.
const FIFO: FifoCtrl4 = FifoCtrl4::new()
    .with_fifo_mode(FifoMode::StreamMode as u8)
    .with_odr_t_batch(FifoTempBatch::_15hz as u8)
    .with_dec_ts_batch(FifoTimestampBatch::Dec1 as u8);

/// An LSM6DSV16X on an I2C bus of at most 1 MHz, of which 400 kHz is enough: ±4 g, ±500 dps, 200 Hz in high-accuracy mode.
///
/// One second of samples takes 4.3 kB on the bus, a tenth of the time at 400 kHz.
pub type Lsm6dsv16x<B, D> = St<Lsm6dsv16xRegisters, B, D>;

/// Registers of the LSM6DSV16X.
#[derive(Debug)]
pub enum Lsm6dsv16xRegisters {}

impl StPart for Lsm6dsv16xRegisters {
    const NAME: &'static str = "LSM6DSV16X";
    /// TIMESTAMP0 …: 1/46 080 s per count, 21.7 µs.
    const CLOCK: SensorClock = SensorClock { bits: 32, count_ps: 21_701_389, period_ns: 5_000_000 };
    const IDENTITY: u8 = ID;
    const RESET: &'static [Setting] =
        &[(Reg::FuncCfgAccess as u8, FuncCfgAccess::new().with_sw_por(1).into_bits())];
    // as in the manufacturer's driver
    const BOOT_MS: u32 = 50;
    const CONFIGURATION: &'static [Setting] = &[
        (Reg::FuncCfgAccess as u8, 0),
        (Reg::Ctrl3 as u8, Ctrl3::new().with_bdu(1).with_if_inc(1).into_bits()),
        (Reg::Ctrl4 as u8, Ctrl4::new().with_drdy_mask(1).into_bits()),
        (Reg::Ctrl6 as u8, Ctrl6::new().with_fs_g(GYRO_RANGE).into_bits()),
        (Reg::Ctrl8 as u8, Ctrl8::new().with_fs_xl(ACCEL_RANGE).into_bits()),
        // offsets that a host may write (X_OFS_USR …) are off
        (Reg::Ctrl9 as u8, Ctrl9::new().into_bits()),
        (Reg::HaodrCfg as u8, HaodrCfg::new().with_haodr_sel(RATE_SET).into_bits()),
        (Reg::FunctionsEnable as u8, FunctionsEnable::new().with_timestamp_en(1).into_bits()),
        (Reg::FifoCtrl2 as u8, FifoCtrl2::new().into_bits()),
        // the batching rate has the same code as the data rate
        (Reg::FifoCtrl3 as u8, FifoCtrl3::new().with_bdr_xl(BATCH).with_bdr_gy(BATCH).into_bits()),
        (
            Reg::Ctrl1 as u8,
            Ctrl1::new().with_odr_xl(RATE).with_op_mode_xl(XlMode::HighAccuracyOdrMd as u8).into_bits(),
        ),
        (
            Reg::Ctrl2 as u8,
            Ctrl2::new().with_odr_g(RATE).with_op_mode_g(GyMode::HighAccuracyOdrMd as u8).into_bits(),
        ),
        (Reg::FifoCtrl4 as u8, FIFO.into_bits()),
    ];
    const FIFO_STATUS1: u8 = Reg::FifoStatus1 as u8;
    const HIGH_LEVEL: u8 = 1;
}

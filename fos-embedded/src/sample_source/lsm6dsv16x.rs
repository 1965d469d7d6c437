//! LSM6DSV16X (STMicroelectronics) over I2C. Registers: data sheet DS13510, chapter 9; their bits from the maker's driver.

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;
use fos_core::FittedOn;
use lsm6dsv16x_rs::asynchronous::prelude::{
    Ctrl1, Ctrl2, Ctrl3, Ctrl4, Ctrl6, Ctrl8, Ctrl9, FifoBatch, FifoCtrl2, FifoCtrl3, FifoCtrl4, FifoMode,
    FifoTempBatch, FifoTimestampBatch, FuncCfgAccess, FunctionsEnable, GyFullScale, GyMode, HaodrCfg, ID,
    Odr, Reg, XlFullScale, XlMode,
};

use super::st::{Address, Registers, St};
use super::{Batch, Imu, SensorClock, SourceError};
use crate::raw::Scales;

/// ±4 g: 0.122 mg/LSB ("Mechanical characteristics", LA_So).
const ACCEL_RANGE: u8 = XlFullScale::_4g as u8;
const ACCEL_MG: f32 = 0.122;

/// ±500 dps: 17.5 mdps/LSB ("Mechanical characteristics", G_So).
const GYRO_RANGE: u8 = GyFullScale::_500dps as u8;
const GYRO_MDPS: f32 = 17.5;

/// 200 Hz, which only the high-accuracy mode has. Low half: rate; high half: set of rates.
const RATE: u8 = Odr::Ha02_200hz as u8 & 0x0f;
const RATE_SET: u8 = Odr::Ha02_200hz as u8 >> 4;

const REGISTERS: Registers = Registers {
    identity: ID,
    reset: &[(Reg::FuncCfgAccess as u8, FuncCfgAccess::new().with_sw_por(1).into_bits())],
    // as in the manufacturer's driver
    boot_ms: 50,
    configuration: &[
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
    ],
    fifo_status: Reg::FifoStatus1 as u8,
    level: 1,
};

const BATCH: u8 = FifoBatch::_240hz as u8;

/// New words overwrite old ones; a timestamp with every sample, a temperature 15 times per second.
const FIFO: FifoCtrl4 = FifoCtrl4::new()
    .with_fifo_mode(FifoMode::StreamMode as u8)
    .with_odr_t_batch(FifoTempBatch::_15hz as u8)
    .with_dec_ts_batch(FifoTimestampBatch::Dec1 as u8);

/// An LSM6DSV16X on an I2C bus: ±4 g, ±500 dps, 200 Hz in high-accuracy mode.
///
/// One second of samples takes 4.3 kB on the bus, a tenth of the time at 400 kHz.
pub struct Lsm6dsv16x<B, D>(St<B, D>);

impl<B: I2c, D: DelayNs> Lsm6dsv16x<B, D> {
    /// Creates the driver; I2C clock at most 1 MHz, of which 400 kHz is enough.
    pub fn new(i2c: B, address: Address, delay: D) -> Self {
        Self(St::new(i2c, address, delay, &REGISTERS))
    }

    /// Lets INT1 rise when [`INTERRUPT_SAMPLES`](super::INTERRUPT_SAMPLES) samples were taken since the FIFO was read, so
    /// that the application can sleep until then. The pin falls when they are read.
    #[must_use]
    pub fn with_interrupt(self) -> Self {
        Self(self.0.with_interrupt())
    }

    /// Returns bus and delay for another use; the part continues as it was set up.
    pub fn release(self) -> (B, D) {
        self.0.release()
    }
}

#[cfg(feature = "defmt")]
impl<B, D> defmt::Format for Lsm6dsv16x<B, D> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Lsm6dsv16x");
    }
}

impl<B: I2c, D: DelayNs> Imu for Lsm6dsv16x<B, D> {
    type BusError = B::Error;

    const NAME: &'static str = "LSM6DSV16X";

    /// TIMESTAMP0 …: 1/46 080 s per count, 21.7 µs.
    const CLOCK: SensorClock = SensorClock { bits: 32, count_ps: 21_701_389, period_ns: 5_000_000 };

    fn scales() -> Scales {
        Scales {
            accel_mps2: ACCEL_MG * 9.806_65e-3,
            gyro_rads: (GYRO_MDPS * 1e-3).to_radians(),
            // "Temperature sensor characteristics"
            temperature_k: 1.0 / 256.0,
            temperature_zero_c: 25.0,
            period_s: 0.005,
            values: FittedOn::Raw,
        }
    }

    async fn set_up(&mut self) -> Result<(), SourceError<B::Error>> {
        self.0.set_up().await
    }

    async fn is_set_up(&mut self) -> Result<bool, SourceError<B::Error>> {
        self.0.is_set_up().await
    }

    async fn read(&mut self, batch: &mut Batch) -> Result<(), SourceError<B::Error>> {
        self.0.read(batch).await
    }

    async fn wait_ms(&mut self, ms: u32) {
        self.0.wait_ms(ms).await;
    }
}

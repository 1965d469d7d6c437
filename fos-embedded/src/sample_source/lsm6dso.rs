//! LSM6DSO (STMicroelectronics) over I2C. Registers: data sheet DS12140, chapter 9.

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;
use fos_core::FittedOn;

use super::st::{Address, Registers, St};
use super::{Batch, Imu, SensorClock, SourceError};
use crate::raw::Scales;

/// ±4 g: 0.122 mg/LSB ("Mechanical characteristics", LA_So).
const ACCEL_MG: f32 = 0.122;

/// ±500 dps: 17.5 mdps/LSB ("Mechanical characteristics", G_So).
const GYRO_MDPS: f32 = 17.5;

/// Code of 208 Hz in CTRL1_XL, CTRL2_G and FIFO_CTRL3, the rate nearest to 200 Hz.
const RATE: u8 = 5;

const FUNC_CFG_ACCESS: u8 = 0x01;
const CTRL3_C: u8 = 0x12;

const REGISTERS: Registers = Registers {
    identity: 0x6c,
    // IF_INC stays set, SW_RESET
    reset: &[(FUNC_CFG_ACCESS, 0), (CTRL3_C, 1 << 2 | 1 << 0)],
    // the boot after power-on takes 10 ms
    boot_ms: 20,
    configuration: &[
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
    ],
    fifo_status: 0x3a,
    level: 3,
};

/// An LSM6DSO on an I2C bus: ±4 g, ±500 dps, 208 Hz in high-performance mode.
///
/// One second of samples takes 4.5 kB on the bus, a tenth of the time at 400 kHz.
pub struct Lsm6dso<B, D>(St<B, D>);

impl<B: I2c, D: DelayNs> Lsm6dso<B, D> {
    /// Creates the driver; I2C clock at most 400 kHz.
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
impl<B, D> defmt::Format for Lsm6dso<B, D> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Lsm6dso");
    }
}

impl<B: I2c, D: DelayNs> Imu for Lsm6dso<B, D> {
    type BusError = B::Error;

    const NAME: &'static str = "LSM6DSO";

    /// TIMESTAMP0 …: 25 µs per count. The nominal rate is 6667/32 Hz, 192 counts per sample.
    const CLOCK: SensorClock = SensorClock { bits: 32, count_ps: 25_000_000, period_ns: 4_800_000 };

    fn scales() -> Scales {
        Scales {
            accel_mps2: ACCEL_MG * 9.806_65e-3,
            gyro_rads: (GYRO_MDPS * 1e-3).to_radians(),
            // "Temperature sensor characteristics"
            temperature_k: 1.0 / 256.0,
            temperature_zero_c: 25.0,
            period_s: 0.004_8,
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

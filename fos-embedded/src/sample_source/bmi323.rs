//! BMI323 (Bosch Sensortec) over SPI. Section numbers refer to its data sheet, BST-BMI323-DS000.

use bmi323_driver::{
    AccelConfig, AccelMode, AccelRange, Access, AverageSamples, Bandwidth, Bmi323 as Driver, Error,
    FifoConfig, GyroConfig, GyroMode, GyroRange, OutputDataRate, SpiTransport,
};
use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::spi::SpiDevice;
use fos_core::{FittedOn, GRAVITY_MPS2};

use super::spi_fifo::{FRAME, is_released, read_frames};
use super::{Batch, Imu, SensorClock, SourceError};
use crate::raw::Scales;

/// ±4 g: 8.192 LSB/mg (§5.6.1).
const ACCEL: AccelConfig = AccelConfig {
    mode: AccelMode::HighPerformance,
    average: AverageSamples::Avg1,
    bandwidth: Bandwidth::OdrOver2,
    range: AccelRange::G4,
    odr: OutputDataRate::Hz200,
};

/// ±500 dps: 65.536 LSB/dps (§5.6.2).
const GYRO: GyroConfig = GyroConfig {
    mode: GyroMode::HighPerformance,
    average: AverageSamples::Avg1,
    bandwidth: Bandwidth::OdrOver2,
    range: GyroRange::Dps500,
    odr: OutputDataRate::Hz200,
};

/// Every frame has accelerometers, gyros, temperature and time (§5.7); when the FIFO is full, new frames overwrite old ones.
const FIFO: FifoConfig = FifoConfig {
    stop_on_full: false,
    include_time: true,
    include_accel: true,
    include_gyro: true,
    include_temperature: true,
};

/// Registers and their values after the set-up (§6.1.2): `acc_conf`, `gyr_conf`, `fifo_watermark`, `fifo_conf`.
const CONFIGURATION: [(u8, u16); 4] =
    [(0x20, ACCEL.to_word()), (0x21, GYRO.to_word()), (0x35, 0), (0x36, FIFO.to_word())];

/// Command that reads the FIFO (§5.7; §7.2.3: read bit and `fifo_data`). It bypasses `read_fifo_words` of the driver, which
/// checks a length at run time and so links a panic, even though it never occurs.
const READ_FIFO: u8 = 0x80 | 0x16;

/// Dummy bytes before the data of a read (§7.2.3).
const DUMMY: usize = 1;

/// Words of a frame and of the FIFO, 2 kB (§5.7). With at most one frame free it counts as full: the oldest frame may have
/// been overwritten.
const FRAME_WORDS: u16 = FRAME as u16 / 2;
const FIFO_WORDS: u16 = 1024;

/// First word of an accelerometer or gyro without data yet (§5.7, table 18). It is also the code of 0.992 of full scale on
/// x, so such a sample is taken for missing.
const NO_ACCEL: i16 = 0x7f01;
const NO_GYRO: i16 = 0x7f02;

/// Code of an empty FIFO, and of a thermometer without a valid value (§5.6.3).
const NOTHING: i16 = i16::MIN;

/// A BMI323 on an SPI bus: ±4 g, ±500 dps, 200 Hz in high-performance mode.
pub struct Bmi323<S, D> {
    spi: S,
    delay: D,
    /// A frame was received since the set-up; from then on every frame has data.
    started: bool,
}

impl<S: SpiDevice, D: DelayNs> Bmi323<S, D> {
    /// Creates the driver; SPI mode 0 or 3, at most 10 MHz.
    pub fn new(spi: S, delay: D) -> Self {
        Self { spi, delay, started: false }
    }

    /// Returns bus and delay for another use; the part continues as it was set up.
    pub fn release(self) -> (S, D) {
        (self.spi, self.delay)
    }

    /// Creates a driver for one call; its state is not used here.
    fn driver(&mut self) -> Driver<SpiTransport<&mut S>> {
        Driver::new_spi(&mut self.spi)
    }
}

/// Takes a frame: words, the low byte first.
fn take(frame: &[u8; FRAME], started: &mut bool, batch: &mut Batch) {
    let ([first, second], []) = frame.as_chunks::<{ FRAME / 2 }>() else { return };
    let ([ax, ay, az, gx], [gy, gz, temperature, stamp]) = (words(first), words(second));
    let (accel, gyro) = ([ax, ay, az], [gx, gy, gz]);
    let is_starting = ax == NO_ACCEL || gx == NO_GYRO || (accel == [NOTHING; 3] && gyro == [NOTHING; 3]);
    let [.., end] = second.as_chunks::<4>().0 else { return };
    if is_released(end) || (is_starting && *started) {
        batch.tear();
        return;
    }
    if !is_starting {
        *started = true;
        let temperature = Some(temperature).filter(|code| *code != NOTHING);
        batch.push(accel, gyro, temperature, u32::from(stamp as u16));
    }
}

#[cfg(feature = "defmt")]
impl<S, D> defmt::Format for Bmi323<S, D> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Bmi323 {{ started: {=bool} }}", self.started);
    }
}

impl<S: SpiDevice, D: DelayNs> Imu for Bmi323<S, D> {
    type BusError = S::Error;

    const NAME: &'static str = "BMI323";

    /// Low word of the sensor time, 39.0625 µs a count (§6.1.2, `sensor_time_0`): it wraps after 2.56 s.
    const CLOCK: SensorClock = SensorClock { bits: 16, count_ps: 39_062_500, period_ns: 5_000_000 };

    fn scales() -> Scales {
        Scales {
            accel_mps2: ACCEL.range.scale_g_per_lsb() * GRAVITY_MPS2,
            gyro_rads: GYRO.range.scale_dps_per_lsb().to_radians(),
            // §5.6.3
            temperature_k: 1.0 / 512.0,
            temperature_zero_c: 23.0,
            period_s: 0.005,
            values: FittedOn::Raw,
        }
    }

    /// After the reset, the offsets and gains that a host may write (`acc_dp_off_x` …) have their power-on values.
    async fn set_up(&mut self) -> Result<(), SourceError<S::Error>> {
        self.started = false;
        let mut driver = Driver::new_spi(&mut self.spi);
        driver.init(&mut self.delay).await?;
        driver.set_fifo_config(FIFO, 0).await?;
        driver.set_accel_config(ACCEL).await?;
        driver.set_gyro_config(GYRO).await?;
        driver.flush_fifo().await?;
        match self.first_mismatch().await? {
            Some((register, written, read)) => Err(SourceError::VerifyFailed { register, written, read }),
            None => Ok(()),
        }
    }

    async fn is_set_up(&mut self) -> Result<bool, SourceError<S::Error>> {
        Ok(self.first_mismatch().await?.is_none())
    }

    async fn read(&mut self, batch: &mut Batch) -> Result<(), SourceError<S::Error>> {
        let level = self.driver().fifo_fill_level().await?;
        batch.overrun |= level >= FIFO_WORDS - FRAME_WORDS;
        batch.left = level / FRAME_WORDS;
        let Self { spi, started, .. } = self;
        let take = |frame: &[u8; FRAME], batch: &mut Batch| take(frame, started, batch);
        read_frames(spi, READ_FIFO, DUMMY, batch, take).await.map_err(SourceError::Bus)
    }

    async fn wait_ms(&mut self, ms: u32) {
        self.delay.delay_ms(ms).await;
    }
}

impl<S: SpiDevice, D: DelayNs> Bmi323<S, D> {
    /// Finds the first configured register with a wrong value: its address, the expected and the read value.
    async fn first_mismatch(&mut self) -> Result<Option<(u8, u16, u16)>, SourceError<S::Error>> {
        for (register, should) in CONFIGURATION {
            let is = self.driver().read_word(register).await.map_err(SourceError::Bus)?;
            if is != should {
                return Ok(Some((register, should, is)));
            }
        }
        Ok(None)
    }
}

fn words(bytes: &[u8; FRAME / 2]) -> [i16; 4] {
    let [a, b, c, d, e, f, g, h] = *bytes;
    [[a, b], [c, d], [e, f], [g, h]].map(i16::from_le_bytes)
}

impl<E> From<Error<E>> for SourceError<E> {
    fn from(error: Error<E>) -> Self {
        match error {
            Error::Bus(error) => Self::Bus(error),
            Error::InvalidChipId(id) => Self::WrongPart(id),
            _ => Self::Fatal,
        }
    }
}

//! ICM-42688-P (TDK InvenSense) over SPI. Section numbers refer to its data sheet, DS-000347.

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::spi::{Operation, SpiDevice};
use fos_core::{FittedOn, GRAVITY_MPS2};

use super::registers::{Setting, are_set};
use super::spi_fifo::{FRAME, is_released, read_frames};
use super::{Batch, Imu, SensorClock, SourceError};
use crate::raw::Scales;

/// ±4 g and ±500 dps: 32 768 codes each (§3).
const ACCEL_G: f32 = 4.0 / 32_768.0;
const GYRO_DPS: f32 = 500.0 / 32_768.0;

/// Registers of bank 0 (§14).
const DEVICE_CONFIG: u8 = 0x11;
const TEMP_DATA1: u8 = 0x1d;
const FIFO_DATA: u8 = 0x30;
const INTF_CONFIG0: u8 = 0x4c;
const PWR_MGMT0: u8 = 0x4e;
const WHO_AM_I: u8 = 0x75;
const REG_BANK_SEL: u8 = 0x76;

const IDENTITY: u8 = 0x47;

/// Code of 200 Hz in GYRO_CONFIG0 and ACCEL_CONFIG0.
const RATE: u8 = 7;

/// Registers and values of the set-up, in this order: the sensors after their settings, the FIFO last.
const CONFIGURATION: [Setting; 9] = [
    // big-endian data and counts, no I2C
    (INTF_CONFIG0, 0x33),
    // GYRO_CONFIG0: ±500 dps
    (0x4f, 2 << 5 | RATE),
    // ACCEL_CONFIG0: ±4 g
    (0x50, 2 << 5 | RATE),
    // TMST_CONFIG: on, 16 µs, no FSYNC; its bit 5 as after a reset
    (0x54, 1 << 5 | 1 << 3 | 1 << 0),
    // FSYNC_CONFIG: no flag in the data
    (0x62, 0),
    // FIFO_CONFIG1: packets with accelerometers, gyros, temperature and time
    (0x5f, 0x0f),
    // both in low-noise mode, with the thermometer
    (PWR_MGMT0, 0x0f),
    // no FIFO watermark
    (0x60, 0),
    // FIFO_CONFIG: stream, so that new packets overwrite old ones
    (0x16, 1 << 6),
];

/// Number of registers from INTF_CONFIG0 to TMST_CONFIG, which are checked in one transfer.
const WATCHED: usize = 9;

/// Delay after the soft reset, ms; 1 ms by the data sheet (DEVICE_CONFIG).
const RESET_MS: u32 = 2;

/// Delay after the sensors were switched on, ms: for 200 µs no register may be written (PWR_MGMT0).
const SWITCH_MS: u32 = 1;

/// Number of registers from the temperature to the number of bytes in the FIFO, read in one transfer.
const STATUS: usize = 19;

/// Bit of INT_STATUS.
const FIFO_FULL: u8 = 1 << 1;

/// Header of a packet with accelerometers, gyros and ODR timestamp; the last two bits note a change of a rate (§6.1).
const HEADER: u8 = 1 << 6 | 1 << 5 | 1 << 3;
const RATE_CHANGED: u8 = 3;

/// Code of a sensor or thermometer without data (§6.1).
const NOTHING: i16 = i16::MIN;

/// An ICM-42688-P on an SPI bus: ±4 g, ±500 dps, 200 Hz in low-noise mode.
pub struct Icm42688<S, D> {
    spi: S,
    delay: D,
    /// A sample was received since the set-up; from then on every packet has data.
    started: bool,
}

impl<S: SpiDevice, D: DelayNs> Icm42688<S, D> {
    /// Creates the driver; SPI mode 0 or 3, at most 24 MHz.
    pub fn new(spi: S, delay: D) -> Self {
        Self { spi, delay, started: false }
    }

    /// Returns bus and delay for another use; the part continues as it was set up.
    pub fn release(self) -> (S, D) {
        (self.spi, self.delay)
    }

    async fn read_registers(&mut self, first: u8, bytes: &mut [u8]) -> Result<(), SourceError<S::Error>> {
        let command = [0x80 | first];
        let mut read = [Operation::Write(&command), Operation::Read(bytes)];
        self.spi.transaction(&mut read).await.map_err(SourceError::Bus)
    }

    async fn write(&mut self, register: u8, value: u8) -> Result<(), SourceError<S::Error>> {
        self.spi.write(&[register, value]).await.map_err(SourceError::Bus)
    }
}

/// Takes a packet; its own temperature has 8 bits only.
fn take(packet: &[u8; FRAME], temperature: Option<i16>, started: &mut bool, batch: &mut Batch) {
    let [header, a, b, c, d, e, f, g, h, i, j, k, l, rest @ ..] = *packet;
    let [_, high, low] = rest;
    let accel = [[a, b], [c, d], [e, f]].map(i16::from_be_bytes);
    let gyro = [[g, h], [i, j], [k, l]].map(i16::from_be_bytes);
    let is_starting = accel == [NOTHING; 3] || gyro == [NOTHING; 3];
    if header & !RATE_CHANGED != HEADER || is_released(&rest) || (is_starting && *started) {
        batch.tear();
        return;
    }
    if !is_starting {
        *started = true;
        batch.push(accel, gyro, temperature, u32::from(u16::from_be_bytes([high, low])));
    }
}

#[cfg(feature = "defmt")]
impl<S, D> defmt::Format for Icm42688<S, D> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Icm42688 {{ started: {=bool} }}", self.started);
    }
}

impl<S: SpiDevice, D: DelayNs> Imu for Icm42688<S, D> {
    type BusError = S::Error;

    const NAME: &'static str = "ICM-42688-P";

    /// Timestamp of a packet: 16 µs per count, times 32/30 without an external clock (§12.7); it wraps after 1.12 s.
    const CLOCK: SensorClock = SensorClock { bits: 16, count_ps: 17_066_667, period_ns: 5_000_000 };

    fn scales() -> Scales {
        Scales {
            accel_mps2: ACCEL_G * GRAVITY_MPS2,
            gyro_rads: GYRO_DPS.to_radians(),
            // §4.13
            temperature_k: 1.0 / 132.48,
            temperature_zero_c: 25.0,
            period_s: 0.005,
            values: FittedOn::Raw,
        }
    }

    /// After the reset, the offsets that a host may write (OFFSET_USER0 …) have their power-on values.
    async fn set_up(&mut self) -> Result<(), SourceError<S::Error>> {
        self.started = false;
        // its identity is in bank 0
        self.write(REG_BANK_SEL, 0).await?;
        let mut id = [0];
        self.read_registers(WHO_AM_I, &mut id).await?;
        let [id] = id;
        if id != IDENTITY {
            return Err(SourceError::WrongPart(id));
        }
        self.write(DEVICE_CONFIG, 1).await?;
        self.delay.delay_ms(RESET_MS).await;
        for (register, value) in CONFIGURATION {
            self.write(register, value).await?;
            if register == PWR_MGMT0 {
                self.delay.delay_ms(SWITCH_MS).await;
            }
        }
        for (register, written) in CONFIGURATION {
            let mut read = [0];
            self.read_registers(register, &mut read).await?;
            let [read] = read;
            if read != written {
                let (written, read) = (u16::from(written), u16::from(read));
                return Err(SourceError::VerifyFailed { register, written, read });
            }
        }
        Ok(())
    }

    async fn is_set_up(&mut self) -> Result<bool, SourceError<S::Error>> {
        let mut read = [0; WATCHED];
        self.read_registers(INTF_CONFIG0, &mut read).await?;
        Ok(are_set(&CONFIGURATION, INTF_CONFIG0, &read))
    }

    async fn read(&mut self, batch: &mut Batch) -> Result<(), SourceError<S::Error>> {
        let mut status = [0; STATUS];
        self.read_registers(TEMP_DATA1, &mut status).await?;
        let [high, low, .., int_status, count_high, count_low] = status;
        let temperature = Some(i16::from_be_bytes([high, low])).filter(|code| *code != NOTHING);
        batch.overrun |= int_status & FIFO_FULL != 0;
        batch.left = u16::from_be_bytes([count_high, count_low]) / FRAME as u16;
        let Self { spi, started, .. } = self;
        let take = |packet: &[u8; FRAME], batch: &mut Batch| take(packet, temperature, started, batch);
        read_frames(spi, 0x80 | FIFO_DATA, 0, batch, take).await.map_err(SourceError::Bus)
    }

    async fn wait_ms(&mut self, ms: u32) {
        self.delay.delay_ms(ms).await;
    }
}

//! Six-axis parts of STMicroelectronics over I2C: set-up, and assembly of the words in their FIFO.

use core::marker::PhantomData;

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;
use fos_core::FittedOn;

use super::registers::{Setting, are_set};
use super::{Batch, Imu, SensorClock, SourceError};
use crate::raw::Scales;

/// ±4 g: 0.122 mg/LSB (LA_So).
const ACCEL_MG: f32 = 0.122;

/// ±500 dps: 17.5 mdps/LSB (G_So).
const GYRO_MDPS: f32 = 17.5;

/// Registers at the same address in all of these parts.
const FIFO_CTRL1: u8 = 0x07;
const INT1_CTRL: u8 = 0x0d;
const WHO_AM_I: u8 = 0x0f;
const FIFO_DATA_OUT_TAG: u8 = 0x78;

/// Number of registers from FIFO_CTRL1 to CTRL10, which are checked in one transfer.
const WATCHED: usize = 19;

/// Bits of FIFO_STATUS2: the FIFO overruns, or did since the status was read.
const OVERRUN: u8 = 1 << 6 | 1 << 3;

/// Bytes of a FIFO word: a tag and six bytes of data.
const WORD: usize = 7;

/// Words per transfer: 224 bytes, because some I2C peripherals count to 255 at most.
const WORDS: usize = 32;

/// Words per sample: accelerometers, gyros, timestamp. Temperatures come in addition.
const WORDS_PER_SAMPLE: usize = 3;

/// Samples in the FIFO, since it was read, at which the interrupt pin rises: 50 ms at 200 Hz.
pub const INTERRUPT_SAMPLES: u8 = 10;

/// Settings of the interrupt pin INT1, which rises with the watermark of the FIFO. Temperatures, of which there is at most one
/// within that many samples, do not reach it earlier.
const INTERRUPT: [Setting; 2] =
    [(FIFO_CTRL1, INTERRUPT_SAMPLES * WORDS_PER_SAMPLE as u8), (INT1_CTRL, 1 << 3)];

/// Most transfers per poll: 256 words, even if most are unusable.
const TRANSFERS: usize = 8;

/// Tags of FIFO words, without their counter.
const GYRO: u8 = 0x01;
const ACCEL: u8 = 0x02;
const TEMPERATURE: u8 = 0x03;
const TIMESTAMP: u8 = 0x04;

/// Samples for which a temperature stays valid, 1 s; a new one comes at least every 17 samples.
const TEMPERATURE_AGE: u8 = 200;

/// Lowest of the three codes that DRDY_MASK puts into the FIFO, on all axes, while a filter settles.
const UNSETTLED: i16 = 0x7ffd;

/// I2C address, set by the connection of SDO/SA0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Address {
    /// Ground: 0x6a.
    Low,
    /// The supply: 0x6b.
    High,
}

/// Differences between the parts, with the values of their registers.
pub trait StPart {
    /// Name of the part in its data sheet.
    const NAME: &'static str;
    /// Clock of the timestamps.
    const CLOCK: SensorClock;
    /// Answer to WHO_AM_I.
    const IDENTITY: u8;
    /// Writes that reset the part.
    const RESET: &'static [Setting];
    /// Delay after the reset, ms.
    const BOOT_MS: u32;
    /// Set-up, in this order: the rates after the settings that they drive, the FIFO last, so that it holds no earlier
    /// data.
    const CONFIGURATION: &'static [Setting];
    /// Address of FIFO_STATUS1; FIFO_STATUS2 follows.
    const FIFO_STATUS1: u8;
    /// High bits of the number of words, in FIFO_STATUS2.
    const HIGH_LEVEL: u8;
}

/// A part `P` on an I2C bus: ±4 g, ±500 dps.
pub struct St<P, B, D> {
    i2c: B,
    address: u8,
    delay: D,
    /// Settings of the interrupt pin, if it is used.
    interrupt: &'static [Setting],
    assembler: Assembler,
    part: PhantomData<P>,
}

impl<P: StPart, B: I2c, D: DelayNs> St<P, B, D> {
    /// Creates the driver.
    pub fn new(i2c: B, address: Address, delay: D) -> Self {
        let address = match address {
            Address::Low => 0x6a,
            Address::High => 0x6b,
        };
        Self { i2c, address, delay, interrupt: &[], assembler: Assembler::new(), part: PhantomData }
    }

    /// Lets INT1 rise when [`INTERRUPT_SAMPLES`] samples were taken since the FIFO was read, so that the application can
    /// sleep until then. The pin falls when they are read.
    #[must_use]
    pub fn with_interrupt(self) -> Self {
        Self { interrupt: &INTERRUPT, ..self }
    }

    /// Set-up in its order: the FIFO last.
    fn settings(&self) -> impl Iterator<Item = &'static Setting> + use<P, B, D> {
        self.interrupt.iter().chain(P::CONFIGURATION)
    }

    /// Returns bus and delay for another use; the part continues as it was set up.
    pub fn release(self) -> (B, D) {
        (self.i2c, self.delay)
    }

    async fn read_registers(&mut self, first: u8, bytes: &mut [u8]) -> Result<(), SourceError<B::Error>> {
        self.i2c.write_read(self.address, &[first], bytes).await.map_err(SourceError::Bus)
    }

    async fn write(&mut self, register: u8, value: u8) -> Result<(), SourceError<B::Error>> {
        self.i2c.write(self.address, &[register, value]).await.map_err(SourceError::Bus)
    }
}

#[cfg(feature = "defmt")]
impl<P: StPart, B, D> defmt::Format for St<P, B, D> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=str}", P::NAME);
    }
}

impl<P: StPart, B: I2c, D: DelayNs> Imu for St<P, B, D> {
    type BusError = B::Error;

    const NAME: &'static str = P::NAME;
    const CLOCK: SensorClock = P::CLOCK;

    /// "Mechanical characteristics" and "Temperature sensor characteristics" of the data sheets, the same for all parts.
    fn scales() -> Scales {
        Scales {
            accel_mps2: ACCEL_MG * 9.806_65e-3,
            gyro_rads: (GYRO_MDPS * 1e-3).to_radians(),
            temperature_k: 1.0 / 256.0,
            temperature_zero_c: 25.0,
            period_s: const { P::CLOCK.period_ns as f64 / 1e9 },
            values: FittedOn::Raw,
        }
    }

    async fn set_up(&mut self) -> Result<(), SourceError<B::Error>> {
        self.assembler = Assembler::new();
        let mut id = [0];
        self.read_registers(WHO_AM_I, &mut id).await?;
        let [id] = id;
        if id != P::IDENTITY {
            return Err(SourceError::WrongPart(id));
        }
        for (register, value) in P::RESET {
            self.write(*register, *value).await?;
        }
        self.delay.delay_ms(P::BOOT_MS).await;
        for (register, value) in self.settings() {
            self.write(*register, *value).await?;
        }
        for (register, written) in self.settings() {
            let mut read = [0];
            self.read_registers(*register, &mut read).await?;
            let [read] = read;
            if read != *written {
                let (written, read) = (u16::from(*written), u16::from(read));
                return Err(SourceError::VerifyFailed { register: *register, written, read });
            }
        }
        Ok(())
    }

    async fn is_set_up(&mut self) -> Result<bool, SourceError<B::Error>> {
        let mut read = [0; WATCHED];
        self.read_registers(FIFO_CTRL1, &mut read).await?;
        Ok([self.interrupt, P::CONFIGURATION].iter().all(|set| are_set(set, FIFO_CTRL1, &read)))
    }

    async fn read(&mut self, batch: &mut Batch) -> Result<(), SourceError<B::Error>> {
        let mut status = [0; 2];
        self.read_registers(P::FIFO_STATUS1, &mut status).await?;
        let [low, high] = status;
        if high & OVERRUN != 0 {
            batch.overrun = true;
            self.assembler.reset();
        }
        let mut left = usize::from(u16::from_le_bytes([low, high & P::HIGH_LEVEL]));
        for _ in 0..TRANSFERS {
            let words = left.min(batch.room().saturating_mul(WORDS_PER_SAMPLE)).min(WORDS);
            let mut bytes = [0; WORDS * WORD];
            let Some(bytes) = bytes.get_mut(..words * WORD).filter(|bytes| !bytes.is_empty()) else { break };
            // after the last byte of a word the address returns to the tag
            self.read_registers(FIFO_DATA_OUT_TAG, bytes).await?;
            left = left.saturating_sub(words);
            for word in bytes.as_chunks().0 {
                self.assembler.take(word, batch);
            }
        }
        batch.left = (left / WORDS_PER_SAMPLE) as u16;
        Ok(())
    }

    async fn wait_ms(&mut self, ms: u32) {
        self.delay.delay_ms(ms).await;
    }
}

/// Assembles the words of one instant, which have the same two-bit counter and come in any order.
#[derive(Debug)]
struct Assembler {
    slot: Slot,
    temperature: Option<i16>,
    /// Samples since the last temperature.
    temperature_age: u8,
    /// A complete sample was received since the set-up or a loss; from then on all are complete.
    in_step: bool,
}

/// Words received for one instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Slot {
    counter: Option<u8>,
    accel: Option<[i16; 3]>,
    gyro: Option<[i16; 3]>,
    stamp: Option<u32>,
}

impl Slot {
    const EMPTY: Self = Self { counter: None, accel: None, gyro: None, stamp: None };

    const fn new(counter: u8) -> Self {
        Self { counter: Some(counter), ..Self::EMPTY }
    }

    fn has_data(&self) -> bool {
        self.accel.is_some() || self.gyro.is_some() || self.stamp.is_some()
    }
}

impl Assembler {
    const fn new() -> Self {
        Self { slot: Slot::EMPTY, temperature: None, temperature_age: 0, in_step: false }
    }

    /// Discards the current words after a loss: they may not belong to the following ones.
    fn reset(&mut self) {
        (self.slot, self.in_step) = (Slot::EMPTY, false);
    }

    fn take(&mut self, word: &[u8; WORD], batch: &mut Batch) {
        let [tag, xl, xh, yl, yh, zl, zh] = *word;
        // the lowest bit is the parity of some parts
        let (sensor, counter) = (tag >> 3, tag >> 1 & 3);
        let axes = [i16::from_le_bytes([xl, xh]), i16::from_le_bytes([yl, yh]), i16::from_le_bytes([zl, zh])];
        match sensor {
            ACCEL => {
                self.turn_to(counter, |slot| slot.accel.is_some(), batch);
                self.slot.accel = Some(axes);
            }
            GYRO => {
                self.turn_to(counter, |slot| slot.gyro.is_some(), batch);
                self.slot.gyro = Some(axes);
            }
            TIMESTAMP => {
                self.turn_to(counter, |slot| slot.stamp.is_some(), batch);
                self.slot.stamp = Some(u32::from_le_bytes([xl, xh, yl, yh]));
            }
            TEMPERATURE => {
                let [code, ..] = axes;
                (self.temperature, self.temperature_age) = (Some(code), 0);
            }
            // no other tags are batched: the FIFO holds less than its level states, or the word before was cut short
            _ => {
                self.discard(batch);
                batch.tear();
            }
        }
        self.complete(batch);
    }

    /// Begins a new instant if the counter changes or a second word of the same kind arrives.
    fn turn_to(&mut self, counter: u8, has: impl Fn(&Slot) -> bool, batch: &mut Batch) {
        if self.slot.counter == Some(counter) && !has(&self.slot) {
            return;
        }
        self.discard(batch);
        self.slot = Slot::new(counter);
    }

    /// Discards the words of an instant that remains incomplete.
    fn discard(&mut self, batch: &mut Batch) {
        if self.slot.has_data() && self.in_step {
            batch.tear();
        }
        self.slot = Slot::EMPTY;
    }

    /// Adds a frame to the batch once it is complete.
    fn complete(&mut self, batch: &mut Batch) {
        let Slot { accel: Some(accel), gyro: Some(gyro), stamp: Some(stamp), .. } = self.slot else { return };
        self.slot = Slot::EMPTY;
        if [accel, gyro].iter().any(|codes| codes.iter().all(|code| *code >= UNSETTLED)) {
            if self.in_step {
                batch.tear();
            }
            return;
        }
        self.in_step = true;
        let temperature = self.temperature.filter(|_| self.temperature_age < TEMPERATURE_AGE);
        self.temperature_age = self.temperature_age.saturating_add(1);
        batch.push(accel, gyro, temperature, stamp);
    }
}

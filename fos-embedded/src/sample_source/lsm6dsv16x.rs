//! LSM6DSV16X (STMicroelectronics) over I2C. Registers: data sheet DS13510, chapter 9.

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;
use fos_core::FittedOn;
use lsm6dsv16x_rs::asynchronous::prelude::{
    Ctrl1, Ctrl2, Ctrl3, Ctrl4, Ctrl6, Ctrl8, Ctrl9, Error, FifoBatch, FifoCtrl2, FifoCtrl3, FifoCtrl4,
    FifoDataOutTag, FifoMode, FifoStatusReg, FifoTempBatch, FifoTimestampBatch, FuncCfgAccess,
    FunctionsEnable, GyFullScale, GyMode, HaodrCfg, I2CAddress, ID, Lsm6dsv16x as Driver, MainBank, Odr, Reg,
    Tag, XlFullScale, XlMode,
};
use st_mems_bus::asynchronous::{BusOperation, RegisterOperation, SensorOperation, i2c::I2cBus};

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

/// Registers and values of the set-up, in this order: the rates after the settings that they drive, the FIFO last, so that
/// it holds no earlier data. Offsets that a host may write (X_OFS_USR …) are off: CTRL9 is 0.
const CONFIGURATION: [(Reg, u8); 13] = [
    (Reg::FuncCfgAccess, 0),
    (Reg::Ctrl3, Ctrl3::new().with_bdu(1).with_if_inc(1).into_bits()),
    (Reg::Ctrl4, Ctrl4::new().with_drdy_mask(1).into_bits()),
    (Reg::Ctrl6, Ctrl6::new().with_fs_g(GYRO_RANGE).into_bits()),
    (Reg::Ctrl8, Ctrl8::new().with_fs_xl(ACCEL_RANGE).into_bits()),
    (Reg::Ctrl9, Ctrl9::new().into_bits()),
    (Reg::HaodrCfg, HaodrCfg::new().with_haodr_sel(RATE_SET).into_bits()),
    (Reg::FunctionsEnable, FunctionsEnable::new().with_timestamp_en(1).into_bits()),
    (Reg::FifoCtrl2, FifoCtrl2::new().into_bits()),
    // the batching rate has the same code as the data rate
    (Reg::FifoCtrl3, FifoCtrl3::new().with_bdr_xl(BATCH).with_bdr_gy(BATCH).into_bits()),
    (Reg::Ctrl1, Ctrl1::new().with_odr_xl(RATE).with_op_mode_xl(XlMode::HighAccuracyOdrMd as u8).into_bits()),
    (Reg::Ctrl2, Ctrl2::new().with_odr_g(RATE).with_op_mode_g(GyMode::HighAccuracyOdrMd as u8).into_bits()),
    (Reg::FifoCtrl4, FIFO.into_bits()),
];

const BATCH: u8 = FifoBatch::_240hz as u8;

/// New words overwrite old ones; a timestamp with every sample, a temperature 15 times per second.
const FIFO: FifoCtrl4 = FifoCtrl4::new()
    .with_fifo_mode(FifoMode::StreamMode as u8)
    .with_odr_t_batch(FifoTempBatch::_15hz as u8)
    .with_dec_ts_batch(FifoTimestampBatch::Dec1 as u8);

/// Number of registers from FIFO_CTRL1 to CTRL9, which are checked in one transfer.
const WATCHED: usize = Reg::Ctrl9 as usize - Reg::FifoCtrl1 as usize + 1;

/// Bytes of a FIFO word: a tag and six bytes of data.
const WORD: usize = 7;

/// Words per transfer: 224 bytes, because some I2C peripherals count to 255 at most.
const WORDS: usize = 32;

/// Words per sample: accelerometers, gyros, timestamp. Temperatures come in addition.
const WORDS_PER_SAMPLE: usize = 3;

/// Most transfers per poll: 256 words, even if most are unusable; without compression the FIFO holds no more.
const TRANSFERS: usize = 8;

/// Delay after the global reset, ms, as in the manufacturer's driver.
const BOOT_MS: u32 = 50;

/// Samples for which a temperature stays valid, 1 s; a new one comes every 13 samples.
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

/// An LSM6DSV16X on an I2C bus: ±4 g, ±500 dps, 200 Hz in high-accuracy mode.
///
/// One second of samples takes 4.3 kB on the bus, a tenth of the time at 400 kHz.
pub struct Lsm6dsv16x<B: I2c, D: DelayNs> {
    driver: Driver<I2cBus<B>, D, MainBank>,
    assembler: Assembler,
}

impl<B: I2c, D: DelayNs> Lsm6dsv16x<B, D> {
    /// Creates the driver; I2C clock at most 1 MHz, of which 400 kHz is enough.
    pub fn new(i2c: B, address: Address, delay: D) -> Self {
        let address = match address {
            Address::Low => I2CAddress::I2cAddL,
            Address::High => I2CAddress::I2cAddH,
        };
        Self { driver: Driver::new_i2c(i2c, address, delay), assembler: Assembler::new() }
    }

    /// Returns bus and delay for another use; the part continues as it was set up.
    pub fn release(self) -> (B, D) {
        (self.driver.bus.i2c, self.driver.tim)
    }
}

#[cfg(feature = "defmt")]
impl<B: I2c, D: DelayNs> defmt::Format for Lsm6dsv16x<B, D> {
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
        let driver = &mut self.driver;
        self.assembler = Assembler::new();
        let id = driver.device_id_get().await?;
        if id != ID {
            return Err(SourceError::WrongPart(id));
        }
        write(driver, Reg::FuncCfgAccess, FuncCfgAccess::new().with_sw_por(1).into_bits()).await?;
        driver.tim.delay_ms(BOOT_MS).await;
        for (register, written) in CONFIGURATION {
            write(driver, register, written).await?;
        }
        for (register, written) in CONFIGURATION {
            let mut read = [0];
            driver.read_from_register(register as u8, &mut read).await?;
            let [read] = read;
            if read != written {
                let (register, written, read) = (register as u8, u16::from(written), u16::from(read));
                return Err(SourceError::NotKept { register, written, read });
            }
        }
        Ok(())
    }

    async fn is_set_up(&mut self) -> Result<bool, SourceError<B::Error>> {
        let mut read = [0; WATCHED];
        self.driver.read_from_register(Reg::FifoCtrl1 as u8, &mut read).await?;
        Ok(CONFIGURATION.iter().all(|(register, written)| {
            let place = (*register as usize).checked_sub(Reg::FifoCtrl1 as usize);
            // registers outside this range are not checked
            place.and_then(|place| read.get(place)).is_none_or(|read| read == written)
        }))
    }

    async fn read(&mut self, batch: &mut Batch) -> Result<(), SourceError<B::Error>> {
        let status = FifoStatusReg::read(&mut self.driver).await?;
        if status.fifo_ovr_ia() != 0 || status.fifo_ovr_latched() != 0 {
            batch.overrun = true;
            self.assembler.reset();
        }
        let mut left = usize::from(status.diff_fifo());
        for _ in 0..TRANSFERS {
            let words = left.min(batch.room().saturating_mul(WORDS_PER_SAMPLE)).min(WORDS);
            let mut bytes = [0; WORDS * WORD];
            let Some(bytes) = bytes.get_mut(..words * WORD).filter(|bytes| !bytes.is_empty()) else { break };
            // after the last byte of a word the address returns to the tag
            self.driver.read_from_register(Reg::FifoDataOutTag as u8, bytes).await?;
            left = left.saturating_sub(words);
            for word in bytes.as_chunks().0 {
                self.assembler.take(word, batch);
            }
        }
        batch.left = (left / WORDS_PER_SAMPLE) as u16;
        Ok(())
    }

    async fn wait_ms(&mut self, ms: u32) {
        self.driver.tim.delay_ms(ms).await;
    }
}

/// Writes a register without the buffer of 257 bytes that the driver's own function for any length needs.
async fn write<B: I2c, D>(
    driver: &mut Driver<I2cBus<B>, D, MainBank>,
    register: Reg,
    value: u8,
) -> Result<(), SourceError<B::Error>>
where
    D: DelayNs,
{
    driver.bus.write_bytes(&[register as u8, value]).await.map_err(SourceError::Bus)
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
        let tag = FifoDataOutTag::from_bits(tag);
        let counter = tag.tag_cnt();
        let axes = [i16::from_le_bytes([xl, xh]), i16::from_le_bytes([yl, yh]), i16::from_le_bytes([zl, zh])];
        match Tag::try_from(tag.tag_sensor()) {
            Ok(Tag::XlNcTag) => {
                self.turn_to(counter, |slot| slot.accel.is_some(), batch);
                self.slot.accel = Some(axes);
            }
            Ok(Tag::GyNcTag) => {
                self.turn_to(counter, |slot| slot.gyro.is_some(), batch);
                self.slot.gyro = Some(axes);
            }
            Ok(Tag::TimestampTag) => {
                self.turn_to(counter, |slot| slot.stamp.is_some(), batch);
                self.slot.stamp = Some(u32::from_le_bytes([xl, xh, yl, yh]));
            }
            Ok(Tag::TemperatureTag) => {
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

impl<E> From<Error<E>> for SourceError<E> {
    fn from(error: Error<E>) -> Self {
        match error {
            Error::Bus(error) => Self::Bus(error),
            // the called functions return no other error
            _ => Self::Fatal,
        }
    }
}

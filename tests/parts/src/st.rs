//! Registers and FIFO that the six-axis parts of STMicroelectronics have in common.

use core::marker::PhantomData;

use crate::bus::Chip;
use crate::codes::{Sample, at_range};
use crate::sampler::Sampler;

/// Registers at the same address in all of them.
pub(crate) const FUNC_CFG_ACCESS: usize = 0x01;
pub(crate) const FIFO_CTRL1: usize = 0x07;
pub(crate) const FIFO_CTRL2: usize = 0x08;
pub(crate) const FIFO_CTRL3: usize = 0x09;
pub(crate) const FIFO_CTRL4: usize = 0x0a;
pub(crate) const INT1_CTRL: usize = 0x0d;
pub(crate) const WHO_AM_I: usize = 0x0f;
pub(crate) const CTRL1: usize = 0x10;
pub(crate) const CTRL2: usize = 0x11;
pub(crate) const CTRL3: usize = 0x12;
pub(crate) const CTRL4: usize = 0x13;
pub(crate) const STATUS: usize = 0x1e;
const OUT_TEMP: usize = 0x20;
const OUT_GYRO: usize = 0x22;
const OUT_ACCEL: usize = 0x28;
pub(crate) const TIMESTAMP: usize = 0x40;
pub(crate) const FIFO_DATA_OUT_TAG: usize = 0x78;
const FIFO_DATA_OUT_END: usize = 0x7e;

/// Bits of CTRL3 and CTRL4.
const BOOT: u8 = 1 << 7;
const IF_INC: u8 = 1 << 2;
const SW_RESET: u8 = 1 << 0;
const DRDY_MASK: u8 = 1 << 3;

/// Bits of FIFO_CTRL2 and FIFO_CTRL4.
const STOP_ON_WATERMARK: u8 = 1 << 7;
const FIFO_MODE: u8 = 0x07;
const MODE_FIFO: u8 = 1;

/// Tags of FIFO words.
const TAG_GYRO: u8 = 0x01;
const TAG_ACCEL: u8 = 0x02;
const TAG_TEMPERATURE: u8 = 0x03;
const TAG_TIMESTAMP: u8 = 0x04;

/// Codes in the FIFO of a sensor whose filters have not settled, x, y, z, if DRDY_MASK is set.
const UNSETTLED: [i16; 3] = [0x7ffd, 0x7fff, 0x7ffe];

/// Rate and range of a sensor that is on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Setting {
    pub(crate) period_ns: u64,
    /// Sensitivity relative to the source's range of ±4 g or ±500 °/s.
    pub(crate) ratio: f64,
}

/// Differences between the parts.
pub(crate) trait Variant {
    const IDENTITY: u8;
    /// Registers with another reset value than 0.
    const RESET: &'static [(usize, u8)];
    /// Bit of FUNC_CFG_ACCESS that resets the part, 0 for none.
    const POWER_ON_RESET: u8;
    const TICK_NS: u64;
    const FIFO_WORDS: usize;
    /// FIFO_STATUS1; the next one is FIFO_STATUS2.
    const FIFO_STATUS1: usize;
    /// Bits of the watermark in FIFO_CTRL2, and of the level in FIFO_STATUS2.
    const HIGH_WATERMARK: u8;
    const HIGH_LEVEL: u8;
    /// Count of the timestamp, ps.
    const TIMESTAMP_PS: u64;
    /// Register and bit that switch the timestamp on.
    const TIMESTAMP_ENABLE: (usize, u8);
    /// Register and bit that make the interrupt pins active low.
    const ACTIVE_LOW: (usize, u8);
    /// The lowest bit of a tag makes its parity even.
    const TAG_PARITY: bool;
    const THERMOMETER_NS: u64;
    /// Periods of temperatures in the FIFO by ODR_T_BATCH, ns; 0 for none.
    const TEMPERATURE_BATCH_NS: [u64; 4];
    /// Time from power-down until the filters have settled.
    const ACCEL_START_NS: u64;
    const GYRO_START_NS: u64;

    fn accel(registers: &[u8; 128]) -> Option<Setting>;

    fn gyro(registers: &[u8; 128]) -> Option<Setting>;

    /// Period of a batching rate of FIFO_CTRL3, ns; `None` for code 0.
    fn batch_ns(registers: &[u8; 128], code: u8) -> Option<u64>;
}

/// Registers of a part.
#[derive(Debug)]
pub(crate) struct St<V> {
    registers: [u8; 128],
    /// Part time at which each sensor was switched on, ns.
    accel_on_ns: Option<u64>,
    gyro_on_ns: Option<u64>,
    /// Part time at which the timestamp was 0, ns.
    timestamp_ns: u64,
    /// An overrun since the status was read.
    overrun_latched: bool,
    /// Counter of the instants in the FIFO, two bits of the tag.
    instant: u8,
    /// Latest temperature put into the FIFO, which is the one that the host reads with a sample.
    temperature: Option<i16>,
    variant: PhantomData<V>,
}

impl<V: Variant> St<V> {
    fn word(&self, tag: u8, data: [u8; 6]) -> Vec<u8> {
        let mut tag = tag << 3 | (self.instant & 3) << 1;
        if V::TAG_PARITY {
            tag |= (tag.count_ones() % 2) as u8;
        }
        [&[tag][..], &data].concat()
    }

    fn watermark(&self) -> usize {
        usize::from(self.registers[FIFO_CTRL2] & V::HIGH_WATERMARK) << 8
            | usize::from(self.registers[FIFO_CTRL1])
    }

    /// FIFO_STATUS2 without the level: watermark, overrun, full.
    fn fifo_flags(&self, sampler: &Sampler) -> u8 {
        let (level, watermark) = (sampler.fifo.len(), self.watermark());
        let mut flags = 0;
        if watermark > 0 && level >= watermark {
            flags |= 1 << 7;
        }
        if sampler.fifo.overrun && level >= V::FIFO_WORDS {
            flags |= 1 << 6;
        }
        // as the next instant would not fit
        if level + 3 > V::FIFO_WORDS {
            flags |= 1 << 5;
        }
        if self.overrun_latched || sampler.fifo.overrun {
            flags |= 1 << 3;
        }
        flags
    }

    fn timestamp(&self, sampler: &Sampler) -> u32 {
        let (register, bit) = V::TIMESTAMP_ENABLE;
        if self.registers[register] & bit == 0 {
            return 0;
        }
        ((sampler.now_ns - self.timestamp_ns) * 1000 / V::TIMESTAMP_PS) as u32
    }

    /// Period at which a sensor is batched, ns; `None` if it is not.
    fn batched_ns(&self, code: u8, setting: Option<Setting>) -> Option<u64> {
        let batch_ns = V::batch_ns(&self.registers, code)?;
        Some(batch_ns.max(setting?.period_ns))
    }

    fn batch(&mut self, sampler: &mut Sampler, mut codes: Sample, settled: [bool; 2]) {
        let [accel, gyro] = [V::accel(&self.registers), V::gyro(&self.registers)];
        let control = self.registers[FIFO_CTRL4];
        let Some(period_ns) = self.period_ns().filter(|_| control & FIFO_MODE != 0) else { return };
        let rates = self.registers[FIFO_CTRL3];
        let is_due = |period_ns_of: Option<u64>| period_ns_of.is_some_and(|of| sampler.is_due(of, period_ns));
        let batched = [self.batched_ns(rates & 0x0f, accel), self.batched_ns(rates >> 4, gyro)];
        let [accel_due, gyro_due] = batched.map(is_due);
        let stamp_every = [0, 1, 8, 32][usize::from(control >> 6)];
        let fastest_ns = batched.iter().flatten().min();
        let stamp_due = stamp_every > 0 && is_due(fastest_ns.map(|ns| ns * stamp_every));
        let temperature_ns = V::TEMPERATURE_BATCH_NS[usize::from(control >> 4 & 3)];
        let temperature_due = temperature_ns > 0 && is_due(Some(temperature_ns));
        if sampler.faults.silent {
            return;
        }
        codes.accel = at_range(codes.accel, accel.map_or(0.0, |setting| setting.ratio));
        codes.gyro = at_range(codes.gyro, gyro.map_or(0.0, |setting| setting.ratio));
        self.instant = self.instant.wrapping_add(1);
        if temperature_due && !sampler.faults.no_temperature {
            self.temperature = Some(codes.temperature);
        }
        codes.temperature = self.temperature.unwrap_or(i16::MIN);
        let row = (accel_due && gyro_due && settled == [true; 2])
            .then(|| sampler.fifo.record(sampler.tick(), codes));
        let bytes = |codes: [i16; 3]| {
            let [[a, b], [c, d], [e, f]] = codes.map(i16::to_le_bytes);
            [a, b, c, d, e, f]
        };
        let masked = self.registers[CTRL4] & DRDY_MASK != 0;
        let shown =
            |codes: [i16; 3], settled: bool| bytes(if masked && !settled { UNSETTLED } else { codes });
        let [accel_settled, gyro_settled] = settled;
        let mut words = Vec::new();
        if gyro_due {
            words.push((self.word(TAG_GYRO, shown(codes.gyro, gyro_settled)), row));
        }
        if accel_due {
            words.push((self.word(TAG_ACCEL, shown(codes.accel, accel_settled)), row));
        }
        if temperature_due && !sampler.faults.no_temperature {
            words.push((self.word(TAG_TEMPERATURE, bytes([codes.temperature, 0, 0])), None));
        }
        if stamp_due {
            let [a, b, c, d] = self.timestamp(sampler).to_le_bytes();
            words.push((self.word(TAG_TIMESTAMP, [a, b, c, d, 0, 0]), row));
        }
        let stops = control & FIFO_MODE == MODE_FIFO;
        let limit = if self.registers[FIFO_CTRL2] & STOP_ON_WATERMARK != 0 {
            self.watermark()
        } else {
            V::FIFO_WORDS
        };
        for (word, row) in words {
            sampler.fifo.push(word, row, limit.max(1), stops);
        }
    }
}

impl<V: Variant> Chip for St<V> {
    const REGISTER_BYTES: u8 = 1;
    const DUMMY_BYTES: [u8; 2] = [0, 0];
    const STARTS_ON_I2C: bool = false;
    const FIFO_DATA: u8 = FIFO_DATA_OUT_TAG as u8;
    const BOOT_NS: u64 = 10_000_000;
    const TICK_NS: u64 = V::TICK_NS;
    /// 26 °C
    const ROOM: i16 = 256;

    fn new() -> Self {
        let mut registers = [0; 128];
        registers[WHO_AM_I] = V::IDENTITY;
        for (register, value) in V::RESET {
            registers[*register] = *value;
        }
        Self {
            registers,
            accel_on_ns: None,
            gyro_on_ns: None,
            timestamp_ns: 0,
            overrun_latched: false,
            instant: 0,
            temperature: None,
            variant: PhantomData,
        }
    }

    fn read(&mut self, sampler: &mut Sampler, register: u8) -> u16 {
        let register = usize::from(register);
        let level = sampler.fifo.len();
        let value = match register {
            WHO_AM_I => sampler.faults.identity.unwrap_or(self.registers[WHO_AM_I]),
            _ if register == V::FIFO_STATUS1 => level as u8,
            _ if register == V::FIFO_STATUS1 + 1 => {
                let flags = self.fifo_flags(sampler);
                (self.overrun_latched, sampler.fifo.overrun) = (false, false);
                flags | (level >> 8) as u8 & V::HIGH_LEVEL
            }
            OUT_TEMP..OUT_GYRO => {
                self.registers[STATUS] &= !4;
                sampler.temperature(V::THERMOMETER_NS).to_le_bytes()[register - OUT_TEMP]
            }
            OUT_GYRO..OUT_ACCEL => {
                self.registers[STATUS] &= !2;
                self.registers[register]
            }
            OUT_ACCEL..=0x2d => {
                self.registers[STATUS] &= !1;
                self.registers[register]
            }
            TIMESTAMP..=0x43 => self.timestamp(sampler).to_le_bytes()[register - TIMESTAMP],
            FIFO_DATA_OUT_TAG => {
                // the word moves to the output registers; without one they hold zeros
                let word = sampler.fifo.pop().unwrap_or_else(|| vec![0; 7]);
                self.registers[FIFO_DATA_OUT_TAG..=FIFO_DATA_OUT_END].copy_from_slice(&word);
                self.registers[register]
            }
            _ => self.registers[register],
        };
        u16::from(value)
    }

    fn write(&mut self, sampler: &mut Sampler, register: u8, value: u16) -> bool {
        let (register, value) = (usize::from(register), value as u8);
        let resets = (register == CTRL3 && value & SW_RESET != 0)
            || (register == FUNC_CFG_ACCESS && value & V::POWER_ON_RESET != 0);
        if resets {
            return true;
        }
        if register == TIMESTAMP + 2 && value == 0xaa {
            self.timestamp_ns = sampler.now_ns;
            return false;
        }
        let read_only = matches!(register, WHO_AM_I | STATUS | OUT_TEMP..=0x2d | TIMESTAMP..=0x43)
            || register >= FIFO_DATA_OUT_TAG
            || register == V::FIFO_STATUS1
            || register == V::FIFO_STATUS1 + 1;
        if read_only || sampler.faults.forgetful {
            return false;
        }
        let had_timestamp = self.registers[V::TIMESTAMP_ENABLE.0] & V::TIMESTAMP_ENABLE.1 != 0;
        // BOOT clears itself
        self.registers[register] = if register == CTRL3 { value & !BOOT } else { value };
        let now_ns = sampler.now_ns;
        if !had_timestamp {
            self.timestamp_ns = now_ns;
        }
        self.accel_on_ns = V::accel(&self.registers).and(self.accel_on_ns.or(Some(now_ns)));
        self.gyro_on_ns = V::gyro(&self.registers).and(self.gyro_on_ns.or(Some(now_ns)));
        if register == FIFO_CTRL4 && value & FIFO_MODE == 0 {
            // bypass empties the FIFO
            sampler.fifo.clear();
            (self.overrun_latched, sampler.fifo.overrun) = (false, false);
        }
        false
    }

    fn next(&self, register: u8) -> u8 {
        match usize::from(register) {
            _ if self.registers[CTRL3] & IF_INC == 0 => register,
            FIFO_DATA_OUT_END => FIFO_DATA_OUT_TAG as u8,
            _ => (register + 1) & 0x7f,
        }
    }

    fn period_ns(&self) -> Option<u64> {
        let settings = [V::accel(&self.registers), V::gyro(&self.registers)];
        settings.iter().flatten().map(|setting| setting.period_ns).min()
    }

    fn sample(&mut self, sampler: &mut Sampler) {
        let now_ns = sampler.now_ns;
        let settled =
            |on_ns: Option<u64>, start_ns| on_ns.is_some_and(|on_ns: u64| now_ns >= on_ns + start_ns);
        let settled =
            [settled(self.accel_on_ns, V::ACCEL_START_NS), settled(self.gyro_on_ns, V::GYRO_START_NS)];
        let codes = sampler.sample(V::THERMOMETER_NS);
        let masked = self.registers[CTRL4] & DRDY_MASK != 0;
        let triads = [
            (OUT_ACCEL, codes.accel, V::accel(&self.registers), settled[0], 1),
            (OUT_GYRO, codes.gyro, V::gyro(&self.registers), settled[1], 2),
        ];
        for (output, axes, setting, settled, flag) in triads {
            let Some(Setting { ratio, .. }) = setting else { continue };
            for (place, code) in at_range(axes, ratio).into_iter().enumerate() {
                self.registers[output + 2 * place..][..2].copy_from_slice(&code.to_le_bytes());
            }
            if settled || !masked {
                self.registers[STATUS] |= flag;
            }
        }
        if sampler.is_due(V::THERMOMETER_NS, self.period_ns().unwrap_or(V::THERMOMETER_NS)) {
            self.registers[STATUS] |= 4;
        }
        self.batch(sampler, codes, settled);
    }

    /// INT1_CTRL and INT2_CTRL: data ready, FIFO watermark, overrun and full.
    fn interrupt(&self, sampler: &Sampler, pin: u8) -> bool {
        let control = self.registers[INT1_CTRL + usize::from(pin.clamp(1, 2)) - 1];
        let flags = self.fifo_flags(sampler);
        // from bits 5 to 7 of the status to bits 3 to 5 of the control: full, overrun, watermark in reverse
        let fifo = (flags >> 7 & 1) << 3 | (flags >> 6 & 1) << 4 | (flags >> 5 & 1) << 5;
        let active = control & (self.registers[STATUS] & 3 | fifo) != 0;
        let (register, bit) = V::ACTIVE_LOW;
        active != (self.registers[register] & bit != 0)
    }
}

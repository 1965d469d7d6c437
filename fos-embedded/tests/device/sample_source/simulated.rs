//! Both parts, simulated at the level of registers and FIFO, with selectable faults.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{self, I2c};
use embedded_hal::spi::{self, SpiDevice};
use fos_embedded::blocking::Blocking;
use fos_embedded::sample_source::{Address, Bmi323, Imu, Lsm6dsv16x, SampleSource};

/// Sample period of the sensor by its own clock, µs.
pub(crate) const PERIOD_US: f64 = 5000.0;

/// Codes at tick `n`, independent of all other ticks: bias, noise of 8 codes, and 1 g on z.
pub(crate) fn codes(n: u64) -> ([i16; 3], [i16; 3]) {
    let code = |axis: u64| {
        let mut noise = 0.0;
        for draw in 0..12 {
            let mut hash = (n * 6 + axis) * 12 + draw + 1;
            for _ in 0..2 {
                hash = (hash ^ (hash >> 31)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            }
            noise += (hash >> 40) as f64 / 16_777_216.0 - 0.5;
        }
        (BIAS[axis as usize] + 8.0 * noise).round() as i16
    };
    ([code(0), code(1), code(2)], [code(3), code(4), code(5)])
}

/// Mean codes at rest, in the order of axes of a hub.
pub(crate) const BIAS: [f64; 6] = [60.0, -40.0, 8192.0, 25.0, -35.0, 10.0];

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    Lsm6dsv16x,
    Bmi323,
}

/// Faults of the sensor or of the bus.
#[derive(Debug, Clone, Default)]
pub(crate) struct Trouble {
    /// Number of following transfers that fail.
    pub(crate) failing: u32,
    /// Number of following FIFO bursts that end early and lose the rest.
    pub(crate) short: u32,
    /// The identity is that of another part.
    pub(crate) other_part: bool,
    /// The codes are stuck.
    pub(crate) stuck: bool,
    /// The thermometer has no valid value.
    pub(crate) no_temperature: bool,
    /// The FIFO stays empty.
    pub(crate) silent: bool,
    /// Registers do not hold written values.
    pub(crate) forgetful: bool,
}

/// A sensor with its bus and the time.
#[derive(Debug)]
pub(crate) struct Chip {
    kind: Kind,
    pub(crate) now_us: f64,
    /// Rate of its clock relative to the nominal one.
    pub(crate) fast: f64,
    next_tick_us: f64,
    /// Ticks since its creation.
    pub(crate) tick: u64,
    /// Ticks since the last reset.
    since_reset: u64,
    /// Samples since the start; the first ones have no data.
    since_start: u32,
    registers: [u16; 256],
    fifo: VecDeque<Vec<u8>>,
    overrun: bool,
    held: Option<([i16; 3], [i16; 3])>,
    pub(crate) trouble: Trouble,
    /// Transfers so far.
    pub(crate) transfers: u64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NoAnswer;

pub(crate) type Shared = Rc<RefCell<Chip>>;

impl Chip {
    pub(crate) fn new(kind: Kind) -> Shared {
        let mut chip = Self {
            kind,
            now_us: 0.0,
            fast: 1.0,
            next_tick_us: 0.0,
            tick: 0,
            since_reset: 0,
            since_start: 0,
            registers: [0; 256],
            fifo: VecDeque::new(),
            overrun: false,
            held: None,
            trouble: Trouble::default(),
            transfers: 0,
        };
        chip.reset();
        Rc::new(RefCell::new(chip))
    }

    /// Returns to the state at power-on.
    pub(crate) fn reset(&mut self) {
        self.registers = [0; 256];
        self.registers[0x12] = 0x04;
        (self.since_reset, self.since_start) = (0, 0);
        self.overrun = false;
        self.fifo.clear();
    }

    /// Lets time pass.
    pub(crate) fn pass(&mut self, us: f64) {
        self.now_us += us;
        while self.next_tick_us <= self.now_us {
            self.next_tick_us += PERIOD_US / self.fast;
            if self.is_running() && !self.trouble.silent {
                self.sample();
            }
            self.tick += 1;
            self.since_reset += 1;
        }
    }

    fn is_running(&self) -> bool {
        let register = |address: usize| self.registers[address];
        match self.kind {
            Kind::Lsm6dsv16x => {
                let stamps = register(0x50) == 0x40;
                stamps && [0x10, 0x11, 0x13, 0x62, 0x0a].map(register) == [0x17, 0x17, 0x08, 2, 0x66]
            }
            Kind::Bmi323 => [0x20, 0x21, 0x36].map(register) == [0x7019, 0x7029, 0x0f00],
        }
    }

    fn sample(&mut self) {
        let (accel, gyro) = match self.held {
            Some(held) if self.trouble.stuck => held,
            _ => codes(self.tick),
        };
        self.held = Some((accel, gyro));
        let starts = self.since_start < 3;
        self.since_start += 1;
        let bytes = |codes: [i16; 3]| codes.map(i16::to_le_bytes).concat();
        match self.kind {
            Kind::Lsm6dsv16x => {
                let tag = |sensor: u8| vec![sensor << 3 | (self.since_reset as u8 & 3) << 1];
                let stamp = (self.since_reset as f64 * 230.4) as u64 as u32;
                let gyro = if starts { [0x7ffe; 3] } else { gyro };
                let mut words = vec![[tag(1), bytes(gyro)].concat(), [tag(2), bytes(accel)].concat()];
                if self.since_reset.is_multiple_of(13) && !self.trouble.no_temperature {
                    words.push([tag(3), bytes([256, 0, 0])].concat());
                }
                words.push([tag(4), stamp.to_le_bytes().to_vec(), vec![0, 0]].concat());
                words.into_iter().for_each(|word| self.push(word, 256));
            }
            Kind::Bmi323 => {
                let temperature = if self.trouble.no_temperature { i16::MIN } else { 1024 };
                let stamp = (self.since_reset * 128 + 9) as u16;
                let rest = bytes([temperature, stamp as i16, 0]);
                let mut frame = [bytes(accel), bytes(gyro), rest[..4].to_vec()].concat();
                if starts {
                    frame[..2].copy_from_slice(&0x7f01_u16.to_le_bytes());
                }
                self.push(frame, 128);
            }
        }
    }

    fn push(&mut self, item: Vec<u8>, room: usize) {
        if self.fifo.len() == room {
            self.fifo.pop_front();
            self.overrun = true;
        }
        self.fifo.push_back(item);
    }

    /// Reads bytes from the FIFO, filled up with `nothing`.
    fn burst(&mut self, bytes: &mut [u8], item: usize, nothing: &[u8]) {
        let n = bytes.len() / item;
        let whole = if self.trouble.short > 0 { n / 2 } else { n };
        self.trouble.short = self.trouble.short.saturating_sub(1);
        for (index, chunk) in bytes.chunks_mut(item).enumerate() {
            let taken = self.fifo.pop_front().filter(|_| index < whole);
            let taken = taken.unwrap_or_else(|| nothing.repeat(item / nothing.len()));
            chunk.copy_from_slice(&taken[..chunk.len()]);
        }
    }

    fn transfer(&mut self, bytes: usize) -> Result<(), NoAnswer> {
        self.transfers += 1;
        let us_per_byte = if self.kind == Kind::Bmi323 { 1.0 } else { 22.5 };
        self.pass(bytes as f64 * us_per_byte);
        if self.trouble.failing > 0 {
            self.trouble.failing -= 1;
            return Err(NoAnswer);
        }
        Ok(())
    }

    fn write(&mut self, register: u8, value: u16) {
        let reset = match self.kind {
            Kind::Lsm6dsv16x => register == 0x01 && value & 0x04 != 0,
            Kind::Bmi323 => register == 0x7e && value == 0xdeaf,
        };
        let flush = self.kind == Kind::Bmi323 && register == 0x37;
        if reset {
            self.reset();
        } else if flush {
            self.fifo.clear();
        } else if !self.trouble.forgetful {
            self.registers[usize::from(register)] = value;
        }
    }

    fn read(&self, register: u8) -> u16 {
        let level = self.fifo.len() as u16;
        match (self.kind, register) {
            (Kind::Lsm6dsv16x, 0x0f) => 0x70 + u16::from(self.trouble.other_part),
            (Kind::Lsm6dsv16x, 0x1b) => level & 0xff,
            (Kind::Lsm6dsv16x, 0x1c) => level >> 8 | u16::from(self.overrun) << 3,
            (Kind::Bmi323, 0x00) => 0x43 + u16::from(self.trouble.other_part),
            (Kind::Bmi323, 0x15) => level * 8,
            _ => self.registers[usize::from(register)],
        }
    }
}

/// The bus of the LSM6DSV16X.
#[derive(Debug, Clone)]
pub(crate) struct I2cBus(pub(crate) Shared);

impl i2c::Error for NoAnswer {
    fn kind(&self) -> i2c::ErrorKind {
        i2c::ErrorKind::NoAcknowledge(i2c::NoAcknowledgeSource::Address)
    }
}

impl i2c::ErrorType for I2cBus {
    type Error = NoAnswer;
}

impl I2c for I2cBus {
    fn transaction(&mut self, address: u8, operations: &mut [i2c::Operation<'_>]) -> Result<(), NoAnswer> {
        assert_eq!(address, 0x6b);
        let mut chip = self.0.borrow_mut();
        match operations {
            [i2c::Operation::Write([register, values @ ..])] => {
                chip.transfer(2 + values.len())?;
                for (place, value) in (*register..).zip(values.iter()) {
                    chip.write(place, u16::from(*value));
                }
            }
            [i2c::Operation::Write([register]), i2c::Operation::Read(bytes)] => {
                chip.transfer(3 + bytes.len())?;
                if *register == 0x78 {
                    chip.burst(bytes, 7, &[0]);
                } else {
                    for (place, byte) in (*register..).zip(bytes.iter_mut()) {
                        *byte = chip.read(place) as u8;
                    }
                    if *register == 0x1b {
                        chip.overrun = false;
                    }
                }
            }
            other => panic!("{other:?}"),
        }
        Ok(())
    }
}

/// The bus of the BMI323.
#[derive(Debug, Clone)]
pub(crate) struct SpiBus(pub(crate) Shared);

impl spi::Error for NoAnswer {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

impl spi::ErrorType for SpiBus {
    type Error = NoAnswer;
}

impl SpiDevice for SpiBus {
    fn transaction(&mut self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), NoAnswer> {
        let mut chip = self.0.borrow_mut();
        match operations {
            [spi::Operation::Write([register, low, high])] => {
                chip.transfer(3)?;
                chip.write(*register, u16::from_le_bytes([*low, *high]));
            }
            [spi::Operation::Write([command]), spi::Operation::Read(bytes)] => {
                chip.transfer(1 + bytes.len())?;
                let register = *command & 0x7f;
                let (dummy, data) = bytes.split_at_mut(1);
                dummy[0] = 0xa5;
                if register == 0x16 {
                    chip.burst(data, 16, &[0x00, 0x80]);
                } else {
                    for (place, word) in (register..).zip(data.chunks_mut(2)) {
                        word.copy_from_slice(&chip.read(place).to_le_bytes());
                    }
                }
            }
            other => panic!("{other:?}"),
        }
        Ok(())
    }
}

/// A delay during which the sensor continues.
#[derive(Debug, Clone)]
pub(crate) struct Delay(pub(crate) Shared);

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        self.0.borrow_mut().pass(f64::from(ns) / 1000.0);
    }
}

pub(crate) type SimulatedLsm6dsv16x = Lsm6dsv16x<Blocking<I2cBus>, Blocking<Delay>>;
pub(crate) type SimulatedBmi323 = Bmi323<Blocking<SpiBus>, Blocking<Delay>>;

/// A simulated part.
pub(crate) trait Simulated: Imu<BusError = NoAnswer> + Sized {
    const KIND: Kind;

    fn new(chip: &Shared) -> Self;

    fn source() -> (Shared, SampleSource<Self>) {
        let chip = Chip::new(Self::KIND);
        let source = SampleSource::new(Self::new(&chip));
        (chip, source)
    }
}

impl Simulated for SimulatedLsm6dsv16x {
    const KIND: Kind = Kind::Lsm6dsv16x;

    fn new(chip: &Shared) -> Self {
        Self::new(Blocking(I2cBus(chip.clone())), Address::High, Blocking(Delay(chip.clone())))
    }
}

impl Simulated for SimulatedBmi323 {
    const KIND: Kind = Kind::Bmi323;

    fn new(chip: &Shared) -> Self {
        Self::new(Blocking(SpiBus(chip.clone())), Blocking(Delay(chip.clone())))
    }
}

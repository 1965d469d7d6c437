//! Bytes on SPI and I2C, the same for all parts.

use crate::clock::Clock;
use crate::codes::Codes;
use crate::faults::{Fault, Faults};
use crate::fifo::Delivered;
use crate::part::Part;
use crate::sampler::Sampler;

/// Registers and sampling of a part.
pub(crate) trait Chip {
    /// Bytes of a register, the low byte first.
    const REGISTER_BYTES: u8;
    /// Bytes without meaning before the data of a read on SPI and on I2C.
    const DUMMY_BYTES: [u8; 2];
    /// After a reset the part is on I2C until the first rising edge of CS.
    const STARTS_ON_I2C: bool;
    /// Address of the FIFO data.
    const FIFO_DATA: u8;
    /// Time after a reset until the part answers, ns.
    const BOOT_NS: u64;
    /// Length of a tick of the source, ns: the sample period at 200 Hz or the nearest rate.
    const TICK_NS: u64;
    /// Code of the thermometer if the codes are generated.
    const ROOM: i16;

    /// Registers at power-on.
    fn new() -> Self;

    /// Reads a register.
    fn read(&mut self, sampler: &mut Sampler, register: u8) -> u16;

    /// Writes a register; returns true if that resets the part.
    fn write(&mut self, sampler: &mut Sampler, register: u8, value: u16) -> bool;

    /// Register after this one in a burst.
    fn next(&self, register: u8) -> u8;

    /// Sample period, ns; `None` if no sensor is on.
    fn period_ns(&self) -> Option<u64>;

    /// Takes a sample.
    fn sample(&mut self, sampler: &mut Sampler);

    /// Level of an interrupt pin.
    fn interrupt(&self, sampler: &Sampler, pin: u8) -> bool;
}

/// Progress of a transfer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Transfer {
    /// None, or one that is not for this part.
    Idle,
    /// The register address follows.
    Address,
    /// Data are read after some dummy bytes.
    Read { dummies: u8 },
    /// Data are written.
    Write,
}

/// A part behind its bus.
#[derive(Debug)]
pub(crate) struct Model<C> {
    chip: C,
    sampler: Sampler,
    clock: Clock,
    /// Time by the host's clock, ns since power-on.
    host_ns: u64,
    i2c_address: u8,
    transfer: Transfer,
    on_spi: bool,
    /// CS has risen since the last reset.
    cs_rose: bool,
    /// The host's SPI mode is none of the part's; the last bits exchanged, which come a clock edge late.
    late_bits: Option<[u8; 2]>,
    register: u8,
    /// The burst began at the FIFO data.
    from_fifo: bool,
    /// Register being read or written, and the number of its bytes done.
    word: u16,
    done: u8,
}

impl<C: Chip> Model<C> {
    pub(crate) fn new(i2c_address: u8, codes: Codes) -> Self {
        Self {
            chip: C::new(),
            sampler: Sampler::new(codes, C::TICK_NS, C::ROOM),
            clock: Clock::new(),
            host_ns: 0,
            i2c_address,
            transfer: Transfer::Idle,
            on_spi: false,
            cs_rose: !C::STARTS_ON_I2C,
            late_bits: None,
            register: 0,
            from_fifo: false,
            word: 0,
            done: 0,
        }
    }

    fn reset(&mut self) {
        self.chip = C::new();
        self.sampler.fifo.clear();
        self.sampler.fifo.overrun = false;
        self.sampler.fifo.lost = 0;
        self.sampler.reset_ns = self.sampler.now_ns;
        self.transfer = Transfer::Idle;
        self.cs_rose = !C::STARTS_ON_I2C;
    }

    /// Returns true if the part answers a transfer that begins now.
    fn answers(&mut self) -> bool {
        let faults = &mut self.sampler.faults;
        if faults.nack > 0 {
            faults.nack -= 1;
            return false;
        }
        self.host_ns >= faults.unanswered_until_ns && self.sampler.since_reset_ns() >= C::BOOT_NS
    }

    fn begin(&mut self, transfer: Transfer) {
        (self.transfer, self.done) = (transfer, 0);
        self.from_fifo = self.register == C::FIFO_DATA && matches!(transfer, Transfer::Read { .. });
    }

    fn end(&mut self) {
        self.transfer = Transfer::Idle;
        self.sampler.fifo.rewind();
    }

    /// Takes a byte from the host.
    fn take(&mut self, byte: u8) {
        match self.transfer {
            Transfer::Idle | Transfer::Read { .. } => {}
            Transfer::Address if self.on_spi => {
                self.register = byte & 0x7f;
                let [dummies, _] = C::DUMMY_BYTES;
                self.begin(if byte & 0x80 != 0 { Transfer::Read { dummies } } else { Transfer::Write });
            }
            Transfer::Address => {
                self.register = byte & 0x7f;
                self.begin(Transfer::Write);
            }
            Transfer::Write => {
                self.word = if self.done == 0 { u16::from(byte) } else { self.word | u16::from(byte) << 8 };
                self.done += 1;
                if self.done == C::REGISTER_BYTES {
                    self.done = 0;
                    if self.chip.write(&mut self.sampler, self.register, self.word) {
                        self.reset();
                    } else {
                        self.register = self.chip.next(self.register);
                    }
                }
            }
        }
    }

    /// Gives a byte to the host.
    fn give(&mut self) -> u8 {
        match self.transfer {
            Transfer::Read { dummies: 0 } => {
                if self.from_fifo && self.sampler.faults.cut == Some(0) {
                    self.sampler.faults.cut = None;
                    self.end();
                    return 0xff;
                }
                if self.done == 0 {
                    self.word = self.chip.read(&mut self.sampler, self.register);
                }
                let [low, high] = self.word.to_le_bytes();
                let byte = if self.done == 0 { low } else { high };
                if let Some(left) = self.sampler.faults.cut.as_mut().filter(|_| self.from_fifo) {
                    *left = left.saturating_sub(1);
                }
                self.done += 1;
                if self.done == C::REGISTER_BYTES {
                    self.done = 0;
                    self.register = self.chip.next(self.register);
                }
                self.sampler.faults.damage(byte)
            }
            // their content is not specified
            Transfer::Read { dummies } => {
                self.transfer = Transfer::Read { dummies: dummies - 1 };
                self.sampler.faults.damage(0xa5)
            }
            Transfer::Idle | Transfer::Address | Transfer::Write => {
                if self.sampler.faults.stuck_low {
                    0
                } else {
                    0xff
                }
            }
        }
    }
}

impl<C: Chip> Part for Model<C> {
    fn spi_select(&mut self, mode: u8) {
        self.late_bits = matches!(mode, 1 | 2).then_some([0; 2]);
        self.on_spi = true;
        let answers = self.answers() && self.cs_rose;
        self.begin(if answers { Transfer::Address } else { Transfer::Idle });
    }

    fn spi_exchange(&mut self, mosi: u8) -> u8 {
        let Some([late_in, late_out]) = self.late_bits else {
            let miso = self.give();
            self.take(mosi);
            return miso;
        };
        let miso = self.give();
        self.take(late_in << 7 | mosi >> 1);
        self.late_bits = Some([mosi & 1, miso & 1]);
        late_out << 7 | miso >> 1
    }

    fn spi_deselect(&mut self) {
        self.end();
        self.on_spi = false;
        self.cs_rose = true;
    }

    fn i2c_start(&mut self, address: u8, read: bool) -> bool {
        self.end();
        self.on_spi = false;
        if self.sampler.faults.stuck_low {
            return true;
        }
        if self.sampler.faults.stuck_high || address != self.i2c_address || !self.answers() {
            return false;
        }
        let [_, dummies] = C::DUMMY_BYTES;
        self.begin(if read { Transfer::Read { dummies } } else { Transfer::Address });
        true
    }

    fn i2c_write(&mut self, byte: u8) -> bool {
        let listens = self.transfer != Transfer::Idle || self.sampler.faults.stuck_low;
        self.take(byte);
        listens
    }

    fn i2c_read(&mut self, ack: bool) -> u8 {
        let byte = self.give();
        if !ack {
            self.end();
        }
        byte
    }

    fn i2c_stop(&mut self) {
        self.end();
    }

    fn stretch_ns(&self) -> u64 {
        self.sampler.faults.stretch_ns
    }

    fn advance_to(&mut self, ns: u64) {
        self.host_ns = self.host_ns.max(ns);
        let until_ns = self.clock.part_ns(self.host_ns).max(self.sampler.now_ns);
        while let Some(period_ns) = self.chip.period_ns() {
            let samples = self.sampler.since_reset_ns() / period_ns + 1;
            let next_ns = self.sampler.reset_ns + samples * period_ns;
            if next_ns > until_ns {
                break;
            }
            self.sampler.now_ns = next_ns;
            self.chip.sample(&mut self.sampler);
        }
        self.sampler.now_ns = until_ns;
    }

    fn interrupt(&self, pin: u8) -> bool {
        self.sampler.faults.pin.unwrap_or_else(|| self.chip.interrupt(&self.sampler, pin))
    }

    fn fault(&mut self, fault: Fault, value: f64) {
        let (on, count) = (value != 0.0, value as u64);
        let faults = &mut self.sampler.faults;
        match fault {
            Fault::None => {
                *faults = Faults::default();
                self.clock.set_ppm(self.host_ns, 0.0);
            }
            Fault::Nack => faults.nack = count,
            Fault::StuckHigh => faults.stuck_high = on,
            Fault::StuckLow => faults.stuck_low = on,
            Fault::Cut => faults.cut = on.then_some(count),
            Fault::Flip => faults.flip = count,
            Fault::Identity => faults.identity = on.then_some(value as u8),
            Fault::Frozen => faults.frozen = on,
            Fault::NoTemperature => faults.no_temperature = on,
            Fault::Silent => faults.silent = on,
            Fault::Forgetful => faults.forgetful = on,
            Fault::Reset if on => self.reset(),
            Fault::Overrun if on => self.sampler.fifo.overrun(),
            Fault::Reset | Fault::Overrun => {}
            Fault::Ppm => self.clock.set_ppm(self.host_ns, value),
            Fault::Drift => self.clock.set_drift(self.host_ns, value),
            Fault::Pin => faults.pin = on.then_some(value > 1.0),
            Fault::Unanswered => faults.unanswered_until_ns = self.host_ns + count,
            Fault::Stretch => faults.stretch_ns = count,
        }
    }

    fn delivered(&self) -> &[Delivered] {
        self.sampler.fifo.delivered()
    }

    fn tick(&self) -> u64 {
        self.sampler.tick()
    }
}

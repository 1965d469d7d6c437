//! The parts of fos-parts behind the buses of embedded-hal, which take time.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{self, I2c};
use embedded_hal::spi::{self, SpiDevice};
use fos_embedded::blocking::Blocking;
use fos_embedded::sample_source::{Address, Bmi323, Icm42688, Imu, Lsm6dso, Lsm6dsv16x, SampleSource};
use fos_parts::{Codes, Fault, Part};

/// I2C address of the parts.
const ADDRESS: u8 = 0x6b;

/// A part with its bus and the time.
pub(crate) struct Board {
    part: Box<dyn Part>,
    now_ns: u64,
    /// Number of following SPI transfers that the host's own peripheral fails.
    spi_fails: u32,
    is_spi: bool,
    /// Transfers so far.
    pub(crate) transfers: u64,
    /// Faults that begin or end later: time, ns, fault and value.
    scheduled: Vec<(u64, Fault, f64)>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NoAnswer;

pub(crate) type Shared = Rc<RefCell<Board>>;

impl Board {
    pub(crate) fn new<P: Simulated>() -> Shared {
        let part = fos_parts::new(P::PART, ADDRESS, Codes::Generated).expect("a part with this name");
        Rc::new(RefCell::new(Self {
            part,
            now_ns: 0,
            spi_fails: 0,
            is_spi: P::IS_SPI,
            transfers: 0,
            scheduled: Vec::new(),
        }))
    }

    pub(crate) fn now_us(&self) -> f64 {
        self.now_ns as f64 * 1e-3
    }

    /// Lets time pass.
    pub(crate) fn pass(&mut self, us: f64) {
        self.now_ns += (us * 1e3).round() as u64;
        while let Some((at_ns, fault, value)) =
            self.scheduled.first().copied().filter(|due| due.0 <= self.now_ns)
        {
            self.scheduled.remove(0);
            self.part.advance_to(at_ns);
            self.part.fault(fault, value);
        }
        self.part.advance_to(self.now_ns);
    }

    /// Schedules a fault, in the order of time.
    pub(crate) fn schedule(&mut self, at_us: u64, fault: Fault, value: f64) {
        self.scheduled.push((at_us * 1000, fault, value));
    }

    /// Level of interrupt pin 1.
    pub(crate) fn interrupt(&self) -> bool {
        self.part.interrupt(1)
    }

    /// Number of the sensor's present tick.
    pub(crate) fn tick(&self) -> u64 {
        self.part.tick()
    }

    pub(crate) fn fault(&mut self, fault: Fault, value: f64) {
        self.part.fault(fault, value);
    }

    /// Lets the following transfers fail.
    pub(crate) fn fail(&mut self, transfers: u32) {
        if self.is_spi {
            self.spi_fails = transfers;
        } else {
            self.part.fault(Fault::Nack, transfers.into());
        }
    }

    /// A byte on I2C at 400 kHz.
    fn i2c_byte(&mut self) {
        self.pass(22.5 + self.part.stretch_ns() as f64 * 1e-3);
    }

    fn i2c(&mut self, address: u8, operations: &mut [i2c::Operation<'_>]) -> Result<(), NoAnswer> {
        let mut reading = None;
        for operation in operations {
            let read = matches!(operation, i2c::Operation::Read(_));
            if reading != Some(read) {
                self.i2c_byte();
                if !self.part.i2c_start(address, read) {
                    return Err(NoAnswer);
                }
                reading = Some(read);
            }
            match operation {
                i2c::Operation::Write(bytes) => {
                    for byte in *bytes {
                        self.i2c_byte();
                        if !self.part.i2c_write(*byte) {
                            return Err(NoAnswer);
                        }
                    }
                }
                i2c::Operation::Read(bytes) => {
                    let last = bytes.len().saturating_sub(1);
                    for (place, byte) in bytes.iter_mut().enumerate() {
                        self.i2c_byte();
                        *byte = self.part.i2c_read(place < last);
                    }
                }
            }
        }
        Ok(())
    }

    /// Exchanges a byte on SPI at 8 MHz.
    fn spi_byte(&mut self, byte: u8) -> u8 {
        self.pass(1.0);
        self.part.spi_exchange(byte)
    }

    fn spi(&mut self, operation: &mut spi::Operation<'_, u8>) {
        match operation {
            spi::Operation::Write(bytes) => {
                bytes.iter().for_each(|byte| {
                    self.spi_byte(*byte);
                });
            }
            spi::Operation::Read(bytes) => bytes.iter_mut().for_each(|byte| *byte = self.spi_byte(0)),
            spi::Operation::Transfer(read, written) => {
                for (read, written) in read.iter_mut().zip(*written) {
                    *read = self.spi_byte(*written);
                }
            }
            spi::Operation::TransferInPlace(bytes) => {
                bytes.iter_mut().for_each(|byte| *byte = self.spi_byte(*byte));
            }
            spi::Operation::DelayNs(ns) => self.pass(f64::from(*ns) * 1e-3),
        }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct I2cBus(pub(crate) Shared);

impl std::fmt::Debug for Board {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Board at {} ns", self.now_ns)
    }
}

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
        let mut board = self.0.borrow_mut();
        board.transfers += 1;
        let result = board.i2c(address, operations);
        board.part.i2c_stop();
        result
    }
}

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
        let mut board = self.0.borrow_mut();
        board.transfers += 1;
        if board.spi_fails > 0 {
            board.spi_fails -= 1;
            return Err(NoAnswer);
        }
        board.part.spi_select(0);
        operations.iter_mut().for_each(|operation| board.spi(operation));
        board.part.spi_deselect();
        Ok(())
    }
}

/// A delay during which the sensor continues.
#[derive(Debug, Clone)]
pub(crate) struct Delay(pub(crate) Shared);

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        self.0.borrow_mut().pass(f64::from(ns) * 1e-3);
    }
}

pub(crate) type SimulatedLsm6dsv16x = Lsm6dsv16x<Blocking<I2cBus>, Blocking<Delay>>;
pub(crate) type SimulatedLsm6dso = Lsm6dso<Blocking<I2cBus>, Blocking<Delay>>;
pub(crate) type SimulatedBmi323 = Bmi323<Blocking<SpiBus>, Blocking<Delay>>;
pub(crate) type SimulatedIcm42688 = Icm42688<Blocking<SpiBus>, Blocking<Delay>>;

/// A driver of a simulated part.
pub(crate) trait Simulated: Imu<BusError = NoAnswer> + Sized {
    /// Name of the part in fos-parts.
    const PART: &'static str;
    const IS_SPI: bool;

    fn new(board: &Shared) -> Self;

    fn source() -> (Shared, SampleSource<Self>) {
        let board = Board::new::<Self>();
        let source = SampleSource::new(Self::new(&board));
        (board, source)
    }
}

/// Defines the parts on a bus.
macro_rules! simulated {
    ($($name:literal: $part:ident, $is_spi:literal, $bus:ident $(, $address:expr)?;)*) => {$(
        impl Simulated for $part<Blocking<$bus>, Blocking<Delay>> {
            const PART: &'static str = $name;
            const IS_SPI: bool = $is_spi;

            fn new(board: &Shared) -> Self {
                Self::new(Blocking($bus(board.clone())), $($address,)? Blocking(Delay(board.clone())))
            }
        }
    )*};
}

simulated! {
    "lsm6dsv16x": Lsm6dsv16x, false, I2cBus, Address::High;
    "lsm6dso": Lsm6dso, false, I2cBus, Address::High;
    "bmi323": Bmi323, true, SpiBus;
    "icm42688": Icm42688, true, SpiBus;
}

/// Calls a generic function for every part.
macro_rules! for_every_part {
    ($function:ident($($argument:expr),*)) => {
        $function::<SimulatedLsm6dsv16x>($($argument),*);
        $function::<SimulatedLsm6dso>($($argument),*);
        $function::<SimulatedBmi323>($($argument),*);
        $function::<SimulatedIcm42688>($($argument),*);
    };
}
pub(crate) use for_every_part;

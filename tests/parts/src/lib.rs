//! Register models of inertial sensors, byte by byte as a driver sees them on SPI or I2C.
//!
//! A part plays codes, generated or from a log, at the rate of its own clock. It records the codes that it put into its
//! FIFO ([`Part::delivered`]), so that a test can compute the expected output. Faults of part, bus and clock are injected
//! with [`Part::fault`]. Time passes only in [`Part::advance_to`].
//!
//! | part | data sheet | bus |
//! |---|---|---|
//! | BMI323 | BST-BMI323-DS000 | SPI, I2C |
//! | LSM6DSV16X | DS13510 | SPI, I2C |
//! | LSM6DSO | DS12140 | SPI, I2C |
//! | ICM-42688-P | DS-000347 | SPI, I2C |
//!
//! Modelled are the registers of the data path: identity, reset, power modes, rates, ranges, FIFO, interrupts, temperature
//! and time. Embedded functions (steps, taps, self-test) only store what is written to them.
//!
//! The same models are a C library, see [`c`].

mod bmi323;
mod bus;
pub mod c;
mod clock;
mod codes;
mod faults;
mod fifo;
mod icm42688;
mod lsm6dso;
mod lsm6dsv16x;
mod sampler;
mod st;

pub use codes::{BIAS, Codes, Sample, generated};
pub use faults::Fault;
pub use fifo::{Delivered, Fate};

use bus::Model;

/// A sensor behind its bus.
///
/// Both buses lead to the same registers. Bytes take no time: [`advance_to`](Self::advance_to) sets the time before each.
pub trait Part {
    /// Selects the part on SPI: CS falls. `mode` is the SPI mode of the host, 0 to 3; the parts understand 0 and 3.
    fn spi_select(&mut self, mode: u8);

    /// Exchanges a byte on SPI; a part that does not drive its output leaves it high.
    fn spi_exchange(&mut self, mosi: u8) -> u8;

    /// Deselects the part on SPI: CS rises.
    fn spi_deselect(&mut self);

    /// Starts or restarts a transfer on I2C with a 7-bit address; returns true if the part acknowledges.
    fn i2c_start(&mut self, address: u8, read: bool) -> bool;

    /// Writes a byte on I2C; returns true if the part acknowledges.
    fn i2c_write(&mut self, byte: u8) -> bool;

    /// Reads a byte on I2C; the host acknowledges all but the last.
    fn i2c_read(&mut self, ack: bool) -> u8;

    /// Stops the transfer on I2C.
    fn i2c_stop(&mut self);

    /// Time for which the part holds SCL low after each byte on I2C, ns.
    fn stretch_ns(&self) -> u64;

    /// Lets time pass until `ns` after power-on by the host's clock; earlier times are ignored.
    fn advance_to(&mut self, ns: u64);

    /// Level of an interrupt pin, 1 or 2; true is high. A pin that is not driven is low.
    fn interrupt(&self, pin: u8) -> bool;

    /// Begins a fault, or ends it with 0; see [`Fault`] for the meaning of `value`.
    fn fault(&mut self, fault: Fault, value: f64);

    /// Codes put into the FIFO so far, one row per tick, oldest first.
    fn delivered(&self) -> &[Delivered];

    /// Number of the source's ticks that have passed since power-on.
    fn tick(&self) -> u64;
}

/// Names of the parts that [`new`] creates.
pub const NAMES: [&str; 4] = ["bmi323", "lsm6dsv16x", "lsm6dso", "icm42688"];

/// Creates a part at power-on by its name in small letters, with its I2C address; `None` for an unknown name.
pub fn new(name: &str, address: u8, codes: Codes) -> Option<Box<dyn Part>> {
    Some(match name {
        "bmi323" => Box::new(Model::<bmi323::Bmi323>::new(address, codes)),
        "lsm6dsv16x" => Box::new(Model::<st::St<lsm6dsv16x::Lsm6dsv16x>>::new(address, codes)),
        "lsm6dso" => Box::new(Model::<st::St<lsm6dso::Lsm6dso>>::new(address, codes)),
        "icm42688" => Box::new(Model::<icm42688::Icm42688>::new(address, codes)),
        _ => return None,
    })
}

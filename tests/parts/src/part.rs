//! Interface of a part.

use crate::faults::Fault;
use crate::fifo::Delivered;

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

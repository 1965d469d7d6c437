//! Register models of inertial sensors, byte by byte as a driver sees them on SPI or I2C.
//!
//! A part plays codes, generated or from a log, at the rate of the part's clock. It records the codes that it put into its
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
//! No model was compared with a part. Least certain are the start-up times, the reset values of the BMI323's configuration
//! registers, the register map of the LSM6DSO, and the factor 32/30 of the ICM-42688-P's timestamps.
//!
//! Assumed, where a data sheet gives no value: start-up times and the rate of the thermometer are typical ones of the maker's
//! parts; a frame that was read in part is sent again from its beginning; samples fall on multiples of their period since
//! the last reset; a data-ready signal lasts until its status or the FIFO is read.
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
mod part;
mod sampler;
mod st;

pub use codes::{BIAS, Codes, Sample, generated};
pub use faults::Fault;
pub use fifo::{Delivered, Fate};
pub use part::Part;

use bus::Model;

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

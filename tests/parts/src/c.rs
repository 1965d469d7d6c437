//! The models as a C library, `libfos_parts.so`, for emulators in other languages.
//!
//! ```c
//! // Creates a part at power-on: "bmi323", "lsm6dsv16x", "lsm6dso", "icm42688". `log` has `rows` rows of 7 codes:
//! // accelerometers x, y, z at ±4 g, gyros x, y, z at ±500 °/s, temperature; one row per sample period; repeated at its
//! // end; copied. NULL: generated codes. Returns NULL for an unknown name.
//! Part *parts_new(const char *name, uint8_t i2c_address, const int16_t *log, size_t rows);
//! void parts_free(Part *part);
//!
//! // SPI: `mode` 0 to 3, the parts understand 0 and 3. Select, exchange every byte, deselect.
//! void parts_spi_select(Part *part, uint8_t mode);
//! uint8_t parts_spi_exchange(Part *part, uint8_t mosi);
//! void parts_spi_deselect(Part *part);
//!
//! // I2C: 7-bit addresses; start and write return whether the part acknowledges; `ack` is false for the last byte read.
//! bool parts_i2c_start(Part *part, uint8_t address, bool read);
//! bool parts_i2c_write(Part *part, uint8_t byte);
//! uint8_t parts_i2c_read(Part *part, bool ack);
//! void parts_i2c_stop(Part *part);
//! // Time for which the part holds SCL low after each byte, ns.
//! uint64_t parts_stretch_ns(const Part *part);
//!
//! // Lets time pass until `ns` after power-on by the host's clock. Bytes take no time: call it before each transfer.
//! void parts_advance_to(Part *part, uint64_t ns);
//! // Level of interrupt pin 1 or 2.
//! bool parts_interrupt(const Part *part, uint8_t pin);
//! // Begins a fault, or ends it with 0; numbers and values as in `Fault`. Returns false for an unknown number.
//! bool parts_fault(Part *part, uint32_t fault, double value);
//!
//! // Copies the record of the codes put into the FIFO from row `from` on; returns the number of rows copied. A row: tick,
//! // accelerometers x, y, z, gyros x, y, z, temperature, and 0 if still in the FIFO, 1 if read, 2 if lost.
//! size_t parts_delivered(const Part *part, size_t from, int32_t (*rows)[9], size_t capacity);
//! // Sample periods since power-on by the part's clock.
//! uint64_t parts_tick(const Part *part);
//! ```
//!
//! `part` must come from `parts_new` and must not be used after `parts_free`; a part may move between threads, but is used
//! by one at a time.

use core::ffi::{CStr, c_char};

use crate::{Codes, Fate, Fault, Part, Sample};

/// A part, behind a pointer that C can hold.
pub struct Handle(Box<dyn Part>);

/// Columns of [`parts_delivered`].
pub const DELIVERED_COLUMNS: usize = 9;

/// Creates a part at power-on; null for an unknown name.
///
/// # Safety
///
/// `name` must be a string that ends with 0; `log` must be null or point to `rows` rows of 7 codes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn parts_new(
    name: *const c_char,
    i2c_address: u8,
    log: *const [i16; 7],
    rows: usize,
) -> *mut Handle {
    // SAFETY: required of the caller
    let name = unsafe { CStr::from_ptr(name) }.to_str().unwrap_or("");
    let codes = if log.is_null() || rows == 0 {
        Codes::Generated
    } else {
        // SAFETY: required of the caller
        let rows = unsafe { core::slice::from_raw_parts(log, rows) };
        let sample = |&[ax, ay, az, gx, gy, gz, temperature]: &[i16; 7]| Sample {
            accel: [ax, ay, az],
            gyro: [gx, gy, gz],
            temperature,
        };
        Codes::Log(rows.iter().map(sample).collect())
    };
    crate::new(name, i2c_address, codes)
        .map_or(core::ptr::null_mut(), |part| Box::into_raw(Box::new(Handle(part))))
}

/// Frees a part; null is ignored.
///
/// # Safety
///
/// `part` must come from [`parts_new`] and must not be used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn parts_free(part: *mut Handle) {
    if !part.is_null() {
        // SAFETY: made by `parts_new`, and freed once
        drop(unsafe { Box::from_raw(part) });
    }
}

/// Defines functions that pass on to the method of [`Part`] with the same name.
macro_rules! pass_on {
    ($($name:ident => $method:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*) => {$(
        #[doc = concat!("Calls [`Part::", stringify!($method), "`].")]
        ///
        /// # Safety
        ///
        /// `part` must come from [`parts_new`].
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(part: *mut Handle, $($argument: $type),*) $(-> $result)? {
            // SAFETY: required of the caller
            unsafe { &mut *part }.0.$method($($argument),*)
        }
    )*};
}

pass_on! {
    parts_spi_select => spi_select(mode: u8);
    parts_spi_exchange => spi_exchange(mosi: u8) -> u8;
    parts_spi_deselect => spi_deselect();
    parts_i2c_start => i2c_start(address: u8, read: bool) -> bool;
    parts_i2c_write => i2c_write(byte: u8) -> bool;
    parts_i2c_read => i2c_read(ack: bool) -> u8;
    parts_i2c_stop => i2c_stop();
    parts_stretch_ns => stretch_ns() -> u64;
    parts_advance_to => advance_to(ns: u64);
    parts_interrupt => interrupt(pin: u8) -> bool;
    parts_tick => tick() -> u64;
}

/// Calls [`Part::fault`]; returns false for an unknown number.
///
/// # Safety
///
/// `part` must come from [`parts_new`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn parts_fault(part: *mut Handle, fault: u32, value: f64) -> bool {
    let Some(fault) = Fault::from_number(fault) else { return false };
    // SAFETY: required of the caller
    unsafe { &mut *part }.0.fault(fault, value);
    true
}

/// Copies rows of [`Part::delivered`] from `from` on; returns their number.
///
/// # Safety
///
/// `part` must come from [`parts_new`]; `rows` must have room for `capacity` rows.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn parts_delivered(
    part: *const Handle,
    from: usize,
    rows: *mut [i32; DELIVERED_COLUMNS],
    capacity: usize,
) -> usize {
    // SAFETY: required of the caller
    let delivered = unsafe { &*part }.0.delivered();
    let delivered = delivered.get(from..).unwrap_or_default();
    let copied = delivered.len().min(capacity);
    for (index, row) in delivered[..copied].iter().enumerate() {
        let Sample { accel: [ax, ay, az], gyro: [gx, gy, gz], temperature } = row.codes;
        let [ax, ay, az, gx, gy, gz, temperature] = [ax, ay, az, gx, gy, gz, temperature].map(i32::from);
        let fate = match row.fate {
            Fate::Queued => 0,
            Fate::Read => 1,
            Fate::Lost => 2,
        };
        // SAFETY: within the capacity, required of the caller
        unsafe { *rows.add(index) = [row.tick as i32, ax, ay, az, gx, gy, gz, temperature, fate] };
    }
    copied
}

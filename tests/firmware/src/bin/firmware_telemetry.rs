//! Telemetry that a firmware of fos-embedded/examples must send for the codes that its sensor delivered.
//!
//! ```text
//! firmware_telemetry FIRMWARE IMAGE CODES TELEMETRY
//! ```
//!
//! FIRMWARE is rp2040 or nrf52840. IMAGE is the model image in the flash, or `-` for none. CODES has 18 bytes for every sample,
//! little-endian: the ticks without a sample before it (u32), then the codes of accelerometers, gyros and thermometer (i16 × 7; −32768
//! for a temperature that is not known). TELEMETRY is written.

use std::error::Error;
use std::fs;

use fos_core::{Fixed, Scalar};
use fos_embedded::blocking::Blocking;
use fos_embedded::raw::{Faults, RawSample, Scales};
use fos_embedded::sample_source::{Bmi323, Imu, Lsm6dsv16x};

#[path = "../../../../fos-embedded/examples/device/telemetry.rs"]
mod telemetry;

use telemetry::{DeviceHub, Telemetry};

/// A collected stream.
struct Collected<'a>(&'a mut Vec<u8>);

impl embedded_io::ErrorType for Collected<'_> {
    type Error = core::convert::Infallible;
}

impl embedded_io::Write for Collected<'_> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        self.0.extend(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }
}

/// A bus that is never used: the scales of the part depend on its type only.
struct NoBus;

impl embedded_hal::spi::ErrorType for NoBus {
    type Error = core::convert::Infallible;
}

impl embedded_hal::spi::SpiDevice for NoBus {
    fn transaction(&mut self, _: &mut [embedded_hal::spi::Operation<'_, u8>]) -> Result<(), Self::Error> {
        Ok(())
    }
}

impl embedded_hal::i2c::ErrorType for NoBus {
    type Error = core::convert::Infallible;
}

impl embedded_hal::i2c::I2c for NoBus {
    fn transaction(&mut self, _: u8, _: &mut [embedded_hal::i2c::Operation<'_>]) -> Result<(), Self::Error> {
        Ok(())
    }
}

impl embedded_hal::delay::DelayNs for NoBus {
    fn delay_ns(&mut self, _: u32) {}
}

type Unused = Blocking<NoBus>;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, firmware, image, codes, to] = &arguments[..] else {
        return Err("usage: firmware_telemetry FIRMWARE IMAGE CODES TELEMETRY".into());
    };
    let image = if image == "-" { None } else { Some(fs::read(image)?) };
    let codes = fs::read(codes)?;
    let (rows, []) = codes.as_chunks::<18>() else { return Err("CODES ends within a sample".into()) };
    let stream = match firmware.as_str() {
        "rp2040" => run::<Fixed>(Bmi323::<Unused, Unused>::scales(), image.as_deref(), rows)?,
        "nrf52840" => run::<f32>(Lsm6dsv16x::<Unused, Unused>::scales(), image.as_deref(), rows)?,
        _ => return Err(format!("no firmware {firmware}: rp2040 or nrf52840").into()),
    };
    fs::write(to, stream)?;
    println!("samples {}", rows.len());
    Ok(())
}

/// Telemetry of a hub with these scales for rows of codes.
fn run<R: Scalar<Stored = f32>>(
    scales: Scales,
    image: Option<&[u8]>,
    rows: &[[u8; 18]],
) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut hub: DeviceHub<R> = DeviceHub::new(scales);
    let mut stream = Vec::new();
    let mut telemetry = Telemetry::new(Collected(&mut stream), &hub);
    if let Some(image) = image {
        // an image that the hub refuses ends the test; the firmware runs without one
        hub.load(image)?;
        telemetry.load(&mut hub, image);
    }
    for row in rows {
        let (skipped, codes) = row.split_at(4);
        let code = |index: usize| i16::from_le_bytes([codes[2 * index], codes[2 * index + 1]]);
        let temperature = Some(code(6)).filter(|code| *code != i16::MIN);
        let _output = hub.update(&RawSample {
            skipped: u32::from_le_bytes(skipped.try_into()?),
            accel: [0, 1, 2].map(code),
            gyro: [3, 4, 5].map(code),
            temperature,
            faults: if temperature.is_some() { Faults::empty() } else { Faults::TEMPERATURE },
        });
        telemetry.sample(&hub);
    }
    Ok(stream)
}

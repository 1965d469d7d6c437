//! Telemetry that the firmware of the Pico (fos-embedded/examples/rp2040) must send for the codes that its sensor delivered.
//!
//! ```text
//! pico_telemetry IMAGE CODES TELEMETRY
//! ```
//!
//! IMAGE is the model image in the flash, or `-` for none. CODES has 18 bytes for every sample, little-endian: the ticks without a sample
//! before it (u32), then the codes of accelerometers, gyros and thermometer (i16 × 7). TELEMETRY is written.

use std::error::Error;
use std::fs;

use fos_core::{Fixed, Image, Info};
use fos_embedded::blocking::Blocking;
use fos_embedded::hub::Hub;
use fos_embedded::raw::RawSample;
use fos_embedded::sample_source::{Bmi323, Imu};
use fos_embedded::telemetry::{HUB_AXES, Recorder, Snapshot, StartFrame, VERSION};

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

impl embedded_hal::delay::DelayNs for NoBus {
    fn delay_ns(&mut self, _: u32) {}
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, image, codes, to] = &arguments[..] else {
        return Err("usage: pico_telemetry IMAGE CODES TELEMETRY".into());
    };
    let scales = Bmi323::<Blocking<NoBus>, Blocking<NoBus>>::scales();
    let mut hub: Hub<16, 128, 256, Fixed> = Hub::new(scales);
    let image = if image == "-" { None } else { Some(fs::read(image)?) };
    let mut info = Info::default();
    if let Some(image) = &image {
        hub.load(image)?;
        info = Image::parse(image)?.info();
    }
    let columns = hub.columns::<256>(&info).ok_or("the names of the columns are too long")?;
    let period_s = scales.period_s as f32;
    let start = StartFrame { version: VERSION, period_s, axes: HUB_AXES, quantities: &columns };
    let mut stream = Vec::new();
    let mut recorder: Recorder<_, 384> = Recorder::new(Collected(&mut stream));
    let codes = fs::read(codes)?;
    let (rows, []) = codes.as_chunks::<18>() else { return Err("CODES ends within a sample".into()) };
    for row in rows {
        let (skipped, codes) = row.split_at(4);
        let code = |index: usize| i16::from_le_bytes([codes[2 * index], codes[2 * index + 1]]);
        let _output = hub.update(&RawSample {
            skipped: u32::from_le_bytes(skipped.try_into()?),
            accel: [0, 1, 2].map(code),
            gyro: [3, 4, 5].map(code),
            temperature: Some(code(6)),
            ..RawSample::default()
        });
        recorder.sample(&start, Snapshot::<16>::new(hub.output(), &hub.logged()).frame())?;
    }
    fs::write(to, stream)?;
    println!("samples {}", rows.len());
    Ok(())
}

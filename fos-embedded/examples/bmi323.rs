//! A hub on a BMI323 over SPI, blocking: the loop of a firmware without an executor.
//!
//! It also compiles for a host, where no sensor answers.

use core::convert::Infallible;

use embedded_hal::{delay::DelayNs, spi::SpiDevice};
use fos_embedded::blocking::{Blocking, poll_once};
use fos_embedded::hub::{Hub, HubError, Output};
use fos_embedded::sample_source::{Bmi323, Counts, Imu, SampleSource, SourceError};

/// Peripherals and clock of the board.
struct Board<S, D> {
    spi: S,
    delay: D,
    /// A monotonic clock, µs.
    now_us: fn() -> u64,
    /// Sleeps for about this long; up to 250 ms lose no samples, because the FIFO buffers them.
    sleep_ms: fn(u32),
}

/// Runs the loop. `image` is the stored model; `use_output` is called for every sample, 200 times per second; `report` for
/// every error of the bus or the part, with the counts.
fn run<S: SpiDevice, D: DelayNs>(
    board: Board<S, D>,
    image: &[u8],
    mut use_output: impl FnMut(&Output),
    mut report: impl FnMut(SourceError<S::Error>, Counts),
) -> Result<Infallible, HubError> {
    // room for 16 inputs, 128 terms, 256 values of history
    let mut hub: Hub<16, 128, 256> = Hub::new(Bmi323::<Blocking<S>, Blocking<D>>::scales());
    hub.load(image)?;
    let mut source = SampleSource::new(Bmi323::new(Blocking(board.spi), Blocking(board.delay)));
    loop {
        let now_us = (board.now_us)();
        match poll_once(source.poll(now_us)) {
            Some(Ok(samples)) => {
                for raw in samples {
                    use_output(hub.update(raw));
                }
                if !samples.is_empty() && !source.has_more() {
                    hub.clock(now_us); // measures the sensor's true sampling rate
                }
            }
            // possibly temporary: continue polling
            Some(Err(error)) => report(error, source.counts()),
            // pending, which does not happen over `Blocking`
            None => {}
        }
        if !source.has_more() {
            (board.sleep_ms)(50);
        }
    }
}

/// A bus without a device.
struct NoBus;

impl embedded_hal::spi::ErrorType for NoBus {
    type Error = embedded_hal::spi::ErrorKind;
}

impl SpiDevice for NoBus {
    fn transaction(&mut self, _: &mut [embedded_hal::spi::Operation<'_, u8>]) -> Result<(), Self::Error> {
        Err(embedded_hal::spi::ErrorKind::Other)
    }
}

impl DelayNs for NoBus {
    fn delay_ns(&mut self, _: u32) {}
}

fn main() {
    let board = Board { spi: NoBus, delay: NoBus, now_us: || 0, sleep_ms: |_| {} };
    let report = |error, counts: Counts| println!("{error}; {} transfers have failed", counts.bus);
    let Err(refused) = run(board, b"not a model", |output| println!("{:?}", output.gyro()), report);
    println!("on a host there is neither a sensor nor an image: {refused}");
}

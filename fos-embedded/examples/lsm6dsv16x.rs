//! A hub on an LSM6DSV16X over I2C, asynchronous: the task of a firmware with an executor.
//!
//! It also compiles for a host, where no sensor answers.

use core::convert::Infallible;

use embedded_hal_async::{delay::DelayNs, i2c::I2c};
use fos_embedded::blocking::poll_once;
use fos_embedded::hub::{Hub, HubError, Output};
use fos_embedded::sample_source::{Address, Counts, Imu, Lsm6dsv16x, SampleSource, SourceError};

/// Runs the loop. `now_us` is a monotonic clock, `image` the stored model; `use_output` is called for every sample, 200
/// times per second; `report` for every error of the bus or the part, with the counts.
async fn run<B: I2c, D: DelayNs + Clone>(
    bus: B,
    mut delay: D,
    now_us: fn() -> u64,
    image: &[u8],
    mut use_output: impl FnMut(&Output),
    mut report: impl FnMut(SourceError<B::Error>, Counts),
) -> Result<Infallible, HubError> {
    // room for 16 inputs, 128 terms, 256 values of history
    let mut hub: Hub<16, 128, 256> = Hub::new(Lsm6dsv16x::<B, D>::scales());
    hub.load(image)?;
    let mut source = SampleSource::new(Lsm6dsv16x::new(bus, Address::Low, delay.clone()));
    loop {
        let now_us = now_us();
        match source.poll(now_us).await {
            Ok(samples) => {
                for raw in samples {
                    use_output(hub.update(raw));
                }
                if !samples.is_empty() && !source.has_more() {
                    hub.clock(now_us); // measures the sensor's true sampling rate
                }
            }
            // possibly temporary: continue polling
            Err(error) => report(error, source.counts()),
        }
        if !source.has_more() {
            delay.delay_ms(50).await;
        }
    }
}

/// A bus without a device.
#[derive(Clone)]
struct NoBus;

impl embedded_hal::i2c::ErrorType for NoBus {
    type Error = embedded_hal::i2c::ErrorKind;
}

impl I2c for NoBus {
    async fn transaction(
        &mut self,
        _: u8,
        _: &mut [embedded_hal::i2c::Operation<'_>],
    ) -> Result<(), Self::Error> {
        Err(embedded_hal::i2c::ErrorKind::Other)
    }
}

impl DelayNs for NoBus {
    async fn delay_ns(&mut self, _: u32) {}
}

fn main() {
    let report = |error, counts: Counts| println!("{error}; {} transfers have failed", counts.bus);
    let task = run(NoBus, NoBus, || 0, b"not a model", |output| println!("{:?}", output.gyro()), report);
    // in place of an executor
    let Some(Err(refused)) = poll_once(task) else { unreachable!("it ends before it waits for anything") };
    println!("on a host there is neither a sensor nor an image: {refused}");
}

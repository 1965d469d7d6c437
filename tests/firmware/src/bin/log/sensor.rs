//! A sensor with failures.

use embedded_hal::spi::ErrorKind;
use fos_core::FittedOn;
use fos_embedded::raw::Scales;
use fos_embedded::sample_source::{Batch, Imu, SensorClock, SourceError};

pub(crate) const SCALES: Scales = Scales {
    accel_mps2: 0.001,
    gyro_rads: 0.0005,
    temperature_k: 1.0 / 256.0,
    temperature_zero_c: 25.0,
    period_s: 0.005,
    values: FittedOn::Raw,
};

/// Found at the second attempt, overruns once, and is unplugged at the end.
pub(crate) struct Sensor {
    set_ups: u8,
    reads: u8,
    stamp: u32,
}

impl Sensor {
    pub(crate) const fn new() -> Self {
        Self { set_ups: 0, reads: 0, stamp: 0 }
    }
}

impl Imu for Sensor {
    type BusError = ErrorKind;

    const NAME: &'static str = "sensor";

    /// One count per sample.
    const CLOCK: SensorClock = SensorClock { bits: 32, count_ps: u32::MAX, period_ns: 4_294_967 };

    fn scales() -> Scales {
        SCALES
    }

    async fn set_up(&mut self) -> Result<(), SourceError<ErrorKind>> {
        self.set_ups += 1;
        match self.set_ups {
            1 => Err(SourceError::WrongPart(0x6b)),
            2 => Ok(()),
            _ => Err(SourceError::Bus(ErrorKind::Other)),
        }
    }

    async fn is_set_up(&mut self) -> Result<bool, SourceError<ErrorKind>> {
        Ok(true)
    }

    async fn read(&mut self, batch: &mut Batch) -> Result<(), SourceError<ErrorKind>> {
        self.reads += 1;
        if self.reads > 6 {
            return Err(SourceError::Bus(ErrorKind::Overrun));
        }
        batch.overrun = self.reads == 3;
        for n in 0..10 {
            self.stamp += 1;
            // a thermometer that falls silent is logged once, not with every sample
            let temperature = (self.reads < 4).then_some(256);
            batch.push([n, 0, 9810], [0, n, 500], temperature, self.stamp);
        }
        Ok(())
    }

    async fn wait_ms(&mut self, _: u32) {}
}

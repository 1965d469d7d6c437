//! Complete samples from a six-axis sensor, an [`Imu`], with fault handling.
//!
//! Four parts are supported over embedded-hal 1.0, each behind the feature of its name: `Lsm6dsv16x` and `Lsm6dso` over
//! I2C, `Bmi323` and `Icm42688` over SPI, all in FIFO mode at 200 Hz (LSM6DSO: 208 Hz) with temperature and sensor time.
//! Blocking buses and delays need the adapter [`Blocking`](crate::blocking::Blocking).
//!
//! Call [`poll`](SampleSource::poll) at least every 250 ms: otherwise the FIFO overruns and samples are lost, flagged and
//! counted. docs/faults.md describes each fault and its recovery time.
//!
//! ```
//! use embedded_hal::{delay::DelayNs, spi::SpiDevice};
//! use fos_embedded::blocking::{Blocking, poll_once};
//! use fos_embedded::hub::Hub;
//! use fos_embedded::sample_source::{Bmi323, SampleSource};
//!
//! fn run<S: SpiDevice, D: DelayNs>(spi: S, delay: D, clock_us: impl Fn() -> u64, mut hub: Hub<8, 60, 128>) {
//!     let mut source = SampleSource::new(Bmi323::new(Blocking(spi), Blocking(delay)));
//!     loop {
//!         let now_us = clock_us();
//!         match poll_once(source.poll(now_us)) {
//!             Some(Ok(samples)) => {
//!                 for raw in samples {
//!                     let _output = hub.update(raw);
//!                 }
//!                 if !samples.is_empty() && !source.has_more() {
//!                     hub.clock(now_us);
//!                 }
//!             }
//!             // possibly temporary, so continue polling; the reaction is up to the application
//!             Some(Err(error)) => println!("no samples: {error}"),
//!             None => {} // pending, which does not happen over Blocking
//!         }
//!         // poll again at once if there are more samples; otherwise sleep for 50 ms
//! #       break;
//!     }
//! }
//! ```

#[cfg(feature = "bmi323")]
mod bmi323;
mod counts;
mod error;
mod frame;
#[cfg(feature = "icm42688")]
mod icm42688;
#[cfg(feature = "lsm6dso")]
mod lsm6dso;
#[cfg(feature = "lsm6dsv16x")]
mod lsm6dsv16x;
#[cfg(any(feature = "icm42688", feature = "lsm6dso", feature = "lsm6dsv16x"))]
mod registers;
mod repeats;
#[cfg(any(feature = "bmi323", feature = "icm42688"))]
mod spi_fifo;
#[cfg(any(feature = "lsm6dso", feature = "lsm6dsv16x"))]
mod st;
mod timeline;

use core::fmt::Debug;
use core::future::Future;

use heapless::Vec;

#[cfg(feature = "bmi323")]
pub use bmi323::Bmi323;
pub use counts::Counts;
pub use error::SourceError;
pub use frame::{Batch, FifoFrame, MAX_SAMPLES};
#[cfg(feature = "icm42688")]
pub use icm42688::Icm42688;
#[cfg(feature = "lsm6dso")]
pub use lsm6dso::Lsm6dso;
#[cfg(feature = "lsm6dsv16x")]
pub use lsm6dsv16x::Lsm6dsv16x;
use repeats::Repeats;
#[cfg(any(feature = "lsm6dso", feature = "lsm6dsv16x"))]
pub use st::{Address, INTERRUPT_SAMPLES};
pub use timeline::SensorClock;
use timeline::Timeline;

use crate::raw::{Faults, RawSample, Scales};

/// Delays before the repetitions of a failed transfer, ms: longer than a glitch, shorter than a sample.
const RETRY_AFTER_MS: [u32; 2] = [1, 2];

/// Longest rest of a repeatedly failing sensor, polls.
const MAX_BACK_OFF: u8 = 64;

/// Time without a sample after which a sensor is set up again, µs; the gyros of all parts start within a third of it.
const SILENT_US: u64 = 250_000;

/// A six-axis sensor with a FIFO, behind its driver.
///
/// Futures need not be `Send`: a source belongs to one task.
pub trait Imu {
    /// Error of the bus driver.
    type BusError: Debug;

    /// Name of the part in its data sheet.
    const NAME: &'static str;

    /// Clock of the sensor, from which its frames have their timestamps.
    const CLOCK: SensorClock;

    /// Nominal scales from the data sheet, for the configuration of [`set_up`](Self::set_up).
    fn scales() -> Scales;

    /// Resets the sensor, checks its identity, configures it and reads the configuration back.
    ///
    /// # Errors
    ///
    /// The bus fails, another part answers, or a register does not hold the value written.
    fn set_up(&mut self) -> impl Future<Output = Result<(), SourceError<Self::BusError>>>;

    /// Returns true if the sensor still has its configuration; false after an unexpected reset.
    ///
    /// # Errors
    ///
    /// The bus fails.
    fn is_set_up(&mut self) -> impl Future<Output = Result<bool, SourceError<Self::BusError>>>;

    /// Reads the oldest frames of the FIFO into `batch`, as many as fit. After an error it may be called again with the
    /// same batch, which holds the frames read before.
    ///
    /// # Errors
    ///
    /// The bus fails.
    fn read(&mut self, batch: &mut Batch) -> impl Future<Output = Result<(), SourceError<Self::BusError>>>;

    /// Waits for at least `ms` between two attempts.
    fn wait_ms(&mut self, ms: u32) -> impl Future<Output = ()>;
}

/// Complete samples from a part, with fault handling.
///
/// The effort on failures is bounded: three attempts per poll, then up to 64 polls of rest before the part is set up again.
#[derive(Debug)]
pub struct SampleSource<P: Imu> {
    part: P,
    state: State,
    /// Polls to rest after the next failure.
    back_off: u8,
    /// Polls before a stuck sensor is set up again.
    stuck_rest: u8,
    /// The sensor was set up at least once, so the next set-up is a reset.
    started: bool,
    /// Time of the last sample or set-up, µs.
    heard_us: u64,
    batch: Batch,
    timeline: Timeline,
    repeats: Repeats,
    /// Faults to report with the next sample.
    pending: Faults,
    counts: Counts,
    samples: Vec<RawSample, MAX_SAMPLES>,
    /// Faults of the previous poll's samples, already logged.
    #[cfg(feature = "defmt")]
    logged: Faults,
}

#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum State {
    Running,
    /// Waits for `rest` polls before the next set-up.
    Down {
        rest: u8,
    },
}

impl<P: Imu> SampleSource<P> {
    /// Creates a source; the part is set up at the first poll.
    pub const fn new(part: P) -> Self {
        Self {
            part,
            state: State::Down { rest: 0 },
            back_off: 1,
            stuck_rest: 0,
            started: false,
            heard_us: 0,
            batch: Batch::new(),
            timeline: Timeline::new(),
            repeats: Repeats::new(),
            pending: Faults::empty(),
            counts: Counts::ZERO,
            samples: Vec::new(),
            #[cfg(feature = "defmt")]
            logged: Faults::empty(),
        }
    }

    /// Returns the samples since the last poll, oldest first, at most [`MAX_SAMPLES`]. Poll again while there are
    /// [more](Self::has_more).
    ///
    /// `now_us` is the application's monotonic clock, µs. A poll takes as long as the bus transfer (LSM6DSV16X at 400 kHz:
    /// 0.5 ms per sample, BMI323 at 10 MHz: 15 µs); failed transfers add 3 ms, a set-up 60 ms. Dropping the future loses
    /// the samples read so far, which causes a gap and nothing worse.
    ///
    /// # Errors
    ///
    /// The sensor cannot be read or set up. Continue polling: it is set up again after 1, 2, 4 … 64 polls.
    pub async fn poll(&mut self, now_us: u64) -> Result<&[RawSample], SourceError<P::BusError>> {
        self.samples.clear();
        self.batch.clear();
        match self.state {
            State::Running => self.run(now_us).await?,
            State::Down { rest: 0 } => self.set_up(now_us).await?,
            State::Down { rest } => {
                self.state = State::Down { rest: rest.saturating_sub(1) };
                return Err(SourceError::Resting(rest));
            }
        }
        Ok(&self.samples)
    }

    /// True if the sensor had more samples at the last poll than fit one call.
    pub fn has_more(&self) -> bool {
        self.state == State::Running && self.batch.left > 0
    }

    /// Counts of samples and faults since the source was created.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Returns the part for another use.
    pub fn release(self) -> P {
        self.part
    }

    async fn run(&mut self, now_us: u64) -> Result<(), SourceError<P::BusError>> {
        let mut set_up = self.transfer().await;
        for wait_ms in RETRY_AFTER_MS {
            let Err(error) = &set_up else { break };
            self.counts.note(error, &mut self.pending);
            self.part.wait_ms(wait_ms).await;
            set_up = self.transfer().await;
        }
        match set_up {
            Ok(true) => {
                self.deliver(now_us);
                Ok(())
            }
            Ok(false) => {
                self.give_up();
                if self.state == (State::Down { rest: 0 }) { self.set_up(now_us).await } else { Ok(()) }
            }
            Err(error) => {
                warn!("{=str}: not read: {}", P::NAME, error.without_bus());
                self.counts.note(&error, &mut self.pending);
                self.give_up();
                Err(error)
            }
        }
    }

    /// Checks the configuration of the sensor and, if it is set up, reads its oldest frames. Returns true if it is set up.
    async fn transfer(&mut self) -> Result<bool, SourceError<P::BusError>> {
        // neither bus has a checksum, so one wrong read does not prove a reset
        let set_up = self.part.is_set_up().await? || self.part.is_set_up().await?;
        if set_up {
            self.part.read(&mut self.batch).await?;
        }
        Ok(set_up)
    }

    async fn set_up(&mut self, now_us: u64) -> Result<(), SourceError<P::BusError>> {
        if let Err(error) = self.part.set_up().await {
            warn!("{=str}: not set up: {}", P::NAME, error.without_bus());
            self.counts.note(&error, &mut self.pending);
            self.give_up();
            return Err(error);
        }
        info!("{=str}: set up, not for the first time: {=bool}", P::NAME, self.started);
        if self.started {
            self.pending |= Faults::RESET;
            self.counts.resets = self.counts.resets.saturating_add(1);
        }
        (self.state, self.started, self.heard_us) = (State::Running, true, now_us);
        // the sensor's clock restarts
        self.timeline.restart();
        Ok(())
    }

    /// Schedules a new set-up, with twice the delay after every failure without a sample in between.
    fn give_up(&mut self) {
        warn!("{=str}: to be set up after {=u8} polls", P::NAME, self.back_off);
        self.state = State::Down { rest: self.back_off.saturating_sub(1) };
        self.back_off = self.back_off.saturating_mul(2).min(MAX_BACK_OFF);
    }

    /// Turns the frames of a poll into samples.
    fn deliver(&mut self, now_us: u64) {
        let overrun = self.batch.overrun;
        if overrun {
            self.pending |= Faults::OVERRUN;
            self.counts.overruns = self.counts.overruns.saturating_add(1);
        }
        let frames = core::mem::take(&mut self.batch.frames);
        let mut younger = u64::from(self.batch.left).saturating_add(frames.len() as u64);
        let mut stuck = false;
        for frame in &frames {
            younger = younger.saturating_sub(1);
            self.count_damaged(frame.damaged);
            let at_us = now_us.saturating_sub(younger.saturating_mul(P::CLOCK.period_us()));
            let Some(ticks) = self.timeline.step(&P::CLOCK, frame.stamp, at_us, overrun) else {
                self.count_damaged(1);
                continue;
            };
            self.heard_us = now_us;
            stuck = self.deliver_frame(frame, ticks.saturating_sub(1));
        }
        self.count_damaged(self.batch.damaged);
        #[cfg(feature = "defmt")]
        self.log_new_faults();
        if stuck {
            self.unstick();
        } else if now_us.saturating_sub(self.heard_us) > SILENT_US {
            self.give_up();
        }
    }

    /// Logs the faults of these samples that the previous poll did not have.
    #[cfg(feature = "defmt")]
    fn log_new_faults(&mut self) {
        let faults = self.samples.iter().fold(Faults::empty(), |faults, raw| faults | raw.faults);
        if !self.logged.contains(faults) {
            warn!("{=str}: {}", P::NAME, faults.difference(self.logged));
        }
        if !self.samples.is_empty() {
            self.logged = faults;
        }
    }

    /// Turns a frame into a sample; returns true if the sensor is stuck.
    fn deliver_frame(&mut self, frame: &FifoFrame, skipped: u32) -> bool {
        let mut faults = core::mem::take(&mut self.pending);
        if skipped > 0 {
            faults |= Faults::GAP;
            self.counts.gaps = self.counts.gaps.saturating_add(1);
            self.counts.skipped = self.counts.skipped.saturating_add(skipped);
        }
        if frame.temperature.is_none() {
            faults |= Faults::TEMPERATURE;
            self.counts.temperature = self.counts.temperature.saturating_add(1);
        }
        let stuck = self.repeats.update(frame);
        if stuck {
            faults |= Faults::STUCK;
            self.counts.stuck = self.counts.stuck.saturating_add(1);
        } else if self.repeats.is_none() {
            (self.back_off, self.stuck_rest) = (1, 0);
        }
        let FifoFrame { accel, gyro, temperature, .. } = *frame;
        self.counts.samples = self.counts.samples.saturating_add(1);
        // never full: at most as many samples as frames
        let _ = self.samples.push(RawSample { skipped, accel, gyro, temperature, faults });
        stuck
    }

    /// Counts discarded frames and flags the next sample.
    fn count_damaged(&mut self, frames: u16) {
        if frames > 0 {
            self.pending |= Faults::BUS;
            self.counts.damaged = self.counts.damaged.saturating_add(u32::from(frames));
        }
    }

    /// Sets up a stuck sensor again, with increasing intervals.
    fn unstick(&mut self) {
        if self.stuck_rest > 0 {
            self.stuck_rest = self.stuck_rest.saturating_sub(1);
            return;
        }
        warn!("{=str}: stuck, to be set up", P::NAME);
        self.stuck_rest = self.back_off;
        self.back_off = self.back_off.saturating_mul(2).min(MAX_BACK_OFF);
        self.state = State::Down { rest: 0 };
    }
}

#[cfg(feature = "defmt")]
impl<P: Imu> defmt::Format for SampleSource<P> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "SampleSource {{ part: {=str}, state: {}, pending: {}, counts: {} }}",
            P::NAME,
            self.state,
            self.pending,
            self.counts
        );
    }
}

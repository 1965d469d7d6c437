//! Samples for the hub from streams with separate timestamps, as from the sensor hub of a phone: [`Streams`].

use fos_core::align::{Aligner, Counts, Joined, Refused, SET_BACK_AFTER, Stream};

use crate::raw::{Faults, SiSample};

/// Nominal periods of the streams, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Periods {
    /// Period of the gyros, which is one tick of the hub. With 0, no sample is passed over and none counts as skipped.
    pub gyro_ns: u64,
    /// Period of the accelerometers.
    pub accel_ns: u64,
    /// Period of the thermometer; 0 if there is none.
    pub temperature_ns: u64,
}

/// A sample of a sensor with separate streams.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StampedSample {
    /// Timestamp of the gyros, ns.
    pub stamp_ns: i64,
    /// Sample for [`Hub::update_si`](crate::hub::Hub::update_si).
    pub sample: SiSample,
}

/// Counts of samples that did not enter a sample of the hub unchanged; each saturates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StreamCounts {
    /// Counts of the gyros.
    pub gyro: Counts,
    /// Counts of the accelerometers. `missing` includes rows that were then passed over.
    pub accel: Counts,
    /// Counts of the thermometer. `missing` includes rows that were then passed over.
    pub temperature: Counts,
    /// Gyro samples passed over because they came faster than the period.
    pub passed_over: u32,
}

/// Resamples gyros, accelerometers and a thermometer with separate timestamps (ns of one clock) to samples of one sensor.
///
/// The gyros lead: every gyro sample becomes a sample of the hub, with the values of the other streams at its timestamp.
/// [`Aligner`] documents the guarantees on order, batches and clocks. Missing values are NaN, which the hub flags:
/// accelerometers where one of their samples was lost, a temperature older than three of its periods, gyro samples with NaN.
///
/// - **Skipped ticks** follow from the timestamps: with the distance D from the last returned sample and the period P,
///   round(D/P) − 1. Counted from sample to sample, a sensor whose clock is a few percent off loses none.
/// - **A faster rate**, requested by another client: a sample is passed over, and counted, if the following one, at the same
///   distance d as this one from its predecessor, will be nearer to one period after the last returned sample:
///   2D + d < 2P. At n times the rate every n-th sample remains; at rates in between, steps are 2/3 to 4/3 P. There is no
///   filter: noise above the band of the nominal rate aliases into it.
/// - **A clock that was set back** (the last 8 gyro timestamps increase, but none is above the newest before them): the
///   sample has [`Faults::RESET`], so that the hub restarts its rate measurement, and counts as skipped the 7 samples
///   that were rejected until then. The true duration of the interruption is unknown.
///
/// The queues hold `DEPTH` samples of gyros and accelerometers: a batch must fit, and if the accelerometers die the output
/// is delayed by as many samples. No heap and no panic. With a depth of 64 the size is 3,504 bytes (64-bit).
///
/// ```
/// use fos_embedded::streams::{Periods, Streams};
///
/// let periods = Periods { gyro_ns: 5_000_000, accel_ns: 10_000_000, temperature_ns: 1_000_000_000 };
/// let mut streams = Streams::<64>::new(&periods);
/// streams.push_temperature(0, 31.5)?;
/// streams.push_accel(0, [0.0, 0.0, 9.8])?;
/// streams.push_accel(10_000_000, [0.0, 0.2, 9.8])?;
/// for stamp_ns in [0, 5_000_000, 10_000_000] {
///     streams.push_gyro(stamp_ns, [0.01, 0.0, 0.0])?;
/// }
/// let mut given = 0;
/// while let Some(stamped) = streams.next() {
///     // let output = hub.update_si(&stamped.sample);
///     assert_eq!(stamped.stamp_ns, 5_000_000 * given);
///     assert!((stamped.sample.accel[1] - 0.1 * given as f32).abs() < 1e-6);
///     assert_eq!((stamped.sample.skipped, stamped.sample.temperature_c), (0, 31.5));
///     given += 1;
/// }
/// assert_eq!(given, 3);
/// # Ok::<(), fos_core::align::Refused>(())
/// ```
#[derive(Debug, Clone)]
pub struct Streams<const DEPTH: usize> {
    aligner: Aligner<f32, 1, 1, DEPTH>,
    gyro_ns: u64,
    last: Option<Last>,
    passed_over: u32,
}

/// Timestamps of the gyros, ns.
#[derive(Debug, Clone, Copy)]
struct Last {
    /// Last returned sample.
    given: i64,
    /// Last sample, returned or passed over.
    came: i64,
}

impl<const DEPTH: usize> Streams<DEPTH> {
    /// Empty streams with these periods.
    pub fn new(periods: &Periods) -> Self {
        let mut streams = Self::without_periods();
        streams.set_periods(periods);
        streams
    }

    /// Empty streams with periods of 0 until they are set. Usable in a `static`, without a copy on the stack.
    pub const fn without_periods() -> Self {
        Self { aligner: Aligner::without_periods(), gyro_ns: 0, last: None, passed_over: 0 }
    }

    /// Sets the periods from the next sample on, after the requested rate of a stream has changed. The period of the gyros
    /// must remain that of the hub's scales.
    pub fn set_periods(&mut self, periods: &Periods) {
        self.gyro_ns = periods.gyro_ns;
        self.aligner.set_follower_period(0, ticks(periods.accel_ns));
        self.aligner.set_slow_period(0, ticks(periods.temperature_ns));
    }

    /// Adds an angular rate x, y, z, rad/s. Call [`Self::next`] afterwards until it returns `None`: a full queue drops its
    /// oldest sample, which is counted.
    ///
    /// # Errors
    /// [`Refused::NotIncreasing`]: the sample is rejected. [`Refused::NotFinite`]: the sample remains, with the gyros missing.
    pub fn push_gyro(&mut self, stamp_ns: i64, rate: [f32; 3]) -> Result<(), Refused> {
        self.aligner.push_lead(stamp_ns, rate)
    }

    /// Adds a specific force x, y, z, m/s².
    ///
    /// # Errors
    /// The timestamp does not increase, or a value is not finite: the sample is rejected.
    pub fn push_accel(&mut self, stamp_ns: i64, force: [f32; 3]) -> Result<(), Refused> {
        self.aligner.push_follower(0, stamp_ns, force)
    }

    /// Adds a temperature of the sensor, °C. Push it before the gyro samples that it applies to.
    ///
    /// # Errors
    /// The timestamp does not increase, or the value is not finite: it is rejected.
    pub fn push_temperature(&mut self, stamp_ns: i64, celsius: f32) -> Result<(), Refused> {
        self.aligner.push_slow(0, stamp_ns, celsius)
    }

    /// Returns the next sample, once no later value can change it or the queue of the gyros is full.
    #[expect(
        clippy::should_implement_trait,
        reason = "none is not the end: there may be more after the next push"
    )]
    pub fn next(&mut self) -> Option<StampedSample> {
        self.first(Aligner::pop)
    }

    /// Returns the next sample with the values available, without waiting for the accelerometers: at the end, or before a
    /// long sleep.
    pub fn flush(&mut self) -> Option<StampedSample> {
        self.first(Aligner::flush)
    }

    /// Counts of rejected, missing, dropped and passed-over samples.
    pub fn counts(&self) -> StreamCounts {
        StreamCounts {
            gyro: self.aligner.counts(Stream::Lead),
            accel: self.aligner.counts(Stream::Follower(0)),
            temperature: self.aligner.counts(Stream::Slow(0)),
            passed_over: self.passed_over,
        }
    }

    /// Returns the first row from `row` that is not passed over, as a sample.
    fn first(
        &mut self,
        row: impl Fn(&mut Aligner<f32, 1, 1, DEPTH>) -> Option<Joined<f32, 1, 1>>,
    ) -> Option<StampedSample> {
        // the largest possible number of rows
        for _ in 0..=DEPTH {
            let row = row(&mut self.aligner)?;
            if let Some((skipped, faults)) = self.step(row.stamp) {
                let ([accel], [temperature]) = (row.followers, row.slow);
                let sample = SiSample {
                    skipped,
                    accel: accel.values,
                    gyro: row.lead,
                    temperature_c: temperature.value,
                    faults,
                };
                return Some(StampedSample { stamp_ns: row.stamp, sample });
            }
            self.passed_over = self.passed_over.saturating_add(1);
        }
        None
    }

    /// Skipped ticks and faults of a gyro sample; `None` if it is passed over.
    fn step(&mut self, stamp: i64) -> Option<(u32, Faults)> {
        let step = match self.last {
            None => (0, Faults::empty()),
            Some(Last { came, .. }) if stamp <= came => (u32::from(SET_BACK_AFTER) - 1, Faults::RESET),
            Some(Last { given, came }) => {
                let (since_given, since_came) = (given.abs_diff(stamp), came.abs_diff(stamp));
                if since_given.saturating_mul(2).saturating_add(since_came) < self.gyro_ns.saturating_mul(2) {
                    self.last = Some(Last { given, came: stamp });
                    return None;
                }
                let ticks =
                    since_given.saturating_add(self.gyro_ns / 2).checked_div(self.gyro_ns).unwrap_or(1);
                (u32::try_from(ticks.saturating_sub(1)).unwrap_or(u32::MAX), Faults::empty())
            }
        };
        self.last = Some(Last { given: stamp, came: stamp });
        Some(step)
    }
}

#[cfg(feature = "defmt")]
impl<const DEPTH: usize> defmt::Format for Streams<DEPTH> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Streams {{ {}, passed over: {=u32} }}", self.aligner, self.passed_over);
    }
}

/// A period in ticks of the aligner, saturated.
fn ticks(period_ns: u64) -> i64 {
    i64::try_from(period_ns).unwrap_or(i64::MAX)
}

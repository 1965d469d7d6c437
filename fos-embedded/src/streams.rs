//! Samples for the hub of streams that have stamps of their own, as the sensor hub of a phone gives them: [`Streams`].

use fos_core::align::{Aligner, Counts, Joined, Refused, SET_BACK_AFTER, Stream};

use crate::raw::{Faults, SiSample};

/// Nominal periods of the streams, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Periods {
    /// Of the gyros, and so of the hub: one of its ticks. 0: nothing is passed over, and nothing counts as skipped.
    pub gyro_ns: u64,
    /// Of the accelerometers.
    pub accel_ns: u64,
    /// Of the thermometer; 0 if there is none.
    pub temperature_ns: u64,
}

/// A sample of a sensor with separate streams.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StampedSample {
    /// As the gyros were stamped, ns.
    pub stamp_ns: i64,
    /// For [`Hub::update_si`](crate::hub::Hub::update_si).
    pub sample: SiSample,
}

/// What did not go into a sample as it came, each held at its highest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StreamCounts {
    /// Of the gyros.
    pub gyro: Counts,
    /// Of the accelerometers. `missing` counts samples that were then passed over too.
    pub accel: Counts,
    /// Of the thermometer; as of the accelerometers.
    pub temperature: Counts,
    /// Samples of the gyros that came faster than their period.
    pub passed_over: u32,
}

/// Gyros, accelerometers and a thermometer, each with stamps of its own (ns of one clock), as samples of one sensor.
///
/// The gyros lead: every sample of theirs is one for the hub, with what the others have at its stamp ([`Aligner`], which
/// says what holds of order, batches and clocks). What is missing is NaN, which the hub says: the accelerometers where
/// one of their samples is lost, the temperature where it is older than three of its periods, gyros that came as NaN.
///
/// - **Skipped ticks** are those of the stamps: with D from the sample before and the period P, round(D/P) − 1. That is
///   counted from sample to sample, so that a sensor whose clock is some percent off loses none.
/// - **A faster rate**, because another client asked for it: a sample is passed over, and counted, if the one after it,
///   should it come as this one did, is nearer to a period after the last that was given: 2D + d < 2P, with d from the
///   stamp before. Of n times the rate every n-th remains; of rates in between, steps between 2/3 and 4/3 P. There is no
///   filter: noise above the band of the nominal rate is folded into it.
/// - **A clock that was set back** (the last 8 stamps of the gyros increase, but none is above the newest before): the
///   sample says [`Faults::RESET`], so that the hub measures its rate anew, and has the 7 as skipped that were refused
///   until that was certain. How long it took by another clock nobody knows here.
///
/// `DEPTH` samples of gyros and accelerometers are queued: a batch must go in, and when the accelerometers die samples come
/// that much later. No heap and no panic. With a depth of 64 it is 3,504 bytes (64-bit).
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

/// Stamps of the gyros, ns.
#[derive(Debug, Clone, Copy)]
struct Last {
    /// Of the last sample that was given.
    given: i64,
    /// Of the last sample, given or passed over.
    came: i64,
}

impl<const DEPTH: usize> Streams<DEPTH> {
    /// Nothing yet, of streams with these periods.
    pub fn new(periods: &Periods) -> Self {
        let mut streams = Self::without_periods();
        streams.set_periods(periods);
        streams
    }

    /// With periods of 0 until they are set. May be in a `static`, and is made in place.
    pub const fn without_periods() -> Self {
        Self { aligner: Aligner::without_periods(), gyro_ns: 0, last: None, passed_over: 0 }
    }

    /// Other periods, from the next sample on: what a stream was asked for has changed. The period of the gyros is to stay
    /// that of the hub's scales.
    pub fn set_periods(&mut self, periods: &Periods) {
        self.gyro_ns = periods.gyro_ns;
        self.aligner.set_follower_period(0, ticks(periods.accel_ns));
        self.aligner.set_slow_period(0, ticks(periods.temperature_ns));
    }

    /// Takes a rate x, y, z, rad/s. Call [`Self::next`] after it until there is nothing more: pushed into a full queue, it
    /// takes the place of the oldest, which is lost and counted.
    ///
    /// # Errors
    /// Its stamp does not increase; it is not taken. Or a value is not finite; it is taken as a sample without gyros.
    pub fn push_gyro(&mut self, stamp_ns: i64, rate: [f32; 3]) -> Result<(), Refused> {
        self.aligner.push_lead(stamp_ns, rate)
    }

    /// Takes a specific force x, y, z, m/s².
    ///
    /// # Errors
    /// Its stamp does not increase, or a value is not finite; it is not taken.
    pub fn push_accel(&mut self, stamp_ns: i64, force: [f32; 3]) -> Result<(), Refused> {
        self.aligner.push_follower(0, stamp_ns, force)
    }

    /// Takes a temperature of the sensor, °C; before the samples of the gyros that it is for.
    ///
    /// # Errors
    /// Its stamp does not increase, or it is not finite; it is not taken.
    pub fn push_temperature(&mut self, stamp_ns: i64, celsius: f32) -> Result<(), Refused> {
        self.aligner.push_slow(0, stamp_ns, celsius)
    }

    /// The next sample, as soon as nothing that may still come can change it, or the queue of the gyros is full.
    #[expect(
        clippy::should_implement_trait,
        reason = "none is not the end: there may be more after the next push"
    )]
    pub fn next(&mut self) -> Option<StampedSample> {
        self.first(Aligner::pop)
    }

    /// The next sample with what there is, without waiting for the accelerometers: for the end, or before a long sleep.
    pub fn flush(&mut self) -> Option<StampedSample> {
        self.first(Aligner::flush)
    }

    /// What was refused, missing, lost or passed over.
    pub fn counts(&self) -> StreamCounts {
        StreamCounts {
            gyro: self.aligner.counts(Stream::Lead),
            accel: self.aligner.counts(Stream::Follower(0)),
            temperature: self.aligner.counts(Stream::Slow(0)),
            passed_over: self.passed_over,
        }
    }

    /// The first that is not passed over of the rows that `row` takes out.
    fn first(
        &mut self,
        row: impl Fn(&mut Aligner<f32, 1, 1, DEPTH>) -> Option<Joined<f32, 1, 1>>,
    ) -> Option<StampedSample> {
        // as many as there can be
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

    /// Skipped ticks and faults of a sample of the gyros; none if it is to be passed over.
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

/// As the aligner takes a period.
fn ticks(period_ns: u64) -> i64 {
    i64::try_from(period_ns).unwrap_or(i64::MAX)
}

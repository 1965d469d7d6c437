//! Resampling of streams with separate timestamps to the time base of one of them: [`Aligner`].

mod counts;
mod follower;
mod order;
mod queue;
mod slow;
#[cfg(test)]
mod tests;

use heapless::Deque;

use crate::Real;
use follower::Follower;
use order::{Arrival, Order};
use queue::Stamped;
use slow::Slow;

pub use counts::{Counts, Refused};
pub use follower::Interpolated;
pub use order::SET_BACK_AFTER;
pub use slow::{HELD_PERIODS, Held, SLOW_DEPTH};

/// Resamples streams with separate timestamps to the time base of one of them, the *lead*, whose samples stay unchanged.
///
/// The clock is the caller's: timestamps are its ticks (for example nanoseconds), anywhere in `i64`. The caller also
/// corrects offsets between clocks, by adding them to the timestamps.
///
/// - A **follower** (three values with one stamp) is interpolated between its neighbours a and b at t₀ < t < t₁:
///
///   ```text
///   w = round(2²⁴ (t − t₀) / (t₁ − t₀))      in integers
///   x = a + 2⁻²⁴ w (b − a)
///   ```
///
///   It is missing where its neighbours are more than 1.5 of its periods apart, because a sample was lost. At the
///   timestamp of a sample it equals that sample bit for bit. Interpolation reduces the variance of white noise by the factor
///   (1 − w)² + w²; see [`Interpolated::weight`].
/// - A **slow** channel (one value: temperature, supply voltage) holds its newest value at or before t, with its age. It
///   is missing when older than [`HELD_PERIODS`] of its periods.
///
/// Missing values are NaN, with a weight or age of `None`. Guarantees:
///
/// - **Any order, any batches.** Streams may arrive sample by sample or in batches, in any order between streams: the
///   output is the same bit for bit while no queue is full and no clock is set back. A row is returned as soon as no later
///   sample of a follower can change it. Slow channels are not waited for: push their values first.
/// - **No stall.** When the queue of the lead is full, its oldest row is returned with the values available: a dead sensor
///   delays the output by at most `DEPTH` samples.
/// - **Every lost sample is counted** ([`Counts`]). A timestamp that does not increase within its stream is rejected. A
///   sample with a value that is not finite is missing; for the lead, the row remains, with NaN.
/// - **Clock jumps.** After a jump ahead a stream continues at once. After a clock was set back, or a single timestamp was
///   far ahead, it restarts at the last of [`SET_BACK_AFTER`] consecutive timestamps that are not above the newest but
///   increase among themselves.
/// - **The same bits on every machine**, no heap, no panic; a push or a pop takes at most a few passes over one queue.
///
/// The queues hold `DEPTH` samples of the lead and of each follower, and [`SLOW_DEPTH`] of each slow channel; a batch must
/// fit. In f32, with one follower, one slow channel and a depth of 32, the size is 1,928 bytes (64-bit).
///
/// ```
/// use fos_core::align::Aligner;
///
/// // a follower every 10 ms, a thermometer every second
/// let mut aligner = Aligner::<f32, 1, 1, 32>::new([10_000_000], [1_000_000_000]);
/// aligner.push_slow(0, 0, 25.0)?;
/// aligner.push_follower(0, 1_000_000, [0.0, 2.0, 4.0])?;
/// aligner.push_lead(6_000_000, [0.5; 3])?;
/// assert!(aligner.pop().is_none(), "the follower may yet have a sample before it");
/// aligner.push_follower(0, 11_000_000, [1.0, 2.0, 0.0])?;
/// while let Some(row) = aligner.pop() {
///     assert_eq!((row.stamp, row.lead), (6_000_000, [0.5; 3]));
///     assert_eq!(row.followers[0].values, [0.5, 2.0, 2.0]);
///     assert_eq!((row.slow[0].value, row.slow[0].age), (25.0, Some(6_000_000)));
/// }
/// # Ok::<(), fos_core::align::Refused>(())
/// ```
#[derive(Debug, Clone)]
pub struct Aligner<R, const FOLLOWERS: usize, const SLOW: usize, const DEPTH: usize> {
    lead: Deque<Stamped<[R; 3]>, DEPTH>,
    order: Order,
    counts: Counts,
    /// Number of samples at the front that were queued before the lead's clock was set back: they wait for no follower.
    before_set_back: usize,
    followers: [Follower<R, DEPTH>; FOLLOWERS],
    slow: [Slow<R>; SLOW],
}

/// A row: a sample of the lead, with the values of the other streams at its timestamp.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Joined<R, const FOLLOWERS: usize, const SLOW: usize> {
    /// Timestamp of the lead, ticks.
    pub stamp: i64,
    /// Measured values of the lead; all NaN if any was not finite.
    pub lead: [R; 3],
    /// Interpolated values of every follower.
    pub followers: [Interpolated<R>; FOLLOWERS],
    /// Held value of every slow channel.
    pub slow: [Held<R>; SLOW],
}

/// A stream of an [`Aligner`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stream {
    /// The stream whose timestamps are the common time base.
    Lead,
    /// A follower by index, from 0.
    Follower(usize),
    /// A slow channel by index, from 0.
    Slow(usize),
}

#[cfg(feature = "defmt")]
impl<R, const FOLLOWERS: usize, const SLOW: usize, const DEPTH: usize> defmt::Format
    for Aligner<R, FOLLOWERS, SLOW, DEPTH>
{
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "Aligner {{ followers: {=usize}, slow: {=usize}, waiting: {=usize} of {=usize} }}",
            FOLLOWERS,
            SLOW,
            self.lead.len(),
            DEPTH
        );
    }
}

impl<R: Real, const FOLLOWERS: usize, const SLOW: usize, const DEPTH: usize>
    Aligner<R, FOLLOWERS, SLOW, DEPTH>
{
    /// Creates an aligner with the period of every follower and slow channel, ticks.
    pub fn new(follower_periods: [i64; FOLLOWERS], slow_periods: [i64; SLOW]) -> Self {
        let mut aligner = Self::without_periods();
        for (follower, period) in aligner.followers.iter_mut().zip(follower_periods) {
            follower.set_period(period);
        }
        for (slow, period) in aligner.slow.iter_mut().zip(slow_periods) {
            slow.set_period(period);
        }
        aligner
    }

    /// Creates an aligner with periods of 0: until they are set, every value that is not exactly at a timestamp of the lead
    /// is missing. Usable in a `static`, without a copy on the stack.
    pub const fn without_periods() -> Self {
        const { assert!(DEPTH >= 2, "a follower needs two samples to be interpolated between") };
        Self {
            lead: Deque::new(),
            order: Order::NEW,
            counts: Counts::NONE,
            before_set_back: 0,
            followers: [const { Follower::NEW }; FOLLOWERS],
            slow: [const { Slow::NEW }; SLOW],
        }
    }

    /// Sets the period of a follower, ticks, from the next row on. No effect if the follower does not exist.
    pub fn set_follower_period(&mut self, follower: usize, period: i64) {
        if let Some(follower) = self.followers.get_mut(follower) {
            follower.set_period(period);
        }
    }

    /// Sets the period of a slow channel, ticks, from the next row on. No effect if the channel does not exist.
    pub fn set_slow_period(&mut self, slow: usize, period: i64) {
        if let Some(slow) = self.slow.get_mut(slow) {
            slow.set_period(period);
        }
    }

    /// Adds a sample of the lead. Call [`Self::pop`] afterwards until it returns `None`: a full queue drops its oldest
    /// sample, which is counted.
    ///
    /// # Errors
    /// [`Refused::NotIncreasing`]: the sample is rejected. [`Refused::NotFinite`]: the row remains, with the lead missing.
    pub fn push_lead(&mut self, stamp: i64, values: [R; 3]) -> Result<(), Refused> {
        match self.order.arrive(stamp) {
            Arrival::InOrder => {}
            Arrival::Refused => return self.counts.refuse(),
            Arrival::SetBack => {
                self.counts.set_back();
                self.before_set_back = self.lead.len();
            }
        }
        let finite = values.iter().all(|value| value.is_finite());
        let value = if finite { values } else { [R::from_f64(f64::NAN); 3] };
        if self.lead.is_full() {
            let _ = self.lead.pop_front();
            self.before_set_back = self.before_set_back.saturating_sub(1);
            self.counts.drop_samples(1);
        }
        let _ = self.lead.push_back(Stamped { stamp, value }); // never full here
        if finite { Ok(()) } else { self.counts.miss() }
    }

    /// Adds a sample of a follower.
    ///
    /// # Errors
    /// The follower does not exist, the timestamp does not increase, or a value is not finite: the sample is rejected.
    pub fn push_follower(&mut self, follower: usize, stamp: i64, values: [R; 3]) -> Result<(), Refused> {
        self.followers.get_mut(follower).ok_or(Refused::NoSuchStream)?.push(stamp, values)
    }

    /// Adds a value of a slow channel.
    ///
    /// # Errors
    /// The channel does not exist, the timestamp does not increase, or the value is not finite: it is rejected.
    pub fn push_slow(&mut self, slow: usize, stamp: i64, value: R) -> Result<(), Refused> {
        self.slow.get_mut(slow).ok_or(Refused::NoSuchStream)?.push(stamp, value)
    }

    /// Returns the next row, once no later sample of a follower can change it or the queue of the lead is full.
    pub fn pop(&mut self) -> Option<Joined<R, FOLLOWERS, SLOW>> {
        let stamp = self.lead.front()?.stamp;
        let waits = self.before_set_back == 0 && !self.lead.is_full();
        if waits && !self.followers.iter_mut().all(|follower| follower.is_certain_at(stamp)) {
            return None;
        }
        self.flush()
    }

    /// Returns the next row with the values available, without waiting for followers: at the end of a log, or before a
    /// long sleep.
    pub fn flush(&mut self) -> Option<Joined<R, FOLLOWERS, SLOW>> {
        let Stamped { stamp, value: lead } = self.lead.pop_front()?;
        self.before_set_back = self.before_set_back.saturating_sub(1);
        Some(Joined {
            stamp,
            lead,
            followers: self.followers.each_mut().map(|follower| follower.at(stamp)),
            slow: self.slow.each_mut().map(|slow| slow.at(stamp)),
        })
    }

    /// Counts of rejected, missing and dropped samples of a stream, and of the rows without it; all 0 if it does not exist.
    pub fn counts(&self, stream: Stream) -> Counts {
        let counts = match stream {
            Stream::Lead => Some(self.counts),
            Stream::Follower(index) => self.followers.get(index).map(Follower::counts),
            Stream::Slow(index) => self.slow.get(index).map(Slow::counts),
        };
        counts.unwrap_or_default()
    }
}

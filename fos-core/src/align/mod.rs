//! Streams with stamps of their own, joined onto the grid of one of them: [`Aligner`].

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

/// Joins streams with stamps of their own onto the grid of one of them, the *lead*, whose samples are not touched.
///
/// Its clock is the caller's: stamps are ticks of it (nanoseconds, say), anywhere in `i64`, and a tick means nothing
/// more here. Offsets between clocks are the caller's too, who adds them to the stamps.
///
/// - A **follower** (three values with one stamp) is interpolated between its neighbours a and b at t₀ < t < t₁:
///
///   ```text
///   w = round(2²⁴ (t − t₀) / (t₁ − t₀))      in integers
///   x = a + 2⁻²⁴ w (b − a)
///   ```
///
///   It is missing where its neighbours are more than 1.5 of its periods apart: a sample is lost there. At a stamp of its
///   own it is that sample, to the bit. White noise is left with (1 − w)² + w² of its variance: [`Interpolated::weight`].
/// - A **slow** channel (one value: a thermometer, the supply) has the newest value that is not of later, and how old it
///   is; it is missing when older than [`HELD_PERIODS`] of its periods.
///
/// What is missing is NaN, and says so. What holds:
///
/// - **Any order, any batches.** Streams may come sample by sample or in batches, and in any order between them: while no
///   queue is full and no clock is set back, what comes out is the same bits. A lead sample is given out when what every
///   follower has at its stamp is certain; slow channels are not waited for, so theirs must have come before.
/// - **No stall.** When the queue of the lead is full its oldest sample is given out with what there is: a sensor that died
///   delays by `DEPTH` samples.
/// - **Nothing is lost uncounted** ([`Counts`]). A stamp that does not increase within its stream is refused. A sample with a
///   value that is not finite is missing: of the lead, the row is there and its values are NaN.
/// - **Clocks that jump.** After a jump ahead or a single wild stamp, and when [`SET_BACK_AFTER`] stamps in a row were not
///   above the newest but increase among themselves, the stream starts anew where it now is.
/// - **The same bits everywhere**, no heap, no panic; a push or a pop takes at most a few passes over one queue.
///
/// `DEPTH` samples of the lead and of each follower are queued, and [`SLOW_DEPTH`] of each slow channel: a batch of each must
/// go in. In f32 with one follower, one slow channel and a depth of 32 it is 1,928 bytes (64-bit).
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
    /// Leads at the front that no follower is waited for, since their clock was set back behind them.
    hurried: usize,
    followers: [Follower<R, DEPTH>; FOLLOWERS],
    slow: [Slow<R>; SLOW],
}

/// A row: a sample of the lead, and what the others have at its stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Joined<R, const FOLLOWERS: usize, const SLOW: usize> {
    /// As the lead stamped it.
    pub stamp: i64,
    /// As the lead measured it; all NaN if any was not finite.
    pub lead: [R; 3],
    /// Every follower there.
    pub followers: [Interpolated<R>; FOLLOWERS],
    /// Every slow channel there.
    pub slow: [Held<R>; SLOW],
}

/// A stream of an [`Aligner`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stream {
    /// The one whose stamps are the grid.
    Lead,
    /// A follower, the first is 0.
    Follower(usize),
    /// A slow channel, the first is 0.
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
    /// With the period of every follower and of every slow channel, ticks.
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

    /// With periods of 0 until they are set: whatever is not at a stamp of the lead is missing. May be in a `static`, and is
    /// made in place.
    pub const fn without_periods() -> Self {
        const { assert!(DEPTH >= 2, "a follower needs two samples to be interpolated between") };
        Self {
            lead: Deque::new(),
            order: Order::NEW,
            counts: Counts::NONE,
            hurried: 0,
            followers: [const { Follower::NEW }; FOLLOWERS],
            slow: [const { Slow::NEW }; SLOW],
        }
    }

    /// Another period for a follower, ticks, by which its neighbours are judged from the next row on; nothing without
    /// such a follower.
    pub fn set_follower_period(&mut self, follower: usize, period: i64) {
        if let Some(follower) = self.followers.get_mut(follower) {
            follower.set_period(period);
        }
    }

    /// Another period for a slow channel, ticks, by which its age is judged from the next row on; nothing without such a
    /// channel.
    pub fn set_slow_period(&mut self, slow: usize, period: i64) {
        if let Some(slow) = self.slow.get_mut(slow) {
            slow.set_period(period);
        }
    }

    /// Takes a sample of the lead. Call [`Self::pop`] after it until there is nothing more: pushed into a full queue, it
    /// takes the place of the oldest, which is lost and counted.
    ///
    /// # Errors
    /// Its stamp does not increase; it is not taken. Or a value is not finite; it is taken as a row whose lead is missing.
    pub fn push_lead(&mut self, stamp: i64, values: [R; 3]) -> Result<(), Refused> {
        match self.order.arrive(stamp) {
            Arrival::InOrder => {}
            Arrival::Refused => return self.counts.refuse(),
            Arrival::SetBack => {
                self.counts.set_back();
                self.hurried = self.lead.len();
            }
        }
        let finite = values.iter().all(|value| value.is_finite());
        let value = if finite { values } else { [R::from_f64(f64::NAN); 3] };
        if self.lead.is_full() {
            let _ = self.lead.pop_front();
            self.hurried = self.hurried.saturating_sub(1);
            self.counts.drop_samples(1);
        }
        let _ = self.lead.push_back(Stamped { stamp, value }); // there is room
        if finite { Ok(()) } else { self.counts.miss() }
    }

    /// Takes a sample of a follower.
    ///
    /// # Errors
    /// There is no such follower, its stamp does not increase, or a value is not finite; it is not taken.
    pub fn push_follower(&mut self, follower: usize, stamp: i64, values: [R; 3]) -> Result<(), Refused> {
        self.followers.get_mut(follower).ok_or(Refused::NoSuchStream)?.push(stamp, values)
    }

    /// Takes a value of a slow channel.
    ///
    /// # Errors
    /// There is no such channel, its stamp does not increase, or the value is not finite; it is not taken.
    pub fn push_slow(&mut self, slow: usize, stamp: i64, value: R) -> Result<(), Refused> {
        self.slow.get_mut(slow).ok_or(Refused::NoSuchStream)?.push(stamp, value)
    }

    /// The next row, as soon as nothing that may still come can change it, or the queue of the lead is full.
    pub fn pop(&mut self) -> Option<Joined<R, FOLLOWERS, SLOW>> {
        let stamp = self.lead.front()?.stamp;
        let waits = self.hurried == 0 && !self.lead.is_full();
        if waits && !self.followers.iter_mut().all(|follower| follower.is_certain_at(stamp)) {
            return None;
        }
        self.flush()
    }

    /// The next row with what there is, without waiting for any follower: for the end, or before a long sleep.
    pub fn flush(&mut self) -> Option<Joined<R, FOLLOWERS, SLOW>> {
        let Stamped { stamp, value: lead } = self.lead.pop_front()?;
        self.hurried = self.hurried.saturating_sub(1);
        Some(Joined {
            stamp,
            lead,
            followers: self.followers.each_mut().map(|follower| follower.at(stamp)),
            slow: self.slow.each_mut().map(|slow| slow.at(stamp)),
        })
    }

    /// What was refused, missing or lost of a stream, and how often it was missing in a row; all 0 without such a stream.
    pub fn counts(&self, stream: Stream) -> Counts {
        let counts = match stream {
            Stream::Lead => Some(self.counts),
            Stream::Follower(index) => self.followers.get(index).map(Follower::counts),
            Stream::Slow(index) => self.slow.get(index).map(Slow::counts),
        };
        counts.unwrap_or_default()
    }
}

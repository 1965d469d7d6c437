//! A slow channel: its newest value, and how old it is.

use super::counts::{Counts, Refused};
use super::order::distance;
use super::queue::Queue;
use crate::Real;

/// A value that is older than so many periods of its channel is missing: one read that is late and one that fails are
/// nothing to a temperature or a supply, that a third does not come means that nothing does.
pub const HELD_PERIODS: u32 = 3;

/// Values of a slow channel that are queued: a batch of 0.2 s of a thermometer of 26 Hz has five.
pub const SLOW_DEPTH: usize = 8;

/// What a slow channel has at a stamp of the lead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Held<R> {
    /// The newest that is not of later; NaN where it is missing.
    pub value: R,
    /// How old it is, ticks; `None` where it is missing.
    pub age: Option<i64>,
}

#[derive(Debug, Clone)]
pub(super) struct Slow<R> {
    values: Queue<R, SLOW_DEPTH>,
    /// Oldest that is held, ticks.
    oldest: u64,
}

impl<R: Real> Slow<R> {
    pub(super) const NEW: Self = Self { values: Queue::NEW, oldest: 0 };

    pub(super) fn set_period(&mut self, period: i64) {
        self.oldest = period.max(0).cast_unsigned().saturating_mul(u64::from(HELD_PERIODS));
    }

    pub(super) fn counts(&self) -> Counts {
        self.values.counts
    }

    pub(super) fn push(&mut self, stamp: i64, value: R) -> Result<(), Refused> {
        self.values.push(stamp, value.is_finite().then_some(value))
    }

    /// What it has at `stamp`, which is not before that of the last call unless the lead was set back.
    pub(super) fn at(&mut self, stamp: i64) -> Held<R> {
        let (newest, _) = self.values.around(stamp);
        let held = newest.filter(|newest| newest.stamp <= stamp);
        let held = held.map(|held| (held.value, distance(held.stamp, stamp)));
        match held.filter(|(_, age)| *age <= self.oldest) {
            Some((value, age)) => Held { value, age: Some(i64::try_from(age).unwrap_or(i64::MAX)) },
            None => {
                self.values.counts.missing_in_row();
                Held { value: R::from_f64(f64::NAN), age: None }
            }
        }
    }
}

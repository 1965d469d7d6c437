//! A slow channel: its newest value and the age of it.

use super::counts::{Counts, Refused};
use super::order::distance;
use super::queue::Queue;
use crate::Real;

/// Age, in periods of its channel, above which a value counts as missing. One late and one failed read do not matter for
/// a temperature or supply voltage; if the third fails too, the channel is taken as dead.
pub const HELD_PERIODS: u32 = 3;

/// Capacity of the queue of a slow channel, values: a batch of 0.2 s from a thermometer at 26 Hz has five.
pub const SLOW_DEPTH: usize = 8;

/// Value of a slow channel at a timestamp of the lead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Held<R> {
    /// Newest value at or before the timestamp; NaN if missing.
    pub value: R,
    /// Age of the value, ticks; `None` if missing.
    pub age: Option<i64>,
}

#[derive(Debug, Clone)]
pub(super) struct Slow<R> {
    values: Queue<R, SLOW_DEPTH>,
    /// Maximum age of a held value, ticks.
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

    /// Returns the value at `stamp`, which does not decrease from call to call unless the clock of the lead was set back.
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

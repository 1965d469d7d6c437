//! Queue of the samples of one stream that are still needed.

use heapless::Deque;

use super::counts::{Counts, Refused};
use super::order::{Arrival, Order};

/// A sample with its timestamp, ticks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stamped<T> {
    pub(super) stamp: i64,
    pub(super) value: T,
}

/// Samples in the order of their timestamps, at most one of them not after the lead's last timestamp.
#[derive(Debug, Clone)]
pub(super) struct Queue<T, const DEPTH: usize> {
    samples: Deque<Stamped<T>, DEPTH>,
    order: Order,
    pub(super) counts: Counts,
}

impl<T, const DEPTH: usize> Queue<T, DEPTH> {
    pub(super) const NEW: Self = Self { samples: Deque::new(), order: Order::NEW, counts: Counts::NONE };

    /// Adds a sample; `value` is `None` if it is not finite. A full queue drops its oldest sample.
    pub(super) fn push(&mut self, stamp: i64, value: Option<T>) -> Result<(), Refused> {
        match self.order.arrive(stamp) {
            Arrival::InOrder => {}
            Arrival::Refused => return self.counts.refuse(),
            Arrival::SetBack => {
                self.counts.set_back();
                self.counts.drop_samples(self.samples.len());
                self.samples.clear();
            }
        }
        let Some(value) = value else { return self.counts.miss() };
        if self.samples.is_full() {
            let _ = self.samples.pop_front();
            self.counts.drop_samples(1);
        }
        let _ = self.samples.push_back(Stamped { stamp, value }); // never full here
        Ok(())
    }

    /// Highest timestamp so far, samples that are not finite included.
    pub(super) fn newest(&self) -> Option<i64> {
        self.order.newest()
    }

    /// Returns the last sample at or before `stamp` and the next one, or the first two if all are later. Earlier samples
    /// are discarded, because `stamp` does not decrease from call to call unless the clock of the lead was set back.
    pub(super) fn around(&mut self, stamp: i64) -> (Option<&Stamped<T>>, Option<&Stamped<T>>) {
        for _ in 0..DEPTH {
            if self.samples.get(1).is_none_or(|next| next.stamp > stamp) {
                break;
            }
            let _ = self.samples.pop_front();
        }
        (self.samples.front(), self.samples.get(1))
    }
}

//! Samples of one stream that are still needed.

use heapless::Deque;

use super::counts::{Counts, Refused};
use super::order::{Arrival, Order};

/// A sample and its stamp, ticks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stamped<T> {
    pub(super) stamp: i64,
    pub(super) value: T,
}

/// In order: at most one is not after the lead's last stamp.
#[derive(Debug, Clone)]
pub(super) struct Queue<T, const DEPTH: usize> {
    samples: Deque<Stamped<T>, DEPTH>,
    order: Order,
    pub(super) counts: Counts,
}

impl<T, const DEPTH: usize> Queue<T, DEPTH> {
    pub(super) const NEW: Self = Self { samples: Deque::new(), order: Order::NEW, counts: Counts::NONE };

    /// Takes a sample, whose value is `None` if it is not finite; the oldest is lost if it is full.
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
        let _ = self.samples.push_back(Stamped { stamp, value }); // there is room
        Ok(())
    }

    /// The highest stamp that came, of a sample that is not finite too.
    pub(super) fn newest(&self) -> Option<i64> {
        self.order.newest()
    }

    /// The last sample that is not after `stamp` and the one after it, or the first two if all are after it. What is before
    /// is forgotten: `stamp` is not before that of the last call unless the lead was set back.
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

//! The ring that holds the latest samples, value after value.

use crate::Real;

/// The last `N` values written; `N` is a power of two.
///
/// One ring serves all axes and inputs. Every tick writes one sample into it, always in the same order: the
/// inputs, then the remainder of each axis. A value `lag` ticks old therefore lies a fixed number of places
/// back from the place that is written next, and a [`Factor`](crate::Factor) is nothing but that number. No value
/// is ever moved.
#[derive(Debug, Clone)]
pub(crate) struct History<R, const N: usize> {
    ring: [R; N],
    next: usize,
}

impl<R: Real, const N: usize> History<R, N> {
    const MASK: usize = {
        assert!(N.is_power_of_two(), "a history's capacity is a power of two");
        N - 1
    };

    /// A history of zeros.
    pub(crate) const fn new() -> Self {
        Self { ring: [R::ZERO; N], next: 0 }
    }

    /// Writes the next value over the oldest.
    #[inline]
    pub(crate) fn write(&mut self, value: R) {
        // the mask bounds the index, so this cannot panic and needs no check
        self.ring[self.next & Self::MASK] = value;
        self.next = self.next.wrapping_add(1);
    }

    /// The value written `back` writes ago: 1 is the latest.
    #[inline]
    pub(crate) fn back(&self, back: u16) -> R {
        self.ring[self.next.wrapping_sub(usize::from(back)) & Self::MASK]
    }
}

//! Ring buffer of the latest samples.

use crate::Scalar;

/// The last `N` values written; `N` is a power of two up to 65536.
///
/// One ring serves all axes and inputs. Every tick writes one sample in the same order: the inputs, then the remainder of
/// each axis. A value `lag` ticks old is therefore a fixed number of places before the next write, and a
/// [`Factor`](crate::Factor) compiles to that number. No value is ever moved.
///
/// Every value is written twice, `N` places apart. The values from the oldest to the latest are then always contiguous,
/// and a factor is found without wrap-around: one instruction less per factor, two more per value written.
#[derive(Debug, Clone)]
pub(crate) struct History<R, const N: usize> {
    twice: [[R; N]; 2],
    next: usize,
}

/// The values of a [`History`], oldest first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window<'a, R, const N: usize>(&'a [R; N]);

impl<R: Copy, const N: usize> History<R, N> {
    const MASK: usize = {
        assert!(N.is_power_of_two() && N <= 1 << 16, "a history's capacity is a power of two up to 65536");
        N - 1
    };

    /// A history filled with `value`.
    pub(crate) const fn filled(value: R) -> Self {
        Self { twice: [[value; N]; 2], next: 0 }
    }

    /// Writes `values` in order, each over the oldest value.
    #[inline(always)]
    pub(crate) fn write(&mut self, values: impl Iterator<Item = R>) {
        let [first, second] = &mut self.twice;
        let mut next = self.next;
        for value in values {
            // the mask bounds the index, so this cannot panic and needs no check
            let place = next & Self::MASK;
            (first[place], second[place]) = (value, value);
            next = place + 1;
        }
        self.next = next;
    }

    /// True if nothing has been written since the start or [`clear`](Self::clear).
    pub(crate) fn is_empty(&self) -> bool {
        self.next == 0
    }

    /// The last `N` values written.
    #[inline]
    pub(crate) fn window(&self) -> Window<'_, R, N> {
        let from_oldest = self.twice.as_flattened().get(self.next & Self::MASK..);
        // at least N values remain: the compiler removes the fallback
        Window(from_oldest.and_then(<[R]>::first_chunk).unwrap_or(&self.twice[0]))
    }
}

#[cfg(feature = "coasts")]
impl<R: Copy, const LANES: usize, const N: usize> History<[R; LANES], N> {
    /// Restarts one lane with `values`, oldest first; every lane needs the same number.
    pub(crate) fn begin_lane(&mut self, lane: usize, values: impl Iterator<Item = R>) {
        let [first, second] = &mut self.twice;
        self.next = 0;
        for ((value, first), second) in values.zip(first).zip(second) {
            if let (Some(first), Some(second)) = (first.get_mut(lane), second.get_mut(lane)) {
                (*first, *second) = (value, value);
            }
            self.next += 1;
        }
    }
}

impl<R: Scalar, const N: usize> History<R, N> {
    /// A history of zeros.
    pub(crate) const fn new() -> Self {
        Self::filled(R::ZERO)
    }

    /// Fills the history with zeros, in place.
    pub(crate) fn clear(&mut self) {
        self.twice.as_flattened_mut().fill(R::ZERO);
        self.next = 0;
    }
}

impl<R: Copy, const N: usize> Window<'_, R, N> {
    /// Place of the value written `back` writes ago, 1 for the latest; `None` if it has been overwritten.
    pub(crate) fn place(back: usize) -> Option<u16> {
        if back == 0 { None } else { N.checked_sub(back).and_then(|place| u16::try_from(place).ok()) }
    }

    /// The value at `place`.
    #[inline]
    pub(crate) fn at(self, place: u16) -> R {
        // the mask bounds the index, so this cannot panic and needs no check
        self.0[usize::from(place) & History::<R, N>::MASK]
    }
}

#[cfg(feature = "coasts")]
impl<'a, R: Copy, const LANES: usize, const N: usize> Window<'a, [R; LANES], N> {
    /// Reference to the values at `place`, one per lane.
    #[inline(always)]
    pub(crate) fn lanes(self, place: u16) -> &'a [R; LANES] {
        &self.0[usize::from(place) & History::<[R; LANES], N>::MASK]
    }
}

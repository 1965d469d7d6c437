//! Order of the timestamps of one stream: increasing, unless the clock was set back.

/// Number of consecutive timestamps, not above the newest but increasing among themselves, after which the clock counts
/// as set back. Samples out of order come one or two at a time; at 26 Hz, the lowest rate of inertial sensors, eight
/// samples take 0.3 s.
pub const SET_BACK_AFTER: u8 = 8;

/// Ticks from one timestamp to a later one; the difference may exceed an `i64`.
pub(super) fn distance(from: i64, to: i64) -> u64 {
    to.wrapping_sub(from).cast_unsigned()
}

/// Classifies the timestamps of a stream.
#[derive(Debug, Clone, Copy)]
pub(super) struct Order {
    newest: Option<i64>,
    /// The last refused timestamp; `in_a_row` counts the consecutive refused ones that increase.
    refused: i64,
    in_a_row: u8,
}

/// Classification of a timestamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Arrival {
    InOrder,
    Refused,
    /// The clock was set back: the stream restarts at this timestamp.
    SetBack,
}

impl Order {
    pub(super) const NEW: Self = Self { newest: None, refused: 0, in_a_row: 0 };

    /// Highest timestamp since the clock was last set back.
    pub(super) fn newest(&self) -> Option<i64> {
        self.newest
    }

    pub(super) fn arrive(&mut self, stamp: i64) -> Arrival {
        if self.newest.is_none_or(|newest| stamp > newest) {
            (self.newest, self.in_a_row) = (Some(stamp), 0);
            return Arrival::InOrder;
        }
        let increases = self.in_a_row > 0 && stamp > self.refused;
        self.in_a_row = if increases { self.in_a_row.saturating_add(1) } else { 1 };
        self.refused = stamp;
        if self.in_a_row < SET_BACK_AFTER {
            return Arrival::Refused;
        }
        (self.newest, self.in_a_row) = (Some(stamp), 0);
        Arrival::SetBack
    }
}

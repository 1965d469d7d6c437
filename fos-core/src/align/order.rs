//! Stamps of one stream: they increase, or the clock was set back.

/// So many stamps in a row that are not above the newest, but increase among themselves, are a clock that was set back:
/// samples out of order come one or two at a time, and at 26 Hz, the slowest that inertial sensors run at, it is a third of
/// a second.
pub const SET_BACK_AFTER: u8 = 8;

/// Ticks from one stamp to a later one, which may be more than an `i64` holds.
pub(super) fn distance(from: i64, to: i64) -> u64 {
    to.wrapping_sub(from).cast_unsigned()
}

/// The order of a stream.
#[derive(Debug, Clone, Copy)]
pub(super) struct Order {
    newest: Option<i64>,
    /// The last stamp that was refused, and how many there were in a row that increase.
    refused: i64,
    in_a_row: u8,
}

/// What a stamp is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Arrival {
    InOrder,
    Refused,
    /// The stream starts anew with it.
    SetBack,
}

impl Order {
    pub(super) const NEW: Self = Self { newest: None, refused: 0, in_a_row: 0 };

    /// The highest stamp since the clock was last set back.
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

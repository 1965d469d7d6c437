//! Time beyond the 32 bits of a timer.

/// Time since the start, from a timer of 1 MHz that wraps after 71 minutes.
pub struct Clock {
    latest_us: u64,
}

impl Clock {
    pub const fn new() -> Self {
        Self { latest_us: 0 }
    }

    /// Time at which the timer had this value, µs: the one nearest to the latest, at most 35 minutes from it.
    pub fn time_us(&mut self, timer: u32) -> u64 {
        let since = timer.wrapping_sub(self.latest_us as u32).cast_signed();
        self.latest_us = self.latest_us.saturating_add_signed(since.into());
        self.latest_us
    }
}

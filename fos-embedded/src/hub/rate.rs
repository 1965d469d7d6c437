//! Measurement of the sensor's true sampling rate with the application's clock.
//!
//! The clocks of inertial sensors are up to 5 % off, and so are their own timestamps; only another clock shows it.

/// Length of the measurement window, µs. Emptying a FIFO leaves an uncertainty of one sample at either end: 0.1 % at
/// 200 Hz.
const WINDOW_US: u64 = 10_000_000;

/// Rate over the latest complete window between two readings of the clock.
#[derive(Debug, Clone, Copy)]
pub(super) struct RateEstimator {
    /// Clock at the start of the window, µs.
    start_us: Option<u64>,
    /// Ticks since then.
    ticks: u32,
    rate_hz: Option<f32>,
}

impl RateEstimator {
    pub(super) const fn new() -> Self {
        Self { start_us: None, ticks: 0, rate_hz: None }
    }

    /// Counts ticks.
    #[inline]
    pub(super) fn tick(&mut self, ticks: u32) {
        self.ticks = self.ticks.saturating_add(ticks);
    }

    /// Restarts the window, because the number of ticks in it is no longer known.
    pub(super) fn disturbed(&mut self) {
        self.start_us = None;
    }

    /// Reads the clock, µs, after all ticks up to now were counted. Returns true if it was set back beyond the start of
    /// the window; a clock set back by less gives a wrong rate.
    pub(super) fn clock(&mut self, now_us: u64) -> bool {
        let elapsed = self.start_us.and_then(|start_us| now_us.checked_sub(start_us));
        let set_back = self.start_us.is_some() && elapsed.is_none();
        match elapsed {
            Some(elapsed) if elapsed < WINDOW_US => return false,
            // after more than twice the window the device slept, and the FIFO may have overrun unnoticed
            Some(elapsed) if elapsed < 2 * WINDOW_US => {
                self.rate_hz = Some(self.ticks as f32 * 1e6 / elapsed as u32 as f32);
            }
            Some(_) | None => {}
        }
        (self.start_us, self.ticks) = (Some(now_us), 0);
        set_back
    }

    /// Ticks per second; `None` before the first complete window.
    pub(super) fn rate_hz(&self) -> Option<f32> {
        self.rate_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(rate: &mut RateEstimator, from_us: u64, seconds: u64, samples_per_second: f64) -> u64 {
        let mut given = 0;
        for look in 1..=20 * seconds {
            let due = (look as f64 / 20.0 * samples_per_second) as u32;
            rate.tick(due - given);
            given = due;
            assert!(!rate.clock(from_us + look * 50_000));
        }
        from_us + seconds * 1_000_000
    }

    #[test]
    fn measures_a_clock_error_of_three_percent() {
        for true_hz in [194.0, 200.0, 206.0] {
            let mut rate = RateEstimator::new();
            run(&mut rate, 7, 9, true_hz);
            assert_eq!(rate.rate_hz(), None, "not yet");
            run(&mut rate, 9_000_007, 12, true_hz);
            let found = f64::from(rate.rate_hz().expect("a rate"));
            assert!((found - true_hz).abs() < 1e-3 * true_hz, "{found}");
        }
    }

    #[test]
    fn discards_windows_of_unknown_length_or_ticks() {
        let mut rate = RateEstimator::new();
        let now_us = run(&mut rate, 0, 8, 200.0);
        rate.disturbed();
        let now_us = run(&mut rate, now_us, 8, 200.0);
        assert!(!rate.clock(now_us + 60_000_000), "slept through");
        assert!(rate.clock(now_us), "set back");
        assert_eq!(rate.rate_hz(), None);
        run(&mut rate, now_us, 11, 200.0);
        assert!(rate.rate_hz().is_some());
    }
}

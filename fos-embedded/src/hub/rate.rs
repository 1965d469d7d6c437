//! The sensor's true sample rate, by the application's clock.
//!
//! The clocks of inertial sensors are up to 5 % off, and their own time stamps are off with them: only another clock
//! can tell.

/// The rate is taken over so long, µs. Reading a FIFO empty leaves at most a sample of doubt at either end: 0.1 % at
/// 200 Hz.
const WINDOW_US: u64 = 10_000_000;

/// The rate over the latest whole window between two looks at the clock.
#[derive(Debug, Clone, Copy)]
pub(super) struct RateEstimator {
    /// Clock at the start of the window, µs.
    start_us: Option<u64>,
    /// Ticks since.
    ticks: u32,
    rate_hz: Option<f32>,
}

impl RateEstimator {
    pub(super) const fn new() -> Self {
        Self { start_us: None, ticks: 0, rate_hz: None }
    }

    /// Ticks have passed.
    #[inline]
    pub(super) fn tick(&mut self, ticks: u32) {
        self.ticks = self.ticks.saturating_add(ticks);
    }

    /// How many ticks have passed is no longer known: the window begins anew.
    pub(super) fn disturbed(&mut self) {
        self.start_us = None;
    }

    /// What the clock shows, µs, now that all ticks up to now were given. Says whether it was set back beyond the
    /// window's start; set back by less, it gives a rate that is off.
    pub(super) fn clock(&mut self, now_us: u64) -> bool {
        let elapsed = self.start_us.and_then(|start_us| now_us.checked_sub(start_us));
        let set_back = self.start_us.is_some() && elapsed.is_none();
        match elapsed {
            Some(elapsed) if elapsed < WINDOW_US => return false,
            // a window that has lasted twice as long was slept through: the FIFO may have run over unseen
            Some(elapsed) if elapsed < 2 * WINDOW_US => {
                self.rate_hz = Some(self.ticks as f32 * 1e6 / elapsed as u32 as f32);
            }
            Some(_) | None => {}
        }
        (self.start_us, self.ticks) = (Some(now_us), 0);
        set_back
    }

    /// Ticks a second; none before the first whole window.
    pub(super) fn rate_hz(&self) -> Option<f32> {
        self.rate_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(rate: &mut RateEstimator, from_us: u64, seconds: u64, samples_a_second: f64) -> u64 {
        let mut given = 0;
        for look in 1..=20 * seconds {
            let due = (look as f64 / 20.0 * samples_a_second) as u32;
            rate.tick(due - given);
            given = due;
            assert!(!rate.clock(from_us + look * 50_000));
        }
        from_us + seconds * 1_000_000
    }

    #[test]
    fn tells_a_clock_that_is_three_percent_off_to_a_tenth_of_a_percent() {
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
    fn a_window_of_unknown_length_or_ticks_tells_nothing() {
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

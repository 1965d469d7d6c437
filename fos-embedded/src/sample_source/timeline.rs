//! Counts the ticks between samples from the timestamps of the sensor.

/// Tolerated difference of a step between the sensor's and the application's clock, µs, plus an eighth of the step. Beyond
/// it the timestamp was damaged on the bus, or is a word of another frame. Sensor clocks are up to 5 % off, and an
/// application may read its clock late.
const DOUBT_US: i64 = 320_000;

/// Longest step, µs: one day. Longer ones are limited to it.
const LONGEST_US: u64 = 86_400_000_000;

/// Clock of a sensor, from which its frames have their timestamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SensorClock {
    /// Bits of a timestamp; at most 32.
    pub bits: u32,
    /// Nominal length of a count, ps.
    pub count_ps: u32,
    /// Nominal sample period, ns.
    pub period_ns: u32,
}

impl SensorClock {
    /// Nominal sample period, µs.
    pub const fn period_us(&self) -> u64 {
        self.period_ns as u64 / 1000
    }

    /// Counts after which a timestamp repeats.
    const fn turn(&self) -> i64 {
        match 1_i64.checked_shl(self.bits) {
            Some(turn) => turn,
            None => 1 << 32,
        }
    }

    /// Duration of `counts`, ns.
    const fn ns(&self, counts: i64) -> i64 {
        counts.saturating_mul(self.count_ps as i64) / 1000
    }
}

/// Time of the latest sample.
#[derive(Debug)]
pub(super) struct Timeline {
    /// Time by the application's clock, µs; `None` before the first sample.
    at_us: Option<u64>,
    /// Timestamp of the sensor; `None` if its clock has restarted since.
    stamp: Option<u32>,
}

impl Timeline {
    pub(super) const fn new() -> Self {
        Self { at_us: None, stamp: None }
    }

    /// Notes that the sensor's clock has restarted.
    pub(super) fn restart(&mut self) {
        self.stamp = None;
    }

    /// Returns the ticks from the previous sample to one with this timestamp, taken at about `at_us` of the application's
    /// clock; at least 1. `None` if the timestamp is implausible: the frame must be discarded, and the next step counts from
    /// the previous sample.
    ///
    /// The sensor's clock counts the ticks; the application's clock counts its wrap-arounds, and the ticks across a reset.
    /// With `overrun`, the step may be longer than one wrap-around.
    pub(super) fn step(&mut self, clock: &SensorClock, stamp: u32, at_us: u64, overrun: bool) -> Option<u32> {
        let Some(before_us) = self.at_us else {
            (self.at_us, self.stamp) = (Some(at_us), Some(stamp));
            return Some(1);
        };
        let elapsed_us = at_us.saturating_sub(before_us).min(LONGEST_US) as i64;
        let elapsed_ns = elapsed_us.saturating_mul(1000);
        let ticks = match self.stamp {
            None => ticks(clock, elapsed_ns).max(1),
            Some(before) => {
                let counts = i64::from(stamp.wrapping_sub(before)).checked_rem(clock.turn()).unwrap_or(0);
                let one_turn_ns = clock.ns(counts);
                let one_turn = ticks(clock, one_turn_ns);
                if one_turn == 1 && !overrun {
                    1
                } else {
                    let turn_ns = clock.ns(clock.turn());
                    let turns = nearest(elapsed_ns.saturating_sub(one_turn_ns), turn_ns);
                    let step_ns = one_turn_ns.saturating_add(turns.saturating_mul(turn_ns));
                    let doubt_ns = DOUBT_US.saturating_mul(1000).saturating_add(elapsed_ns / 8);
                    if step_ns.saturating_sub(elapsed_ns).saturating_abs() > doubt_ns {
                        return None;
                    }
                    ticks(clock, step_ns)
                }
            }
        };
        if ticks < 1 {
            return None;
        }
        // the newest frame of a FIFO may be old if the sensor has stopped since; its clock is never an eighth slow
        let step_us = (ticks as u64).saturating_mul(clock.period_us());
        let latest_us = before_us.saturating_add(step_us).saturating_add(step_us / 8);
        let at_us = if self.stamp.is_some() { at_us.min(latest_us) } else { at_us };
        (self.at_us, self.stamp) = (Some(at_us), Some(stamp));
        Some(u32::try_from(ticks).unwrap_or(u32::MAX))
    }
}

/// Number of periods nearest to `length_ns`.
fn ticks(clock: &SensorClock, length_ns: i64) -> i64 {
    nearest(length_ns, i64::from(clock.period_ns))
}

/// Integer nearest to `dividend`/`divisor`; `divisor` is positive.
fn nearest(dividend: i64, divisor: i64) -> i64 {
    dividend.saturating_add(divisor / 2).checked_div_euclid(divisor).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 128 counts per tick, 512 ticks per wrap-around.
    const SHORT: SensorClock = SensorClock { bits: 16, count_ps: 39_062_500, period_ns: 5_000_000 };
    /// 230.4 counts per tick.
    const LONG: SensorClock = SensorClock { bits: 32, count_ps: 21_701_389, period_ns: 5_000_000 };

    /// Timestamp of tick `n`, from a sensor clock that is `fast` times the nominal one.
    fn stamp(clock: &SensorClock, n: u64, fast: f64) -> u32 {
        let counts = n as f64 * f64::from(clock.period_ns) * 1000.0 / f64::from(clock.count_ps) * fast;
        (counts as u64 % clock.turn() as u64) as u32
    }

    #[test]
    fn counts_gaps_over_several_wrap_arounds() {
        for clock in [SHORT, LONG] {
            for offset in [0, 500, 18_600_000] {
                for gap in (1..200).chain((200..6000).step_by(37)) {
                    let mut line = Timeline::new();
                    let first = stamp(&clock, offset, 1.0);
                    assert_eq!(line.step(&clock, first, 0, false), Some(1));
                    let at_us = gap * 5000 + 30_000; // the application reads its clock late
                    let ticks = line.step(&clock, stamp(&clock, offset + gap, 1.0), at_us, gap > 100);
                    assert_eq!(ticks, Some(gap as u32));
                }
            }
        }
    }

    #[test]
    fn three_percent_clock_error_makes_no_gaps() {
        for (clock, fast) in [(SHORT, 1.03), (LONG, 0.97)] {
            let mut line = Timeline::new();
            for n in 0..5000 {
                let at_us = (n as f64 * 5000.0 / fast) as u64;
                // sampling and timestamps use the same clock
                assert_eq!(line.step(&clock, stamp(&clock, n, 1.0), at_us, n % 7 == 0), Some(1));
            }
        }
    }

    #[test]
    fn rejects_implausible_timestamps() {
        for clock in [SHORT, LONG] {
            let mut line = Timeline::new();
            assert_eq!(line.step(&clock, stamp(&clock, 1000, 1.0), 0, false), Some(1));
            for wrong in [1000, 999, 900, 1100, 1200] {
                assert_eq!(line.step(&clock, stamp(&clock, wrong, 1.0), 5000, false), None, "{wrong}");
            }
            assert_eq!(line.step(&clock, stamp(&clock, 1002, 1.0), 10_000, false), Some(2));
        }
    }

    #[test]
    fn counts_by_the_application_clock_across_a_reset() {
        let mut line = Timeline::new();
        assert_eq!(line.step(&LONG, 77, 1_000_000, false), Some(1));
        line.restart();
        assert_eq!(line.step(&LONG, 5, 1_200_000, false), Some(40));
        assert_eq!(line.step(&LONG, 235, 1_205_000, false), Some(1));
        line.restart();
        assert_eq!(line.step(&LONG, 5, 0, false), Some(1), "a clock that was set back");
    }

    #[test]
    fn samples_of_a_stopped_sensor_are_not_younger_than_its_clock_shows() {
        for clock in [SHORT, LONG] {
            let mut line = Timeline::new();
            for n in 0..15 {
                // the application reads ten frames, then five that are 25 ms old
                let at_us = if n < 10 { n * 5000 } else { n * 5000 + 25_000 };
                assert_eq!(line.step(&clock, stamp(&clock, n, 1.0), at_us, false), Some(1));
            }
            line.restart();
            // 26 without the tolerance of an eighth, 21 by the application's clock alone
            assert_eq!(line.step(&clock, 0, 200_000, false), Some(25));
        }
    }

    #[test]
    fn accepts_any_numbers() {
        for clock in [SHORT, LONG, SensorClock { bits: 99, count_ps: u32::MAX, period_ns: 0 }] {
            let mut line = Timeline::new();
            for stamp in [0, 1, u32::MAX, 7, 1 << 31] {
                for at_us in [0, u64::MAX, 5, 1 << 40] {
                    let _ = line.step(&clock, stamp, at_us, true);
                    line.restart();
                    let _ = line.step(&clock, stamp, at_us, false);
                }
            }
        }
    }
}

//! Duty-cycled logs: bursts of samples, and pauses without loss.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::*;

/// True period of the synthetic logs: 0.7 % off 50 Hz.
const T: f64 = 0.02 * 1.007;

fn load(time_s: Vec<f64>, rate_hz: Option<f64>) -> Result<Recording, RecordingError> {
    let values = vec![0.0; time_s.len()];
    let columns = vec![("t_s".to_owned(), time_s), ("gx_rads".to_owned(), values)];
    let options = LoadOptions { rate_hz, ..LoadOptions::default() };
    Recording::from_columns(Source::made_by("test"), columns, &options)
}

/// Timestamps of `bursts` bursts of `rows` rows, one every `every_s`, with a random delay of up to a fifth of it.
fn duty_cycled(bursts: usize, rows: usize, every_s: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let begins = (0..bursts).map(|burst| (burst as f64 + random.random_range(0.0..0.2)) * every_s);
    begins.flat_map(|begin| (0..rows).map(move |row| begin + row as f64 * T)).collect()
}

#[track_caller]
fn is_read(time_s: Vec<f64>, bursts: usize, within: f64) {
    for rate_hz in [None, Some(50.0)] {
        let log = load(time_s.clone(), rate_hz).unwrap();
        assert!((log.rate.period_s / T - 1.0).abs() < within, "{} Hz", log.rate.true_hz);
        assert_eq!((log.quality.gaps, log.quality.samples_missing, log.samples_missing()), (0, 0, 0));
        assert_eq!((log.segments.len(), log.quality.pauses), (bursts, bursts as u64 - 1));
        assert!(log.segments[1..].iter().all(|segment| segment.boundary == Boundary::Pause));
        // the ticks keep the time
        let last = &log.segments[bursts - 1];
        let counted_s = last.tick as f64 * log.rate.period_s;
        let stamped_s = log.time_s[last.rows.start] - log.time_s[0];
        assert!((counted_s / stamped_s - 1.0).abs() < 1e-3, "{counted_s} {stamped_s}");
    }
}

/// 50 Hz for 5 s every 300 s used to be read as 0.83 Hz, the mean.
#[test]
fn rate_of_a_duty_cycled_log_excludes_pauses() {
    for (bursts, rows, every_s) in [(288, 250, 300.0), (60, 256, 20.0), (500, 50, 60.0), (100, 1500, 600.0)] {
        is_read(duty_cycled(bursts, rows, every_s, 1), bursts, 1e-9);
    }
}

#[test]
fn duty_cycle_survives_jitter_rounding_and_polling() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let jitter = Normal::new(0.0, 0.2 * T).unwrap();
    let exact = duty_cycled(200, 250, 300.0, 3);
    is_read(exact.iter().map(|stamp| stamp + jitter.sample(&mut random)).collect(), 200, 1e-4);
    is_read(exact.iter().map(|stamp| (stamp * 1e3).floor() / 1e3).collect(), 200, 1e-5);
    let mut polled: Vec<f64> = exact.iter().map(|stamp| (stamp / 0.16).ceil() * 0.16).collect();
    for row in 1..polled.len() {
        polled[row] = polled[row].max(polled[row - 1] + 5e-4);
    }
    is_read(polled, 200, 1e-3);
}

#[test]
fn counts_losses_within_a_burst() {
    let mut stamps = duty_cycled(200, 250, 300.0, 4);
    for burst in (0..200).rev().step_by(10) {
        stamps.drain(250 * burst + 100..250 * burst + 103);
    }
    let log = load(stamps, None).unwrap();
    assert_eq!((log.quality.gaps, log.samples_missing(), log.quality.pauses), (20, 60, 199));
}

/// Seconds between two polls are no pauses: everything was recorded.
#[test]
fn slow_polling_is_no_pause() {
    let stamps = |rate_hz: f64, poll_s: f64| -> Vec<f64> {
        let ready = (0..40_000).map(|row| ((row + 1) as f64 / rate_hz / poll_s).ceil() * poll_s);
        let mut stamps: Vec<f64> = ready.collect();
        for row in 1..stamps.len() {
            stamps[row] = stamps[row].max(stamps[row - 1] + 5e-4);
        }
        stamps
    };
    for (rate_hz, poll_s) in [(100.0, 1.5), (50.0, 5.0), (12.5, 20.0)] {
        let log = load(stamps(rate_hz, poll_s), None).unwrap();
        assert!((log.rate.true_hz / rate_hz - 1.0).abs() < 0.01, "{}", log.rate.true_hz);
        assert_eq!((log.segments.len(), log.rate.stamps), (1, Stamps::Bursts));
    }
    // 2 s of 5 s at 50 Hz look the same as 20 Hz polled every 5 s: the stated rate decides
    let ambiguous = duty_cycled(200, 100, 5.0, 5);
    assert!((load(ambiguous.clone(), None).unwrap().rate.period_s / T - 1.0).abs() < 1e-6);
    assert!((load(ambiguous, Some(20.0)).unwrap().rate.true_hz / 20.0 - 1.0).abs() < 0.07);
}

#[test]
fn ten_seconds_of_nothing_are_a_pause_and_five_a_loss() {
    for (hole_s, pauses, missing) in [(5.0, 0, 248), (12.0, 1, 0)] {
        let stamps = (0..5000).map(|row| row as f64 * T + if row < 2000 { 0.0 } else { hole_s });
        let log = load(stamps.collect(), None).unwrap();
        assert_eq!((log.quality.pauses, log.segments.len()), (pauses, 2));
        assert!(log.samples_missing().abs_diff(missing) <= 2, "{}", log.samples_missing());
    }
}

#[test]
fn stated_rate_replaces_contradicting_timestamps_and_keeps_pauses() {
    for (rate_hz, is_right) in [(50.0, true), (52.0, true), (55.0, false), (40.0, false), (200.0, false)] {
        let log = load(duty_cycled(100, 250, 300.0, 6), Some(rate_hz)).unwrap();
        assert_eq!((log.rate.nominal_hz, log.segments.len(), log.quality.pauses), (Some(rate_hz), 100, 99));
        assert_eq!(
            (log.rate.true_hz == rate_hz, log.quality.clock.is_empty()),
            (!is_right, is_right),
            "{rate_hz}"
        );
        let text = log.quality.clock.iter().map(ToString::to_string).collect::<String>();
        assert!(is_right || text.contains("49.65") && text.contains(&rate_hz.to_string()), "{text}");
    }
}

/// A duty cycle of one half in 5.7 s used to be reported as 49 % of the samples lost.
#[test]
fn short_pauses_at_regular_intervals_are_a_duty_cycle() {
    let stamps = |waits: &mut dyn FnMut(usize) -> f64| -> Vec<f64> {
        let (mut stamps, mut begin) = (Vec::new(), 0.0);
        for burst in 0..120 {
            stamps.extend((0..144).map(|row| begin + row as f64 * T));
            begin += 144.0 * T + waits(burst);
        }
        stamps
    };
    let log = load(stamps(&mut |burst| 2.8 + 0.1 * (burst % 3) as f64), Some(50.0)).unwrap();
    assert_eq!((log.quality.gaps, log.samples_missing(), log.quality.pauses), (0, 0, 119));
    let cycle = log.duty_cycle().unwrap();
    assert_eq!(cycle.to_string(), "recorded in 120 bursts of 2.9 s every 5.8 s");
    // a gap of another length is still a gap
    let log = load(stamps(&mut |burst| if burst == 60 { 8.0 } else { 2.8 }), Some(50.0)).unwrap();
    assert_eq!((log.quality.gaps, log.quality.pauses), (1, 118));
}

/// Negative control of the rule: losses of any length at random moments are losses.
#[test]
fn losses_at_random_moments_are_no_duty_cycle() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for seconds in [1.5, 4.0] {
        let (mut stamps, mut now) = (Vec::new(), 0.0);
        for _ in 0..40_000 {
            stamps.push(now);
            now += T;
            if random.random_range(0.0..1.0) < 0.003 {
                now += seconds;
            }
        }
        let log = load(stamps, Some(50.0)).unwrap();
        assert!(log.duty_cycle().is_none() && log.samples_missing() > 1000, "{:?}", log.duty_cycle());
    }
}

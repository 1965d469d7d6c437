//! The gap rule on timestamps with known truth.

use std::ops::Range;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::*;

/// True period of the synthetic logs: 1.3 % off 200 Hz.
pub(super) const T: f64 = 0.005 * 1.013;

fn record(time_s: Vec<f64>) -> Recording {
    let values = vec![0.0; time_s.len()];
    let columns = vec![("t_s".to_owned(), time_s), ("gx_rads".to_owned(), values)];
    Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).unwrap()
}

/// Row and number of missing samples of every gap.
pub(super) fn gaps(recording: &Recording) -> Vec<(usize, u64)> {
    recording.segments[1..].iter().map(|s| (s.rows.start, s.missing_before)).collect()
}

/// Timestamps of `n` samples with normal jitter of `sd` periods.
fn jittered(n: usize, sd: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let jitter = Normal::new(0.0, sd * T).unwrap();
    (0..n).map(|i| 100.0 + i as f64 * T + jitter.sample(&mut random)).collect()
}

/// Arrival times at a host that polls every 1 to `longest` samples, and reads the buffer at 0.2 T per sample.
pub(super) fn bursts(n: usize, longest: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut stamps = Vec::with_capacity(n);
    let mut poll = 0.0_f64;
    while stamps.len() < n {
        poll += random.random_range(1.0..longest) * T;
        let mut read_at = poll;
        while stamps.len() < n && stamps.len() as f64 * T <= read_at {
            stamps.push(read_at);
            read_at += 0.2 * T;
        }
        poll = poll.max(read_at);
    }
    stamps
}

fn remove(mut stamps: Vec<f64>, rows: Range<usize>) -> Vec<f64> {
    stamps.drain(rows);
    stamps
}

#[test]
fn a_single_missing_sample_splits_the_segment() {
    let recording = record(remove((0..1000).map(|i| i as f64 * T).collect(), 400..401));
    assert_eq!(gaps(&recording), [(400, 1)]);
    assert_eq!(recording.segments[1].tick, 401);
    assert_eq!(recording.segments[1].boundary, Boundary::Gap);
    assert_eq!((recording.quality.gaps, recording.quality.samples_missing), (1, 1));
    assert!((recording.rate.period_s / T - 1.0).abs() < 1e-12);
    assert_eq!(recording.rate.stamps, Stamps::Regular);
}

#[test]
fn jitter_of_a_fifth_of_the_period_never_makes_a_gap() {
    for seed in 0..10 {
        let recording = record(jittered(100_000, 0.2, seed));
        assert_eq!(gaps(&recording), [], "seed {seed}");
        assert_eq!(recording.rate.stamps, Stamps::Jittered);
        // the median of N/2 slopes over N/2 rows: 1.25 · 0.2 √2 / (N/2) / √(N/2) = 3e-8 of T, times six
        assert!((recording.rate.period_s / T - 1.0).abs() < 2e-7, "{}", recording.rate.period_s / T);
        // a robust sd of N timestamps is accurate to 1.2/√N; blocks of 64 remove 1/64 of the variance
        assert!((recording.rate.jitter_s / (0.2 * T) - 1.0).abs() < 0.03, "{}", recording.rate.jitter_s / T);
    }
}

#[test]
fn bursts_never_make_a_gap() {
    for seed in 0..10 {
        for longest in [4.0, 12.0, 60.0] {
            let recording = record(bursts(60_000, longest, seed));
            assert_eq!(gaps(&recording), [], "seed {seed}, up to {longest} samples");
            assert!((recording.rate.period_s / T - 1.0).abs() < 1e-4);
            if longest > 4.0 {
                assert_eq!(recording.rate.stamps, Stamps::Bursts);
            }
        }
    }
}

#[test]
fn a_poll_that_slips_slowly_against_the_sample_clock_makes_no_gap() {
    for poll_in_samples in [8.001, 8.005, 8.02, 8.03, 8.1, 7.97] {
        let poll = poll_in_samples * T;
        let stamps: Vec<f64> = (0..50_000)
            .map(|i| {
                let ready = f64::ceil(i as f64 * T / poll) * poll;
                ready + (i % 8) as f64 * 1e-6
            })
            .collect();
        let mut stamps = stamps;
        stamps.sort_by(f64::total_cmp);
        assert_eq!(gaps(&record(stamps)), [], "{poll_in_samples}");
    }
}

#[test]
fn slow_catch_up_of_a_host_is_no_gap() {
    // polls of 8 samples, and one absence of 50 after which 1.3 samples are read per period
    let mut stamps = bursts(20_000, 12.0, 4);
    let back = stamps[9000] + 50.0 * T;
    for (i, stamp) in stamps[9000..].iter_mut().enumerate() {
        *stamp = stamp.max(back + i as f64 * T / 1.3);
    }
    assert_eq!(gaps(&record(stamps)), []);
}

#[test]
fn a_removed_block_is_found_with_its_length_under_jitter() {
    for seed in 0..40 {
        for k in [1, 2, 5, 17, 1000] {
            let recording = record(remove(jittered(6000, 0.1, seed), 2500..2500 + k));
            let found = gaps(&recording);
            assert_eq!(found.len(), 1, "seed {seed}: {found:?} of {k}");
            assert_eq!(found[0].1, k as u64, "seed {seed}");
            // half a period is five standard deviations: one or two rows may be assigned to the other side
            assert!(found[0].0.abs_diff(2500) <= 2, "seed {seed}: {found:?}");
        }
    }
}

#[test]
fn a_removed_block_is_found_under_heavy_jitter_too() {
    let (mut exact, mut tried) = (0, 0);
    for seed in 0..100 {
        for k in [1, 3] {
            let found = gaps(&record(remove(jittered(3000, 0.2, seed), 1500..1500 + k)));
            assert_eq!(
                found.iter().map(|(_, missing)| missing).sum::<u64>(),
                k as u64,
                "seed {seed}: {found:?}"
            );
            assert!(found[0].0.abs_diff(1500) <= 6, "seed {seed}: {found:?}");
            exact += usize::from(found[0].0 == 1500);
            tried += 1;
        }
    }
    assert!(exact * 10 >= tried * 8, "{exact} of {tried} in place");
}

#[test]
fn a_removed_block_is_found_with_its_length_under_bursts() {
    for seed in 0..40 {
        for k in [3, 10, 500] {
            let found = gaps(&record(remove(bursts(20_000, 12.0, seed), 9000..9000 + k)));
            assert_eq!(
                found.iter().map(|(_, missing)| missing).sum::<u64>(),
                k as u64,
                "seed {seed}: {found:?}"
            );
            assert!(found[0].0.abs_diff(9000) <= 12, "seed {seed}: {found:?} of {k}");
        }
    }
}

#[test]
fn many_single_losses_in_a_regular_log_are_all_found() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let kept: Vec<usize> = (0..50_000).filter(|&i| i == 0 || random.random_range(0.0..1.0) > 0.05).collect();
    let expected: Vec<(usize, u64)> = (1..kept.len())
        .filter(|&row| kept[row] - kept[row - 1] > 1)
        .map(|row| (row, (kept[row] - kept[row - 1] - 1) as u64))
        .collect();
    let recording = record(kept.iter().map(|&i| i as f64 * T).collect());
    assert_eq!(gaps(&recording), expected);
    assert!((recording.rate.period_s / T - 1.0).abs() < 1e-12);
}

#[test]
fn wrong_timestamp_of_one_row_is_no_gap() {
    for error in [3.0, 50.0, -3.0, -50.0] {
        let mut stamps: Vec<f64> = (0..1000).map(|i| i as f64 * T).collect();
        stamps[500] += error * T;
        let recording = record(stamps);
        assert_eq!(gaps(&recording), [], "{error}");
        assert_eq!(recording.quality.clock_back, 1, "{error}");
    }
}

#[test]
fn clock_set_back_ends_the_segment() {
    let stamps = (0..1000).map(|i| if i < 600 { 50.0 + i as f64 * T } else { i as f64 * T - 1.0 }).collect();
    let recording = record(stamps);
    assert_eq!(gaps(&recording), [(600, 0)]);
    assert_eq!(recording.segments[1].boundary, Boundary::ClockBack);
    assert_eq!(recording.segments[1].tick, 600);
    assert_eq!(recording.quality.clock_back, 1);
    assert!((recording.duration_s() - 999.0 * T).abs() < 1e-9);
    assert!((recording.rate.period_s / T - 1.0).abs() < 1e-9);
    for (row, time_s) in recording.with_monotonic_time().time_s.iter().enumerate() {
        assert!((time_s - (50.0 + row as f64 * T)).abs() < 1e-9, "{row}: {time_s}");
    }
}

#[test]
fn wrong_timestamp_shifts_no_other() {
    let stamps = |wrong: usize| -> Vec<f64> {
        let stamps = (0..1000).map(|i| if i < 600 { i as f64 * T } else { i as f64 * T + 3.0 });
        stamps.enumerate().map(|(i, stamp)| if i == wrong { 1e6 } else { stamp }).collect()
    };
    for wrong in [300, 599, 600, 800] {
        let recording = record(stamps(wrong));
        assert_eq!(recording.segments.len(), 2, "{wrong}");
        assert_eq!(recording.with_monotonic_time().time_s, stamps(wrong), "{wrong}");
    }
}

#[test]
fn a_very_long_gap_between_two_short_stretches_keeps_the_rate() {
    let stamps = (0..12_000).map(|i| i as f64 * 0.01 + if i < 550 { 0.0 } else { 3246.0 }).collect();
    let recording = record(stamps);
    assert_eq!(gaps(&recording), [(550, 324_600)]);
    assert!((recording.rate.true_hz - 100.0).abs() < 1e-6);
}

#[test]
fn whole_millisecond_or_second_timestamps_make_no_gap() {
    for (period, tick) in [(0.0025, 0.001), (0.005065, 0.001), (0.01, 1.0)] {
        let stamps = (0..20_000).map(|i| f64::floor(i as f64 * period / tick) * tick).collect();
        let recording = record(stamps);
        assert_eq!(gaps(&recording), [], "{period} in ticks of {tick}");
        assert!((recording.rate.period_s / period - 1.0).abs() < 1e-3, "{}", recording.rate.period_s);
    }
}

#[test]
fn segments_hold_every_row_once() {
    let recording = record(remove(jittered(5000, 0.1, 1), 1000..1100));
    let rows: Vec<usize> = recording.segments.iter().flat_map(|segment| segment.rows.clone()).collect();
    assert_eq!(rows, (0..4900).collect::<Vec<_>>());
}

#[test]
fn two_rows_are_enough() {
    let recording = record(vec![0.0, 0.01]);
    assert_eq!(gaps(&recording), []);
    assert!((recording.rate.true_hz - 100.0).abs() < 1e-9);
}

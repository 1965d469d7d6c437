//! Logs as written by boards, hosts and phones, generated from seeds: every feature of the logs of `real_log_tests.rs`,
//! with known truth, through files.

use std::fmt::Write as _;
use std::io::Write as _;

use flate2::{Compression, write::GzEncoder};
use fos_testkit::noise::white_noise;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

use super::gap_tests::{bursts, gaps};
use super::*;

/// Recording of `text` as gzip'd CSV, and the digest of the file.
fn load_text(text: &str, columns: &[&str]) -> (Recording, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv.gz");
    let mut file = GzEncoder::new(Vec::new(), Compression::fast());
    file.write_all(text.as_bytes()).unwrap();
    let bytes = file.finish().unwrap();
    std::fs::write(&path, &bytes).unwrap();
    let columns = ColumnMap::from_specs(columns.iter().copied()).unwrap();
    let log = load(&path, &LoadOptions { columns, ..LoadOptions::default() }).unwrap();
    let digest = Sha256::digest(&bytes).iter().fold(String::new(), |hex, byte| hex + &format!("{byte:02x}"));
    (log, digest)
}

/// Log with these timestamps and one gyro in steps of 1.33e-4 rad/s, as of a converter.
fn log_of(stamps: &[f64], decimals: usize) -> String {
    let mut text = "t_s,gx_rads\n".to_owned();
    for (stamp, noise) in stamps.iter().zip(white_noise(1, stamps.len())) {
        writeln!(text, "{stamp:.decimals$},{:.6}", 1.33e-4 * (10.0 * noise).round()).unwrap();
    }
    text
}

#[test]
fn jitter_beyond_a_period_hides_no_lost_sample_and_adds_none() {
    const HZ: f64 = 397.344;
    let mut random = ChaCha8Rng::seed_from_u64(2);
    // the recorder stalls for up to 1.3 periods and makes up for it with the next row; at ten other rows a sample is
    // lost permanently
    let lost = [795, 8653, 10_224, 12_581, 16_510, 20_439, 24_368, 40_086, 44_014, 55_802];
    let mut stamps = Vec::new();
    let mut tick = 0;
    for row in 0..60_000 {
        tick += usize::from(lost.contains(&row));
        let stalled = if row % 367 == 200 { random.random_range(0.6..1.3) } else { 0.0 };
        stamps.push((tick as f64 + stalled + random.random_range(-0.05..0.05)) / HZ);
        tick += 1;
    }
    let (log, _) = load_text(&log_of(&stamps, 6), &[]);
    assert_eq!(gaps(&log), lost.map(|row| (row, 1)));
    // so the sensor's own rate is above the mean of the file
    let mean = (log.n_rows() - 1) as f64 / (log.time_s[log.n_rows() - 1] - log.time_s[0]);
    assert!((mean - HZ * 60_000.0 / 60_010.0).abs() < 1e-3, "{mean}");
    // ten samples of 60,000 are 0.066 Hz
    assert!((log.rate.true_hz - HZ).abs() < 0.005, "{}", log.rate.true_hz);
}

/// Arrival times of samples every `period_s` at a host that polls, and is away at `stalls` for 0.1 to 0.5 s.
fn arrivals(n: usize, period_s: f64, stalls: &[usize]) -> Vec<f64> {
    let mut stamps = bursts(n, 9.0, 3);
    let scale = period_s / gap_tests::T;
    stamps.iter_mut().for_each(|stamp| *stamp *= scale);
    for (k, stall) in stalls.iter().enumerate() {
        let back = stamps[*stall] + 0.1 + 0.4 * k as f64 / stalls.len() as f64;
        // the backlog is read at once, faster than new samples come
        for (i, stamp) in stamps[*stall..].iter_mut().enumerate() {
            *stamp = stamp.max(back + 0.1 * period_s * i as f64);
        }
    }
    stamps
}

#[test]
fn arrival_times_in_bursts_show_the_mean_rate_and_no_gap() {
    let stalls: Vec<usize> = (1..=10).map(|k| 5500 * k).collect();
    let stamps = arrivals(65_000, 1.0 / 99.317, &stalls);
    assert!(stamps.is_sorted(), "time runs forward");
    let (log, _) = load_text(&log_of(&stamps, 6), &[]);
    assert_eq!(log.rate.stamps, Stamps::Bursts);
    assert!((log.rate.true_hz - 99.317).abs() < 0.1, "{}", log.rate.true_hz);
    // after each stall the timestamps return to where they were
    assert_eq!(gaps(&log), []);
}

#[test]
fn the_long_gap_is_found_and_copies_are_dropped() {
    // a board whose link repeats the last row when one was lost: 8 times two copies; and an interval of 3246 s
    const PERIOD_S: f64 = 0.0109;
    let mut text = "t_s,ax_mps2,gx_rads,state\n".to_owned();
    let mut copied = 0;
    let mut last = String::new();
    for row in 0..12_000_u32 {
        let wait = if row < 500 { 0.0 } else { 3246.0 };
        if row > 600 && row % 1400 < 2 {
            copied += 1;
        } else {
            let state = if row < 6000 { 'S' } else { 'L' };
            let value = f64::from(row.wrapping_mul(2_654_435_769) >> 20) * 1e-5;
            last = format!("{:.6},{value:.5},{:.6},{state}\n", f64::from(row) * PERIOD_S + wait, -value);
        }
        text += &last;
    }
    let (log, _) = load_text(&text, &[]);
    assert_eq!(log.quality.text_columns, ["state"]);
    let long = log.segments.iter().max_by_key(|segment| segment.missing_before).unwrap();
    assert!((log.time_s[long.rows.start] - (500.0 * PERIOD_S + 3246.0)).abs() < 1e-9);
    assert!((long.missing_before as f64 * log.rate.period_s - 3246.0).abs() < PERIOD_S);
    assert_eq!((log.quality.rows_repeated, copied), (16, 16));
    // each stretch of copies stands in for samples that were lost
    let missing: Vec<u64> = gaps(&log).into_iter().map(|(_, missing)| missing).collect();
    assert_eq!((log.segments.len(), missing.iter().filter(|missing| **missing == 2).count()), (10, 8));
}

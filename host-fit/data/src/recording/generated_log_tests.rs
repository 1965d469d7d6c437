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
fn a_regular_log_of_a_million_rows_is_one_segment() {
    let mut text = "t_s,ax_mps2,gx_rads\n".to_owned();
    for row in 0..1_000_000_u32 {
        // coarse, as of an old part; no random generator, since this is about the number of rows
        let code = row.wrapping_mul(2_654_435_769) >> 29;
        writeln!(text, "{}.{:02},0.0{code},-0.00{code}", row / 100, row % 100).unwrap();
    }
    let (log, digest) = load_text(&text, &[]);
    assert_eq!(log.n_rows(), 1_000_000);
    assert_eq!(log.segments.len(), 1);
    assert_eq!(log.rate.stamps, Stamps::Regular);
    assert!((log.rate.true_hz - 100.0).abs() < 1e-6);
    assert_eq!(log.sources[0].sha256, digest);
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

#[test]
fn whole_millisecond_timestamps_give_the_true_rate() {
    // 286 Hz: intervals of three and of four milliseconds
    let stamps: Vec<f64> = (0..50_000).map(|row| (f64::from(row) * 1e3 / 285.714).round() / 1e3).collect();
    let (log, _) = load_text(&log_of(&stamps, 3), &[]);
    assert_eq!(gaps(&log), []);
    assert!((log.rate.true_hz - 285.714).abs() < 0.001, "{}", log.rate.true_hz);
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
fn gauss_become_microtesla_by_a_map_and_single_losses_show_in_bursts() {
    let mut stamps = arrivals(50_000, 1.0 / 76.93, &[]);
    let lost = [10_591, 18_571, 20_789, 24_344, 30_525];
    for row in lost.iter().rev() {
        stamps.remove(*row);
    }
    let mut text = "t_s,mx_gauss,gx_rads\n".to_owned();
    for (row, stamp) in stamps.iter().enumerate() {
        writeln!(text, "{stamp:.6},{:.7},0.00{}", 0.2137615 + 1e-4 * (row % 7) as f64, row % 7).unwrap();
    }
    let (log, _) = load_text(&text, &["mag_x_ut=mx_gauss:gauss"]);
    assert!((log.channel("mag_x_ut").unwrap().values[0] - 21.37615).abs() < 1e-9);
    assert!((log.rate.true_hz - 76.93).abs() < 0.1, "{}", log.rate.true_hz);
    let found = gaps(&log);
    assert_eq!(found.len(), lost.len(), "{found:?}");
    for (k, ((row, missing), lost)) in found.into_iter().zip(lost).enumerate() {
        // timestamps do not show where in its burst a sample is missing: a burst is up to 9 rows
        assert!(missing == 1 && row.abs_diff(lost - k) <= 9, "{row} for {lost}, {missing} missing");
    }
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

#[test]
fn the_segment_column_splits_where_the_sensor_was_handled() {
    // seconds of handling were cut out; the clock went on
    let mut text = "t_s,ay_mps2,segment\n".to_owned();
    for second in (0..4000).chain(4370..8000) {
        writeln!(text, "{second},0.{:02},{}", second % 97, 1 + second / 4100).unwrap();
    }
    let (log, _) = load_text(&text, &[]);
    assert_eq!(log.segments.len(), 2);
    assert_eq!(log.segments[1].boundary, Boundary::SegmentColumn);
    assert_eq!(log.segments[1].missing_before, 370);
    assert!((log.rate.true_hz - 1.0).abs() < 1e-9);
}

#[test]
fn nan_cells_stay_in_their_column() {
    // the camera loses sight of the device, in one long stretch and in many short ones
    let mut text = "t_s,gx_rads,qw\n".to_owned();
    let mut unseen = 0;
    for row in 0..20_000 {
        let sight = !(3000..5500).contains(&row) && row % 83 != 0;
        unseen += usize::from(!sight);
        let attitude = if sight { "0.707" } else { ["nan", "", "NaN"][row % 3] };
        writeln!(text, "{:.6},0.00{},{attitude}", row as f64 / 285.714, row % 7).unwrap();
    }
    let (log, _) = load_text(&text, &[]);
    assert_eq!(log.segments.len(), 1);
    assert_eq!(log.channel("qw").unwrap().n_missing(), unseen);
    assert_eq!(log.channel("gx_rads").unwrap().n_missing(), 0);
}

#[test]
fn raw_counts_become_si_by_a_map() {
    // an unsigned converter, whose zero is half its range
    let mut text = "t_s,gx_cnt\n".to_owned();
    for (row, noise) in white_noise(4, 5000).into_iter().enumerate() {
        let count = if row == 0 { 32_786 } else { 32_768 + (27.0 * noise) as i32 };
        writeln!(text, "{:.6},{count}", row as f64 / 100.01).unwrap();
    }
    let (log, _) = load_text(&text, &["gx_rads=gx_cnt:-32768/6258:rad/s"]);
    assert!((log.axis("gx").unwrap().values[0] - 18.0 / 6258.0).abs() < 1e-12);
    assert_eq!(log.segments.len(), 1);
    assert!((log.rate.true_hz - 100.01).abs() < 0.01, "{}", log.rate.true_hz);
}

#[test]
fn jitter_in_parquet_makes_no_gap() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.parquet");
    for (seed, off) in [(1, 0.985), (2, 1.0), (3, 1.015)] {
        let jitter = white_noise(seed, 100_000);
        let time: Vec<f64> =
            jitter.iter().enumerate().map(|(row, x)| (row as f64 + 0.05 * x) / (200.0 * off)).collect();
        let rates = white_noise(seed + 10, time.len());
        write_columns(&path, &[("t_s", &time), ("gx_rads", &rates)]).unwrap();
        let log = load(&path, &LoadOptions::default()).unwrap();
        assert_eq!(gaps(&log), [], "{off}");
        assert!((log.rate.true_hz / (200.0 * off) - 1.0).abs() < 1e-6, "{}", log.rate.true_hz);
    }
}

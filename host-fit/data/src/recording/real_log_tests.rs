//! Logs recorded by other people, if they are available ([`fos_testkit::outside`]). `generated_log_tests.rs` reproduces
//! their features from seeds.

use fos_testkit::outside;

use super::gap_tests::gaps;
use super::*;

fn load_shared(name: &str) -> Option<Recording> {
    let recording = load(outside::path(name)?, &LoadOptions::default()).unwrap();
    println!(
        "{name}: {} rows, {:?}, {} gaps, {} missing",
        recording.n_rows(),
        recording.rate,
        recording.quality.gaps,
        recording.quality.samples_missing
    );
    Some(recording)
}

#[test]
fn a_regular_log_of_a_million_rows_is_one_segment() {
    let Some(log) = load_shared("data/adis16405_static_run1_100hz.csv.gz") else { return };
    assert_eq!(log.n_rows(), 1_000_000);
    assert_eq!(log.segments.len(), 1);
    assert_eq!(log.rate.stamps, Stamps::Regular);
    assert!((log.rate.true_hz - 100.0).abs() < 1e-6);
    assert_eq!(log.sources[0].sha256, "c6b8c031ed6695f07d537f22286664760dc8f0672770a0d9552f52fb5d93637a");
}

#[test]
fn jitter_beyond_a_period_hides_no_lost_sample_and_adds_none() {
    let Some(log) = load_shared("data/icm45686_rocket_jackpot3_400hz.csv.gz") else { return };
    // 164 intervals exceed 1.5 periods and are made up for at once; at ten rows the timestamps shift by one period
    // permanently (0.98 T each), every 3929 rows (9.9 s) or a multiple of it, as when the recorder stalls
    let rows = [795, 8653, 10224, 12581, 16510, 20439, 24368, 40086, 44014, 55802];
    assert_eq!(gaps(&log), rows.map(|row| (row, 1)));
    // so the sensor's own rate is above the mean of 397.28 Hz that is in the file
    let mean = (log.n_rows() - 1) as f64 / (log.time_s[log.n_rows() - 1] - log.time_s[0]);
    assert!((mean - 397.28).abs() < 0.01, "{mean}");
    assert!((log.rate.true_hz - 397.344).abs() < 0.01, "{}", log.rate.true_hz);
}

#[test]
fn arrival_times_in_bursts_show_the_mean_rate_and_no_gap() {
    let Some(log) = load_shared("data/mpu6050_static_10min_100hz.csv.gz") else { return };
    assert_eq!(log.rate.stamps, Stamps::Bursts);
    assert!((log.rate.true_hz - 99.317).abs() < 0.1, "{}", log.rate.true_hz);
    // ten intervals are of 0.1 to 0.5 s; after each the timestamps return to where they were, within the scatter of the
    // host
    assert_eq!(gaps(&log), []);
}

#[test]
fn gauss_become_microtesla_by_a_map_and_single_losses_show_in_bursts() {
    let Some(path) = outside::path("data/mpu6050_static_10min_hmc5883l_mag.csv.gz") else { return };
    let columns = ColumnMap::from_specs(["mag_x_ut=mx_gauss:gauss"]).unwrap();
    let log = load(path, &LoadOptions { columns, ..LoadOptions::default() }).unwrap();
    assert!((log.channel("mag_x_ut").unwrap().values[0] - 21.37615).abs() < 1e-9);
    assert!((log.rate.true_hz - 76.93).abs() < 0.1, "{}", log.rate.true_hz);
    // at each of these the lower envelope rises by 0.9 to 1.1 T and stays there for at least 700 rows
    assert_eq!(gaps(&log), [10591, 18571, 20789, 24344, 30525].map(|row| (row, 1)));
}

#[test]
fn the_long_gap_is_found_and_copies_are_dropped() {
    let Some(log) = load_shared("data/icm45686_rocket_jackpot4_100hz_supply.csv.gz") else { return };
    println!("{:?}", gaps(&log));
    assert_eq!(log.quality.text_columns, ["state"]);
    let long = log.segments.iter().max_by_key(|segment| segment.missing_before).unwrap();
    assert!((log.time_s[long.rows.start] - 3331.906747).abs() < 1e-9);
    assert!((long.missing_before as f64 * log.rate.period_s - 3246.2).abs() < 0.1);
    // each stretch of copies stands in for samples that were lost
    assert_eq!(log.quality.rows_repeated, 16);
    assert_eq!(log.segments.len(), 11, "{:?}", gaps(&log));
}

#[test]
fn the_segment_column_splits_where_the_sensor_was_handled() {
    let Some(log) = load_shared("data/cats_tag_thermal_orient12_1hz.csv.gz") else { return };
    assert_eq!(log.segments.len(), 2);
    assert_eq!(log.segments[1].boundary, Boundary::SegmentColumn);
    assert_eq!(log.segments[1].missing_before, 370);
    assert!((log.rate.true_hz - 1.0).abs() < 1e-9);
}

#[test]
fn nan_cells_stay_in_their_column() {
    let Some(log) = load_shared("data/broad26_phone_vibration_286hz.csv.gz") else { return };
    assert_eq!(log.segments.len(), 1);
    assert_eq!(log.channel("qw").unwrap().n_missing(), 3944);
    assert_eq!(log.channel("gx_rads").unwrap().n_missing(), 0);
}

#[test]
fn raw_counts_become_si_by_a_map() {
    let Some(path) = outside::path("data/xsens_mti_multipose_100hz_rawcounts.csv.gz") else { return };
    let columns = ColumnMap::from_specs(["gx_rads=gx_cnt:-32768/6258:rad/s"]).unwrap();
    let log = load(path, &LoadOptions { columns, ..LoadOptions::default() }).unwrap();
    assert!((log.axis("gx").unwrap().values[0] - 18.0 / 6258.0).abs() < 1e-12);
    assert_eq!(log.segments.len(), 1);
    assert!((log.rate.true_hz - 100.01).abs() < 0.01, "{}", log.rate.true_hz);
}

#[test]
fn simulated_cases_with_jitter_have_no_gap() {
    for case in ["case_001", "case_002", "case_006"] {
        for part in ["baseline", "field", "eval"] {
            let Some(log) = load_shared(&format!("cases/{case}/{part}.parquet")) else { continue };
            assert_eq!(gaps(&log), [], "{case}/{part}");
            assert!((log.rate.true_hz / 200.0 - 1.0).abs() < 0.02, "{}", log.rate.true_hz);
        }
    }
}

/// Times reading and writing of 720,000 rows of 7 columns; run in release with `--ignored --nocapture`.
#[test]
#[ignore = "a measurement, not a check; .ci/release prints it"]
fn time_to_read_and_write_an_hour_at_200_hz() {
    let n = 720_000;
    let time: Vec<f64> = (0..n).map(|i| f64::from(i) * 0.005).collect();
    let axis: Vec<f64> = (0..n).map(|i| f64::from(i * 79 % 10_007) * 1.3316e-4 - 0.6).collect();
    let names = ["ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads"];
    let mut columns = vec![("t_s", time.as_slice())];
    columns.extend(names.map(|name| (name, axis.as_slice())));
    let folder = tempfile::tempdir().unwrap();
    for name in ["hour.csv", "hour.csv.gz", "hour.parquet"] {
        let path = folder.path().join(name);
        let start = std::time::Instant::now();
        write_columns(&path, &columns).unwrap();
        let written = start.elapsed();
        let start = std::time::Instant::now();
        let log = load(&path, &LoadOptions::default()).unwrap();
        let loaded = start.elapsed();
        assert_eq!((log.n_rows(), log.segments.len()), (n as usize, 1));
        println!("{name}: {} bytes, written in {written:.2?}, loaded in {loaded:.2?}", log.sources[0].bytes);
    }
}

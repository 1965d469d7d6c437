use std::f64::consts::PI;
use std::ops::Range;

use fos_core::{AxisParameters, FittedOn, Range as Bounds, y};
use fos_data::recording::{LoadOptions, Recording, Source};
use fos_testkit::noise::{autoregression, random_walk, white_noise};

use super::*;
use crate::evaluate::{Coasted, Rival, rival, strapdown_errors, trace, trace_of};
use crate::model::{FittedAxis, FittedTerm, HostPredictor, UnitModel};
use crate::playback::Playback;

const GYRO: &str = "gx_rads";
const ACCELEROMETER: &str = "ax_mps2";

/// A log of one or more columns at `rate_hz`, without the rows in `gap`.
fn log(columns: &[(&str, &[f64])], rate_hz: f64, gap: Range<usize>) -> Recording {
    let with_gap = |values: Vec<f64>| -> Vec<f64> {
        values.into_iter().enumerate().filter(|(row, _)| !gap.contains(row)).map(|(_, value)| value).collect()
    };
    let time = (0..columns[0].1.len()).map(|row| row as f64 / rate_hz).collect();
    let columns = columns.iter().map(|(name, values)| ((*name).to_owned(), with_gap(values.to_vec())));
    let columns = std::iter::once(("t_s".to_owned(), with_gap(time))).chain(columns).collect();
    Recording::from_columns(Source::made_by("a test"), columns, &LoadOptions::default()).expect("a log")
}

/// r(n) = 0.9 r(n − 1) on each column, with a constant bias.
fn model(columns: &[&str], period_s: f64) -> UnitModel {
    let axis = |column: &&str| FittedAxis {
        column: (*column).to_owned(),
        parameters: AxisParameters {
            axis: Column::named(column).axis(),
            offset: 0.05,
            range: Bounds::new(-1e6, 1e6),
            ..fos_testkit::models::plain()
        },
        physical: Vec::new(),
        stochastic: vec![FittedTerm { coefficient: 0.9, standard_error: None, factors: vec![y(1)] }],
        plain: None,
    };
    UnitModel {
        period_s,
        fitted_on: FittedOn::Raw,
        stillness: None,
        calibration: None,
        quantities: Vec::new(),
        inputs: Vec::new(),
        axes: columns.iter().map(axis).collect(),
    }
}

/// Errors at the ends of all windows of one column, by length.
fn ends(column: &str, values: &[f64], rate_hz: f64, kind: Rival, offset: f64) -> [Vec<f64>; 4] {
    let log = log(&[(column, values)], rate_hz, 0..0);
    let mut model = model(&[column], log.rate.period_s);
    model.axes[0].parameters.offset = offset;
    let still = vec![true; log.n_rows()];
    let playback = Playback::new(&log, &model, &still).expect("a playback");
    let rival = rival(&model, kind, &[0.0]);
    let trace = trace(&rival, &playback, 0..log.n_rows()).expect("a trace");
    trace.axes.into_iter().next().expect("an axis").unaided
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

/// Velocity and position are stepped as a navigator does, from predictors that have seen all rows before the window.
#[test]
fn windows_equal_free_runs_that_are_integrated_step_by_step() {
    let (rate_hz, rows) = (20.0, 16_000);
    let series = |seed| autoregression(seed, rows, &[0.95], 0.01);
    let (mut gyro, accelerometer) = (series(1), series(2));
    // one sample that was not measured, at 600 s
    gyro[12_000] = f64::NAN;
    let log = log(&[(GYRO, &gyro), (ACCELEROMETER, &accelerometer)], rate_hz, 3000..3100);
    let model = model(&[GYRO, ACCELEROMETER], log.rate.period_s);
    // the device is moved from 650 s to 660 s of the rows
    let still: Vec<bool> = (0..log.n_rows()).map(|row| !(13_000..13_200).contains(&row)).collect();
    let playback = Playback::new(&log, &model, &still).expect("a playback");
    let rows = 500..log.n_rows();
    let traced = trace(&model, &playback, rows.clone()).expect("a trace");

    let ticks = UNAIDED_S.map(|window_s| (window_s * rate_hz) as usize);
    let mut expected: [[Vec<f64>; 4]; 2] = Default::default();
    let mut predictor: HostPredictor<f64> = model.predictor().expect("a predictor");
    let mut feed = playback.feed();
    let stretches = playback.still_stretches(rows.clone());
    assert_eq!(stretches, [500..3000, 3000..13_000, 13_200..15_900], "gap and motion split the log");
    for row in 0..log.n_rows() {
        for (length, n) in ticks.into_iter().enumerate() {
            // 5 s after the begin of each stretch
            let holds = |stretch: &&Range<usize>| stretch.start + 100 <= row && row + n <= stretch.end;
            let stretch = stretches.iter().find(holds);
            if stretch.is_none_or(|stretch| !(row - stretch.start - 100).is_multiple_of(n)) {
                continue;
            }
            let (mut free, mut feed) = (predictor.clone(), feed.clone());
            let (mut heading, mut velocity, mut position) = (0.0, 0.0, 0.0);
            let period_s = log.rate.period_s;
            for at in row..row + n {
                let predicted: Vec<f64> =
                    feed.coast(&mut free, at).iter().map(|correction| correction.predicted).collect();
                heading += (playback.error(0, at) - predicted[0]) * period_s;
                let acceleration = playback.error(1, at) - predicted[1];
                position += velocity * period_s + 0.5 * acceleration * period_s * period_s;
                velocity += acceleration * period_s;
            }
            if heading.is_finite() {
                expected[0][length].push(heading);
            }
            expected[1][length].push(position);
        }
        let _ = feed.step(&mut predictor, row);
    }
    for (axis, expected) in expected.iter().enumerate() {
        for (found, expected) in traced.axes[axis].unaided.iter().zip(expected) {
            assert_eq!(found.len(), expected.len(), "axis {axis}");
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{found} {expected}");
            }
        }
    }
    let windows = |axis: usize| traced.axes[axis].unaided.each_ref().map(Vec::len);
    assert_eq!([windows(0), windows(1)], [[744, 73, 11, 0], [745, 74, 12, 0]]);
}

#[test]
fn a_strapdown_of_six_axes_tilts_gravity_into_the_position() {
    let (rate_hz, rows, g, b) = (20.0, 5000, 9.81, 1e-4);
    let columns = ["ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads"];
    let values = [0.0, 0.0, g, 0.0, b, 0.0].map(|value| vec![value; rows]);
    let errors = |n_axes: usize| {
        let columns = &columns[..n_axes];
        let series: Vec<(&str, &[f64])> =
            columns.iter().copied().zip(values.iter().map(Vec::as_slice)).collect();
        let log = log(&series, rate_hz, 0..0);
        let mut model = model(columns, log.rate.period_s);
        model.axes.iter_mut().for_each(|axis| axis.parameters.offset = 0.0);
        model.axes[2].parameters.offset = g;
        let still = vec![true; rows];
        let playback = Playback::new(&log, &model, &still).expect("a playback");
        let rival = rival(&model, Rival::Mean, &[0.0; 6]);
        strapdown_errors(
            &trace_of(&rival, &playback, 0..rows, Coasted::AllRowsAndStrapdown).expect("a trace"),
        )
    };
    let found = errors(6);
    let after_60_s = found[2];
    assert_eq!((found.len(), after_60_s.window_s, after_60_s.windows), (4, 60.0, 4));
    // the first of 1200 samples is not tilted yet
    let position = after_60_s.position_m.expect("an RMS").rms / (g * b * 60.0_f64.powi(3) / 6.0);
    assert!((position - 1.0).abs() < 3e-3, "{position}");
    assert!(after_60_s.heading_rad.expect("an RMS").rms < 1e-12);
    assert_eq!((found[3].windows, found[3].position_m), (0, None));
    assert_eq!(errors(5), []);
}

/// Standard error of an RMS of n normal values, four times, as a share of it.
fn four_sigma(n: usize) -> f64 {
    4.0 / (2.0 * n as f64).sqrt()
}

#[test]
fn white_noise_grows_as_theory_says() {
    let (rate_hz, rows) = (10.0, 10 * 36_000);
    let density = 0.3;
    let values: Vec<f64> =
        white_noise(3, rows).iter().map(|value| value * density * f64::sqrt(rate_hz)).collect();
    for (column, power) in [(GYRO, 0.5), (ACCELEROMETER, 1.5)] {
        let found = ends(column, &values, rate_hz, Rival::Mean, 0.0);
        for (window_s, ends) in UNAIDED_S.into_iter().zip(found) {
            // N √T, and N √(T³/3)
            let theory = density * window_s.powf(power) / if column == GYRO { 1.0 } else { 3_f64.sqrt() };
            let ratio = rms(&ends) / theory;
            assert!((ratio - 1.0).abs() < four_sigma(ends.len()), "{column} {window_s} s: {ratio}");
        }
    }
}

/// The last value held leaves the walk since the begin of the window.
#[test]
fn random_walk_and_bias_grow_as_theory_says() {
    let (rate_hz, rows) = (10.0, 10 * 36_000);
    let size = 0.02;
    let walk: Vec<f64> = random_walk(4, rows).iter().map(|value| value * size / f64::sqrt(rate_hz)).collect();
    for (window_s, ends) in UNAIDED_S.into_iter().zip(ends(GYRO, &walk, rate_hz, Rival::LastValue, 0.0)) {
        // K √(T³/3); a window has few samples, of which the first has moved by one step
        let n = window_s * rate_hz;
        let sampled = ((n + 1.0) * (2.0 * n + 1.0) / (2.0 * n * n)).sqrt();
        let ratio = rms(&ends) / (size * (window_s.powi(3) / 3.0).sqrt() * sampled);
        assert!((ratio - 1.0).abs() < four_sigma(ends.len()), "{window_s} s: {ratio}");
    }
    // one degree per second and 1 mm/s² more than the constant that was learnt
    for (column, bias) in [(GYRO, PI / 180.0), (ACCELEROMETER, 1e-3)] {
        let found = ends(column, &vec![0.4 + bias; 20_000], rate_hz, Rival::Mean, 0.4);
        for (window_s, ends) in UNAIDED_S.into_iter().zip(found) {
            let expected = if column == GYRO { bias * window_s } else { 0.5 * bias * window_s * window_s };
            assert!(
                ends.len() >= 3 && ends.iter().all(|end| (end / expected - 1.0).abs() < 1e-6),
                "{ends:?}"
            );
        }
    }
}

/// Windows of errors whose correlation at a lag of one window is up to 0.9, in short and long logs.
#[test]
fn intervals_cover_the_rms_as_often_as_they_state() {
    for (n, correlation, least) in [
        (3, 0.0, 0.87),
        (14, 0.0, 0.87),
        (60, 0.0, 0.87),
        (3, 0.8, 0.84),
        (14, 0.5, 0.87),
        (14, 0.8, 0.84),
        (60, 0.9, 0.85),
    ] {
        // logs so far apart that they are independent
        let (trials, apart) = (1000, n + 100);
        let series = autoregression(5, trials * apart, &[correlation], 1.0 - correlation * correlation);
        let covers = |log: &&[f64]| {
            let RmsInterval { low, high, .. } = RmsInterval::of(&[&log[..n]]);
            low <= 1.0 && 1.0 <= high
        };
        let share = series.chunks(apart).filter(covers).count() as f64 / trials as f64;
        assert!((least..0.97).contains(&share), "{n} windows, correlation {correlation}: {share}");
    }
}

#[test]
fn equal_errors_count_as_one_window() {
    let RmsInterval { rms, low, high } = RmsInterval::of(&[&[0.2; 30]]);
    assert!((rms - 0.2).abs() < 1e-12);
    // χ² of one degree of freedom: 0.00393 and 3.84
    assert!((low / rms - 0.51).abs() < 0.01 && (high / rms - 15.9).abs() < 0.1, "{low} {high}");
}

#[test]
fn two_windows_are_too_short_and_other_columns_have_none() {
    let short = UnaidedError::of(Triad::Gyros, 60.0, &[0.1, 0.2]);
    assert_eq!((short.windows, short.rms()), (2, None));
    let text =
        serde_json::to_string(&UnaidedError::of(Triad::Accelerometers, 60.0, &[0.1, 0.2, -0.3])).unwrap();
    assert!(text.contains(r#""position_m":{"rms":0.216"#) && !text.contains("heading"), "{text}");
    assert_eq!(Integral::of("mag_x_ut"), None);
}

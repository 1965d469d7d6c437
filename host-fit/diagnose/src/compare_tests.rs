//! Comparison on a log that continues the fitted one.

use std::ops::Range;

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_fit::fit::{FitOptions, Train, fit_axis, rest};
use fos_testkit::noise::white_noise;

use crate::compare::{AxisComparison, Comparison, compare_study, strapdown, study_of};

const RATE_HZ: f64 = 4.0;
const TAU_S: f64 = 120.0;

/// Rows of a log of a gyro in rad/s, with white noise of this standard deviation a sample, that follows a temperature in °C after
/// [`TAU_S`]. The timestamps are shifted by `shift_s`.
pub(crate) fn lagging(rate_hz: f64, deviation: f64, rows: Range<usize>, shift_s: f64) -> Recording {
    let mut lagging = 25.0;
    let noise = white_noise(7, rows.end);
    let mut columns: Vec<(String, Vec<f64>)> =
        ["t_s", "gx_rads", "temp_c"].map(|name| (name.to_owned(), Vec::new())).into();
    for (row, noise) in noise.iter().enumerate() {
        let time_s = row as f64 / rate_hz;
        let temperature = 25.0 + 15.0 * (time_s / 190.0).sin();
        lagging += (temperature - lagging) / (TAU_S * rate_hz);
        let values = [time_s + shift_s, 2e-4 * lagging + deviation * noise, temperature];
        if rows.contains(&row) {
            columns.iter_mut().zip(values).for_each(|((_, column), value)| column.push(value));
        }
    }
    Recording::from_columns(Source::made_by("test"), columns, &LoadOptions::default()).expect("a log")
}

/// The lag of a second file restarted at the temperature of its first row, although the device had run on.
#[test]
fn log_that_continues_the_fitted_one_starts_with_its_lags() {
    let part = |rows, shift_s| lagging(RATE_HZ, 6e-5, rows, shift_s);
    let fitted = part(0..3600, 0.0);
    let lag = format!("temp_c:lowpass({TAU_S})").parse().expect("an input");
    let options =
        FitOptions { physical: vec![lag], max_lag: 2, train: Train::Share(1.0), ..FitOptions::default() };
    let stillness = rest(&fitted, options.train);
    let fit = fit_axis(&fitted, &stillness, "gx", &options).expect("a fit");
    let half = FitOptions { train: Train::Share(0.5), ..options };
    let study =
        study_of(&fitted, &stillness, vec![fit], half, LoadOptions::default(), &mut |_| {}).expect("a study");
    let error = |comparison: &Comparison| comparison.axes[0].slow_errors()[1].expect("an error");
    let columns = study.columns();
    let evaluated =
        |log: &Recording, own| compare_study(&study, &columns, log, own, &mut |_| {}).expect("a comparison");
    let follows = part(3600..6000, 0.0);
    let (continued, alone) = (evaluated(&follows, Some(&fitted)), evaluated(&follows, None));
    let later = evaluated(&part(3600..6000, 100.0), Some(&fitted));
    let [continued_rms, alone_rms, later_rms] =
        [&continued, &alone, &later].map(|evaluation| error(&evaluation.comparison));
    println!("RMS {continued_rms:e} rad/s; with restarted lags {alone_rms:e} and {later_rms:e}");
    // the white noise alone is 3e-5 rad/s RMS in 1-s means
    assert!(continued_rms < 0.75 * alone_rms.min(later_rms));
    assert_eq!((continued.trace.rows, continued.comparison.evaluated_s), (0..2400, (900.0, 1499.75)));
    assert_eq!(continued.stillness.still.len(), 2400);
}

/// Such a log was not evaluated at all.
#[test]
fn log_in_another_orientation_is_evaluated_about_its_own_mean() {
    let lying = |name: &str, level: f64, seed: u64| {
        let noise = white_noise(seed, 3000);
        let columns = [
            ("t_s", (0..3000).map(|row| f64::from(row) / RATE_HZ).collect()),
            ("ax_mps2", noise.iter().map(|noise| level + 0.01 * noise).collect()),
        ];
        let columns = columns.map(|(name, values): (&str, Vec<f64>)| (name.to_owned(), values)).into();
        Recording::from_columns(Source::made_by(name), columns, &LoadOptions::default()).expect("a log")
    };
    let fitted = lying("fitted", 0.1, 1);
    let options = FitOptions { max_lag: 2, ..FitOptions::default() };
    let stillness = rest(&fitted, options.train);
    let fit = fit_axis(&fitted, &stillness, "ax", &options).expect("a fit");
    let study = study_of(&fitted, &stillness, vec![fit], options, LoadOptions::default(), &mut |_| {});
    let study = study.expect("a study");
    let evaluated = |log: &Recording| {
        let evaluation = compare_study(&study, &["ax_mps2".to_owned()], log, Some(&fitted), &mut |_| {});
        evaluation.expect("a comparison").comparison.axes.remove(0)
    };
    let [same, other] = [&lying("same", 0.1, 3), &lying("turned", 9.8, 2)].map(evaluated);
    let is_told =
        |axis: &AxisComparison| axis.cautions.iter().any(|text| text.contains("another orientation"));
    assert_eq!((other.rows, is_told(&same), is_told(&other)), (3000, false, true));
    let [same, other] = [same, other].map(|axis| axis.slow_errors()[0].expect("an error"));
    // means of four samples of noise, of two seeds
    assert!((same / other - 1.0).abs() < 0.2, "{same:e} {other:e}");
}

#[test]
fn strapdown_of_a_study_is_that_of_its_comparison() {
    let columns = ["ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads"];
    let log = |seed: u64| {
        let level = |axis: usize| if axis == 2 { 9.81 } else { 0.0 };
        let of_axis = |(axis, name): (usize, &&str)| {
            let noise = white_noise(seed + axis as u64, 1200);
            ((*name).to_owned(), noise.iter().map(|noise| level(axis) + 1e-3 * noise).collect::<Vec<f64>>())
        };
        let mut series: Vec<_> = columns.iter().enumerate().map(of_axis).collect();
        series.push(("t_s".to_owned(), (0..1200).map(|row| f64::from(row) / RATE_HZ).collect()));
        Recording::from_columns(Source::made_by("test"), series, &LoadOptions::default()).expect("a log")
    };
    let (fitted, other) = (log(1), log(11));
    let options = FitOptions { max_lag: 2, ..FitOptions::default() };
    let stillness = rest(&fitted, options.train);
    let fits = columns.map(|column| fit_axis(&fitted, &stillness, column, &options).expect("a fit")).into();
    let read = LoadOptions::default();
    let study = study_of(&fitted, &stillness, fits, options, read, &mut |_| {}).expect("a study");
    for (log, own) in [(&fitted, None), (&other, Some(&fitted))] {
        let evaluation =
            compare_study(&study, &study.columns(), log, own, &mut |_| {}).expect("a comparison");
        let found = strapdown(&study, log, own).expect("a strapdown");
        assert!(found[1].iter().all(|error| error.heading_rad.is_some() && error.position_m.is_some()));
        assert_eq!(found, evaluation.comparison.strapdown);
    }
    let alone = study.only("gx_rads").expect("an axis");
    assert!(strapdown(&alone, &other, None).expect("no strapdown").is_empty());
}

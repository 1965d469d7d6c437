//! Comparison on a log that continues the fitted one.

use std::ops::Range;

use fos_data::recording::{LoadOptions, Recording, Source};
use fos_fit::fit::{FitOptions, Train, fit_axis, rest};
use fos_testkit::noise::white_noise;

use crate::compare::{Comparison, compare_study, study_of};

const RATE_HZ: f64 = 10.0;
const TAU_S: f64 = 120.0;

/// Rows of a log of a gyro in rad/s, with white noise of this standard deviation, that follows a temperature in °C after
/// [`TAU_S`]. The timestamps are shifted by `shift_s`.
pub(crate) fn lagging(deviation: f64, rows: Range<usize>, shift_s: f64) -> Recording {
    let mut lagging = 25.0;
    let noise = white_noise(7, rows.end);
    let mut columns: Vec<(String, Vec<f64>)> =
        ["t_s", "gx_rads", "temp_c"].map(|name| (name.to_owned(), Vec::new())).into();
    for (row, noise) in noise.iter().enumerate() {
        let time_s = row as f64 / RATE_HZ;
        let temperature = 25.0 + 15.0 * (time_s / 190.0).sin();
        lagging += (temperature - lagging) / (TAU_S * RATE_HZ);
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
    let part = |rows, shift_s| lagging(1e-4, rows, shift_s);
    let fitted = part(0..9000, 0.0);
    let lag = format!("temp_c:lowpass({TAU_S})").parse().expect("an input");
    let options =
        FitOptions { physical: vec![lag], max_lag: 2, train: Train::Share(1.0), ..FitOptions::default() };
    let stillness = rest(&fitted, options.train);
    let fit = fit_axis(&fitted, &stillness, "gx", &options).expect("a fit");
    let half = FitOptions { train: Train::Share(0.5), ..options };
    let study =
        study_of(&fitted, &stillness, vec![fit], half, LoadOptions::default(), |_| {}).expect("a study");
    let error = |comparison: &Comparison| comparison.axes[0].slow_errors()[1].expect("an error");
    let columns: Vec<String> = study.model.axes.iter().map(|axis| axis.column.clone()).collect();
    let evaluated =
        |log: &Recording, own| compare_study(&study, &columns, log, own, |_| {}).expect("a comparison");
    let follows = part(9000..15000, 0.0);
    let (continued, alone) = (evaluated(&follows, Some(&fitted)), evaluated(&follows, None));
    let later = evaluated(&part(9000..15000, 100.0), Some(&fitted));
    let [continued_rms, alone_rms, later_rms] =
        [&continued, &alone, &later].map(|evaluation| error(&evaluation.comparison));
    println!("RMS {continued_rms:e} rad/s; with restarted lags {alone_rms:e} and {later_rms:e}");
    // the white noise alone is 3.2e-5 rad/s RMS in 1-s means
    assert!(continued_rms < 0.75 * alone_rms.min(later_rms));
    assert_eq!((continued.trace.rows, continued.comparison.evaluated_s), (0..6000, (900.0, 1499.9)));
    assert_eq!(continued.stillness.still.len(), 6000);
}

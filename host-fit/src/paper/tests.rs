use fos_data::recording::{LoadOptions, Recording, Source};
use fos_data::stillness::{self, Stillness};
use fos_fit::fit::autoregression::Method;
use fos_fit::fit::{FitMethod, FitOptions, Search, Train, fit_axis};
use fos_fit::signal;
use fos_simulate::band_limited::{band_limited, innovation_variance};

use super::*;

fn settings() -> Settings {
    Settings {
        train_s: 180.0,
        evaluate_s: 60.0,
        max_order: 10,
        max_degree: 2,
        denoising: "db4:4:soft".parse().unwrap(),
        repeats: 1,
        search: Search::Greedy,
    }
}

fn recording() -> Recording {
    Recording::from_columns(Source::made_by("test"), band_limited(600.0, 1), &LoadOptions::default()).unwrap()
}

fn compared(
    recording: &Recording,
    stillness: &Stillness,
    axis: &str,
    settings: &Settings,
) -> Result<(Comparison, Split), PaperError> {
    compare(recording, stillness, &recording.error_series(axis).unwrap(), settings, |_| {})
}

fn evaluation(comparison: &Comparison, entry: Entry, order: u16) -> &Evaluated {
    let found = comparison.cells.iter().find(|cell| cell.entry == entry && cell.order == order);
    found.unwrap().result.as_ref().unwrap()
}

#[test]
fn only_fos_reaches_the_innovation_of_a_quadratic_truth() {
    let recording = recording();
    let stillness = stillness::find(&recording);
    for axis in ["ay", "gy"] {
        let (comparison, split) = compared(&recording, &stillness, axis, &settings()).unwrap();
        assert_eq!(split.samples(), [36_000, 12_000, 72_000]);
        let at_ten = |entry| evaluation(&comparison, entry, 10).mse_same_target;
        let (linear, quadratic) = (at_ten(Entry::Fos(1)), at_ten(Entry::Fos(2)));
        let innovation = innovation_variance(&comparison.column).unwrap();
        // 72,000 squares of normal numbers: 0.5 % standard deviation, times four.
        assert!((quadratic / innovation - 1.0).abs() < 0.02, "{quadratic} for {innovation}");
        for method in Method::ALL {
            assert!(at_ten(Entry::Raw(method)) > 100.0 * quadratic, "{method}");
            assert!(at_ten(Entry::Denoised(method)) > 100.0 * quadratic, "{method}");
            assert!(at_ten(Entry::Denoised(method)) > linear, "{method}");
        }
        let chosen = &comparison.cells[comparison.chosen.unwrap()];
        assert_eq!((chosen.entry, chosen.order), (Entry::Fos(2), 10));
    }
}

#[test]
fn linear_fos_with_all_lags_is_the_covariance_method_with_an_intercept() {
    let recording = recording();
    let stillness = stillness::find(&recording);
    let (comparison, _) = compared(&recording, &stillness, "ay", &settings()).unwrap();
    let fos = evaluation(&comparison, Entry::Fos(1), 10);
    let covariance = evaluation(&comparison, Entry::Raw(Method::Covariance), 10);
    assert_eq!(fos.terms, 10);
    // The mean of the training part was subtracted, so an intercept has almost no effect.
    assert!((fos.mse_same_target / covariance.mse_same_target - 1.0).abs() < 1e-3);
}

#[test]
fn residuals_equal_those_of_fos_core() {
    let recording = recording();
    let stillness = stillness::find(&recording);
    let (comparison, split) = compared(&recording, &stillness, "gy", &settings()).unwrap();
    let options = FitOptions {
        method: FitMethod::Linear(Method::Burg),
        train: Train::Seconds(180.0),
        ..FitOptions::default()
    };
    let fit = fit_axis(&recording, &stillness, "gy", &options).unwrap();
    let playback = fos_fit::playback::Playback::new(&recording, &fit.model, &stillness.still).unwrap();
    let rows = split.predict[0].clone();
    let trace = fos_fit::evaluate::trace(&fit.model, &playback, rows.clone()).unwrap();
    // The same rows: those preceded by ten samples of the prediction part.
    let squares: Vec<f64> = trace.axes[0].one_step[10..].iter().map(|e| e * e).collect();
    let mse = signal::mean(&[&squares]);
    let ours = evaluation(&comparison, Entry::Raw(Method::Burg), 10).mse_same_target;
    // The same sums of 10⁵ rows in another order.
    assert!((mse / ours - 1.0).abs() < 1e-9, "{mse} for {ours}");
}

#[test]
fn rejects_log_too_short_for_three_parts() {
    let recording = recording();
    let stillness = stillness::find(&recording);
    let long = Settings { train_s: 500.0, ..settings() };
    let refused = compared(&recording, &stillness, "ay", &long).unwrap_err().to_string();
    assert!(refused.contains("600 s at rest") && refused.contains("620 s"), "{refused}");
}

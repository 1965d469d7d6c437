//! Fits a series in memory and forecasts it: `cargo run -p fos-fit --example from_a_slice`.

use fos_fit::fit::FitOptions;
use fos_fit::fit::autoregression::{Criterion, Method, best_order};
use fos_fit::series::fit_series;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // a slow wave and a fast chirp at 200 Hz
    let series: Vec<f64> =
        (0..4000).map(|n| (0.01 * f64::from(n)).sin() + 0.1 * (7.7 * f64::from(n * n)).sin()).collect();
    let (order, _) = best_order(Method::Burg, &[&series], 20, Criterion::Bic)?;
    let fit = fit_series(&series, 200.0, &FitOptions { max_lag: order as u16, ..FitOptions::default() })?;
    println!("order {order} by BIC; {} terms; {}", fit.model.n_terms(), fit.report.stopped);
    let forecast = fit.forecast(&series, 10)?;
    for (ahead, next) in (1..).zip(&forecast) {
        println!("{ahead:>3} samples on: {:.3} ± {:.3}", next.value, next.standard_error);
    }
    let truth = (0.01 * 4009.0_f64).sin();
    assert!((forecast[9].value - truth).abs() < 4.0 * forecast[9].standard_error);
    Ok(())
}

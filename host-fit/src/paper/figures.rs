//! The paper's Figures 2, 5, 6 and 7 for one axis.

use super::curves::Curves;
use super::result::{Cell, Comparison, Entry, Evaluated};
use fos_data::column::Column;
use fos_data::text::capitalised;
use fos_figures::{Axis, Figure, Ink, Panel, Series, Shape};
use fos_fit::fit::autoregression::Method;

/// Figures with their names; without the autocorrelation if the log is too short.
pub fn figures(comparison: &Comparison, curves: &Curves) -> Vec<(&'static str, Figure)> {
    let mut figures = Vec::new();
    if let Some(correlation) = &curves.autocorrelation {
        let period_s = 1.0 / comparison.rate_hz;
        figures.push(("autocorrelation", against_gauss_markov(comparison, &correlation.values, period_s)));
    }
    figures.push(("samples", samples(comparison, curves)));
    figures.push(("mse_by_order", mse_by_order(comparison)));
    figures
}

/// Figure 2 over Figure 1: test for a first-order Gauss-Markov process.
fn against_gauss_markov(comparison: &Comparison, values: &[f64], period_s: f64) -> Figure {
    let at = |lag: usize| lag as f64 * period_s;
    let measured = values.iter().enumerate().map(|(lag, value)| (at(lag), *value)).collect();
    let first = values.get(1).copied().unwrap_or(0.0);
    let gauss_markov = (0..values.len()).map(|lag| (at(lag), first.powi(lag as i32))).collect();
    let line = |label, ink, points| Series::new(label, ink, Shape::Line(points));
    let series = [
        line("first-order Gauss-Markov, same at lag 1", Ink::Bound, gauss_markov),
        line("measured", Ink::Measured, measured),
    ];
    Figure {
        title: format!("{}: autocorrelation against a first-order Gauss-Markov process", name(comparison)),
        panels: vec![Panel::new(Axis::linear("Lag (s)"), Axis::linear("Autocorrelation (1)"), series)],
    }
}

/// Figure 5: the samples, split in three.
fn samples(comparison: &Comparison, curves: &Curves) -> Figure {
    let inks = [("train", Ink::Predicted), ("evaluate", Ink::Other), ("predict", Ink::Measured)];
    let series = inks.into_iter().zip(&curves.parts).flat_map(|((label, ink), envelopes)| {
        envelopes.iter().map(move |envelope| {
            Series::new(format!("{label}, lowest to highest"), ink, Shape::Band(envelope.band()))
        })
    });
    let y = Axis::linear(format!("{} ({})", name(comparison), comparison.unit));
    Figure {
        title: format!("{}: the samples, less the first", name(comparison)),
        panels: vec![Panel::new(Axis::linear("Time (s)"), y, series)],
    }
}

/// Figures 6 and 7: mean square error against model order.
fn mse_by_order(comparison: &Comparison) -> Figure {
    let panel = |title: &str, mse: fn(&Evaluated) -> f64, with_raw: bool| {
        let mut series: Vec<Series> = Vec::new();
        for cells in comparison.cells.chunk_by(|a, b| a.entry == b.entry) {
            let entry = cells[0].entry;
            let points = cells.iter().filter_map(|cell| point(cell, mse)).collect();
            let (is_raw, ink) = (matches!(entry, Entry::Raw(_)), Ink::Method(place(entry)));
            let shape = if is_raw { Shape::Points(points) } else { Shape::Line(points) };
            if !is_raw || with_raw {
                // Listed in the title: thirteen entries are too many for a legend.
                let label = if is_raw { String::new() } else { entry.to_string() };
                series.push(Series::new(label, ink, shape));
            }
        }
        series.push(Series::new("predicting the mean", Ink::Bound, Shape::Level(comparison.variance)));
        if let Some((floor, _)) = comparison.noise_floor {
            series.push(Series::new("noise floor of linear predictors", Ink::Floor, Shape::Level(floor)));
        }
        let y = Axis::log(format!("Mean square error (({})²)", comparison.unit));
        Panel::new(Axis::linear("Model order, largest output lag (1)"), y, series).titled(title)
    };
    Figure {
        title: format!("{}: one-step prediction error against model order", name(comparison)),
        panels: vec![
            panel("As in the paper: what each was fitted to", |evaluation| evaluation.mse_as_fitted, false),
            panel(
                "Same target: samples as measured (dots: fitted to them)",
                |evaluation| evaluation.mse_same_target,
                true,
            ),
        ],
    }
}

fn point(cell: &Cell, mse: fn(&Evaluated) -> f64) -> Option<(f64, f64)> {
    cell.result.as_ref().ok().map(|evaluation| (f64::from(cell.order), mse(evaluation)))
}

/// Colour of a method, the same for measured and de-noised samples.
fn place(entry: Entry) -> usize {
    match entry {
        Entry::Raw(Method::YuleWalker) | Entry::Denoised(Method::YuleWalker) => 0,
        Entry::Raw(Method::Covariance) | Entry::Denoised(Method::Covariance) => 1,
        Entry::Raw(Method::ModifiedCovariance) | Entry::Denoised(Method::ModifiedCovariance) => 2,
        Entry::Raw(Method::Burg) | Entry::Denoised(Method::Burg) => 3,
        Entry::Fos(degree) => 3 + degree,
    }
}

fn name(comparison: &Comparison) -> String {
    capitalised(Column::named(&comparison.column).label())
}

//! The Allan deviation of a log at rest, and the white noise, bias instability and random walk that make it.

use fos_fit::noise::{AxisNoise, FLICKER_FLOOR, Level};

use super::{Axis, Figure, Ink, Panel, Series, Shape};
use crate::units::{ShownUnit, three};
use fos_data::column::Column;
use fos_fit::export::SHARE;

/// One panel an axis: measured with intervals of 90 %, the lines of N, B and K as far as they were seen, their sum.
/// `units` gives the units in which the legend states N, B and K.
pub fn allan_of_noise(log: &str, axes: &[AxisNoise], units: impl Fn(&AxisNoise) -> [ShownUnit; 3]) -> Figure {
    let panels = axes.iter().map(|axis| panel(axis, &units(axis)));
    Figure { title: format!("{log}: N, B and K"), panels: panels.collect() }
}

fn panel(axis: &AxisNoise, units: &[ShownUnit; 3]) -> Panel {
    let bars = axis.allan.iter().map(|point| {
        let (low, high) = point.interval(SHARE);
        (point.tau_s, point.deviation, low, high)
    });
    let taus: Vec<f64> = axis.allan.iter().map(|point| point.tau_s).collect();
    let [white, flicker, walk] = units;
    let (lowest, highest) = axis.allan.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), point| {
        (low.min(point.deviation), high.max(point.deviation))
    });
    // A line far below the measurements would compress their picture.
    let line = |of: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        let points = taus.iter().map(|tau| (*tau, of(*tau)));
        points.filter(|(_, value)| (0.5 * lowest..=2.0 * highest).contains(value)).collect()
    };
    let mut series = Vec::new();
    let levels = &axis.levels;
    let at: [fn(f64, f64) -> f64; 3] = [
        |white, tau| white / tau.sqrt(),
        |flicker, _| FLICKER_FLOOR * flicker,
        |walk, tau| walk * (tau / 3.0).sqrt(),
    ];
    let parts = [
        ("N", &levels.white, white, Ink::Predicted),
        ("B", &levels.flicker, flicker, Ink::Residual),
        ("K", &levels.walk, walk, Ink::Other),
    ];
    for ((name, level, unit, ink), of) in parts.into_iter().zip(at) {
        let points = level.value.map_or_else(Vec::new, |value| line(&|tau| of(value, tau)));
        let drawn = if name == "B" && level.value.is_some() { ", drawn at 0.664 B" } else { "" };
        let label = with_interval(name, level, unit) + drawn;
        series.push(Series::new(label, ink, Shape::Line(points)));
    }
    let together = taus.iter().map(|tau| (*tau, levels.allan_deviation(*tau))).collect();
    series.push(Series::new("N, B and K together", Ink::Floor, Shape::Line(together)));
    if let Some(process) = levels.gauss_markov {
        let seconds = ShownUnit { label: "s".into(), divisor: 1.0 };
        let sigma = with_interval("σ", &process.deviation, flicker);
        let tau = with_interval("τ", &process.tau_s, &seconds);
        let label = format!("N and a Gauss–Markov process: {sigma}, {tau}");
        let together = taus.iter().map(|tau| (*tau, process.allan_deviation(*tau))).collect();
        series.push(Series::new(label, Ink::Method(4), Shape::Line(together)));
    }
    series.push(Series::new("measured (90 %)", Ink::Measured, Shape::Bars(bars.collect())));
    let y = Axis::log(format!("Allan deviation ({})", axis.unit));
    Panel::new(Axis::log("Averaging time (s)"), y, series)
        .titled(fos_data::text::capitalised(Column::named(&axis.column).label()))
}

fn with_interval(name: &str, level: &Level, unit: &ShownUnit) -> String {
    let ShownUnit { label, divisor } = unit;
    let shown = |value: f64| three(value / divisor);
    match (level.value, level.low) {
        (Some(value), Some(low)) => {
            format!("{name} {} ({} … {}) {label}", shown(value), shown(low), shown(level.high))
        }
        _ => format!("{name} not seen, at most {} {label}", shown(level.high)),
    }
}

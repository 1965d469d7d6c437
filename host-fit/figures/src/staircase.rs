//! Figure of the remaining error after each added effect, predicted and measured.

use super::{Axis, Figure, Ink, Panel, Series, Shape};
use fos_data::text::capitalised;

/// Remaining error after one step of the refinement.
#[derive(Debug, Clone, PartialEq)]
pub struct Tread {
    /// Name of the step, shown below the axis.
    pub name: String,
    /// Slow error: RMS of the 1-s means.
    pub slow: f64,
    /// Broadband error: RMS of the samples.
    pub wide: f64,
    /// Predicted slow or broadband error with its interval.
    pub predicted: Option<Predicted>,
    /// RMS error while coasting: (horizon in s, error).
    pub coast: Vec<(f64, f64)>,
}

/// Predicted error after a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// The prediction is of the broadband error, otherwise of the slow error.
    pub wide: bool,
    /// Predicted remaining error.
    pub left: f64,
    /// 90 % interval of `left`.
    pub interval: [f64; 2],
}

/// Half of the length of a tread. Treads touch, so that the risers are vertical.
const TREAD: f64 = 0.5;

/// Line with a level for each step.
fn treads(values: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
    let treads =
        values.enumerate().map(|(at, value)| [(at as f64 - TREAD, value), (at as f64 + TREAD, value)]);
    treads.flatten().collect()
}

/// Figure of `channel`, in `unit`.
pub fn staircase(channel: &str, unit: &str, steps: &[Tread]) -> Figure {
    let names: Vec<String> = steps.iter().map(|step| step.name.clone()).collect();
    let x = || Axis { names: names.clone(), ..Axis::linear("") };
    let panel = |title: &str, label: &str, value: fn(&Tread) -> f64, wide: bool| {
        let stairs = treads(steps.iter().map(value));
        let predicted = steps.iter().enumerate().filter_map(|(at, step)| {
            let predicted = step.predicted.filter(|predicted| predicted.wide == wide)?;
            let [low, high] = predicted.interval;
            Some((at as f64, predicted.left, low, high))
        });
        // A series for each step, without a line between them.
        let predicted = predicted.map(|bar| Series {
            label: "predicted, 90 %".into(),
            ink: Ink::Predicted,
            shape: Shape::Bars(vec![bar]),
        });
        let mut series =
            vec![Series { label: "measured".into(), ink: Ink::Residual, shape: Shape::Line(stairs) }];
        series.extend(predicted);
        Panel { title: title.into(), x: x(), y: Axis::log(label), series, ..Panel::default() }
    };
    let horizons: Vec<f64> = steps.first().iter().flat_map(|step| step.coast.iter().map(|c| c.0)).collect();
    let coast = horizons.iter().enumerate().map(|(method, horizon)| {
        let at = |step: &Tread| step.coast.iter().find(|c| c.0 == *horizon).map_or(f64::NAN, |c| c.1);
        Series {
            label: format!("after {horizon} s"),
            ink: Ink::Method(method),
            shape: Shape::Line(treads(steps.iter().map(at))),
        }
    });
    let coast = Panel {
        title: "free run".into(),
        x: x(),
        y: Axis::log(format!("RMS ({unit})")),
        series: coast.collect(),
        ..Panel::default()
    };
    Figure {
        title: format!("{}: error after every step, on data that were not fitted", capitalised(channel)),
        panels: vec![
            panel("slow error", &format!("RMS of 1-s means ({unit})"), |step| step.slow, false),
            panel("broadband error", &format!("RMS of samples ({unit})"), |step| step.wide, true),
            coast,
        ],
    }
}

//! The figure of a model that is refined: the error after every step, predicted and measured.

use super::compare::capitalised;
use super::{Axis, Figure, Ink, Panel, Series, Shape};

/// A tread of a staircase: the error that a step of the refinement left.
#[derive(Debug, Clone, PartialEq)]
pub struct Tread {
    /// What was done, as under the axis.
    pub name: String,
    /// Root of the variance of 1-s means that is left.
    pub slow: f64,
    /// Root of the variance of the samples that is left.
    pub wide: f64,
    /// What was predicted of the one or the other, with its interval.
    pub predicted: Option<Predicted>,
    /// Root mean square error when coasting: horizon in s, error.
    pub coast: Vec<(f64, f64)>,
}

/// What was predicted of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Of the samples, else of the 1-s means.
    pub wide: bool,
    /// What should be left.
    pub left: f64,
    /// Its 90 % interval.
    pub interval: [f64; 2],
}

/// Half of the length of a tread: they meet, so that the risers are upright.
const TREAD: f64 = 0.5;

/// A line that is level at every step.
fn treads(values: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
    let treads =
        values.enumerate().map(|(at, value)| [(at as f64 - TREAD, value), (at as f64 + TREAD, value)]);
    treads.flatten().collect()
}

/// The staircase of `channel`, in `unit`.
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
        // each step of its own: nothing was predicted in between
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

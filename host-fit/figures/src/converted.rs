//! A figure with its values in another unit.

use super::compare::per_hertz;
use super::{Axis, Figure, Series, Shape};
use crate::units::ShownUnit;

impl Figure {
    /// The figure with values in the unit `from`, and their squares per Hz, shown in `to`; other axes stay.
    pub fn in_unit(mut self, from: &str, to: &ShownUnit) -> Self {
        for panel in &mut self.panels {
            let [x, y] = [&mut panel.x, &mut panel.y].map(|axis| divisor(axis, from, to));
            panel.series.iter_mut().for_each(|series| series.divide(x, y));
        }
        self
    }
}

/// Renames the unit of an axis; returns what its values are divided by.
fn divisor(axis: &mut Axis, from: &str, to: &ShownUnit) -> f64 {
    let units = [
        (from.to_owned(), to.label.clone(), to.divisor),
        (per_hertz(from), per_hertz(&to.label), to.divisor * to.divisor),
    ];
    for (from, to, divisor) in units {
        if let Some(name) = axis.label.strip_suffix(&format!("({from})")) {
            axis.label = format!("{name}({to})");
            return divisor;
        }
    }
    1.0
}

impl Series {
    fn divide(&mut self, x: f64, y: f64) {
        match &mut self.shape {
            Shape::Line(points) | Shape::Points(points) | Shape::Stems(points) => {
                for (at, value) in points {
                    *at /= x;
                    *value /= y;
                }
            }
            Shape::Band(points) => {
                for (at, low, high) in points {
                    *at /= x;
                    *low /= y;
                    *high /= y;
                }
            }
            Shape::Bars(points) => {
                for (at, value, low, high) in points {
                    *at /= x;
                    *value /= y;
                    *low /= y;
                    *high /= y;
                }
            }
            Shape::Level(level) => *level /= y,
            Shape::Cells(cells) | Shape::Frames(cells) => {
                for (left, right, low, high) in cells {
                    *left /= x;
                    *right /= x;
                    *low /= y;
                    *high /= y;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Ink, Panel};
    use super::*;

    #[test]
    fn converts_values_and_densities_of_the_unit_and_nothing_else() {
        let degree = std::f64::consts::PI / 180.0;
        let series = Series::new("", Ink::Residual, Shape::Line(vec![(2.0, degree)]));
        let panel = |y: &str| Panel::new(Axis::linear("Time (s)"), Axis::linear(y), [series.clone()]);
        let figure = Figure {
            title: String::new(),
            panels: vec![panel("Residual (rad/s)"), panel("Density ((rad/s)²/Hz)"), panel("Score")],
        };
        let converted = figure.in_unit("rad/s", &ShownUnit { label: "°/s".to_owned(), divisor: degree });
        let labels: Vec<&str> = converted.panels.iter().map(|panel| panel.y.label.as_str()).collect();
        assert_eq!(labels, ["Residual (°/s)", "Density ((°/s)²/Hz)", "Score"]);
        for (panel, expected) in converted.panels.iter().zip([1.0, 1.0 / degree, degree]) {
            let Shape::Line(points) = &panel.series[0].shape else { panic!("a line") };
            assert!(points[0].0 == 2.0 && (points[0].1 / expected - 1.0).abs() < 1e-12, "{points:?}");
        }
    }
}

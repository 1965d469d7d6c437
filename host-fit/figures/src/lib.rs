#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// Names of fields speak for themselves; doc comments are written where they add a unit, a range or a reason.
#![allow(missing_docs)]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

mod canvas;
pub mod compare;
mod converted;
pub mod curves;
pub mod dependence;
mod draw;
pub mod evidence;
mod file;
pub mod noise;
pub mod plots;
pub mod population;
pub mod rests;
mod round_joins;
mod scale;
mod shading;
pub mod staircase;
pub mod units;

pub use file::{FigureError, png, svg, write_png, write_svg};
use fos_data::column::Column;
pub use shading::{ShadedRange, Shading, Tone, moved};

/// A picture of one or more panels below each other.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Figure {
    /// Headline.
    pub title: String,
    /// Panels from top to bottom. Panels with the same x range are aligned.
    pub panels: Vec<Panel>,
}

/// A pair of axes with its content.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Panel {
    /// Title, beside the legend.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Series in the order of drawing, later ones on top.
    pub series: Vec<Series>,
    /// Ranges of x set apart by a shaded background; later ones on top.
    pub shading: Vec<Shading>,
}

impl Panel {
    /// A panel without a title and without shading.
    pub fn new(x: Axis, y: Axis, series: impl IntoIterator<Item = Series>) -> Self {
        Panel { x, y, series: series.into_iter().collect(), ..Panel::default() }
    }

    /// The panel with a title.
    pub fn titled(self, title: impl Into<String>) -> Self {
        Panel { title: title.into(), ..self }
    }

    /// The panel with shaded ranges.
    pub fn shaded(self, shading: impl Into<Vec<Shading>>) -> Self {
        Panel { shading: shading.into(), ..self }
    }
}

/// An axis. Its range is that of the finite values (on a logarithmic axis, of the positive ones).
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Axis {
    /// Quantity and unit, as in `Rate (rad/s)`.
    pub label: String,
    /// Spacing of the values.
    pub scale: Scale,
    /// Names of the values 0, 1, …, in place of numbers.
    pub names: Vec<String>,
}

impl Axis {
    /// An axis with evenly spaced values.
    pub fn linear(label: impl Into<String>) -> Self {
        Axis { label: label.into(), ..Axis::default() }
    }

    /// An axis with evenly spaced decades.
    pub fn log(label: impl Into<String>) -> Self {
        Axis { label: label.into(), scale: Scale::Log, ..Axis::default() }
    }
}

/// Spacing of the values along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub enum Scale {
    /// Even.
    #[default]
    Linear,
    /// Even in the logarithm; zero and negative values are not drawn.
    Log,
}

/// Numbers to draw, all of one kind.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub struct Series {
    /// Text in the legend. Series with the same label share one entry (pieces of a recording with gaps); an empty label has none.
    pub label: String,
    /// Origin of the numbers; decides the colour.
    pub ink: Ink,
    /// Numbers and their shape.
    pub shape: Shape,
}

impl Series {
    /// A series with its label in the legend.
    pub fn new(label: impl Into<String>, ink: Ink, shape: Shape) -> Self {
        Series { label: label.into(), ink, shape }
    }
}

/// Shape of a series. A value that is not finite (in JSON null) interrupts a line or band and is otherwise skipped.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub enum Shape {
    /// Points (x, y) joined by a line.
    #[cfg_attr(feature = "page-types", ts(as = "Vec<(Option<f64>, Option<f64>)>"))]
    #[serde(deserialize_with = "places")]
    Line(Vec<(f64, f64)>),
    /// (x, low, high), filled between low and high.
    #[cfg_attr(feature = "page-types", ts(as = "Vec<(Option<f64>, Option<f64>, Option<f64>)>"))]
    #[serde(deserialize_with = "places")]
    Band(Vec<(f64, f64, f64)>),
    /// Dots at (x, y).
    #[cfg_attr(feature = "page-types", ts(as = "Vec<(Option<f64>, Option<f64>)>"))]
    #[serde(deserialize_with = "places")]
    Points(Vec<(f64, f64)>),
    /// (x, y, low, high): dots joined by a line, each with a bar from low to high.
    #[cfg_attr(feature = "page-types", ts(as = "Vec<(Option<f64>, Option<f64>, Option<f64>, Option<f64>)>"))]
    #[serde(deserialize_with = "places")]
    Bars(Vec<(f64, f64, f64, f64)>),
    /// Stems from zero to (x, y).
    #[cfg_attr(feature = "page-types", ts(as = "Vec<(Option<f64>, Option<f64>)>"))]
    #[serde(deserialize_with = "places")]
    Stems(Vec<(f64, f64)>),
    /// A dashed horizontal line.
    Level(f64),
    /// Filled rectangles (left, right, low, high), side by side.
    #[cfg_attr(feature = "page-types", ts(as = "Vec<(Option<f64>, Option<f64>, Option<f64>, Option<f64>)>"))]
    #[serde(deserialize_with = "places")]
    Cells(Vec<(f64, f64, f64, f64)>),
    /// Outlines of rectangles (left, right, low, high).
    #[cfg_attr(feature = "page-types", ts(as = "Vec<(Option<f64>, Option<f64>, Option<f64>, Option<f64>)>"))]
    #[serde(deserialize_with = "places")]
    Frames(Vec<(f64, f64, f64, f64)>),
}

/// Origin of the numbers of a series. A colour has the same meaning in every figure; the colours are those of Okabe & Ito (Color Universal
/// Design, 2008), distinguishable with any kind of colour vision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "page-types", derive(ts_rs::TS))]
pub enum Ink {
    /// Measurements (blue).
    Measured,
    /// Predictions (vermilion).
    Predicted,
    /// Residuals (green).
    Residual,
    /// Noise floor, the unpredictable part (black).
    Floor,
    /// Limits of values by chance (grey).
    Bound,
    /// Other numbers (purple).
    Other,
    /// A step of a scale from too little (blue) over usual (pale) to too much (orange to brown), numbered from 0; higher numbers use
    /// the last colour.
    Step(usize),
    /// One of several methods, numbered from 0; beyond the seventh the colours repeat.
    Method(usize),
}

/// Reads the places of a shape; what JSON has as null is not finite.
fn places<'de, D, T, const N: usize>(deserializer: D) -> Result<Vec<T>, D::Error>
where
    D: serde::Deserializer<'de>,
    T: From<[f64; N]>,
    [Option<f64>; N]: serde::Deserialize<'de>,
{
    let rows: Vec<[Option<f64>; N]> = serde::Deserialize::deserialize(deserializer)?;
    Ok(rows.into_iter().map(|row| T::from(row.map(|value| value.unwrap_or(f64::NAN)))).collect())
}

/// A column with its unit, shown below an axis.
fn named_with_unit(column: &str) -> String {
    with_unit(column, Column::named(column).unit().label())
}

fn with_unit(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") }
}
